"""The forms of the position projection in sweeps: lanes that need other iterations, and runs that fail."""

from typing import Any

import numpy as np
import pytest

from lienumba.batch import statuses
from tests.rigs.sweeps import assert_same, edit_samples, loop, run

ROCK = "bodies.left.angular_velocity[0]"
FORMS = [("local", True), ("embedded", False), ("embedded", True)]


def rocking(position: str, chord: bool, **keys: Any) -> dict[str, Any]:
    """Loops of which some need more iterations than others."""
    return loop(output={"every": 0.02}, projection={"position": position, "chord": chord, "tolerance": 1e-12, **keys})


@pytest.mark.parametrize(("position", "chord"), FORMS)
def test_a_run_alone_has_the_bits_that_it_has_among_others(
    position: str, chord: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = rocking(position, chord, max_iterations=20)
    edit_samples(monkeypatch, {3: {ROCK: 20.0}})
    every = run(data)
    assert (every["status"] == 0).all()
    needed = every["position_iterations"].isel(time=slice(1, None))
    assert (needed.max("run") > needed.min("run")).any()
    for label in (2, 3):
        assert_same(run(data, runs=[label]), every.sel(run=[label]))
    assert_same(run(data, workers=2), every)


@pytest.mark.parametrize(("position", "chord"), FORMS)
def test_too_few_iterations_end_the_run_alone_that_needs_more(
    position: str, chord: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    calm = run(rocking(position, chord))
    edit_samples(monkeypatch, {3: {ROCK: 20.0}})
    data = rocking(position, chord, max_iterations=int(calm["position_iterations"].max()))
    found = run(data)
    assert int(found["status"].sel(run=3)) == statuses.NOT_CONVERGED
    assert np.isnan(found["position"].sel(run=3).values[int(found["steps"].sel(run=3)) + 1 :]).all()
    assert_same(found.drop_sel(run=3), calm.drop_sel(run=3), without={"max_energy_drift"})


@pytest.mark.parametrize(("position", "chord"), FORMS)
def test_what_is_no_number_is_no_number_in_every_form(
    position: str, chord: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    edit_samples(monkeypatch, {5: {"gravity[0]": 1e200}})
    found = run(rocking(position, chord, max_iterations=20))
    assert int(found["status"].sel(run=5)) in (statuses.NON_FINITE, statuses.ROTATION)
    assert (found["status"].drop_sel(run=5) == 0).all()
