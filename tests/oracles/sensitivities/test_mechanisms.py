"""Derivatives of random mechanisms against differences of lienumba, and of an engine that shares nothing with it."""

import copy
from typing import Any

import numpy as np
import pytest

from lienumba.scenario.base import paths
from tests.oracles.mechanisms.drawing import mechanism
from tests.oracles.mechanisms.engine import Mechanism, SingularError
from tests.oracles.sensitivities.differences import PLACES, WEIGHTS, derivatives, differences
from tests.oracles.switching.drawing import changing

OF = ["position", "velocity", "angular_velocity"]
BOUND = 1e-8  # of the largest number, or of 1
KEYS = ("stiffness", "damping", "linear", "quadratic", "coulomb", "viscous", "mu", "free_length", "restitution")
WAYS = [
    {"method": "dop853", "tolerance": 1e-12, "coordinates": "joint"},
    {"method": "dop853", "tolerance": 1e-12, "coordinates": "lie"},
    {"method": "dp54", "tolerance": 1e-12, "coordinates": "joint"},
    {"method": "rk4", "step": 1e-3, "coordinates": "lie"},
]
STEP = 1e-3  # of an input, relative to it


def inputs_of(data: dict[str, Any], seed: int, most: int = 3) -> dict[str, float]:
    """Some numbers of a mechanism."""
    model = data["model"]
    found = {"gravity[2]": model["gravity"][2]}
    found |= {f"bodies.{body['name']}.mass": body["mass"] for body in model["bodies"]}
    for kind in ("forces", "limits", "contacts"):
        for part in model.get(kind, ()):
            found |= {f"{kind}.{part['name']}.{key}": part[key] for key in KEYS if isinstance(part.get(key), float)}
    drawn = np.random.default_rng(seed).permutation(len(found))[:most]
    return {path: found[path] for path in (list(found)[n] for n in drawn)}


def within(found: Any, expected: Any) -> bool:
    """Whether derivatives agree, each input apart."""
    sizes = np.maximum(np.abs(expected).max(axis=tuple(range(expected.ndim - 1))), 1.0)
    return bool((np.abs(found - expected) <= BOUND * sizes).all())


def own_differences(data: dict[str, Any], at: dict[str, float]) -> np.ndarray:
    """Of positions by the engine of tests/oracles/mechanisms (times, bodies, axes, inputs)."""
    found = []
    for path, x in at.items():
        step, total = STEP * (abs(x) or 1.0), 0.0
        for place, weight in zip(PLACES, WEIGHTS, strict=True):
            model = copy.deepcopy(data["model"])
            paths.put(model, paths.parse(path), x + place * step)
            course = Mechanism(model).run(data["output"]["times"], tolerance=1e-13)
            total = total + weight * np.array([motion.state.r for motion in course])
        found.append(total / step)
    return np.stack(found, axis=-1)


def against_differences(data: dict[str, Any], seed: int, way: dict[str, Any]) -> None:
    """Compare with differences of lienumba's own runs."""
    data, at = data | {"integrator": {"end_time": data["integrator"]["end_time"]} | way}, inputs_of(data, seed)
    ds, expected = derivatives(data, OF, at), differences(data, OF, at)
    assert (int(ds.status), int(ds.sensitivity_flags)) == (0, 0)
    for name in OF:
        assert within(ds[f"d_{name}"].values, expected[name]), name


@pytest.mark.parametrize(("seed", "way"), [(13, 0), (14, 1), (2, 3), (24, 2)])
def test_differences_say_the_same(seed: int, way: int) -> None:
    against_differences(mechanism(seed), seed, WAYS[way])


@pytest.mark.release
@pytest.mark.parametrize("seed", [14, 29])
def test_another_engine_says_the_same(seed: int) -> None:
    data = mechanism(seed)
    data["integrator"] |= WAYS[seed % 2]
    at = inputs_of(data, seed)
    assert within(derivatives(data, OF, at).d_position.values, own_differences(data, at))


@pytest.mark.campaign(6)
def test_another_engine_says_the_same_of_new_mechanisms(seed: int) -> None:
    data = mechanism(seed)
    data["integrator"] |= WAYS[seed % 2]
    at = inputs_of(data, seed, 2)
    try:
        expected = own_differences(data, at)
    except SingularError as error:
        pytest.skip(str(error))
    assert within(derivatives(data, OF, at).d_position.values, expected)


@pytest.mark.release
@pytest.mark.parametrize("seed", [0, 5, 8])
def test_differences_say_the_same_through_changes(seed: int) -> None:
    """Locks, numbers that are set, releases."""
    data = changing(seed)
    assert data["events"]
    against_differences(data, seed, WAYS[seed % 2])
