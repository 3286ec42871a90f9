"""Impulses of contacts: against all modes one by one, closed forms, and the laws themselves."""

import itertools
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lienumba.compiler.flat import Flat, compiled
from lienumba.compiler.routines.marks import Integers1
from lienumba.integrators.drivers.switching.complementarity import newton, solve
from lienumba.integrators.drivers.switching.problem import (
    BOUNDED,
    FREE,
    HOLDS,
    PARADOX,
    PRESSES,
    SLIDES,
    SOLVED,
    UNSOLVED,
    Problem,
)
from lienumba.integrators.layout import SWITCH_NUMBERS, SWITCH_SHARES


def problem(S: Any, free: Any, laws: list[tuple[float, int, int, float]], direction: Any = None) -> Problem:
    """laws: of each switch its law, rows, tangents, and friction or bound."""
    S, q, s = np.array(S, float), len(free), len(laws)
    switches, first = np.zeros((s, SWITCH_NUMBERS), np.int64), 0
    for n, (_, rows, tangents, _) in enumerate(laws):
        switches[n, 1:4] = first, rows, tangents
        switches[n, SWITCH_SHARES] = laws[n][0] in (PRESSES, SLIDES) and any(x[2] for x in laws)
        first += rows
    numbers = np.array([x[3] for x in laws])
    d = np.zeros(q) if direction is None else np.array(direction, float)
    return Problem(
        S, np.array(free, float), switches, np.array([float(x[0]) for x in laws]), numbers, numbers.copy(), d,
        np.zeros(q), np.zeros(q), np.zeros(q), np.zeros(q), np.zeros(q), np.zeros(q), np.zeros(q), np.zeros((q, q + 1)),
        np.zeros(s), np.zeros((4 * q, 4 * q + 2)), np.zeros((4 * q, 7)), np.zeros((2, 4 * q + 1)),
    )  # fmt: skip


def wrong(p: Problem) -> float:
    """How far the laws are from being fulfilled, relative to the impulses."""
    r, x, D = p.S @ p.x + p.free, p.x, np.diag(p.S)
    unit = max(abs(x).max(), (abs(p.free) / D).max())
    worst = 0.0
    for n, law in enumerate(p.law):
        first, rows, tangents = p.switches[n, 1:4]
        mine, t = slice(first, first + rows), slice(first + 1, first + 1 + tangents)
        if law == HOLDS:
            worst = max(worst, *abs(r[mine] / D[mine]))
        if law == BOUNDED:
            t, most = mine, p.bound[n]
        if law in (PRESSES, SLIDES):
            most = p.friction[n] * x[first]
            worst = max(worst, -x[first], -r[first] / D[first], min(x[first], r[first] / D[first]))
        if law == SLIDES:
            worst = max(worst, *abs(x[t] + most * p.direction[t]))
        elif law in (PRESSES, BOUNDED) and tangents:
            length = np.linalg.norm(x[t])
            worst = max(worst, length - most)
            slip = r[t] / D[t].mean()
            if most > 0.0:
                against = np.linalg.norm(slip + x[t] * np.linalg.norm(slip) / most)
                worst = max(worst, min(np.linalg.norm(slip), max(most - length, against)))
    return float(worst / unit)


def definite(random: np.random.Generator, q: int, rank: int | None = None) -> np.ndarray:
    J = random.normal(size=(q, rank or q))
    return J @ J.T


@settings(derandomize=True, max_examples=60)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_without_friction_as_one_of_all_modes(seed, contacts):
    random = np.random.default_rng(seed)
    S, free = definite(random, contacts), random.normal(size=contacts)
    p = problem(S, free, [(PRESSES, 1, 0, 0.0)] * contacts)
    assert solve(p) == SOLVED
    found = []
    for mode in itertools.product((False, True), repeat=contacts):
        on, x = np.array(mode), np.zeros(contacts)
        x[on] = np.linalg.solve(S[np.ix_(on, on)], -free[on])
        if (x >= 0).all() and (S @ x + free >= -1e-12 * abs(free).max()).all():
            found.append(x)
    np.testing.assert_allclose(p.x, found[0], rtol=1e-7, atol=1e-11 * abs(found[0]).max())
    assert wrong(p) < 1e-12


