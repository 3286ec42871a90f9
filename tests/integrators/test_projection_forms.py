"""The forms of the position projection: in the matrix elements, and as a chord method, on whole steps of the engine."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.integrators.tracing.program import Method, build
from lienumba.mechanics.system import kkt, projection
from lienumba.scenario.start.prepare import prepare
from tests.facade import Instant, resolve
from tests.mechanics.system.test_projection import COARSE, step, twin
from tests.oracles.reference import naive
from tests.oracles.reference.nearest import nearest
from tests.rigs import plain
from tests.rigs.places import SCENARIOS
from tests.rigs.scenarios import BENNETT, LOOP, PENDULUM, TOP, chain, scenario, simulate, start_of, state_at

FORMS = [("local", True), ("embedded", False), ("embedded", True)]  # beside the local one of full iterations
IDS = ["local-chord", "embedded", "embedded-chord"]


def misses(R: np.ndarray) -> float:
    return float(np.abs(R @ R.transpose(0, 2, 1) - np.eye(3)).max())


# ---------------------------------------------------------------- in the matrix elements
@pytest.mark.parametrize("name", COARSE)
def test_it_goes_to_the_papers_minimum(name: str) -> None:
    """A hundred times nearer than the local one, which is off by the third power of the correction."""
    mechanism, h = COARSE[name]
    _, joints, _ = twin(name)
    _, (r, R, v, w) = step(name, "none", "none")
    best = nearest(joints, r, R)
    off = {}
    for position in ("local", "embedded"):
        dataset = simulate(mechanism, h, h, method="heun", projection=(position, "none"), tolerance=1e-14)
        new_r, new_R, new_v, new_w = state_at(dataset)
        off[position] = max(np.abs(new_r - best[0]).max(), np.abs(new_R - best[1]).max())
        np.testing.assert_array_equal(new_v, v)
        np.testing.assert_array_equal(new_w, w)
    assert off["embedded"] < 1e-10 < off["local"]
    assert misses(new_R) < 4e-15
    assert np.abs(naive.residual(joints, new_r, new_R)).max() < 4e-15


def test_rotations_are_as_orthogonal_as_the_tolerance_says() -> None:
    mechanism, h = COARSE["loop"]
    found = []
    for tolerance in (1e-2, 1e-3, 1e-5, 1e-8, 1e-13):
        dataset = simulate(mechanism, h, h, method="heun", projection=("embedded", "none"), tolerance=tolerance)
        found.append((misses(state_at(dataset)[1]), int(dataset["position_iterations"][-1])))
        assert found[-1][0] <= tolerance
        assert float(dataset["position_violation"][-1]) <= tolerance
    assert found[0][0] > 1e-6  # loose ones do leave something
    assert [n for _, n in found] == sorted(n for _, n in found)


def test_rotations_do_not_drift() -> None:
    """The local form multiplies rotations, whose rounding adds up; this one asks for R R^T = I in every step."""
    off = {}
    for position in ("local", "embedded"):
        off[position] = misses(state_at(simulate(TOP, 1e-3, 4.0, projection=(position, "mass")))[1])
    assert off["embedded"] < 2e-15 < off["local"]


# ---------------------------------------------------------------- as a chord method
@pytest.mark.parametrize("position", ["local", "embedded"])
@pytest.mark.parametrize("name", COARSE)
def test_a_chord_leads_to_the_same_point(name: str, position: str) -> None:
    mechanism, h = COARSE[name]
    for tolerance, bound in ((1e-14, 1e-9), (1e-9, 1e-6)):
        keys: dict[str, Any] = {"method": "heun", "projection": (position, "none"), "tolerance": tolerance}
        full, chord = (simulate(mechanism, h, h, chord=chord, **keys) for chord in (False, True))
        for a, b in zip(state_at(full), state_at(chord), strict=True):
            np.testing.assert_allclose(b, a, rtol=0, atol=bound)
        assert float(chord["position_violation"][-1]) <= max(tolerance, 4e-15)
        assert int(chord["position_iterations"][-1]) >= int(full["position_iterations"][-1]) > 1


@pytest.mark.parametrize("name", COARSE)
def test_chords_have_the_same_limit_to_rounding_and_get_there_linearly(name: str) -> None:
    """A simplified one, by the Jacobian of q^ alone, would end elsewhere, by the square of the correction."""
    mechanism, h = COARSE[name]
    model, _ = start_of(scenario(mechanism, h, h))
    _, joints, _ = twin(name)
    _, state = step(name, "none", "none")
    hat: Any = tuple(tuple(body) for body in plain.rows(state).tolist())
    structure, mask = kkt.Structure.of(model), [1.0] * sum(naive.rows_of(joint) for joint in joints)
    x, now = [0.0] * (6 * len(hat)), hat
    for _ in range(12):
        x = projection.position_correction(model, structure, Instant(now), x, mask).x
        now = projection.placed(hat, x)
    first = projection.position_correction(model, structure, Instant(hat), [0.0] * len(x), mask)
    chord, mu, errors = first.x, first.mu, []
    for _ in range(12):
        errors.append(np.abs(np.subtract(chord, x)).max())
        again = projection.chord_correction(
            model, first.by, Instant(projection.placed(hat, chord)), chord, mu, mask
        )  # fmt: skip
        chord, mu = again.x, again.mu
    assert errors[-1] < 1e-15
    rates = np.divide(errors[1:4], errors[:3])
    assert (rates < 0.1).all()
    assert (rates > 1e-4).all()  # Newton's squares would be below


@pytest.mark.parametrize("position", ["local", "embedded"])
def test_a_chord_iteration_does_not_eliminate(position: str) -> None:
    """The numbers of the elimination are read, not computed again."""
    prepared = prepare(resolve(scenario(PENDULUM, 1e-3, 1e-3)), [0])
    full = build(prepared.model, Method("rk4", position, "mass"))
    chord = build(prepared.model, Method("rk4", position, "mass", chord=True))
    first, later = (chord.kernels[name].counts() for name in ("position", "chord"))
    assert "chord" not in full.kernels
    assert full.kernels["position"].counts() == first
    assert first["divide"] > 2
    if position == "embedded":  # in body axes there is little to save: much of the elimination is constant
        assert later["operations"] < 0.85 * first["operations"]
    assert later["divide"] == (0 if position == "local" else 2)  # of R^-T
    assert (full.sizes.chord, chord.sizes.chord > 20) == (0, True)


# ---------------------------------------------------------------- all of it, on all kinds of mechanisms
@pytest.mark.parametrize(("position", "chord"), FORMS, ids=IDS)
@pytest.mark.parametrize("name", COARSE)
def test_compiled_and_plain_python_agree(name: str, position: str, chord: bool) -> None:
    mechanism, h = COARSE[name]
    keys: dict[str, Any] = {"method": "heun", "projection": (position, "identity"), "chord": chord}
    python, most = plain.run(scenario(mechanism, h, 3 * h, **keys))
    dataset = simulate(mechanism, h, 3 * h, **keys)
    np.testing.assert_allclose(plain.rows(state_at(dataset)), python, rtol=0, atol=1e-11)
    assert (int(dataset["position_iterations"][-1]), int(dataset["velocity_iterations"][-1])) == most


@pytest.mark.parametrize(
    ("mechanism", "h", "end"),
    [(BENNETT, 4e-3, 0.4), (chain(5), 1e-2, 0.1), (LOOP, 1e-2, 0.2)],
    ids=["redundant", "large", "loop"],
)
def test_every_form_moves_alike(mechanism: dict[str, Any], h: float, end: float) -> None:
    """Redundant rows that are exchanged on the way, steps of many kernels, loops: up to what a step misses, cubed."""
    local = state_at(simulate(mechanism, h, end))
    dataset = simulate(mechanism, h, end, projection=("embedded", "mass"), chord=True)
    assert float(dataset["position_violation"].max()) < 1e-11
    assert misses(state_at(dataset)[1]) < 1e-11
    for a, b in zip(state_at(dataset), local, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-9)


def test_constraints_of_the_users_own_and_drivers() -> None:
    """A cam, whose profile is a function of its angle, off the rotations too."""
    file = SCENARIOS / "cam.toml"
    short = {"integrator.end_time": 0.1, "output": {"times": [0.0, 0.1]}}
    local, other = (lienumba.run(file, overrides=short | {"projection.position": x}) for x in ("local", "embedded"))
    assert int(other["position_iterations"].max()) >= 1
    for name in ("position", "rotation", "velocity"):
        np.testing.assert_allclose(other[name], local[name], rtol=0, atol=1e-12)
