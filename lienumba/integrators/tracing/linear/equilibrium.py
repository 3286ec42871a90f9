"""Equilibria and uniform rotations of all runs: Q - M a = C^T mu, Phi = 0, s' = 0.

By pseudo-transient continuation (Kelley, Keyes 1998, SIAM J. Numer. Anal. 35(2):508-523): implicit steps of a strongly
damped motion, sigma dq = Q - M a - C^T mu. sigma is so large that a step is at most `MAX_STEP` long. It is larger than
any negative curvature, so steps lead downhill, away from unstable equilibria. It falls with the forces, and the last
steps are Newton's. A step is halved where it leads to numbers that are not finite or far beyond the place where the
forces vanish, and ends where a stop or a contact closes (`supports`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lienumba.integrators.codes import FOUND, NONE_FOUND, UNSTABLE
from lienumba.integrators.tracing.linear.algebra import Array, applied, grows
from lienumba.integrators.tracing.linear.freedoms import GluedTracer
from lienumba.integrators.tracing.linear.steps import MAX_STEP, RATE_RTOL, Step, Stepping
from lienumba.integrators.tracing.linear.systems import STILL, States
from lienumba.mechanics.mechanism.kinematics import OFF
from lienumba.mechanics.mechanism.model import Model

MAX_STEPS = 400
MAX_IDLE = 60  # steps in a row without less force than ever before: the search is given up
MAX_STALLED = 5  # such steps, once forces are balanced: what is left is roundoff
STEP_GROWTH = 2.0  # of MAX_STEP, from step to step, while no force changes and a contact may close
STEP_TOL = 1e-13  # rad, and relative to the size: a shorter step of Newton's changes nothing
STALLED_TOL = 1e-6  # the same for steps after which the forces no longer fall
FORCE_RTOL = 1e-9  # relative to the largest force of the search: may be left
FIRST = 8  # steps
FIRST_RTOL = 1e-3  # relative to the largest forces of these, and their terms: more is left on a pole
STEADY_RTOL = 1e-6  # of the largest force and the speed: a uniform rotation may change by so much
TURNED = (1.0, 2.2)  # rad, by which a uniform rotation is turned to see whether it persists


@dataclass(frozen=True)
class Equilibria:
    """rows: of the states; status (runs,): FOUND, NONE_FOUND or UNSTABLE; force (runs,): the largest one left along a
    coordinate; growth (runs,): the largest real part of an eigenvalue (1/s), NaN where none was found."""

    rows: list[Array]
    status: Array
    force: Array
    growth: Array


def rest(
    tracer: GluedTracer, model: Model, rows: Sequence[Any], runs: int, rotation: Sequence[Any] = STILL,
    driven: bool = False,
) -> Equilibria:  # fmt: skip
    """Find the equilibria to which runs come from their states at t = 0.

    Parameters
    ----------
    tracer, model, rows, runs
        Of the mechanism, of a model with arrays (runs,); of the states.
    rotation : three floats or arrays (runs,)
        The angular velocity (rad/s, global) of axes through the origin. Positions are those at rest along these axes,
        and velocities those of the rotation.
    driven : bool
        Whether states at rest get the least velocities that the drivers of joints ask for.
    """
    return _Search(tracer, model, rows, runs, rotation).search(driven)


class _Search(Stepping):
    """holds (runs,): whether the contact law holds where a run came to rest; largest, first (runs,): the largest force
    so far, and of forces and their terms in the first steps; last, least (2, runs): force and restlessness of the last
    step, and the least ones so far; idle (runs,): the steps since."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.holds, self.idle = np.ones(self.runs, bool), np.zeros(self.runs)
        self.largest, self.first = np.zeros((2, self.runs))
        self.last, self.least = np.full((2, 2, self.runs), np.inf)

    def search(self, driven: bool) -> Equilibria:
        """All runs together, none of which sees another; those that rest, or never will, take no further part."""
        every = np.arange(self.runs)
        (done, still), left = np.zeros((2, self.runs), bool), np.full(self.runs, np.nan)
        for n in range(MAX_STEPS):
            which = every[~done & (self.idle < MAX_IDLE) & np.isfinite(self.state).all(axis=0)]
            if not len(which):
                break
            step = self.step(which)
            left[which], still[which] = step.force, step.still
            self.largest[which] = np.maximum(self.largest[which], step.force)
            if n < FIRST:
                self.first[which] = np.maximum(self.first[which], np.maximum(step.force, step.terms))
            fraction, met = self.move(which, step)
            done[which] = self._rests(which, step, fraction) & ~met
            changed = np.concatenate([which[met], self._released(which[done[which]])])
            done[changed] = False
            self._begin_again(changed)
        good = done & self.holds & (still | (left <= FORCE_RTOL * self.largest)) & (left <= FIRST_RTOL * self.first)
        which = every[good]
        good[which] = self._persists(which)
        which = every[good & ~self.turns]
        resting = self.state[:, which].copy()
        if self.model.drivers and len(which):
            self.state[:, which] = self.with_rates(resting, self.asked(resting, which))
        growth, unstable = self._growth(good)
        if not driven:
            self.state[:, which] = resting
        status = np.where(good, np.where(unstable, UNSTABLE, FOUND), NONE_FOUND)
        return Equilibria(list(self.state), status, left, growth)

    def _rests(self, which: Array, step: Step, fraction: Array) -> Array:
        """Whether runs rest behind a step of which they made this fraction."""
        now = np.array([step.force, step.restless])
        length = fraction * np.abs(step.dq / self.sizes[which]).max(axis=1, initial=0.0)
        falls, same = now < self.last[:, which], np.abs(now - self.last[:, which])[0] <= FORCE_RTOL * now[0]
        balanced = step.still | (step.force <= FORCE_RTOL * self.largest[which])
        stalled = (length < STALLED_TOL) | step.still | (self.idle[which] >= MAX_STALLED)
        settled = (length < STEP_TOL) | (~falls[0] & stalled)
        rests = (step.restless < RATE_RTOL) | (~falls[1] & (step.restless < STALLED_TOL))
        self.last[:, which] = now
        self.idle[which] = np.where((now < self.least[:, which]).any(axis=0), 0, self.idle[which] + 1)
        self.least[:, which] = np.minimum(self.least[:, which], now)
        flies = same & self.supports.may_close(which).any(axis=1)
        self.max_step[which] = np.where(flies, STEP_GROWTH * self.max_step[which], MAX_STEP)
        return settled & rests & balanced & step.newton & step.closed

    def _begin_again(self, which: Array) -> None:
        """Go on with other contacts."""
        self.idle[which], self.max_step[which] = 0, MAX_STEP
        self.last[:, which] = self.least[:, which] = np.inf
        self.support(which)

    # ---------------------------------------------------------------- at the end
    def _released(self, which: Array) -> Array:
        """The runs at rest of which a contact opens or slides, since the contact law does not hold it."""
        self.holds[which] = True
        which = which[(self.supports.on[:, which] != OFF).any(axis=0)]
        if not len(which):
            return which
        runs, D = len(which), self.sizes[which]
        state, motion = self.moving(self.state[:, which], which)
        a = np.zeros((runs, self.n)) if motion is None else motion.a
        at = self.at(state, a, np.zeros((runs, self.m)), which, self.masses)
        M = -at.dense("along", "a", runs) * D[:, :, None] * D[:, None, :]
        f, C = at.vector("along", runs) * D, self.scaled_rows(at, which)
        self.holds[which], changes = self.supports.stays(C, M, f, self.other_rank[which], which)
        return which[changes]

    def _persists(self, which: Array) -> Array:
        """Take over the velocities of the rotation. Whether these fulfil the constraints, and forces and the rates of
        laws are the same after it has turned (runs,); True at rest."""
        state, at, motion = self.evaluated(self.state[:, which], which, self.equations)
        self.state[:, which] = state
        if motion is None:
            return np.ones(len(which), bool)
        runs, rates = len(which), state[self.rates].T
        speed = np.linalg.norm(self.rotation[:, which], axis=0)
        unmet = np.abs(at.vector("rates", runs) / self.null_space(at, which).lengths).max(axis=1, initial=0.0)
        good = motion.carried.turns(self.tree, rates, STEADY_RTOL * speed) & (unmet <= STEADY_RTOL * speed)
        scale = self.first[which]
        for angle in TURNED:
            ahead = motion.carried.ahead(self.tree, rates, np.where(speed > 0.0, speed, 1.0), angle)
            later = self.moved(state, ahead, np.zeros((runs, self.tracer.laws)), which)
            _, there, _ = self.evaluated(later, which, self.equations)
            basis = self.null_space(there, which).basis
            along = applied(basis.mT, there.vector("along", runs) * self.sizes[which])
            good &= np.abs(along).max(axis=1, initial=0.0) <= STEADY_RTOL * scale
            change = np.abs(there.vector("laws", runs) - at.vector("laws", runs))
            good &= change.max(axis=1, initial=0.0) <= STEADY_RTOL * speed
        return good | ~self.turns[which]

    def _growth(self, good: Array) -> tuple[Array, Array]:
        """The largest real part (1/s) of the eigenvalues of the linear system that `lienumba.modes` shows, -inf without
        freedoms; and whether roundoff does not explain it. States of laws at a limit stay there."""
        growth, unstable = np.full(self.runs, np.nan), np.zeros(self.runs, bool)
        if not good.any():
            return growth, unstable
        states = States(good, 0.0, list(self.state), self.numbers)
        for system in self.linear.systems(states, tuple(self.rotation)):
            A, own = system.A.copy(), system.runs
            _, at, _ = self.evaluated(self.state[:, own], own, self.equations)
            rests = np.zeros(A.shape[:2], bool)
            rests[:, A.shape[1] - len(self.equations.outputs["laws"]) :] = at.vector("halted", len(own)) != 0.0
            fastest = 1.0 + np.abs(A).max(axis=(1, 2), initial=0.0)
            A[rests[:, :, None] | rests[:, None, :]] = 0.0
            A -= np.eye(A.shape[1]) * (rests * fastest[:, None])[:, None, :]
            values = self.linear.moving(replace(system, A=A)).eigenvalues()
            growth[own], unstable[own] = values.real.max(axis=1, initial=-np.inf), grows(values).any(axis=1)
        return growth, unstable
