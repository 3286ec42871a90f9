"""Panels that are let go and latch, 16 changes in each run, against minimal coordinates."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.panels import Course, deploy

CHAIN, Q, LATCH, LET_GO, END = scenarios.eight()
HINGES = range(8)


def known() -> Course:
    return deploy(CHAIN, Q, np.zeros(11), LATCH, LET_GO, END)


@pytest.fixture(scope="module")
def course() -> Course:
    return known()


@pytest.fixture(scope="module")
def dataset() -> Any:
    return lienumba.run(scenarios.panels(CHAIN, Q, LATCH, LET_GO, END)).isel(run=0)


def test_every_change_comes_when_minimal_coordinates_say(dataset: Any, course: Course) -> None:
    assert course.kinds.count("locked") == 8
    for t, hinge, kind in zip(course.times, course.hinges, course.kinds, strict=True):
        name = f"latch_{hinge}" if kind == "locked" else f"let_go_{hinge}"
        assert float(dataset.event_time.sel(event=name)) == pytest.approx(t, abs=1e-10)
    assert dataset.changes == 16
    np.testing.assert_allclose(dataset.change_time, course.times, rtol=0, atol=1e-10)
    np.testing.assert_allclose(dataset.change_energy, course.lost, rtol=0, atol=1e-8)


def test_the_end_is_that_of_minimal_coordinates(dataset: Any, course: Course) -> None:
    last = dataset.isel(time=-1)
    angles = [float(last[f"at_{i}.angle"]) for i in HINGES]
    np.testing.assert_allclose(angles, course.q[3:], rtol=0, atol=1e-11)
    np.testing.assert_allclose(last.position.sel(body="hub")[:2], course.q[:2], rtol=0, atol=1e-10)


def test_no_change_moves_a_momentum_or_loses_track_of_energy(dataset: Any, course: Course) -> None:
    moved = np.sqrt(2 * sum(CHAIN.m) * sum(course.lost))  # kg m/s, a size of what moved
    for kind in ("linear", "angular"):
        assert abs(dataset[f"momentum.{kind}"]).max() < 1e-13 * moved
    assert abs(dataset.energy_residual).max() < 1e-12 * sum(course.lost)
    np.testing.assert_allclose(dataset.energy_lost, sum(course.lost), rtol=1e-9)


def test_momenta_and_energy_follow_the_tolerance() -> None:
    """With scattered springs, at all times: what changes leave is the error of the method, not of the changes."""
    stiffness = CHAIN.stiffness * np.random.default_rng(4).uniform(0.9, 1.1, (24, 8))
    data = scenarios.panels(CHAIN, Q, LATCH, LET_GO, END)
    data["integrator"]["tolerance"] = 3e-14
    data["output"]["times"] = np.linspace(0, END, 21).tolist()
    data["sweep"] = scenarios.table({f"forces.spring_{i}.stiffness": stiffness[:, i] for i in HINGES})
    ds = lienumba.run(data)
    assert (ds.changes == 16).all()
    moved = np.sqrt(2 * sum(CHAIN.m) * ds.energy_lost)
    for kind in ("linear", "angular"):
        assert (abs(ds[f"momentum.{kind}"]).max(("time", "axis")) < 1e-13 * moved).all()
    assert (abs(ds.energy_residual).max("time") < 1e-13 * ds.energy_lost).all()


def test_steps_of_one_length_that_changes_cut_keep_the_order(course: Course) -> None:
    """Order 8, where errors scatter since changes cut steps anywhere: 3.4 times as many steps, 16,000 times as good."""
    errors = []
    for steps in (120, 404):
        data = scenarios.panels(CHAIN, Q, LATCH, LET_GO, END)
        data["integrator"] = {"method": "dop853", "step": END / steps, "end_time": END, "coordinates": "joint"}
        errors.append(np.abs(lienumba.run(data).change_time[0] - course.times).max())
    assert errors[1] < 1e-3 * errors[0] < 1e-8
