"""What runs do beside their steps, with implicit ones: outputs between steps, events, neighbours, workers, replays,
and how a run ends whose stages cannot be solved."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba

BODY = {"mass": 1.0, "inertia": [0.1, 0.2, 0.3], "rotation": [1.0, 0.0, 0.0, 0.0]}


def servo(gain: float = 1e6, **more: Any) -> lienumba.System:
    """A pendulum that a motor holds, with stiff gains, to 0.5 sin(3 t)."""
    system = lienumba.System("servo")
    system.body("arm", position=[0.5, 0, 0], **BODY)
    system.joint("hinge", "revolute", ["ground", "arm"], at=[0, 0, 0], axis=[0, 1, 0])
    system.quantity("hinge", "joint", joint="hinge")
    value = f"{gain}*(0.5*sin(3*t) - hinge.angle) - {0.1 * gain}*hinge.rate"
    system.force("motor", type="actuator", joint="hinge", value=value)
    return system.integrator(method="radau5", coordinates="joint", tolerance=1e-6, end_time=2.0).output(every=0.1)


def wanted(t: np.ndarray) -> np.ndarray:
    """The angle of the servo: 0.1 q' + q = 0.5 sin(3 t), but for inertia and weight against the gain."""
    lag, w = 0.1, 3.0
    forced = 0.5 * (np.sin(w * t) - w * lag * np.cos(w * t)) / (1 + (w * lag) ** 2)
    return np.asarray(forced + 0.5 * w * lag / (1 + (w * lag) ** 2) * np.exp(-t / lag))


def test_a_motor_with_a_gain_of_a_million() -> None:
    found = lienumba.run(servo()).isel(run=0)
    assert int(found.status) == 0
    assert found.steps < 200  # explicit steps would be 2e-6 s
    np.testing.assert_allclose(found["hinge.angle"], wanted(found.time.values), rtol=0, atol=2e-5)


def test_events_come_when_they_should_and_end_runs() -> None:
    system = servo(1e8).event("up", when="hinge.angle > 0.3").event("back", when="hinge.rate < 0", action="stop")
    found = lienumba.run(system).isel(run=0)
    t = np.linspace(0, 2, 2_000_001)
    up = t[np.argmax(wanted(t) > 0.3)]
    back = t[np.argmax(np.diff(wanted(t)) < 0)]
    assert found.event_time.sel(event="up") == pytest.approx(up, abs=3e-6)
    assert found.event_time.sel(event="back") == pytest.approx(back, abs=3e-5)
    assert found.end_time == found.event_time.sel(event="back")


@pytest.mark.parametrize(("method", "order"), [("radau3", 3), ("radau5", 5)])
def test_what_lies_between_steps_is_of_the_order_of_the_polynomial(method: str, order: int) -> None:
    system = lienumba.System("top")
    system.body("b", position=[0, 0, -1], angular_velocity=[0.3, 1.0, 0.5], **BODY)
    system.joint("p", "spherical", ["ground", "b"], at=[0, 0, 0])
    system.integrator(method="dop853", tolerance=1e-12, end_time=1.0).output(times=list(np.linspace(0, 1, 78)))
    exact = lienumba.run(system).rotation
    errors = []
    for step in (0.1, 0.05):
        paced = {"tolerance": 0.1, "first_step": step, "max_step": step, "method": method}
        found = lienumba.run(system, overrides={f"integrator.{key}": x for key, x in paced.items()})
        errors.append(float(abs(found.rotation - exact).max()))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def test_runs_are_the_same_alone_on_any_workers_and_again(tmp_path: Any) -> None:
    vary = {"bodies.arm.mass": {"distribution": "uniform", "low": 0.5, "high": 2.0}}
    ways: dict[str, Any] = {"sweep": {"runs": 19, "seed": 5, "vary": vary}}
    lienumba.run(servo(1e4), overrides={"sweep": ways["sweep"] | {"runs": 5}}, output=tmp_path / "one.nc")
    one = lienumba.run(servo(1e4), overrides=ways, workers=1, output=tmp_path / "one.nc", resume=True)
    for n in (1, 2):
        lienumba.run(servo(1e4), overrides=ways, output=tmp_path / f"part{n}.nc", part=(n, 2))
    lienumba.merge([tmp_path / "part1.nc", tmp_path / "part2.nc"], tmp_path / "merged.nc")
    with xr.open_dataset(tmp_path / "merged.nc") as merged:
        np.testing.assert_array_equal(one.rotation.values, merged.rotation.values)
    two = lienumba.run(servo(1e4), overrides=ways, workers=2)
    np.testing.assert_array_equal(one.rotation.values, two.rotation.values)
    alone = lienumba.run(servo(1e4), overrides=ways, runs=[11])
    np.testing.assert_array_equal(one.rotation.values[11], alone.rotation.values[0])
    again = lienumba.replay(tmp_path / "one.nc", 11, every=0.1)
    np.testing.assert_array_equal(again.rotation.values[0], alone.rotation.values[0])