@settings(derandomize=True, max_examples=80)
@given(st.integers(0, 10**6), st.integers(1, 4), st.sampled_from([0.0, 0.05, 0.2, 0.4]), st.sampled_from([1.0, 0.5]))
def test_laws_of_all_kinds_hold_together(seed, contacts, mu, share):
    """A joint, joint friction and contacts; with fewer freedoms than rows they are redundant."""
    random = np.random.default_rng(seed)
    laws = [(HOLDS, 2, 0, 0.0), (BOUNDED, 1, 1, 0.3), (FREE, 1, 0, 0.0)]
    laws += [(PRESSES, 3, 2, mu)] * contacts
    q = 4 + 3 * contacts
    J = random.normal(size=(q, max(8, int(share * q))))
    J[4::3] *= 3.0  # normals that tangents hardly move: then there is a solution
    S = J @ J.T
    p = problem(S, J @ random.normal(size=J.shape[1]), laws)
    assert solve(p) == SOLVED
    assert wrong(p) < 1e-12
    assert p.x[3] == 0.0


def test_a_cradle_follows_the_rule_of_newton():
    """Three equal balls in a row, e = 1, hit by the first: all contacts at once, so that Newton's rule sends two balls
    off, and the first one back."""
    m, v = 1.0, np.array([1.0, 0.0, 0.0])
    J = np.array([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])
    before = J @ v
    p = problem(J @ J.T / m, before + 1.0 * before, [(PRESSES, 1, 0, 0.0)] * 2)
    assert solve(p) == SOLVED
    np.testing.assert_allclose(v + J.T @ p.x / m, [-1 / 3, 2 / 3, 2 / 3], atol=1e-15)


def table(load: tuple[float, float], push: float, mu: float) -> Problem:
    """A square table of mass 1 on four legs, pressed down and pushed: 12 rows of 6 freedoms."""
    corners = [(x, y, -1.0) for x in (-1.0, 1.0) for y in (-1.0, 1.0)]
    rows = []
    for c in corners:
        for axis in ((0, 0, 1), (1, 0, 0), (0, 1, 0)):
            rows.append([*axis, *np.cross(c, axis)])
    J, inverse = np.array(rows, float), np.diag([1, 1, 1, 2, 2, 2.0])
    force = np.array([push, 0, -9.81, -9.81 * load[1], 9.81 * load[0], 0])
    return problem(J @ inverse @ J.T, J @ inverse @ force, [(PRESSES, 3, 2, mu)] * 4)


def test_a_table_on_four_legs_stands_sticks_and_slides():
    p = table((0.2, 0.1), 3.0, 0.5)
    assert solve(p) == SOLVED
    assert p.x[0::3].sum() == pytest.approx(9.81, rel=1e-13)
    assert p.x[1::3].sum() == pytest.approx(-3.0, rel=1e-12)
    assert abs(p.rates).max() < 1e-12
    p = table((0.2, 0.1), 6.0, 0.5)
    assert solve(p) == SOLVED
    assert (p.rates[1::3] > 0.5).all()
    assert wrong(p) < 1e-12
    p = table((1.2, 0.0), 0.0, 0.5)  # it falls over an edge
    assert solve(p) == SOLVED
    assert (p.rates[[0, 3]] > 1e-3).all()


