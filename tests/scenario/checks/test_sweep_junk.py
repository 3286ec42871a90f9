"""Junk in place of anything that a sweep may say: a sentence with a remedy, or samples."""

import copy
from typing import Any

import pytest

from lienumba import ScenarioError
from lienumba.scenario.start.design import draw
from tests.facade import resolve
from tests.rigs.scenario_example import EXAMPLE
from tests.scenario.checks.test_junk import changed, check_sentences, junk_for, places

DRAWN: dict[str, Any] = {
    "runs": 12,
    "sampler": "sobol",
    "nominal": True,
    "vary": {
        "bodies.top.mass": {"distribution": "truncated_normal", "mean": 15, "std": 0.1, "low": 14, "high": 16},
        "bodies.top.inertia": {"distribution": "inertia", "std": 0.1},
        "bodies.top.rotation": {"distribution": "rotation_normal", "std": [0.1, 0.2, 0.3], "frame": "global"},
        "bodies.top.position[0]": {"distribution": "choice", "values": [0, 1], "weights": [1, 2]},
        "bodies.top.position[1]": {"distribution": "triangular", "low": 0, "mode": 0.5, "high": 1},
        "bodies.top.position[2]": {"distribution": "lognormal", "median": 2, "sigma": 0.1},
        "bodies.top.angular_velocity[0]": {"scipy": "beta", "a": 2, "b": 3, "scale": 2, "relative": False},
        "bodies.top.angular_velocity[1]": {"expression": "2*bodies.top.mass"},
        "bodies.top.angular_velocity[2]": {"distribution": "constant", "value": 1},
        "gravity": {"distribution": "direction", "angle": 0.1},
    },
    "correlate": [{"paths": ["bodies.top.mass", "bodies.top.rotation[0]"], "matrix": [[1, 0.5], [0.5, 1]]}],
}
GIVEN: dict[str, Any] = {
    "runs": 2,
    "sampler": "table",
    "vary": {
        "bodies.top.position[0]": {"column": "x"},
        "bodies.top.rotation": {"column": ["x", "x", "y", "y"]},
    },
    "table": {"columns": {"x": [1, 2], "y": [1, 2], "gravity[0]": [1, 2]}, "runs": [0, 1]},
}
PLACES = [(sweep, place) for sweep in (DRAWN, GIVEN) for place in places(sweep)]


def drawn(sweep: dict[str, Any]) -> list[str]:
    """The lines of the error; none if there are samples."""
    try:
        scenario = resolve(copy.deepcopy(EXAMPLE) | {"sweep": sweep})
        draw(scenario, scenario.labels)
    except ScenarioError as error:
        return str(error).splitlines()
    assert resolve(scenario).sha256() == scenario.sha256()
    return []


@pytest.mark.parametrize("sweep", [DRAWN, GIVEN], ids=["drawn", "given"])
def test_without_junk_there_are_samples(sweep: dict[str, Any]) -> None:
    assert drawn(sweep) == []


@pytest.mark.parametrize(
    ("sweep", "place"), PLACES, ids=lambda x: ".".join(map(str, x)) if isinstance(x, tuple) else ""
)
def test_junk_in_place_of_any_value(sweep: dict[str, Any], place: tuple[Any, ...]) -> None:
    for junk in junk_for(PLACES.index((sweep, place))):
        check_sentences(drawn(changed(sweep, place, junk)))
