"""Functions of arrays of runs in sampled laws: as the same laws for Numba; each run by itself."""

from pathlib import Path

import numpy as np
import pytest

import lienumba
from tests.facade import ScenarioError, resolve
from tests.laws import arrays
from tests.laws.rigs import close, pendulum, run
from tests.laws.test_jitted import arm, swinging
from tests.laws.test_libraries import calling

FILE = Path(__file__).with_name("arrays.py")


def test_a_controller_is_as_the_jitted_one():
    a, b = run(calling(arm(), f"{FILE}:pid")), run(arm())
    close(a, b, "position", "angular_velocity", "own.integral", atol=1e-13)
    np.testing.assert_array_equal(run(calling(arm(), arrays.pid)).position, a.position)


@pytest.mark.usefixtures("vectors")
def test_a_run_in_which_it_raises_fails_alone():
    """The others have the bits that they have without it, in whichever lane they are, and for any workers."""
    data = calling(swinging(every=0.02), f"{FILE}:motor")
    with pytest.warns(RuntimeWarning, match="limited raised ValueError: too far; the run fails"):
        whole = lienumba.run(data, workers=1)
    failed = whole.status.values != 0
    np.testing.assert_array_equal(whole.status, lienumba.run(swinging(every=0.02), workers=1).status)
    good = np.flatnonzero(~failed).tolist()
    with pytest.warns(RuntimeWarning):
        two = lienumba.run(data, workers=2)
    for ds in (two, run(data, runs=good[1:])):
        np.testing.assert_array_equal(ds.position, whole.position.sel(run=ds.run))


REFUSED = {
    "by_mean": "mean returns other numbers when it is called in another block of runs with equal arguments; let its",
    "by_limits": "of_first returns other numbers when it is called in another block of runs with equal arguments; let",
    "by_complex": "complex_torque returns complex numbers; return real ones",
    "by_first": "first returns other numbers when it is called in another block of runs with equal arguments; "
    "let its outputs depend on its arguments alone",
    "by_single": r"single must return 2 arrays of shape \(8,\), but returns shapes \[\(8,\)\]; return a number of each",
    "by_raising": "by_raising in .*raise KeyError",
}


@pytest.mark.parametrize("function", REFUSED)
def test_what_is_refused_is_refused_before_runs_begin(function):
    with pytest.raises(ScenarioError, match=f"model.forces.own: {REFUSED[function]}"):
        lienumba.run(calling(swinging(every=0.02), f"{FILE}:{function}"))


def test_its_law_is_sampled():
    rule = "calls limited, which gets the runs of a block at once, but is not sampled; give every, an interval in s"
    with pytest.raises(ScenarioError, match=f"model.forces.own: {rule}"):
        lienumba.run(calling(swinging(), f"{FILE}:motor"))
    with pytest.raises(ScenarioError, match=r"model\.forces\.own\.function.*: is a function for Numba or of arrays"):
        lienumba.run(calling(swinging(), f"{FILE}:limited"))


def test_its_law_reads_noise_and_tables():
    """Also when it is tried."""
    law = {"name": "own", "type": "python", "joints": ["hinge"], "every": 0.02, "parameters": {"gain": "late(t) + 2"}}
    noise = [{"name": "gust", "type": "band", "std": 0.4, "frequency": 1.5, "every": 0.02, "units": "N m"}]
    late = {"times": [0, 0.1, 1], "values": [0, 1, 0], "interpolation": "linear"}
    data = pendulum(law, end=0.2, noise=noise, tables={"late": late}, sweep={"runs": 3, "seed": 1})
    a, b = (run(calling(data, f"{FILE}:{function}")) for function in ("by_gust", "by_gust_traced"))
    close(a, b, "position", atol=1e-13)


def test_arrays_that_it_reads_are_part_of_the_scenario(monkeypatch):
    before = arrays.policy.identity()
    monkeypatch.setattr(arrays, "WEIGHTS", arrays.WEIGHTS * 2.0)
    assert arrays.policy.identity() != before
    data = calling(swinging(every=0.02), f"{FILE}:by_policy")
    sha = resolve(data).sha256()
    monkeypatch.setattr(type(arrays.policy), "identity", lambda self: "another")
    assert resolve(data).sha256() != sha