def test_a_force_that_jumps_against_the_motion_leaves_stages_that_cannot_be_solved() -> None:
    """A relay at rest: with no rate at the end of a step, however short, does its force lead there."""
    system = servo(1.0).force("relay", type="actuator", joint="hinge", value="where(hinge.rate > 0, -1e3, 1e3)")
    ways = {"integrator.tolerance": None, "integrator.step": 0.1, "integrator.end_time": 0.1}
    found = lienumba.run(system, overrides=ways)
    told = dict(zip(found.status.flag_values, found.status.flag_meanings.split(), strict=True))
    assert told[int(found.status[0])] == "stages_not_solved"
    assert float(found.end_time[0]) == 0.0
    assert (
        "stages_not_solved: the equations of an implicit step were not solved, also in much shorter steps; see whether "
        "a force jumps, or take an explicit method"
    ) in str(lienumba.analysis.summarise(found))


def test_a_step_that_is_made_in_parts_finds_the_motion() -> None:
    """Two bars that a damper makes nearly one. Where stages were not found in a step, it went on from a part of it by
    the whole rest, in 2 of 400 runs, here in one of 16, to stages that held but were no motion, as a success 0.03 m
    away."""
    axes, w = [[0, 1, 0], [0, 1, 0]], {"rate": -1.3}
    system = lienumba.System("bars").parameter("c", 1e6).parameter("g", 9.7)
    system.gravity = [0, 0, "-g"]
    system.body("a", mass=1.7, inertia=[0.04, 0.043, 0.01], rotation={"axis": [0, 1, 0], "angle": -0.7})
    system.body("b", mass=0.9, inertia=[0.026, 0.031, 0.008], rotation={"axis": [0, 1, 0], "angle": -0.25})
    system.joint("top", "revolute", ["ground", "a"], points=[[0, 0, 0], [0, 0, 0.27]], axes=axes, **w)
    system.joint("elbow", "revolute", ["a", "b"], points=[[0, 0, -0.35], [0, 0, 0.35]], axes=axes, rate=0)
    system.force("damper", type="spring_damper", bodies=["a", "b"], points=[[0.11, 0, -0.05], [-0.09, 0, 0.03]],
                 stiffness=0, damping="c")  # fmt: skip
    system.sweep(runs=400, seed=8).vary("parameters.c", "uniform", low=0.9e6, high=1.1e6)
    system.vary("parameters.g", "uniform", low=9.6, high=9.8)
    system.integrator(method="radau5", step=0.4, end_time=0.4).output(times=[0.4], variables=["position"])
    found = lienumba.run(system, runs=range(104, 120))
    fine = {"method": "radau5", "step": 0.02, "coordinates": "joint", "end_time": 0.4}
    motion = lienumba.run(system, runs=range(104, 120), overrides={"integrator": fine})
    assert (found.status == 0).all()
    assert (found.rejected_steps > 0).all()
    np.testing.assert_allclose(found.position, motion.position, rtol=0, atol=2e-4)  # of the method 5e-5
