"""Runs in the coordinates of the joints: orders, tolerances, loops, bits, failures, against the paper's own way."""

import copy
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.batch.statuses import INVALID, STOPPED, SUCCESS
from lienumba.integrators import codes
from lienumba.integrators.tracing import step_kernels
from lienumba.scenario.reading.loading import load
from tests.rigs import parts
from tests.rigs.places import SCENARIOS
from tests.rigs.scenarios import BENNETT, LOOP, scenario

J = [0.06, 0.05, 0.02, 0.004, -0.006, 0.005]
JOINT = {"integrator.coordinates": "joint"}
STATES = ("position", "rotation", "velocity", "angular_velocity")
STORED = (*STATES, "joint_force", "joint_torque", "multiplier")
MIXED: dict[str, Any] = {  # a body on the ground, one on it, one under a ball, and one that flies; some bodies second
    "model": {
        "gravity": [0.3, "0.1*t", -9.81],
        "bodies": [
            parts.body("a", 1.3, J, position=[0.3, 0, 0], rotation=[1, 0, 0, 0]),
            parts.body("b", 0.8, J),
            parts.body("c", 0.5, J, angular_velocity=[2, -1, 3]),
            parts.body("f", 0.7, J, position=[2, 0, 0], angular_velocity=[1, 3, 2]),
        ],
        "joints": [
            parts.hinge("j", "ground", axis=[0, 1, 0.1], to="a", rate=4.0, armature=0.05),
            parts.joint("k", "universal", "b", "a", points=[[0.1, 0.1, 0], [-0.2, 0, 0]],
                        axes=[[0, 0, 1], [0.2, 1, 0]]),
            parts.joint("l", "spherical", "a", "c", points=[[0.1, 0, 0.2], [0.2, 0, 0]]),
        ],
        "forces": [
            {"name": "brake", "type": "friction", "joint": "j", "viscous": 0.2, "coulomb": 0.1, "velocity": 0.5},
            {"name": "spring", "type": "spring_damper", "bodies": ["f", "c"], "points": [[0, 0, 0.1], [0, 0.1, 0]],
             "stiffness": 9.0, "damping": 0.3},
        ],
    },
    "integrator": {"step": 0.01, "end_time": 0.32},
    "quantities": [{"name": "tip", "type": "point", "body": "b", "point": [0.1, 0, 0.1]}],
    "output": {"every": 0.16, "also": ["multiplier"]},
}  # fmt: skip


def run(data: Any, overrides: dict[str, Any], **options: Any) -> Any:
    return lienumba.run(data, overrides=overrides, **{"workers": 1, **options})


@cache
def exact() -> Any:
    """In the coordinates of the bodies."""
    found = run(MIXED, {"integrator.method": "tsit54", "integrator.step": 1e-3})
    assert (found.status == 0).all()
    return found


def error(found: Any, known: Any = None) -> float:
    assert (found.status == 0).all()
    known = exact() if known is None else known
    return max(float(abs(found[name] - known[name]).max()) for name in STATES)


def close(found: Any, known: Any, bound: float, names: tuple[str, ...] = STORED) -> None:
    for name in names:
        a, b = found[name].values, known[name].values
        size = max(1.0, float(np.nanmax(np.abs(b), initial=0.0)))
        np.testing.assert_allclose(a, b, rtol=0.0, atol=bound * size, err_msg=name)


# ---------------------------------------------------------------- accuracy
@pytest.mark.parametrize(
    ("method", "order", "step"), [("kutta3", 3, 0.01), ("rk4", 4, 0.01), ("cf4", 4, 0.01), ("tsit54", 5, 0.01)]
)
def test_measured_orders(method: str, order: int, step: float) -> None:
    found = []
    for h in (step, step / 2):
        found.append(error(run(MIXED, JOINT | {"integrator.method": method, "integrator.step": h})))
    assert np.log2(np.divide(found[:-1], found[1:])) == pytest.approx(order, abs=0.2), found
    assert found[-1] < 1e-4


def test_a_tolerance_is_kept_and_outputs_lie_on_the_motion() -> None:
    """An error of 1e-4 of the tolerance or the like falls with it, at times that no step ends on."""
    settings = JOINT | {"integrator.step": None, "integrator.method": "dp54"}
    found = [error(run(MIXED, settings | {"integrator.tolerance": x})) for x in (1e-5, 1e-7, 1e-9)]
    assert found[0] < 1e-3
    assert all(a > 20.0 * b for a, b in pairwise(found)), found


