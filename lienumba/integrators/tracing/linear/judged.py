"""Whether what rests, or turns, may be called an equilibrium, and of which kind: what is found is looked at again."""

from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import Rows, product, turned, unit_rows
from lienumba.integrators.codes import FOUND, NONE_FOUND, NOT_ISOLATED, UNSTABLE
from lienumba.integrators.tracing.linear.balance import Balance, Motion
from lienumba.integrators.tracing.linear.equations import Linear
from lienumba.integrators.tracing.linear.rounding import scale
from lienumba.integrators.tracing.linear.stability import Near, stability

Array = npt.NDArray[Any]
CLOSED = 1e-9  # rad, and of the size: by how much joints may miss each other
STEADY = 1e-6  # of the largest force there was, and of the speed: what a steady motion may change in a radian
EXACT = 1e-10  # of the terms of a sum that is 0 but for rounding
AHEAD = (1.0, 2.2)  # rad, by which it turns: where a force that turns beside it may have no slope, it has another size


class Judged(Balance):
    """Of states that a search has come to."""

    def judged(self, which: Array, worst: Array) -> tuple[Array, Array, Array]:
        """Of runs whose forces are balanced the status, the growth and what is left of their forces; their states move
        as they should from now on. worst (runs,): the largest force there was."""
        state, at, motion = self.looked(self.state[:, which], which, self.equations)
        self.state[:, which] = state
        rows, lengths = self.rows_of(at, which)
        sums = self.sums(at, state, motion, which)
        lasts = self._lasts(state, at, motion, rows, lengths, which, worst, sums)
        gamma = np.zeros((len(which), self.n, self.n)) if motion is None else motion.carried.rates_by
        lambda_ = np.zeros_like(gamma) if motion is None else motion.carried.shifts_by

        def of_forces(own: Array) -> dict[str, Array]:
            some = which[own]
            every, D = self.summed(state[:, own], motion and motion.part(own), some, self.terms), self.sizes[some]
            return {by: every.dense("along", by, len(some)) * D[:, None, :] * D[:, :, None] for by in ("q", "v")}

        fast = scale(sums, at, state[self.rates].T, self.sizes[which])
        near = Near(
            at, fast, of_forces, rows, self.rows_of(at, which, self.held)[0],
            {by: at.dense("rows", by, len(which)) / lengths[:, :, None] for by in ("q", "v")},
            at.dense("rates", "q", len(which)) / lengths[:, :, None], self.sizes[which], gamma, lambda_,
        )  # fmt: skip
        found = stability(near)
        drifts = found.zeros > 0
        if motion is not None and drifts.any():
            held = near.held(unit_rows(self.sized(at, which))[0], self.held, state[self.rates].T)
            turns = held.places.rank > near.places.rank  # of which one says how far
            drifts &= ~self.turns[which] | ((found.zeros > turns) & (stability(held).zeros > 0))
        status = np.where(found.grows, UNSTABLE, np.where(drifts, NOT_ISOLATED, FOUND))
        closed = np.abs(at.vector("positions", len(which)) / lengths).max(axis=1, initial=0.0) <= CLOSED
        good = lasts & closed & ~np.isnan(found.growth)
        left = np.abs(self._along(at, rows, which)).max(axis=1, initial=0.0)
        return np.where(good, status, NONE_FOUND), found.growth, left

    def _lasts(
        self, state: Array, at: Linear, motion: Motion | None, rows: Rows, lengths: Array, which: Array, worst: Array,
        sums: Array,
    ) -> Array:  # fmt: skip
        """Whether what shall turn turns, and goes on: its velocities fulfil the constraints, and its forces and the
        rates of its laws do not change while it turns, nor are they others when it has turned (runs,). worst (runs,):
        the largest force there was; sums: `Balance.sums`."""
        if motion is None:
            return np.ones(len(which), bool)
        runs, D, rates = len(which), self.sizes[which], state[self.rates].T
        speed = np.linalg.norm(self.rotation[:, which], axis=0)
        unmet = np.abs(at.vector("rates", runs) / lengths).max(axis=1, initial=0.0)
        good = motion.carried.turns(self.tree, rates, STEADY * speed) & (unmet <= STEADY * speed)
        turns = np.where(speed > 0.0, speed, 1.0)
        later = [motion.carried.ahead(self.tree, rates, turns, angle) for angle in AHEAD]
        there = [
            self._when_turned(self.elsewhere(state, x, np.zeros((runs, self.tracer.laws)), which), which) for x in later
        ]
        ways = {"q": rates, "v": motion.a, "a": motion.carried.jerks}
        for of, sizes in (("along", D), ("laws", np.ones((runs, len(self.equations.outputs["laws"]))))):
            slopes = {by: at.dense(of, by, runs) * sizes[:, :, None] for by in ways}
            change = sum((product(slopes[by], x) for by, x in ways.items()), np.zeros(sizes.shape))
            if of == "along":
                change = product(rows.Q, rows.free(product(turned(rows.Q), change)))
            terms = [np.abs(slopes[by]).max(axis=(1, 2), initial=0.0) * np.abs(x).max(axis=1) for by, x in ways.items()]
            terms.append(np.abs(slopes["v"]).max(axis=(1, 2), initial=0.0) * np.abs(rates).max(axis=1) * speed)
            if of == "along":
                terms.append((sums * D).max(axis=1, initial=0.0) * speed)
            most = STEADY * speed * worst + EXACT * np.max(terms, axis=0)
            good &= np.abs(change).max(axis=1, initial=0.0) <= most
            for found in there:  # what is left of laws where they rest is left of them there, too
                change = found[of] - (at.vector(of, runs) if of == "laws" else 0.0)
                good &= np.abs(change).max(axis=1, initial=0.0) * speed <= most
        return good | ~self.turns[which]

    def _when_turned(self, state: Array, which: Array) -> dict[str, Array]:
        """What is left of forces along the freedoms, and the rates of laws."""
        _, at, _ = self.looked(state, which, self.equations)
        along = self._along(at, self.rows_of(at, which)[0], which)
        return {"along": along, "laws": at.vector("laws", len(which))}

    def _along(self, at: Linear, rows: Rows, which: Array) -> Array:
        """What forces do along what the constraints leave free (runs, n)."""
        along = product(turned(rows.Q), at.vector("along", len(which)) * self.sizes[which])
        return product(rows.Q, rows.free(along))
