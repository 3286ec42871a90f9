"""Closed loops at and through positions where the constraints lose their rank: the N-four-bar, all bars in a line.

All its bars turn alike, so that it is one pendulum: w' = -G cos(phi) / J about the aligned position phi = 0.
"""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lienumba
from lienumba.batch.statuses import SINGULAR
from lienumba.scenario.start.prepare import check_initial
from tests.facade import resolve
from tests.rigs import parts

SLENDER = [1e-4, 1 / 12, 1 / 12]
GRAVITY = 9.81


def n_four_bar(n: int, angle: float, rate: float, step: float = 1e-3, end: float = 10.0) -> dict[str, Any]:
    """n parallelograms of unit bars, all revolutes about y; the angle of the bars counts from the aligned position."""
    c, s = float(np.cos(angle)), float(np.sin(angle))
    turned = {"axis": [0, 1, 0], "angle": -angle}
    bodies = [
        parts.body(f"b{i}", 1, SLENDER, position=[i + 0.5 * c, 0, 0.5 * s], rotation=turned,
                   angular_velocity=[0, -rate, 0])
        for i in range(n + 1)
    ]  # fmt: skip
    bodies += [parts.body(f"c{i}", 1, SLENDER, position=[i + c + 0.5, 0, s], rotation=[1, 0, 0, 0]) for i in range(n)]
    ends = [("ground", f"b{i}", [i, 0, 0]) for i in range(n + 1)]
    ends += [(f"b{i}", f"c{i}", [i + c, 0, s]) for i in range(n)]
    ends += [(f"c{i}", f"b{i + 1}", [i + 1 + c, 0, s]) for i in range(n)]
    joints = [parts.hinge(f"j{m}", b, at, to=a) for m, (a, b, at) in enumerate(ends)]
    return {
        "model": {"gravity": [0, 0, -GRAVITY], "bodies": bodies, "joints": joints},
        "integrator": {"step": step, "end_time": end},
        "output": {"every": end / 100},
    }


def angles(dataset: Any, body: str) -> np.ndarray:
    R = dataset.rotation.sel(body=body).isel(run=0).values
    return np.arctan2(-R[:, 2, 0], R[:, 0, 0])


def check(dataset: Any, n: int) -> None:
    assert (dataset.status == 0).all()
    assert float(dataset.max_energy_drift[0]) < 2e-8
    assert float(dataset.max_position_violation[0]) < 1e-12
    assert float(dataset.max_velocity_violation[0]) < 1e-10
    for i in range(n):
        np.testing.assert_allclose(dataset.angular_velocity.sel(body=f"c{i}"), 0.0, atol=1e-7)


@pytest.mark.parametrize(("n", "angle", "rate"), [(1, np.pi / 2, 1.0), (2, 0.3, 7.0)])
def test_passing_keeps_the_energy(n: int, angle: float, rate: float) -> None:
    dataset = lienumba.run(n_four_bar(n, angle, rate))
    check(dataset, n)
    passed = np.diff(np.sign(np.sin(angles(dataset, "b0"))))
    assert np.count_nonzero(passed) >= 4


@pytest.mark.parametrize(("n", "rate"), [(1, 3.0), (2, 0.5)])
def test_starting_there_goes_the_way_of_the_velocities(n: int, rate: float) -> None:
    from scipy.integrate import solve_ivp

    dataset = lienumba.run(n_four_bar(n, 0.0, rate, end=1.0))
    check(dataset, n)
    J, G = (n + 1) / 3 + n, GRAVITY * ((n + 1) / 2 + n)
    exact = solve_ivp(
        lambda t, y: [y[1], -G * np.cos(y[0]) / J], (0, 1), [0.0, rate], method="DOP853", rtol=1e-12, atol=1e-12,
        t_eval=dataset.time.values,
    )  # fmt: skip
    np.testing.assert_allclose(-dataset.angular_velocity.sel(body="b1", axis="y")[0], exact.y[1], atol=1e-8)


def test_the_rank_is_that_of_the_motion_not_of_the_singular_start() -> None:
    beside, there = (check_initial(resolve(n_four_bar(2, angle, 3.0))).rank for angle in (0.7, 0.0))
    assert (there.rank, there.freedom) == (beside.rank, beside.freedom) == (29, 1)


def test_every_run_of_a_sweep_passes_for_itself() -> None:
    """The same bits alone and among others, also where a run needs other rows and goes again."""
    data = n_four_bar(2, 0.0, 3.0, end=0.5)
    data["sweep"] = {
        "runs": 20,
        "vary": {
            "gravity[2]": {"distribution": "normal", "std": 3.0},
            "bodies.c0.mass": {"distribution": "normal", "std": 0.1},
        },
    }
    together = lienumba.run(data)
    assert (together.status == 0).all()
    assert float(together.max_energy_drift.max()) < 1e-7
    for label in (0, 13):
        alone = lienumba.run(data, runs=[label], workers=1)
        for name in ("position", "velocity", "joint_force", "energy_residual"):
            np.testing.assert_array_equal(alone[name].values[0], together[name].sel(run=label).values)


def test_a_driver_that_a_dead_point_lets_go_of_ends_the_run() -> None:
    """The slider of a stretched crank is held by its speed alone, of which C says nothing there."""
    bodies = [
        parts.body(name, 1.0, 0.01, position=[x, 0, 0], rotation=[1, 0, 0, 0])
        for name, x in (("crank", 0.05), ("rod", 0.2), ("slider", 0.3))
    ]
    joints = [
        parts.hinge("main", "crank"),
        parts.hinge("pin", "rod", [0.1, 0, 0], to="crank"),
        parts.hinge("end", "slider", [0.3, 0, 0], to="rod"),
        parts.joint("rail", "prismatic", "slider", at=[0.3, 0, 0], axis=[1, 0, 0]),
    ]
    model = {"bodies": bodies, "joints": joints, "drivers": [{"joint": "rail", "rate": 0}]}
    dataset = lienumba.run({"model": model, "integrator": {"step": 1e-3, "end_time": 0.2}})
    assert dataset.status.item() == SINGULAR
    assert dataset.end_time.item() < 0.1
    assert np.nanmax(dataset.velocity_violation) < 1e-5


