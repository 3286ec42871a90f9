"""Steps of the search for an equilibrium: strongly damped at first, Newton's at last.

In independent coordinates y (see `NullSpace`) and changes ds of the states of laws a step solves

    (K + sigma N^T N) y - S ds = N^T f,    -L y + (tau - P) ds = s',

with the forces f = Q - M a - C^T mu, the stiffness K and the other derivatives where it begins. sigma damps
coordinates, and tau = sqrt(sigma/(K + sigma)) states of laws; both vanish with the forces.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lienumba.integrators.tracing.linear.algebra import Array, NullSpace, applied, is_finite
from lienumba.integrators.tracing.linear.balance import Balance, by_places

MAX_STEP = 0.2  # rad, and relative to the size of the mechanism
MAX_HALVINGS = 12
OVERSHOOT = 0.5  # of the force along a step: as much may oppose it at its end
POLE = 4.0  # times the forces at both ends of a step: as much on the way shows a pole
ON_THE_WAY = 0.38, 0.72  # of a step
DAMPING = 0.5  # of the sigma with which a step without stiffness is MAX_STEP long
CURVATURE = 1.5  # times a negative curvature
NEWTON = 1e-3  # of the stiffness: with a smaller sigma a step is Newton's
STILL_RTOL = 1e-12  # relative to the terms of a force: a smaller one is roundoff
ENTRY_RTOL = 1e-14  # the same of an entry of the stiffness
PIVOT_RTOL = 1e-13  # relative to the largest singular value of the scaled equations: a smaller one is zero
RATE_GROWTH = 4.0  # times the largest rate of a law's state so far: a step makes none larger
RATE_RTOL = 1e-10  # relative to the terms of the rate of a law's state: a smaller one is roundoff
CLOSED_TOL = 1e-9  # rad, and relative to the size: joints may be open by so much


@dataclass(frozen=True)
class Step:
    """dq, ds: of coordinates and of states of laws; force, terms: the largest force at its start, and the largest terms
    of one; restless: the largest rate of a state of a law, relative to its terms; still: whether the forces are
    roundoff; newton: whether it is a step of Newton's; closed: whether the joints are closed at its start; push: the
    work of the forces at its start along it; most: the fraction that is not too long."""

    dq: Array
    ds: Array
    force: Array
    terms: Array
    restless: Array
    still: Array
    newton: Array
    closed: Array
    push: Array
    most: Array


@dataclass(frozen=True)
class _Linearised:
    """The equations where a step begins, in independent coordinates; force_terms, rate_terms: how large the numbers are
    that forces (runs, n) and rates (runs, s) are sums of; closing (runs, n): what closes the joints."""

    space: NullSpace
    force: Array
    K: Array
    S: Array
    L: Array
    P: Array
    rates: Array
    force_terms: Array
    rate_terms: Array
    closing: Array


class Stepping(Balance):
    """max_step (runs,): the longest step; fastest (runs, s): the largest rates of laws' states so far."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.max_step = np.full(self.runs, MAX_STEP)
        self.fastest = np.zeros((self.runs, len(self.equations.outputs["laws"])))

    def step(self, which: Array) -> Step:
        """The next step of these runs. Forces that are roundoff move nothing, as long as others do."""
        at = self._linearised(which)
        roundoff = np.abs(at.force) <= STILL_RTOL * at.force_terms
        still: Array = np.asarray(roundoff.all(axis=1))
        force = np.where(roundoff & ~still[:, None], 0.0, at.force)
        pair = np.sqrt(at.force_terms[:, :, None] * at.force_terms[:, None, :])
        K = np.where(np.abs(at.K) <= ENTRY_RTOL * pair, 0.0, at.K)
        driving = np.abs(force).max(axis=1, initial=0.0)
        sigma = np.maximum(DAMPING * driving / self.max_step[which], -CURVATURE * _lowest(K))
        sigma = np.where(still, 0.0, sigma)
        restless = np.abs(at.rates) / np.maximum(at.rate_terms, 1e-300)
        A = self._damped(at, K, sigma, restless < RATE_RTOL)
        x = _solved(A, np.concatenate([force, at.rates], axis=1))
        y, ds = x[:, : self.n], x[:, self.n :]
        dq = at.closing + applied(at.space.basis, y)
        length = np.abs(dq).max(axis=1, initial=0.0)
        return Step(
            dq * self.sizes[which], ds,
            force=np.abs(at.force).max(axis=1, initial=0.0), terms=at.force_terms.max(axis=1, initial=0.0),
            restless=restless.max(axis=1, initial=0.0), still=still,
            newton=still | (sigma <= NEWTON * np.abs(K).max(axis=(1, 2), initial=0.0)),
            closed=np.abs(at.closing).max(axis=1, initial=0.0) <= CLOSED_TOL,
            push=((force + applied(at.S, ds)) * y).sum(axis=1),
            most=np.minimum(1.0, self.max_step[which] / np.maximum(length, 1e-300)),
        )  # fmt: skip

    def _linearised(self, which: Array) -> _Linearised:
        """The equations where these runs are, with the multipliers of this place."""
        runs, D = len(which), self.sizes[which]
        state, at, _ = self.evaluated(self.state[:, which], which, self.masses)
        space = self.null_space(at, which)
        N, Nt = space.basis, space.basis.mT
        self.mu[which] += applied(space.inverse.mT, at.vector("along", runs) * D)
        state, at, motion = self.evaluated(self.state[:, which], which, self.equations)
        closing = applied(space.inverse, -at.vector("positions", runs))
        slopes = by_places(at, "along", motion, runs) * D[:, None, :] * D[:, :, None]
        force = applied(Nt, at.vector("along", runs) * D + applied(slopes, closing))
        K, S = -Nt @ slopes @ N, Nt @ (at.dense("along", "laws", runs) * D[:, :, None])
        L, P = (by_places(at, "laws", motion, runs) * D[:, None, :]) @ N, at.dense("laws", "laws", runs)
        M = -at.dense("along", "a", runs) * D[:, :, None] * D[:, None, :]
        swing = self.swing[which] + (self.rotation[:, which] ** 2).sum(axis=0)
        laws = np.abs(self.state[self.tree.state : self.tree.state + P.shape[1], which].T)
        force_terms = np.abs(K).max(axis=2, initial=0.0) + applied(np.abs(S), laws)
        force_terms += space.masses(M).diagonal(axis1=1, axis2=2) * swing[:, None]
        force_terms += np.abs(S @ _inverse(P) @ L).max(axis=2, initial=0.0)
        rate_terms = np.abs(L).sum(axis=2) + applied(np.abs(P), laws)
        rate_terms += applied(np.abs(at.dense("laws", "v", runs)), np.abs(state[self.rates].T))
        rates = at.vector("laws", runs)
        self.fastest[which] = np.maximum(self.fastest[which], np.maximum(np.abs(rates), RATE_RTOL * rate_terms))
        return _Linearised(space, force, K, S, L, P, rates, force_terms, rate_terms, closing)

    def _damped(self, at: _Linearised, K: Array, sigma: Array, rests: Array) -> Array:
        """The matrix of a step. A state of a law that rests (runs, s), and on which no rate depends, takes what the
        forces ask for."""
        n, s, N = self.n, at.P.shape[1], at.space.basis
        A = np.zeros((len(N), n + s, n + s))
        A[:, :n, :n], A[:, :n, n:] = K + sigma[:, None, None] * (N.mT @ N), -at.S
        A[:, n:, :n], A[:, n:, n:] = -at.L, -at.P
        idle = rests & (np.abs(A[:, n:]) <= RATE_RTOL * at.rate_terms[:, :, None]).all(axis=2)
        tau = np.sqrt(sigma / np.maximum(np.abs(K).max(axis=(1, 2), initial=0.0) + sigma, 1e-300))
        A[:, n:, n:] += tau[:, None, None] * np.eye(s)
        A[:, n:][idle] = 0.0
        return A

    def move(self, which: Array, step: Step) -> tuple[Array, Array]:
        """Move by as much of the step as is allowed; the fraction, and whether a contact closed (runs,)."""
        runs, part, old = len(which), step.most.copy(), self.state[:, which]
        for _ in range(MAX_HALVINGS):
            new = self.moved(old, part[:, None] * step.dq, part[:, None] * step.ds, which)
            _, at, _ = self.evaluated(new, which, self.forces)
            force, rates = at.vector("along", runs), at.vector("laws", runs)
            bad = ~np.isfinite(new).all(axis=0) | ~np.isfinite(force).all(axis=1)
            bad |= ~(np.abs(rates) <= RATE_GROWTH * self.fastest[which]).all(axis=1)
            ahead = (force * step.dq).sum(axis=1)
            bad |= ((ahead < -OVERSHOOT * step.push) | self._leaps(old, part, step, ahead, which)) & ~step.newton
            if not bad.any():
                break
            part[bad] *= 0.5
        met: Array = np.zeros(runs, bool)
        if self.supports.switches:
            none = np.zeros((runs, self.n))
            before, after = (
                self.at(x, none, self.mu[which], which, self.gaps).vector("gaps", runs) for x in (old, new)
            )
            fraction, closes = self.supports.meets(before, after, which)
            met = np.asarray(closes.any(axis=1))
            if met.any():
                part *= fraction
                self.supports.close(closes, which)
                new = self.moved(old, part[:, None] * step.dq, part[:, None] * step.ds, which)
        self.state[:, which] = self.counted(new, which)
        return part, met

    def _leaps(self, old: Array, part: Array, step: Step, ahead: Array, which: Array) -> Array:
        """Whether steps lead over a pole, with much more force on the way than at both ends (runs,)."""
        most, leaps = POLE * np.maximum(np.abs(ahead), np.abs(step.push)), np.zeros(len(which), bool)
        for fraction in ON_THE_WAY:
            to = fraction * part[:, None]
            _, at, _ = self.evaluated(self.moved(old, to * step.dq, to * step.ds, which), which, self.forces)
            leaps |= ~(np.abs((at.vector("along", len(which)) * step.dq).sum(axis=1)) <= most)
        return leaps & (step.ds == 0.0).all(axis=1)