def test_what_is_stored_beside_the_state_is_the_same() -> None:
    """Reactions, multipliers, energies, quantities."""
    found = run(MIXED, JOINT | {"integrator.method": "tsit54", "integrator.step": 2e-3})
    close(found, exact(), 1e-9, (*STORED, "energy", "kinetic_energy", "tip"))
    assert float(abs(found.energy_residual).max()) < 1e-9
    assert float(found.position_violation.max()) < 1e-14
    for name in STATES:
        np.testing.assert_array_equal(found[f"last_{name}"], found[name][:, -1])


def test_stage_by_stage_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """Large mechanisms have a kernel for each stage, for steps of one length and of their own."""
    ways = [{}, {"integrator.step": None, "integrator.tolerance": 1e-7, "integrator.method": "dp54"}]
    whole = [run(MIXED, JOINT | way) for way in ways]
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    for one, way in zip(whole, ways, strict=True):
        close(run(MIXED, JOINT | way), one, 1e-11)


def test_events_are_found() -> None:
    data = copy.deepcopy(MIXED) | {"events": [{"name": "low", "when": "tip.z < 0", "action": "stop"}]}
    settings = {"integrator.step": None, "integrator.tolerance": 1e-9, "integrator.method": "dp54"}
    known, found = run(data, settings), run(data, settings | JOINT)
    assert known.status.values.tolist() == found.status.values.tolist()
    assert found.status.values.tolist() == [STOPPED]
    assert 0.0 < float(known.end_time[0]) < 0.32
    np.testing.assert_allclose(found.end_time, known.end_time, atol=1e-8)


# ---------------------------------------------------------------- loops
def test_a_loop_of_redundant_rows_through_a_full_turn() -> None:
    """On the way the rows in use become dependent, and others are chosen; not so, the energy leaps by 1e-6."""
    data = scenario(BENNETT, 1e-3, 0.4, output={"every": 0.05, "also": ["multiplier"]})
    known, found = run(data, {}), run(data, JOINT)
    close(found, known, 1e-7, STATES)
    assert float(abs(found.energy_residual).max()) < 2.0 * float(abs(known.energy_residual).max())
    assert float(found.position_violation.max()) < 1e-13
    assert float(found.velocity_violation.max()) < 1e-11


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"projection.velocity": "identity"},
        {"projection.position": "none", "projection.velocity": "none", "projection.baumgarte": 20.0},
    ],
    ids=lambda settings: "-".join(str(x) for x in settings.values()) or "mass",
)
def test_a_loop_with_rods(settings: dict[str, Any]) -> None:
    data = scenario(LOOP, 5e-4, 0.05, output={"every": 0.025, "also": ["multiplier"]})
    close(run(data, settings | JOINT), run(data, settings), 1e-8)


def test_every_joint_of_a_loop_may_have_a_rotor() -> None:
    data = load(SCENARIOS / "four_bar.toml")
    data.pop("sweep", None)
    for n, joint in enumerate(data["model"]["joints"]):
        joint["armature"] = 0.1 * (n + 1)
    settings = {"integrator.end_time": 0.1}
    known, found = run(data, settings), run(data, settings | JOINT)
    close(found, known, 1e-9, STATES)
    assert float(abs(found.energy_residual).max()) < 1e-8
    without = run(SCENARIOS / "four_bar.toml", settings, runs=[0])
    assert float(abs(without.position.isel(run=0) - found.position.isel(run=0)).max()) > 1e-4


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_rotor_does_not_ask_which_way_axes_point(coordinates: str) -> None:
    def moved(z: int) -> Any:
        links = [
            parts.body(n, 1, J[:3], position=[x, 0, 0], rotation=[1, 0, 0, 0]) for n, x in (("a", 0.4), ("b", 0.9))
        ]
        ends: Any = {"points": [[0.3, 0, 0], [-0.2, 0, 0]], "axes": [[0, 1, 0], [0, z, 0]]}
        hinges = [parts.hinge("j", "a"), parts.joint("k", "revolute", "b", "a", **ends, rate=2.0, armature=0.5)]
        integrator = {"step": 2e-3, "end_time": 0.2, "coordinates": coordinates}
        return run({"model": {"bodies": links, "joints": hinges}, "integrator": integrator}, {})

    along, against = moved(1), moved(-1)
    close(against, along, 1e-12, STATES)
    assert float(abs(against.energy_residual).max()) < 1e-8


