"""BibTeX entries of what a dataset or a scenario was computed with."""

import re
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from lienumba.errors import ScenarioError
from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import GROUPS, JOINT
from lienumba.present import references
from lienumba.scenario.base.toml import Tables
from lienumba.scenario.resolve import written_tables
from lienumba.sweep.samplers import SAMPLERS

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.scenario.resolve import Scenario

OWN = "lienumba"
PACKAGES = {"numpy": "harris2020", "scipy": "virtanen2020", "numba": "lam2015", "xarray": "hoyer2017"}


def cite_dataset(dataset: "xr.Dataset") -> str:
    """Return the entries for a dataset, with the versions and the year that it names. No code of it is run."""
    content = written_tables(dataset, "the dataset")
    if not content:
        raise ScenarioError("the dataset brings no scenario, which would say what is to be cited")
    ending = "_version"
    versions = {key.removesuffix(ending): str(x) for key, x in dataset.attrs.items() if key.endswith(ending)}
    year = re.match(r"\d{4}", str(dataset.attrs.get("history", "")))
    return _entries(content, versions, int(year[0]) if year else datetime.now(UTC).year)


def cite_scenario(scenario: "Scenario") -> str:
    """Return the entries for a scenario, with the versions that are installed here."""
    from lienumba.store.provenance import versions

    return _entries(scenario.to_dict(), versions(), datetime.now(UTC).year)


def _entries(content: Tables, versions: Mapping[str, str], year: int) -> str:
    return "\n\n".join([references.software(versions[OWN], year), *references.bibtex(_keys(content, versions))])


def _keys(content: Tables, versions: Mapping[str, str]) -> list[str]:
    """Keys of the references, each once: the formulation, methods, groups, contacts, the sampler, packages."""
    reference = content.get("study", {}).get("reference", {})
    others = [reference.get(key) for key in ("method", "integrator.method")]
    methods = [METHODS[name] for name in (*_values(content, "integrator.method"), *others) if name in METHODS]
    coordinates = _values(content, "integrator.coordinates")
    elements = [*methods, *(GROUPS[name] for name in _values(content, "integrator.group") if "lie" in coordinates)]
    if content.get("sweep", {}).get("vary"):
        elements.append(SAMPLERS[content["sweep"]["sampler"]])
    keys = ["terze2015"]
    if JOINT in coordinates:
        keys.append("featherstone2008")
    if "lie" in coordinates and not all(method.composed or method.series for method in methods):
        keys += ["munthekaas1998", "munthekaas1999"]
    keys += [reference.key for element in elements for reference in element.references]
    if any(_values(content, "projection.baumgarte")):
        keys.append("baumgarte1972")
    if any(contact.get("stiffness") is not None for contact in content["model"].get("contacts", [])):
        keys.append("hunt1975")
    keys += [key for name, key in PACKAGES.items() if name in versions]
    return list(dict.fromkeys(keys))


def _values(content: Tables, path: str) -> list[Any]:
    """Values of a setting: those on the grids of a study, or the scenario's own."""
    section, _, key = path.partition(".")
    grids = content.get("study", {}).get("grid") or [{}]
    values = [value for grid in grids for value in grid.get(path, [content[section].get(key)])]
    return list(dict.fromkeys(value for value in values if value is not None))
