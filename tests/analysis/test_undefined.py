"""Quantities that have no value: the run says so, and which and when; its neighbours are good."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.analysis import summarise
from lienumba.batch.statuses import SUCCESS, UNDEFINED

FALL: dict[str, Any] = {  # z = 1 - 4.905 t^2 is below 0 from 0.45 s on
    "model": {"bodies": [{"name": "ball", "mass": 1, "inertia": [1, 1, 1], "position": [0, 0, 1]}]},
    "quantities": [
        {"name": "place", "type": "point", "body": "ball"},
        {"name": "root", "type": "expression", "value": "sqrt(place.z)"},
    ],
    "integrator": {"step": 0.01, "end_time": 0.6},
    "output": {"every": 0.1},
    "sweep": {"runs": 2, "vary": {"bodies.ball.position[2]": {"distribution": "uniform", "low": 0.9, "high": 2.5}}},
}


@pytest.fixture(scope="module")
def fallen() -> Any:
    return lienumba.run({**FALL, "sweep": {**FALL["sweep"], "runs": 8}})


def test_who_has_no_value_fails_and_nobody_else(fallen: Any) -> None:
    low = fallen["bodies.ball.position[2]"].values < 4.905 * 0.6**2
    assert 0 < low.sum() < 8
    assert np.array_equal(fallen["status"].values, np.where(low, UNDEFINED, SUCCESS))
    assert np.isfinite(fallen["position"]).all()
    assert np.isfinite(fallen["root"].values[~low]).all()
    assert (fallen["end_time"] == 0.6).all()


def test_the_summary_says_which_and_when(fallen: Any) -> None:
    run = int((fallen["status"].values == UNDEFINED).argmax())
    when = float(fallen["time"].values[np.isnan(fallen["root"].values[run]).argmax()])
    assert f"runs {run} (root at {when:g} s)" in str(summarise(fallen))


def test_what_nobody_keeps_fails_no_run() -> None:
    kept = {"every": 0.1, "variables": ["position"]}
    assert (lienumba.run({**FALL, "output": kept})["status"] == SUCCESS).all()


def test_reactions_beyond_all_numbers_are_no_success() -> None:
    far = {"bodies.ram.position[1]": 1e99, "joints.thread.axis[2]": 1e14}
    short = {"integrator": {"method": "rk4", "step": 1e-3, "end_time": 4e-3}, "output": {}}
    found = lienumba.run("scenarios/screw_press.toml", overrides={**far, **short})
    assert not np.isfinite(found["joint_torque"]).all()
    assert (found["status"] == UNDEFINED).all()
    assert np.isfinite(found["position"]).all()
    assert "(joint_" in str(summarise(found))


def test_what_is_summed_up_counts_too() -> None:
    summed = {"mode": "summary", "every": 0.1, "summary": {"root": ["final"]}}
    found = lienumba.run({**FALL, "output": summed, "sweep": {**FALL["sweep"], "runs": 8}})
    assert np.array_equal(found["status"].values == UNDEFINED, np.isnan(found["root_final"].values))
    assert 0 < (found["status"] == UNDEFINED).sum() < 8
    assert "(root_final)" in str(summarise(found))