# ---------------------------------------------------------------- sweeps
def sweep(runs: int) -> dict[str, Any]:
    """Of numbers of bodies, frames of joints and the start; some runs have no mass, which fails."""
    vary = {
        "bodies.a.mass": {"distribution": "normal", "std": 1.2},
        "bodies.c.inertia": {"distribution": "inertia", "std": 0.1},
        "joints.j.at[0]": {"distribution": "uniform", "low": -0.1, "high": 0.1},
        "joints.k.axes[0][0]": {"distribution": "uniform", "low": -0.1, "high": 0.1},
        "joints.j.rate": {"distribution": "normal", "std": 1.0},
    }
    return copy.deepcopy(MIXED) | {"sweep": {"runs": runs, "vary": vary}}


@pytest.mark.filterwarnings("ignore:sweep.vary")
def test_runs_of_a_sweep_are_their_own() -> None:
    """In any company, on any number of cores; each like the same run in the coordinates of bodies."""
    many = run(sweep(13), JOINT)
    bad = many.status.values
    assert {*bad.tolist()} == {SUCCESS, INVALID}
    close(many, run(sweep(13), {}), 1e-5, STATES)
    for other, labels in (
        (run(sweep(13), JOINT, workers=2), range(13)),
        (run(sweep(13), JOINT, runs=[3, 11]), (3, 11)),
    ):
        for name in (*STORED, *(f"last_{x}" for x in STATES)):
            np.testing.assert_array_equal(other[name].values, many[name].values[list(labels)], err_msg=name)
    good = bad == 0
    for name in STATES:
        np.testing.assert_array_equal(many[f"last_{name}"].values[good], many[name].values[good, -1])


def test_runs_whose_axes_point_different_ways() -> None:
    """The same motions, whether a body is turned by half a turn about the axis across or not."""
    turned = "pi*(0.5 + 0.5*(way - 0.5)/abs(way - 0.5))"
    hinge = {"type": "revolute", "axes": [[0, 0, 1], [0, 0, 1]]}
    data: dict[str, Any] = {
        "parameters": {"way": 0.1},
        "model": {
            "gravity": [0, -9.81, 1],
            "bodies": [
                parts.body("a", 1, J[:3], position=[0.4, 0, 0], rotation=[1, 0, 0, 0]),
                parts.body("b", 1, J[:3], position=[0.9, 0, 0], rotation={"axis": [1, 0, 0], "angle": turned}),
            ],
            "joints": [
                hinge | {"name": "j", "bodies": ["ground", "a"], "points": [[0, 0, 0], [-0.4, 0, 0]], "rate": 1.0},
                hinge | {"name": "k", "bodies": ["a", "b"], "points": [[0.3, 0, 0], [-0.2, 0, 0]], "rate": 2.0,
                         "armature": 0.5},
            ],
        },
        "integrator": {"step": 2e-3, "end_time": 0.2},
        "output": {"also": ["multiplier"]},
        "sweep": parts.sweep(6, {"parameters.way": (0.0, 1.0)}),
    }  # fmt: skip
    found = run(data, JOINT)
    ways = found["parameters.way"].values > 0.5
    assert 0 < ways.sum() < 6
    close(found, run(data, {}), 1e-8)
    for name in ("position", "velocity"):
        np.testing.assert_allclose(found[name], np.broadcast_to(found[name][:1], found[name].shape), atol=1e-12)
    alone = run(data, JOINT, runs=[2])
    np.testing.assert_array_equal(alone["position"][0], found["position"][2])


# ---------------------------------------------------------------- failures
def test_a_step_that_turns_too_far_is_told() -> None:
    changed = {"integrator.step": 0.08, "joints.j.rate": 60.0}
    known, found = run(MIXED, changed), run(MIXED, changed | JOINT)
    assert known.status.values.tolist() == found.status.values.tolist() == [codes.ROTATION]
    np.testing.assert_array_equal(found.end_time, known.end_time)