def _lowest(K: Array) -> Array:
    """The lowest curvature (runs,): the smallest eigenvalue of the symmetric part, at most 0."""
    symmetric = np.where(is_finite(K)[:, None, None], 0.5 * (K + K.mT), 0.0)
    lowest: Array = np.linalg.eigvalsh(symmetric).min(axis=1, initial=0.0)
    return lowest


def _inverse(A: Array) -> Array:
    """The pseudo-inverses of finite matrices, else 0."""
    return np.linalg.pinv(np.where(is_finite(A)[:, None, None], A, 0.0))


def _solved(A: Array, b: Array) -> Array:
    """Solve A x = b, with rows and columns of one size; directions in which A is singular do not move."""
    bad = ~is_finite(A, b)
    A, b = np.where(bad[:, None, None], 0.0, A), np.where(bad[:, None], 0.0, b)
    rows = np.abs(A).max(axis=2, initial=0.0)
    rows = np.where(rows > 0.0, rows, 1.0)
    A = A / rows[:, :, None]
    columns = np.abs(A).max(axis=1, initial=0.0)
    columns = np.where(columns > 0.0, columns, 1.0)
    x = applied(np.linalg.pinv(A / columns[:, None, :], PIVOT_RTOL), b / rows) / columns
    x[bad] = np.nan
    return x