def test_a_rod_that_friction_pushes_into_the_floor():
    """Painleve's: a rod of length 2 slides on its end at the angle a; beyond mu = 4/3 nothing fits any more."""
    a = np.arctan(2.0)
    n, t = np.array([0, 1, -np.cos(a)]), np.array([1, 0, np.sin(a)])
    J, inverse = np.array([n, t]), np.diag([1, 1, 3.0])
    S = J @ inverse @ J.T
    critical = S[0, 0] / -S[0, 1]
    for mu, expected in ((0.9 * critical, SOLVED), (1.1 * critical, PARADOX)):
        p = problem(S, [-9.81, 0.0], [(SLIDES, 2, 1, mu)], [0.0, -1.0])
        assert solve(p) == expected
    p = problem(S, [-9.81, 0.0], [(SLIDES, 2, 1, 0.9 * critical)], [0.0, 1.0])
    assert solve(p) == SOLVED
    assert p.x[0] == pytest.approx(9.81 / (S[0, 0] - 0.9 * critical * S[0, 1]), rel=1e-14)


def impact(seed: int, rough: float) -> Problem:
    """A body is hit at up to six points at once, some of them with this coefficient."""
    random = np.random.default_rng(seed)
    contacts = int(random.integers(1, 7))
    M = np.diag([1, 1, 1, *random.uniform(0.3, 2.0, 3) / 0.4])
    rows: list[Any] = []
    for _ in range(contacts):
        p, n = random.uniform(-1, 1, 3), random.normal(size=3)
        n /= np.linalg.norm(n)
        n = -n if n @ p > 0 else n
        rows += [[*a, *np.cross(p, a)] for a in (n, *np.linalg.svd(n[None])[2][1:])]
    J, v, mu = np.array(rows), random.normal(size=6), random.uniform(0, 2, contacts)
    mu = np.where(random.random(contacts) < 0.5, rough, mu)
    return problem(J @ M @ J.T, J @ v, [(PRESSES, 3, 2, float(x)) for x in mu])


@pytest.mark.parametrize("seed", [2, 4, 20, 51, 59, 74, 76, 85])
def test_where_newtons_method_needs_a_start(seed: int) -> None:
    """Coefficients of 1,000: it diverges from rest."""
    assert newton(impact(seed, 1e3)) == UNSOLVED
    p, said = impact(seed, 1e3), np.zeros(1, np.int64)
    machine_code()(p, said)
    assert said[0] == SOLVED
    assert wrong(p) < 1e-12


def _entry(p: Problem, said: Integers1) -> None:
    said[0] = solve(p)


@cache
def machine_code() -> Flat:
    return compiled(_entry)


def test_compiled_as_plain():
    random = np.random.default_rng(5)
    laws = [(HOLDS, 2, 0, 0.0), (BOUNDED, 1, 1, 0.3), (PRESSES, 3, 2, 0.3), (SLIDES, 3, 2, 0.1)]
    direction, fast = np.array([0, 0, 0, 0, 0, 0, 0, 0.6, 0.8]), machine_code()
    for share in (9, 6):
        S, free = definite(random, 9, share), random.normal(size=9)
        S[3::3] *= 3.0
        S[:, 3::3] *= 3.0
        p, again, said = problem(S, free, laws, direction), problem(S, free, laws, direction), np.zeros(1, np.int64)
        assert solve(p) == SOLVED
        fast(again, said)
        assert said[0] == SOLVED
        np.testing.assert_array_equal(p.x, again.x)


def test_forces_that_nearly_cancel_are_found_within_their_rounding() -> None:
    """Rows that say the same of a body on which loads of 10 N leave 1e-4 m/s^2: what rounding of the loads leaves of
    them contradicts itself, by more than `CLOSE` of the forces that are left."""
    c = np.array([0.08, 0.06, 0.77])
    p = problem(np.outer(c, c), 1e-4 * c + [5e-15, -5e-15, 0.0], [(HOLDS, 1, 0, 0.0)] * 3)
    assert solve(p) == UNSOLVED
    p.x[:], p.least[:] = 0.0, 10.0
    assert solve(p) == SOLVED
    np.testing.assert_allclose(p.S @ p.x + p.free, 0.0, atol=1e-13)
