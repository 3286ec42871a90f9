"""How the inputs of a sweep were drawn, in words."""

from collections.abc import Mapping
from typing import Any

from lienumba.scenario.base.toml import Tables
from lienumba.sweep.distributions.registry import class_of
from lienumba.sweep.samplers import SAMPLERS
from lienumba.words import listed, number, show

Table = Mapping[str, Any]


def inputs(vary: Mapping[str, Table], units: Mapping[str, str], nominal: Tables) -> str:
    """Every varied path with its nominal value and distribution; those of the same distribution together."""
    groups: dict[tuple[str, bool], list[str]] = {}
    for path, d in vary.items():
        form = class_of(d).model_validate(d).words(unit(units[path]))
        groups.setdefault((form, nominal.get(path) is None), []).append(path)
    return "; ".join(
        f"{listed(paths)} ({'' if unknown else _nominal([_plain(nominal[x], units[x]) for x in paths])}{form})"
        for (form, unknown), paths in groups.items()
    )


def _nominal(values: list[str]) -> str:
    """Of one or more inputs."""
    same = len(values) > 1 and len(set(values)) == 1
    return f"each nominal {values[0]}; " if same else f"nominal {listed(values)}; "


def _plain(value: object, units: str) -> str:
    """A nominal value: numbers with their unit, formulas and the like as the scenario has them."""
    flat = value if isinstance(value, list) else [value]
    if all(isinstance(x, int | float) for x in flat):
        return f"{number(value)}{unit(units)}"
    behind = "" if units == "1" else f" ({units})"
    return f"{value}{behind}" if isinstance(value, str) else show(value)


def correlations(groups: list[Table]) -> str:
    """The correlated inputs with their matrices."""
    said = [
        f"{listed(group['paths'])} with "
        + (f"{number(group['matrix'][0][1])}" if len(group["paths"]) == 2 else f"the matrix {number(group['matrix'])}")
        for group in groups
    ]
    return f"The normal numbers behind some of them were correlated (Gaussian copula): {'; '.join(said)}."


def drawn(sweep: Table) -> str:
    """The sampler and its seed."""
    sampler = SAMPLERS[sweep["sampler"]]
    seed = "" if sampler.from_table and not _random(sweep) else f" with the seed {sweep['seed']}"
    return f"Their values were drawn from {sampler.words}{seed}"


def _random(sweep: Table) -> bool:
    """Whether anything is drawn beside a table."""
    return any(class_of(entry).dimensions > 0 for entry in sweep["vary"].values())


def unit(units: str) -> str:
    """What stands behind a number."""
    return "" if units == "1" else f" {units}"


def capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def proposals(given: Tables) -> str:
    """Where inputs were drawn instead."""
    each = [
        f"{path} (shift {number(x.get('shift', 0.0))}, scale {number(x.get('scale', 1.0))})"
        for path, x in given.items()
    ]
    return (
        f"The normal numbers behind {listed(each)} were drawn about the shift with the scale for standard deviation, "
        "in a tenth of the runs as they are; statistics are weighted by the ratio of the densities."
    )
