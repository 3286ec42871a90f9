"""Random mechanisms against an engine that shares nothing with lienumba; `scripts/fuzz_mechanisms` does many more."""

import copy
from typing import Literal

import numpy as np
import pytest

import lienumba
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.forces.built_in import Drag
from tests.oracles.mechanisms.comparing import BOUND, RESIDUAL, compare
from tests.oracles.mechanisms.drawing import mechanism, unknown
from tests.oracles.mechanisms.engine import Mechanism, SingularError
from tests.oracles.mechanisms.places import exp, log

SEEDS = (2, 12, 13, 14, 24, 29)


def test_the_engine_knows_every_element() -> None:
    """A new one wants its few lines of mechanics here, or a word in ELSEWHERE where another oracle has it."""
    assert not unknown()


def test_what_it_does_not_know_is_named() -> None:
    class Wind(Drag):
        type: Literal["wind"]  # type: ignore[assignment]

    with FORCES.temporarily(Wind):
        assert unknown() == {"forces": {"wind"}}


@pytest.mark.parametrize("seed", SEEDS)
def test_both_see_the_same(seed: int) -> None:
    found = compare(mechanism(seed))
    assert found.status == 0
    assert found.worst < BOUND, found.deviations
    assert found.residual < RESIDUAL


@pytest.mark.campaign(8)
def test_both_see_the_same_in_new_mechanisms(seed: int) -> None:
    try:
        found = compare(mechanism(seed))
    except (SingularError, lienumba.ScenarioError) as error:
        pytest.skip(f"not compared: {type(error).__name__}")
    assert (found.status, found.worst < BOUND, found.residual < RESIDUAL) == (0, True, True), found


def test_a_wrong_number_would_show() -> None:
    data = mechanism(SEEDS[0])
    other = copy.deepcopy(data)
    other["model"]["bodies"][0]["mass"] *= 1.0 + 1e-5
    here, there = (Mechanism(x["model"]) for x in (data, other))
    a, b = (m.motion(m.start, 0.0).accelerations for m in (here, there))
    assert np.abs(a - b).max() > 1e2 * BOUND


def test_the_engine_swings_a_pendulum() -> None:
    """A rod on a hinge: the angular acceleration, the period's energy, and the reaction at the turning point."""
    m, length, g = 2.0, 0.6, 9.81
    J = m * length**2 / 12
    tilt = exp(np.array([0.0, 0.7, 0.0]))
    body = {
        "name": "rod", "mass": m, "inertia": np.diag([J, J, 1e-3]).tolist(), "rotation": tilt.tolist(),
        "position": (tilt @ [0.0, 0.0, -length / 2]).tolist(),
    }  # fmt: skip
    hinge = {"name": "h", "type": "revolute", "bodies": ["ground", "rod"], "points": [[0, 0, 0], [0, 0, length / 2]]}
    hinge |= {"axes": [[0, 1, 0], [0, 1, 0]], "references": [[1, 0, 0], [1, 0, 0]]}
    engine = Mechanism({"bodies": [body], "joints": [hinge], "gravity": [0, 0, -g]})
    first, last = engine.run([0.0, 0.5])
    assert first.accelerations[4] == pytest.approx(
        -m * g * length / 2 * np.sin(0.7) / (J + m * length**2 / 4), rel=1e-12
    )
    fallen = last.state.r[0, 2] - first.state.r[0, 2]
    assert engine.kinetic(last) == pytest.approx(-m * g * fallen, rel=1e-9)
    assert log(last.state.R)[0, 1] != pytest.approx(0.7, abs=0.1)