def test_no_run_stops_dead_there() -> None:
    """With a tolerance steps may end so near to it that the loop could come out on a branch where it cannot move."""
    scenario = n_four_bar(2, np.pi / 2, 1.0, end=1.0)
    scenario["integrator"] = {"method": "dop853", "tolerance": 1e-11, "end_time": 1.0, "coordinates": "joint"}
    scenario["sweep"] = parts.sweep(16, {"gravity[2]": (-10, -9)}, seed=1)
    dataset = lienumba.run(scenario)
    assert (dataset.status == 0).all()
    assert np.abs(dataset.energy_residual.values).max() < 1e-7  # of 50 J


@pytest.mark.parametrize(
    ("method", "tolerance", "coordinates", "steps"),
    [("dop853", 1e-12, "lie", 300), ("dop853", 1e-12, "joint", 300), ("radau5", 1e-10, "joint", 600),
     ("radau9", 1e-12, "joint", 300)],
)  # fmt: skip
def test_sharp_tolerances_pass_with_their_own_accuracy(
    method: str, tolerance: float, coordinates: str, steps: int
) -> None:
    """Slow and fast, on the right branch; against the pendulum that the mechanism is."""
    ways = {"method": method, "tolerance": tolerance, "end_time": 0.8, "coordinates": coordinates}
    dataset, found = swinging({"distribution": "uniform", "low": -3.0, "high": 8.0}, 8, 0.2, ways)
    assert (dataset.status == 0).all()
    assert float(abs(dataset.energy_residual).max()) < 1e-8
    assert int(dataset.steps.max()) < steps
    for angle, rate in zip(found, dataset["joints.j0.rate"].values, strict=True):
        exact = pendulum(rate, dataset.time.values)
        assert exact.min() < -0.1
        np.testing.assert_allclose(angle, exact, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("method", "error"), [("radau9", 1e-12), ("generalized_alpha", 1e-5)])
def test_implicit_steps_of_given_length_that_would_end_there_are_made_in_parts(method: str, error: float) -> None:
    """Of each run a step would end within 1e-5 rad of the position, by what errors of the steps before let expect."""
    step, before = 5e-3, 31
    aims, off = np.array([1e-5, -1e-6, 1e-7, -1e-8, 1e-9, 0.0, -1e-5, 1e-6]), np.zeros(8)
    for steps in (before, before + 10):
        rates = [
            brentq(lambda rate, aim=aim: pendulum(rate, [0.0, step * (before + 1)])[-1] - aim, 0.0, 9.0, xtol=1e-15)
            for aim in aims - off
        ]
        ways = {"method": method, "step": step, "end_time": steps * step, "coordinates": "joint"}
        dataset, found = swinging({"column": "rate"}, len(aims), step, ways, {"rate": rates})
        errors = found - [pendulum(rate, dataset.time.values) for rate in rates]
        off = 2 * errors[:, -1] - errors[:, -2]
    assert (dataset.status == 0).all()
    assert (dataset.steps == before + 10).all()
    assert np.abs(errors).max() < error


def test_implicit_steps_that_have_to_end_there_end_the_run() -> None:
    """At the end of the run nothing says on which branch it is."""
    end = 0.16
    rates = [
        brentq(lambda rate, aim=aim: pendulum(rate, [0.0, end])[-1] - aim, 0.0, 9.0, xtol=1e-15)
        for aim in (1e-4, 1e-7, 0.0)
    ]
    ways = {"method": "radau9", "step": 5e-3, "end_time": end, "coordinates": "joint"}
    dataset, _ = swinging({"column": "rate"}, 3, end, ways, {"rate": rates})
    assert dataset.status.values.tolist() == [0, SINGULAR, SINGULAR]
    np.testing.assert_allclose(dataset.end_time, end, rtol=0, atol=1e-6)


def swinging(
    rate: dict[str, Any], runs: int, every: float, integrator: dict[str, Any], columns: dict[str, Any] | None = None
) -> tuple[Any, np.ndarray]:
    """One parallelogram from 0.6 rad on at these rates of its first joint; its angles (runs, times)."""
    data = n_four_bar(1, 0.6, 0.0)
    data["integrator"], data["output"]["every"] = integrator, every
    for body in data["model"]["bodies"]:
        body.pop("angular_velocity", None)
    data["model"]["joints"][0]["rate"] = 2.0
    data["sweep"] = {"runs": runs, "vary": {"joints.j0.rate": rate}}
    if columns is not None:
        data["sweep"] |= {"sampler": "table", "table": {"columns": columns}}
    dataset = lienumba.run(data)
    R = dataset.rotation.sel(body="b0").transpose("run", "time", ...).values
    return dataset, np.unwrap(np.arctan2(R[:, :, 2, 0], R[:, :, 0, 0]))


def pendulum(rate: float, times: Any) -> np.ndarray:
    """The angle that it has then."""
    pull = 2.0 * GRAVITY / (2 * (1 / 12 + 1 / 4) + 1)
    return solve_ivp(
        lambda t, y: [y[1], -pull * np.cos(y[0])], (0, times[-1]), [0.6, -rate], "DOP853", times,
        rtol=1e-13, atol=1e-14,
    ).y[0]  # fmt: skip
