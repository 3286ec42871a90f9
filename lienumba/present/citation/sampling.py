"""How the inputs of a sweep were drawn, in words."""

import re
from collections.abc import Callable, Mapping
from typing import Any

from lienumba.scenario.base.toml import Tables
from lienumba.sweep.distributions.registry import form_of
from lienumba.sweep.samplers import SAMPLERS
from lienumba.words import listed, show

Table = Mapping[str, Any]
Told = Callable[[Table, "Words"], str]


class Words:
    """Numbers of one distribution; relative ones are multiples of the nominal value."""

    def __init__(self, distribution: Table, units: str) -> None:
        self.relative = bool(distribution.get("relative"))
        self.unit = unit(units)

    def value(self, x: float) -> str:
        return f"{number(x)} times the nominal value" if self.relative else f"{number(x)}{self.unit}"

    def place(self, x: float | None) -> str:
        return "the nominal value" if x is None else self.value(x)


def number(x: Any) -> str:
    """A number as short as it can be without losing a digit; lists of them."""
    if isinstance(x, list | tuple):
        return f"[{', '.join(map(number, x))}]"
    text = str(int(x)) if float(x).is_integer() and abs(x) < 1e15 else repr(float(x))
    return re.sub(r"e([+-])0+", lambda sign: f"e{sign[1].strip('+')}", text)


def _bounds(d: Table, say: Words) -> str:
    low, high = d.get("low"), d.get("high")
    if low is None or high is None:
        return f"below {say.value(d['high'])}" if low is None else f"above {say.value(low)}"
    return f"between {say.value(low)} and {say.value(high)}"


def _rotation(d: Table, say: Words) -> str:
    spread = f"standard deviation {number(d['std'])} rad" if d.get("std") is not None else None
    spread = spread or f"covariance {number(d['covariance'])} rad^2"
    return f"the nominal rotation times exp of a normal rotation vector in {d['frame']} axes, mean 0, {spread}"


def _scipy(d: Table, say: Words) -> str:
    given = ", ".join(f"{key} = {number(x)}" for key, x in d.items() if key not in ("scipy", "relative"))
    return f"{d['scipy']} of scipy.stats{f' with {given}' if given else ''}" + (
        ", times the nominal value" if say.relative else ""
    )


FORMS: dict[str, Told] = {
    "normal": lambda d, say: f"normal, mean {say.place(d.get('mean'))}, standard deviation {say.value(d['std'])}",
    "uniform": lambda d, say: f"uniform {_bounds(d, say)}",
    "truncated_normal": lambda d, say: (
        f"normal, mean {say.place(d.get('mean'))}, standard deviation "
        f"{say.value(d['std'])}, truncated to values {_bounds(d, say)}"
    ),
    "lognormal": lambda d, say: (
        f"lognormal, median {say.place(d.get('median'))}, standard deviation of the logarithm {number(d['sigma'])}"
    ),
    "triangular": lambda d, say: f"triangular {_bounds(d, say)}, mode {say.place(d.get('mode'))}",
    "choice": lambda d, say: (
        f"one of {listed(map(say.value, d['values']), 'or')}, "
        + (f"with weights {number(d['weights'])}" if d.get("weights") else "all as likely")
    ),
    "constant": lambda d, say: f"{say.value(d['value'])} in all runs",
    "rotation_normal": _rotation,
    "rotation_uniform": lambda d, say: "uniform on SO(3)",
    "direction": lambda d, say: (
        "of nominal length, its direction uniform "
        + ("on the sphere" if d.get("angle") is None else f"within {number(d['angle'])} rad of the nominal one")
    ),
    "inertia": lambda d, say: (
        "the nominal mass distribution stretched at random, relative standard deviation of its "
        f"second moments {number(d['std'])}"
    ),
    "scipy": _scipy,
    "expression": lambda d, say: f"the formula {d['expression']}",
    "column": lambda d, say: "from the table",
}


def inputs(vary: Mapping[str, Table], units: Mapping[str, str], nominal: Tables) -> str:
    """Every varied path with its nominal value and distribution; those of the same distribution together."""
    groups: dict[tuple[str, bool], list[str]] = {}
    for path, d in vary.items():
        form = FORMS[form_of(d) or ""](d, Words(d, units[path]))
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
    return any(form_of(d) not in ("column", "expression", "constant") for d in sweep["vary"].values())


def unit(units: str) -> str:
    """What stands behind a number."""
    return "" if units == "1" else f" {units}"


def capital(text: str) -> str:
    return text[:1].upper() + text[1:]
