"""Parameters that are lists of numbers: read by index, varied one by one."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba import ScenarioError

SPRING: dict[str, Any] = {  # of the stiffness 2 k0 on the mass 2 k2
    "parameters": {"k": [4.0, "2*k[0]", "half"], "half": 0.5},
    "model": {
        "gravity": [0, 0, 0],
        "bodies": [
            {"name": "bob", "mass": "2*k[2]", "inertia": [1, 1, 1], "position": [1, 0, 0], "rotation": [1, 0, 0, 0]}
        ],
        "forces": [{"name": "pull", "type": "force", "body": "bob", "value": ["-k[1]*x.x", 0, "k[0]*sin(t)"]}],
    },
    "quantities": [{"name": "x", "type": "point", "body": "bob"}],
    "measures": [{"name": "far", "value": "max(x.x)*k[0] + k[1]"}],
    "integrator": {"step": 0.01, "end_time": 1.0},
    "output": {"every": 0.5},
}


def varied(path: str) -> dict[str, Any]:
    return SPRING | {"sweep": {"runs": 4, "seed": 1, "vary": {path: {"distribution": "normal", "std": 0.1}}}}


def test_every_number_has_its_index() -> None:
    ds = lienumba.run(varied("parameters.k[0]"))
    k = ds["parameters.k[0]"].values
    assert len(set(k)) == 4
    np.testing.assert_allclose(ds.x[:, -1, 0], np.cos(np.sqrt(2 * k)), rtol=0, atol=1e-8)
    np.testing.assert_allclose(ds.far, k + 2 * k, rtol=1e-14)
    np.testing.assert_array_equal(lienumba.replay(ds, 2).far, ds.far[2:3])
    system = lienumba.System("a spring").parameter("k", [4, "2*k[0]", 0.5])
    assert system.to_dict()["parameters"] == {"k": [4, "2*k[0]", 0.5]}
    set_ = lienumba.run(SPRING, overrides={"parameters.k[0]": 5, "parameters.half": 0.25})
    np.testing.assert_allclose(set_.x[0, -1, 0], np.cos(np.sqrt(20)), atol=1e-6)


def test_events_set_single_numbers() -> None:
    """The spring is switched off where it would pull the bob past the middle, which then goes on as it is."""
    off = [{"name": "off", "when": "x.x < 0", "action": "set", "parameters": {"k[0]": 0}}]
    ds = lienumba.run(SPRING | {"events": off, "integrator": {"tolerance": 1e-10, "end_time": 1.0}})
    w = np.sqrt(8.0)
    np.testing.assert_allclose(ds.x[0, -1, 0], -w * (1 - np.pi / 2 / w), rtol=1e-7)


WRONG = {
    "parameters.k[1] = [2]: must be a number or a formula of other parameters; give one number, or a list": [1, [2]],
    "parameters.k = []: must be a number or a formula of other parameters; give one number, or a list of numbers": [],
    'parameters.k[1] = "k[5]": has the unknown name "k[5]"; the nearest known name is "k[0]"': [1, "k[5]"],
    'parameters.k[1] = "k": uses "k", which has several numbers; write k[0]': [1, "k"],
}


@pytest.mark.parametrize(("sentence", "value"), WRONG.items())
def test_what_is_wrong_with_a_list_is_said(sentence: str, value: list[Any]) -> None:
    with pytest.raises(ScenarioError) as caught:
        lienumba.run(SPRING | {"parameters": {"k": value, "half": 0.5}})
    assert str(caught.value).startswith(sentence)


PATHS = {
    "parameters.k": "is a list of numbers; vary one of them, such as parameters.k[0]",
    "parameters.k[7]": 'does not exist; the nearest known name is "k[0]"',
    "parameters.k[1]": 'is the formula "2*k[0]"; vary parameters.k[0] instead',
}


@pytest.mark.parametrize(("path", "sentence"), PATHS.items())
def test_what_cannot_vary_is_said(path: str, sentence: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        lienumba.run(varied(path))
    assert str(caught.value) == f'sweep.vary."{path}": the path {path} {sentence}'
