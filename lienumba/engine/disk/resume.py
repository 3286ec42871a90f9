"""Whether what is there already belongs to the sweep that is asked for: a sentence names the first difference."""

from typing import Any

from lienumba import __version__
from lienumba.errors import ScenarioError
from lienumba.scenario.base.paths import PLACES
from lienumba.scenario.base.toml import Tables
from lienumba.scenario.resolve import Scenario
from lienumba.store.form import by_path, scenario_tables
from lienumba.sweep.samplers import GROWING, SAMPLERS
from lienumba.words import option, show

INDIFFERENT = ("title", "sweep.runs", "sweep.nominal", "sweep.stop.")  # what may be otherwise
LONGEST = 40  # characters of a value in a sentence


def manifest(resolved: Scenario) -> dict[str, Any]:
    """What a sweep is, for those who want to go on with it."""
    return {"lienumba_version": __version__, "scenario": resolved.to_toml()}


def check_same(there: Tables, resolved: Scenario, where: str) -> None:
    """A ScenarioError if `there`, a manifest or the attributes of a dataset, is another sweep."""
    remedy = f"go on with what is there, choose another output, or start again with {option('overwrite')}"
    if there.get("lienumba_version") != __version__:
        raise ScenarioError(
            f"{where}: was begun by lienumba {there.get('lienumba_version')}, but this is {__version__}, whose results "
            f"may differ; go on with that version, or start again with {option('overwrite')}"
        )
    old, new = values(there, where), values(manifest(resolved), where)
    key = first_difference(old, new)
    if key is not None:
        raise ScenarioError(
            f"{where}: belongs to another scenario, {key} = {_shown(old, key)} there and {_shown(new, key)} here; "
            f"{remedy}"
        )
    check_samplers(old, new, where, f'start again with {option("overwrite")}, or use the sampler "{GROWING}"')


def check_parts(there: Tables, here: Tables, where: str, first: str) -> None:
    """A ScenarioError if the attributes of a dataset are not those of another part of the sweep that `first` is of."""
    if there["lienumba_version"] != here["lienumba_version"]:
        raise ScenarioError(
            f"{where}: was made by lienumba {there['lienumba_version']}, but {first} by {here['lienumba_version']}, "
            "and their results may differ; merge datasets of one version"
        )
    own, others = values(there, where), values(here, first)
    key = first_difference(own, others)
    if key is not None:
        raise ScenarioError(
            f"{where}: is of another scenario than {first}, {key} = {_shown(own, key)} there and {_shown(others, key)} "
            "here; merge datasets of one sweep"
        )
    check_samplers(own, others, where, f"{first} cannot be merged with it")


def values(there: Tables, where: str) -> dict[str, Any]:
    """Every value of the scenario of a manifest, or of the attributes of a dataset, by its path."""
    return by_path(scenario_tables(there, where))


def first_difference(old: Tables, new: Tables) -> str | None:
    """The path of the first value that makes other runs, or another dataset of them."""
    differing = (key for key in sorted(old.keys() | new.keys()) if old.get(key) != new.get(key))
    return next((key for key in differing if not (key.startswith(INDIFFERENT) or PLACES.fullmatch(key))), None)


def check_samplers(old: Tables, new: Tables, where: str, remedy: str) -> None:
    """The samples of some samplers depend on how many there are."""
    sampler, before, runs = SAMPLERS[str(new["sweep.sampler"])], old["sweep.runs"], new["sweep.runs"]
    if sampler.whole and before != runs:
        raise ScenarioError(
            f"{where}: has samples for sweep.runs = {before}, not {runs}: the sampler {show(sampler.name)} "
            f"{sampler.whole}, so that samples would not fit together; {remedy}"
        )


def _shown(values: Tables, key: str) -> str:
    if key not in values:
        return "nothing"
    text = show(values[key])
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."
