"""Loads of the user's own: the same as those that are built in, to rounding and to the operation."""

from typing import Any

import numpy as np
import pytest

from lienumba.engine.runner import operation_counts
from tests.facade import resolve
from tests.laws.rigs import close, order, own, pair, pendulum, run

MOTION = ("position", "rotation", "velocity", "angular_velocity", "joint_force", "joint_torque")
ENERGIES = ("energy", "kinetic_energy", "potential_energy", "work", "energy_residual")
P, Q = [0.1, 0, -0.2], [0, 0.05, 0.15]
ENDS = {"bodies": ["arm", "ball"], "points": [P, Q]}
BUILT_IN = {"name": "own", "type": "spring_damper", **ENDS, "stiffness": 30, "damping": 2, "free_length": 0.8}
LOADS = own("spring", bodies=["arm", "ball"], parameters={"stiffness": 30, "damping": 2, "length": 0.8})


def formulas() -> dict[str, Any]:
    """The spring as two forces whose numbers are formulas of points."""
    ends = [("a", "arm", P), ("b", "ball", Q)]
    points = [
        {"name": f"{n}{order}", "type": "point", "body": body, "point": p, "derivative": order}
        for n, body, p in ends
        for order in (0, 1)
    ]
    along = [{"name": f"d{i}", "type": "expression", "value": f"b0.{i} - a0.{i}"} for i in "xyz"]
    length = {"name": "length", "type": "expression", "value": "sqrt(dx*dx + dy*dy + dz*dz)"}
    speed = " + ".join(f"d{i}*(b1.{i} - a1.{i})" for i in "xyz")
    pull = {"name": "pull", "type": "expression", "value": f"30*(length - 0.8)/length + 2*({speed})/length/length"}
    pulls = [
        {"name": f"on_{body}", "type": "force", "body": body, "point": p, "value": [f"{sign}pull*d{i}" for i in "xyz"]}
        for body, p, sign in (("arm", P, ""), ("ball", Q, "-"))
    ]
    return pair(*pulls, quantities=[*points, *along, length, pull])


def test_a_spring_is_the_same_built_in_as_loads_and_as_formulas():
    built_in, loads, written = run(pair(BUILT_IN)), run(pair(LOADS)), run(formulas())
    for other in (loads, written):
        close(other, built_in, *MOTION, "kinetic_energy")
        assert np.abs(other.energy_residual).max() < 1e-8
    assert not np.allclose(built_in.position, run(pair()).position, atol=1e-2)  # it does something
    stored = built_in.potential_energy - loads.potential_energy  # that of the spring: to the others it is work
    np.testing.assert_allclose(loads.work - built_in.work, (stored[:, 0] - stored), rtol=0, atol=1e-6)


def test_it_costs_what_the_built_in_one_costs():
    built_in, loads, written = (
        operation_counts(resolve(data))["step"]["operations"] for data in (pair(BUILT_IN), pair(LOADS), formulas())
    )
    assert loads == pytest.approx(built_in, rel=0.05)
    assert written == pytest.approx(built_in, rel=0.05)


# ---------------------------------------------------------------- forces, torques, efforts
PUSHED = {"type": "force", "body": "ball", "point": Q, "value": [3, "-2*sin(5*t)", 1]}
TWISTED = {"type": "torque", "body": "ball", "value": [3, 0.2, "-0.5*t"]}
SAME = {
    "gust": PUSHED,
    "thrust": PUSHED | {"frame": "body"},
    "twist": TWISTED,
    "twist_along": TWISTED | {"frame": "body"},
}


@pytest.mark.parametrize("function", SAME)
def test_a_load_in_either_frame_is_the_built_in_one(function):
    built_in = run(pair({"name": "own", **SAME[function]}))
    written = run(pair(own(function, bodies=["ball"], parameters={"x": 3})))
    close(written, built_in, *MOTION, *ENERGIES)
    assert np.abs(written.work).max() > 0.01


def test_a_load_on_the_ground_and_no_load_at_all_do_nothing():
    free = run(pair())
    for function, keys in (
        ("gust", {"parameters": {"x": 3}}),
        ("twist_along", {"parameters": {"x": 3}}),
        ("nothing", {}),
    ):
        idle = run(pair(own(function, bodies=["ground"], **keys)))
        close(idle, free, *MOTION, *ENERGIES, atol=0)


@pytest.mark.parametrize("joint", ["shoulder", "rail"])
@pytest.mark.parametrize("limit", [1e3, 1.5])
def test_an_effort_is_the_built_in_actuator(joint, limit):
    actuator = {"name": "own", "type": "actuator", "joint": joint, "stiffness": 30, "damping": 2,
                "target": "0.5*sin(3*t)", "limit": limit}  # fmt: skip
    numbers = {"kp": 30, "kd": 2, "target": "0.5*sin(3*t)", "rate": "1.5*cos(3*t)", "limit": limit}
    built_in, written = run(pair(actuator)), run(pair(own("servo", joints=[joint], parameters=numbers)))
    close(written, built_in, *MOTION, *ENERGIES)
    assert np.abs(written.work).max() > 0.01


def test_efforts_of_both_coordinates():
    actuators = [
        {"name": f"own_{c}", "type": "actuator", "joint": "sleeve", "coordinate": c, "stiffness": 9, "limit": 0.8}
        for c in ("angle", "displacement")
    ]
    written = run(pair(own("two_servos", joints=["sleeve"], parameters={"kp": 9, "limit": 0.8})))
    close(written, run(pair(*actuators)), *MOTION, *ENERGIES)


def test_what_it_works_is_accounted_for():
    law = own("damped_drive", joints=["shoulder"], bodies=["ball"], parameters={"drive": 2, "drag": 0.3})
    found = [run(pair(law, step=h)) for h in (8e-3, 4e-3)]
    assert np.abs(found[1].work).max() > 0.5
    residuals = [float(np.abs(ds.energy_residual).max()) for ds in found]
    assert order(residuals) > 3.7, residuals
    assert residuals[1] < 1e-6


def test_quantities_come_by_the_names_of_arguments():
    quantities = [
        {"name": "pointing", "type": "rotation_error", "body": "rod"},
        {"name": "turning", "type": "angular_velocity", "body": "rod"},
    ]
    formula = {"name": "own", "type": "torque", "body": "rod", "value": [0, "-9*pointing.y - 0.5*turning.y", 0]}
    written = own("pointing_servo", bodies=["rod"], parameters={"kp": 9, "kd": 0.5})
    a, b = (run(pendulum(force, quantities=quantities)) for force in (formula, written))
    close(b, a, *MOTION, *ENERGIES)
