"""Where a mechanism rests: Q = C^T mu, Phi = 0, s' = 0, for all runs at once.

By pseudo-transient continuation (Kelley, Keyes 1998, SIAM J. Numer. Anal. 35(2):508-523): implicit steps of a motion
that is damped so strongly that velocities follow forces, sigma dq = Q - C^T mu. While forces are large steps are
short and lead downhill, away from unstable equilibria; sigma falls with the forces, and the last steps are Newton's,
on the group of all joints with its constraints. A step is halved where it leads to what is not finite.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.integrators.tracing.linear.equations import Equations, Linear
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.tracer import Posture, split
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.system import constraints
from lienumba.numerics.number import Vector
from lienumba.numerics.operations import sqrt

Array = npt.NDArray[Any]
LONGEST = 0.2  # rad, and of the size of the mechanism: the most that a step moves
STEPS = 400
HALVINGS = 12
DONE = 1e-13  # rad, and of the size: a step of Newton's that is shorter changes nothing
ROUNDING = 1e-9  # of the largest force there was: what may be left where nothing falls any more
STILL = 1e-12  # rad, and of the size: how far forces may push in a step of Newton's where they are rounding
SLOW = 0.5  # of the sigma with which forces move as far as a step may be, if K does not hold them
DOWNHILL = 1.5  # times what a step takes that leads downhill
REDUNDANT = 1e-6  # of the largest singular value of the rows of C
SMALL = 1e-12  # of the largest singular value: what counts as 0


@dataclass(frozen=True)
class Resting:
    """rows: of the states; found (runs,): whether each rests there; left (runs,): the largest force along a freedom."""

    rows: list[Array]
    found: Array
    left: Array


class _Positions:
    """Phi of the rows in use."""

    inputs = 0

    def model(self, model: Model, t: Any, inputs: Sequence[Any]) -> Model:
        return model

    def outputs(self, model: Model, posture: Posture, mask: list[Any], used: Sequence[int]) -> dict[str, list[Any]]:
        residual = constraints.residual(model, posture.now)
        return {"positions": [mask[row] * residual[row] for row in used]}


def rest(tracer: FreedomTracer, model: Model, rows: Sequence[Any], runs: int) -> Resting:
    """The equilibria that runs (of a model with arrays) come to from these states, at t = 0, with all at rest."""
    try:
        return _Search(tracer, model, rows, runs).found()
    except np.linalg.LinAlgError:  # no decomposition has converged
        return Resting([np.full(runs, np.nan) for _ in rows], np.zeros(runs, bool), np.full(runs, np.nan))


class _Search:
    def __init__(self, tracer: FreedomTracer, model: Model, rows: Sequence[Any], runs: int) -> None:
        self.tracer, self.model, self.runs = tracer, model, runs
        self.equations = Equations.of(tracer, _Positions())
        self.state = np.array([np.broadcast_to(np.asarray(x, float), (runs,)) for x in rows])
        self.state[tracer.velocity_rows(tracer.graph()[1])] = 0.0
        self.numbers = split(model)[1]
        self.n, self.m = tracer.velocities, len(self.equations.used)
        self.laws = len(self.equations.columns["laws"])
        self.sizes = self._sizes()

    def _sizes(self) -> Array:
        """What a coordinate is small against (runs, n): 1 rad, or how large the mechanism is (m)."""
        tree, found = self.tracer.tree(self.tracer.graph()[1]), np.ones((self.runs, self.n))
        lent = with_lent_masses(self.model).bodies
        own = [sqrt(sum(body.inertia[:3]) / body.mass) for body in lent]
        reach = [abs(np.asarray(x)) for joint in self.model.joints for p in joint.points or () for x in p]
        every = [np.broadcast_to(np.asarray(x, float), (self.runs,)) for x in (*own, *reach)]
        size = np.max(every, axis=0)
        for link in tree.links:
            shifts = link.move.freedoms == 2 * 3
            for n, rate in enumerate(link.rates):
                if (shifts and n < 3) or not link.move.turns:
                    found[:, rate] = size
        return found

    def _at(self, state: Array, mu: Array, which: Array, equations: Equations) -> Linear:
        numbers = [x[which] if isinstance(x, np.ndarray) and x.shape == (self.runs,) else x for x in self.numbers]
        with np.errstate(all="ignore"):
            return equations.at(list(state), 0.0, [0.0] * self.n, list(mu.T), numbers.__getitem__)

    def _forces(self, state: Array, which: Array) -> Array:
        """Along all velocities, without reactions."""
        at = self._at(state, np.zeros((len(which), self.m)), which, replace(self.equations, entries={}))
        return at.vector("along", len(which))

    def found(self) -> Resting:
        """All runs together; those that rest take no further part."""
        every = np.arange(self.runs)
        mu = np.zeros((self.runs, self.m))
        done, left, worst = np.zeros(self.runs, bool), np.full(self.runs, np.nan), np.zeros(self.runs)
        last = np.full(self.runs, np.inf)
        for _ in range(STEPS):
            which = every[~done & np.isfinite(self.state).all(axis=0)]
            if not len(which):
                break
            step = self._step(which, mu[which])
            left[which] = step.force
            worst[which] = np.maximum(worst[which], step.force)
            moved = self._moved(which, step)
            mu[which] += step.dmu * moved[:, None]
            size = moved * np.abs(step.dq / self.sizes[which]).max(axis=1, initial=0.0)
            falls = step.force < last[which]
            last[which] = np.minimum(last[which], step.force)
            settled = (size < DONE) | (~falls & (size < np.sqrt(DONE)))
            done[which] = settled & (step.newton | (step.force <= ROUNDING * worst[which]))
        good = done & (left <= np.maximum(ROUNDING * worst, 1e-12))
        return Resting(list(self.state), good, left)

    def _step(self, which: Array, mu: Array) -> "_Step":
        runs, n, m, s = len(which), self.n, self.m, self.laws
        at = self._at(self.state[:, which], mu, which, self.equations)
        D, S = self.sizes[which], at.dense("along", "laws", runs)
        K = -at.dense("along", "q", runs) * D[:, None, :] * D[:, :, None]
        C, along = -at.dense("rows", "a", runs) * D[:, None, :], at.vector("along", runs) * D
        phi, rates = at.vector("positions", runs), at.vector("laws", runs)
        lengths = np.linalg.norm(C, axis=2, keepdims=True)
        lengths[lengths == 0.0] = 1.0
        C, phi = _independent(C / lengths, phi / lengths[:, :, 0])
        free = along - np.einsum("rij,rj->ri", np.linalg.pinv(C, SMALL) @ C, along) if m else along
        force = np.abs(free).max(axis=1, initial=0.0)
        falling, largest = _extremes(K, C)
        still = force <= STILL * largest  # what is left is rounding
        sigma = np.where(still, 0.0, np.maximum(SLOW * force / LONGEST, DOWNHILL * falling))
        scale = np.maximum(np.abs(K).max(axis=(1, 2), initial=0.0) + sigma, 1e-300)
        total = np.zeros((runs, n + m + s, n + m + s))
        total[:, :n, :n] = (K + sigma[:, None, None] * np.eye(n)) / scale[:, None, None]
        total[:, :n, n : n + m], total[:, n : n + m, :n] = C.transpose(0, 2, 1), C
        total[:, :n, n + m :] = -S * D[:, :, None] / scale[:, None, None]
        total[:, n + m :, :n] = -at.dense("laws", "q", runs) * D[:, None, :]
        total[:, n + m :, n + m :] = np.sqrt(sigma / scale)[:, None, None] * np.eye(s) - at.dense("laws", "laws", runs)
        right = np.concatenate([along / scale[:, None], -phi, rates], axis=1)
        x = _solve(total, right)
        dq, dmu = x[:, :n] * D, x[:, n : n + m] * scale[:, None] / lengths[:, :, 0]
        size = np.abs(dq / D).max(axis=1, initial=0.0)
        short = np.minimum(1.0, LONGEST / np.maximum(size, 1e-300))
        newton = sigma <= 1e-3 * largest
        return _Step(dq, dmu, x[:, n + m :], force, short, newton | still)

    def _moved(self, which: Array, step: "_Step") -> Array:
        """Move the states by as much of the step as leads to finite forces; how much that is."""
        runs, part, old = len(which), step.short.copy(), self.state[:, which]
        chart = self.tracer.chart_of(self._of(which))
        waiting = np.arange(runs)
        for _ in range(HALVINGS):
            u = [*(part * step.dq.T), *np.zeros((self.n, runs)), *(part * step.ds.T)]
            u += [np.zeros(runs)] * (chart.size - len(u))
            elements = self.tracer.tree(self.tracer.graph()[1]).state + self.tracer.laws
            with np.errstate(all="ignore"):
                moved = chart.settled(chart.moved(tuple(old[:elements]), tuple(u)))
            new = np.array([*(np.broadcast_to(np.asarray(x), (runs,)) for x in moved), *old[elements:]])
            bad = ~np.isfinite(new).all(axis=0)
            bad |= ~np.isfinite(self._forces(new, which)).all(axis=1)
            waiting = np.flatnonzero(bad)
            if not len(waiting):
                break
            part[waiting] *= 0.5
        self.state[:, which] = self._counted(new, which)
        return part

    def _of(self, which: Array) -> Model:
        """The model of these runs."""
        return map_numbers(
            self.model, lambda x, _: x[which] if isinstance(x, np.ndarray) and x.shape == (self.runs,) else x
        )

    def _counted(self, state: Array, which: Array) -> Array:
        """With the turns of joints counted on."""
        augmented = self.tracer.augmented
        if not augmented.angles:
            return state
        model, first = self._of(which), len(state) - augmented.rows
        posture = self.tracer.posture(model, [tuple(state[:first])], tuple(state[first:]), 0.0)
        for n, angle in enumerate(augmented.counted(model, posture.now)):
            state[first + n] = angle
        return state


@dataclass(frozen=True)
class _Step:
    """newton: whether the pseudo-transient part no longer counts; short: how much of it is not too long."""

    dq: Array
    dmu: Array
    ds: Array
    force: Array
    short: Array
    newton: Array


def _extremes(K: Array, C: Array) -> tuple[Array, Array]:
    """Of the symmetric part of K on what C leaves free: minus the least eigenvalue, or 0, and the largest absolute one.
    With a sigma above the first a step leads downhill."""
    good = np.isfinite(K).all(axis=(1, 2)) & np.isfinite(C).all(axis=(1, 2))
    falling, largest = np.zeros((2, len(K)))
    if good.any():
        free = np.eye(K.shape[1]) - np.linalg.pinv(C[good], SMALL) @ C[good]
        sizes = np.linalg.eigvalsh(free @ (0.5 * (K[good] + K[good].transpose(0, 2, 1))) @ free)
        largest[good] = np.abs(sizes).max(axis=1)
        falling[good] = np.maximum(-sizes[:, 0] - 1e-9 * largest[good], 0.0)
    return falling, largest


def _independent(C: Array, phi: Array) -> tuple[Array, Array]:
    """Without what redundant rows say only because the mechanism is not quite closed."""
    good = np.isfinite(C).all(axis=(1, 2))
    if C.shape[1] and good.any():
        U, sizes, V = np.linalg.svd(C[good], full_matrices=False)
        kept = np.where(sizes > REDUNDANT * sizes[:, :1], 1.0, 0.0)
        C, phi = C.copy(), phi.copy()
        C[good] = (U * (kept * sizes)[:, None, :]) @ V
        phi[good] = ((U * kept[:, None, :]) @ (U.transpose(0, 2, 1) @ phi[good, :, None]))[:, :, 0]
    return C, phi


def _solve(matrix: Array, right: Vector | Array) -> Array:
    """Least solutions; NaN where numbers are not finite."""
    right = np.asarray(right)
    found = np.full(right.shape, np.nan)
    good = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    if good.any():
        found[good] = (np.linalg.pinv(matrix[good], SMALL) @ right[good, :, None])[:, :, 0]
    return found
