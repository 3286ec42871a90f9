"""States of laws travel with the bodies: stage by stage, through exchanges of rows, and in sweeps, bit by bit."""

from typing import Any

import numpy as np
import pytest

from lienumba.engine.runner import operation_counts
from lienumba.integrators.tracing import step_kernels
from tests.facade import resolve
from tests.laws.rigs import close, order, own, pair, run
from tests.rigs.scenarios import TOP, chain
from tests.rigs.sweeps import assert_same, linkage

PID = own("pid", joints=["shoulder"], parameters={"kp": 30, "kd": 2, "target": 1.0, "ki": 25}, states={"integral": 0.1})
MOTOR = own("rail_motor", "motor", joints=["rail"], parameters={"volts": 9, "lag": 0.15}, states={"torque": -0.4})


# ---------------------------------------------------------------- large mechanisms
def with_memory(mechanism: dict[str, Any], body: str, step: float, end: float = 0.1, **sections: Any) -> dict[str, Any]:
    law = own("memory", bodies=[body], parameters={"lag": 0.03, "gain": 0.05},
              states={"x": 0.1, "y": -0.2, "z": 0.3})  # fmt: skip
    more = own("memory", "more", bodies=[body], parameters={"lag": 0.05, "gain": 0.02},
               states=dict.fromkeys("xyz", 1.0))  # fmt: skip
    again = more | {"name": "again"}
    last = again | {"name": "last"}
    model = mechanism["model"] | {"forces": [law, more, again, last]}
    return {
        "model": model,
        "integrator": {"step": step, "end_time": end},
        "output": {"times": [0.0, end]},
    } | sections  # fmt: skip


STORED = ("position", "rotation", "velocity", "angular_velocity", "energy", "work", "own.x", "own.z", "last.y")


@pytest.mark.parametrize("mechanism", [TOP, chain(2)], ids=["top", "two links"])
def test_stage_by_stage_is_the_same(mechanism, monkeypatch):
    body = mechanism["model"]["bodies"][-1]["name"]
    data = with_memory(mechanism, body, 1e-3)
    whole = run(data)
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    assert "step" not in operation_counts(resolve(data))
    staged = run(data)
    for name in STORED:
        np.testing.assert_allclose(staged[name], whole[name], rtol=1e-13, atol=1e-12, err_msg=name)


def test_a_chain_of_six_links_keeps_the_order():
    """Against itself at finer steps; and what the laws work is accounted for."""
    assert "step" not in operation_counts(resolve(with_memory(chain(6), "link5", 1e-3)))
    found = [run(with_memory(chain(6), "link5", h, 0.032)) for h in (1e-3, 5e-4, 2.5e-4)]
    for name in ("angular_velocity", "own.x", "last.y", "work"):
        a, b, c = (ds[name].values[0, -1] for ds in found)
        assert order([np.abs(a - b).max(), np.abs(b - c).max()]) == pytest.approx([4], abs=0.3), name
    assert order([abs(float(ds.energy_residual[0, -1])) for ds in found[:2]]) > 3.5
    assert abs(float(found[0].work[0, -1])) > 1e-3


def test_a_linkage_whose_rows_are_exchanged_carries_them_along():
    """What filters and samples of nothing but themselves do is known; the motion and the choice of rows stay."""
    data = linkage()
    free = run(data)
    data["model"]["forces"] = [
        own("decay", joints=["hinge1"], parameters={"lag": 0.3}, states={"x": 2.0}),
        own("counter", "asked", joints=["hinge1"], states={"count": 0, "last": -1}, every=0.05),
    ]
    ds = run(data)
    np.testing.assert_allclose(ds["own.x"], np.tile(2 * np.exp(-ds.time.values / 0.3), (20, 1)), rtol=1e-8)
    np.testing.assert_array_equal(ds["asked.count"], np.tile([1, 1, 2, 3, 4], (20, 1)))
    close(ds, free, "position", "angular_velocity", "energy", atol=1e-7)


# ---------------------------------------------------------------- bits
def sweep(runs: int) -> dict[str, Any]:
    vary = {
        "bodies.arm.mass": {"distribution": "normal", "std": 0.1},
        "forces.own.states.integral": {"distribution": "normal", "std": 1.0},
        "forces.own.parameters.kp": {"distribution": "uniform", "low": 10, "high": 50},
    }
    return pair(PID, MOTOR, end=0.1, sweep={"runs": runs, "seed": 4, "vary": vary})


def test_the_same_bits_alone_in_a_sweep_and_with_any_workers():
    data = sweep(21)
    whole = run(data)
    assert_same(run(data, workers=3), whole)
    labels = [17, 3]
    part = run(data, runs=labels)
    names = ("position", "rotation", "own.integral", "motor.torque", "work", "joint_force")
    for name in names:
        np.testing.assert_array_equal(part[name], whole[name].sel(run=labels), err_msg=name)
        np.testing.assert_array_equal(run(data, runs=[17])[name], whole[name].sel(run=[17]), err_msg=name)
    assert len(np.unique(whole["own.integral"][:, -1])) == 21
