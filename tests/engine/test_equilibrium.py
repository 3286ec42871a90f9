"""Static equilibria against closed forms, and what is said of those that are none."""

from typing import Any

import numpy as np
import pytest

import lienumba

G = 9.81
SHORT = {"integrator": {"step": 1e-3, "end_time": 0.1}}


def pendulum(angle: float, **sweep: Any) -> dict[str, Any]:
    """A bob of 1.2 kg at 0.5 m on a hinge with a coil spring; angle 0 hangs."""
    bob = {"name": "bob", "mass": 1.2, "inertia": [0.02, 0.02, 0.01]}
    pivot = {
        "name": "pivot", "type": "revolute", "bodies": ["ground", "bob"], "points": [[0, 0, 0], [0, 0, 0.5]],
        "axes": [[0, 1, 0]] * 2, "references": [[1, 0, 0]] * 2, "angle": angle, "rate": 3.0,
    }  # fmt: skip
    coil = {"name": "coil", "type": "torsion_spring", "joint": "pivot", "stiffness": 0.0, "free_angle": 0.0}
    seen = {"name": "swing", "type": "joint", "joint": "pivot"}
    model = {"bodies": [bob], "joints": [pivot], "forces": [coil], "quantities": [seen]}
    return {"model": model, **SHORT, "sweep": sweep}


@pytest.mark.parametrize("angle", [0.3, 2.5, 3.1, -3.1])
def test_a_pendulum_comes_to_hang_wherever_it_starts(angle: float) -> None:
    found = lienumba.equilibrium(pendulum(angle))
    assert found.status.item() == 0
    np.testing.assert_allclose(found.position.values, [[[0, 0, -0.5]]], atol=1e-12)


def test_what_stands_upright_is_unstable() -> None:
    found = lienumba.equilibrium(pendulum(np.pi))
    assert found.status.item() == 2
    assert found.growth.item() == pytest.approx(np.sqrt(1.2 * G * 0.5 / (0.02 + 1.2 * 0.25)), rel=1e-10)


def test_every_run_of_a_sweep_rests_at_its_own_place() -> None:
    """k (angle - 1) = -m g a sin(angle)."""
    scenario = pendulum(0.2, sampler="table", table={"columns": {"forces.coil.stiffness": [1.0, 5.0, 40.0]}})
    scenario["model"]["forces"][0] |= {"stiffness": 3.0, "free_angle": 1.0}
    found = lienumba.equilibrium(scenario)
    x, k = found["swing.angle"].values, np.array([1.0, 5.0, 40.0])
    np.testing.assert_allclose(k * (x - 1.0), -1.2 * G * 0.5 * np.sin(x), rtol=1e-12)
    assert found.status.values.tolist() == [0, 0, 0]


def test_a_free_body_on_bushings_and_one_that_nothing_holds() -> None:
    block = {"name": "block", "mass": 3.0, "inertia": [0.2, 0.3, 0.4], "position": [0.1, 0, 0.2],
             "rotation": {"axis": [1, 2, 0], "angle": 0.7}}  # fmt: skip
    mount = {"name": "mount", "type": "bushing", "bodies": ["ground", "block"], "points": [[0, 0, 0]] * 2,
             "stiffness": [100, 200, 300], "rotational_stiffness": [5, 5, 5]}  # fmt: skip
    found = lienumba.equilibrium({"model": {"bodies": [block], "forces": [mount]}, **SHORT})
    assert found.status.item() == 0
    np.testing.assert_allclose(found.position.values[0, 0], [0, 0, -3.0 * G / 300], atol=1e-12)
    falling = lienumba.equilibrium({"model": {"bodies": [block]}, **SHORT})
    assert falling.status.item() == 1
    assert np.isnan(falling.position.values).all()
    floating = lienumba.equilibrium({"model": {"gravity": [0, 0, 0], "bodies": [block]}, **SHORT})
    assert floating.status.item() == 3


def test_a_loop_with_redundant_rows_comes_to_rest() -> None:
    """A four-bar linkage hangs where its potential energy is least, all rows kept."""
    found = lienumba.equilibrium("scenarios/four_bar.toml")
    assert found.status.item() == 0
    now = lienumba.linearise("scenarios/four_bar.toml").isel(run=0, time=0)
    assert np.linalg.eigvals(now.A.values).real.max() > 0.0  # where it starts it does not rest
