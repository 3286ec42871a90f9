"""Whatever stands in a scenario, the answer is a ScenarioError with whole sentences, or a valid scenario."""

import copy
from collections.abc import Iterator
from typing import Any

import pytest
from scenario_example import EXAMPLE

from lienumba.errors import ScenarioError
from lienumba.scenario.build import build
from lienumba.scenario.resolve import resolve

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
FULL["projection"] = {"position": "local", "velocity": "mass", "tolerance": 1e-11, "max_iterations": 10}
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
    for junk in [*JUNK, KeyError]:
        data = copy.deepcopy(FULL)
        node = data
        for key in place[:-1]:
            node = node[key]
        if junk is KeyError:
            del node[place[-1]]
        else:
            node[place[-1]] = junk
        lines = problems(data)
        assert len(set(lines)) == len(lines)
        for line in lines:
            assert "; " in line, line
            assert "validation" not in line, line
            assert "<" not in line, line


SETTINGS = ["", "[", "{", "nan", "1e400", "x" * 100, '"', "[1, [2, {a = 3}]]", "\n", "1 = 2", "1\nb = 2", " 3 "]


@pytest.mark.parametrize("text", SETTINGS)
@pytest.mark.parametrize("path", ["title", "bodies.top", "bodies.top.position", "integrator.step", "sweep.vary"])
def test_junk_in_settings(path: str, text: str) -> None:
    lines = problems(EXAMPLE, {path: text})
    assert all("; " in line for line in lines)
