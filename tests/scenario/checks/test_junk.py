"""Whatever stands in a scenario, the answer is a ScenarioError with whole sentences, or a valid scenario."""

import copy
from collections.abc import Iterator
from typing import Any

import pytest

from lienumba.scenario.start.build import build
from lienumba.scenario.start.prepare import check_initial
from tests.facade import ScenarioError, resolve
from tests.rigs.every_law import EVERY_LAW, alone
from tests.rigs.scenario_example import EXAMPLE

JUNK: list[Any] = [
    "", "text", "15", "ground", True, 0, -1, 3, 10**400, 2**63, 0.5, 1e-300, 1e300, float("nan"), float("inf"),
    [], [[]], [1], [0, 0, 0], [0, 0, 0, 0], [1, 1, 1, 1, 1, 1], [[1, 0], [0, 1]], [[0] * 3] * 3, ["a", "b"], [None],
    {}, {"a": 1}, {"": {}}, {"axis": 1}, {"axis": [0, 0, 1]}, {"angle": 1, "euler": "ZYX"}, {"name": "top"},
    [{"name": 1}], [{}], {"distribution": "normal"}, {"distribution": 3}, {"distribution": "uniform", "low": 0},
]  # fmt: skip


def places(node: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The place of every value in nested dicts and lists."""
    if path:
        yield path
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, item in items:
        yield from places(item, (*path, key))


FULL = copy.deepcopy(EXAMPLE)
FULL["projection"] = {"position": "local", "velocity": "mass", "tolerance": 1e-11, "max_iterations": 10, "chord": True}
FULL["output"] = {"every": 0.01, "variables": ["position"]}
FULL["model"]["joints"].append(
    {"name": "rod", "type": "distance", "bodies": ["top", "ground"], "points": [[0, 0, 0], [0, 0, 0]], "length": 1.0}
)
FULL["sweep"]["vary"]["bodies.top.rotation[1]"] = {"distribution": "uniform", "low": -0.1, "high": 0.1}
PLACES = list(places(FULL))


def problems(data: dict[str, Any], overrides: dict[str, Any] | None = None) -> list[str]:
    """The lines of the error; none if the scenario is valid, which is then built."""
    try:
        scenario = resolve(data, overrides=overrides)
    except ScenarioError as error:
        return str(error).splitlines()
    build(scenario, {})
    assert resolve(scenario).sha256() == scenario.sha256()
    return []


@pytest.mark.parametrize("place", PLACES, ids=lambda place: ".".join(str(key) for key in place))
def test_junk_in_place_of_any_value(place: tuple[Any, ...]) -> None:
    for junk in junk_for(PLACES.index(place)):
        check_sentences(problems(changed(FULL, place, junk)))


def junk_for(number: int, more: tuple[Any, ...] = (), apart: int = 5) -> list[Any]:
    """One of `apart` kinds of junk, of neighbouring places others, and what is left out."""
    return [*[*JUNK, *more][number % apart :: apart], KeyError]


def changed(data: dict[str, Any], place: tuple[Any, ...], junk: Any) -> dict[str, Any]:
    """The scenario with junk in a place, or without what is there."""
    data = copy.deepcopy(data)
    node: Any = data
    for key in place[:-1]:
        node = node[key]
    if junk is KeyError:
        del node[place[-1]]
    else:
        node[place[-1]] = copy.deepcopy(junk)
    return data


def check_sentences(lines: list[str]) -> None:
    assert len(set(lines)) == len(lines)
    for line in lines:
        assert "; " in line, line
        assert "validation" not in line, line
        assert "<" not in line, line


# ----------------------------------------------------------------------- joints, drivers and forces, each for itself
LAWS = [(kind, index) for kind in ("joints", "drivers", "forces") for index in range(len(EVERY_LAW["model"][kind]))]
FORMULAS: tuple[Any, ...] = (
    "t", "-1", "1/t", "sqrt(t)", "sin(", "2t", "1e400", "t**1e9", "1e200*t", "exp(1e5)", "t\n", "\0", "(" * 300,
    ["t", "1/t", 0], [1e-300] * 3, [[1, 0, 0]] * 2, [[1e90] * 3] * 2, ["ground"] * 2, ["revolute"] * 2, "revolute",
)  # fmt: skip
NEW_KEYS = ("value", "rate", "angle", "speed", "points", "at", "axis", "references", "length", "point", "number", "t")


def test_every_law_is_valid() -> None:
    check_initial(resolve(EVERY_LAW))


@pytest.mark.parametrize(("kind", "index"), LAWS)
def test_junk_in_a_law(kind: str, index: int) -> None:
    data, law = alone(kind, index)
    item = data["model"][kind][law[-1]]
    check_initial(resolve(data))
    listed = [law, *(law + inside for inside in places(item)), *(law + (key,) for key in NEW_KEYS if key not in item)]
    for number, place in enumerate(listed, LAWS.index((kind, index))):
        known = place[-1] not in NEW_KEYS or place[-1] in item
        for junk in junk_for(number, FORMULAS, 19):
            if junk is KeyError and not known:
                continue
            try:
                check_initial(resolve(changed(data, place, junk)))
            except ScenarioError as error:
                check_sentences(str(error).splitlines())


SETTINGS = ["", "[", "{", "nan", "1e400", "x" * 100, '"', "[1, [2, {a = 3}]]", "\n", "1 = 2", "1\nb = 2", " 3 "]


@pytest.mark.parametrize("text", SETTINGS)
@pytest.mark.parametrize("path", ["title", "bodies.top", "bodies.top.position", "integrator.step", "sweep.vary"])
def test_junk_in_settings(path: str, text: str) -> None:
    lines = problems(EXAMPLE, {path: text})
    assert all("; " in line for line in lines)
