"""The linear systems of all runs at one time, from the partial derivatives of the trace."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import accelerations, product, turned
from lienumba.engine.linear.looked import Looked, turning_links
from lienumba.engine.linear.reduction import Blocks, Constraints, Reduced, reduced
from lienumba.engine.linear.states import States
from lienumba.groups import so3
from lienumba.integrators.tracing.linear.equations import Equations, Linear, RunsNumbers
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.linear.recorded import recorded
from lienumba.integrators.tracing.linear.rounding import Moves, scale
from lienumba.mechanics.mechanism.model import GROUND
from lienumba.mechanics.mechanism.moves import Free
from lienumba.mechanics.system.constraints import constraints_of

Array = npt.NDArray[Any]
AT_ONCE = 2048  # runs, so that what is computed for them stays in the cache
BY = ("q", "v", "laws", "inputs")


@dataclass(frozen=True)
class Systems:
    """Of some runs (indices) whose constraints have the same rank: x' = A x + B u, seen = C x + D u; bodies: the shifts
    and turns (global axes, 6 per body) of all bodies that go with x; order: how many of x are places, how many rates;
    chosen: which coordinates and rates of the tree these are; scale (runs,): see `rounding.scale`; moves: how all
    coordinates go with x."""

    runs: Array
    A: Array
    B: Array
    C: Array
    D: Array
    bodies: Array
    chosen: tuple[Array, Array]
    scale: Array
    moves: Moves


@dataclass(frozen=True)
class Recorded:
    """A mechanism whose equations are recorded."""

    tracer: FreedomTracer
    equations: Equations

    @staticmethod
    def of(tracer: FreedomTracer, looked: Looked) -> "Recorded":
        return Recorded(tracer, recorded(tracer, looked))

    def of_forces(self, states: States, turning: Sequence[float]) -> dict[str, Array]:
        """How large what forces change by with places and rates is a sum of (see `Moves.rounded`), along the axes
        looked at; for any number of threads."""
        equations = self.equations.only(("q", "v", "a"), ("along",)).terms
        with np.errstate(all="ignore"):
            a, mu = self.solved(states)
            found, runs = self._at(equations, states, a, mu), len(states.labels)
            T = np.abs(self._axes(self._at(self.equations.only((), ("axes",)), states, a, mu), states, turning)[0])
            return {by: product(T, product(found.dense("along", by, runs), turned(T))) for by in ("q", "v")}

    def systems(self, states: States, turning: Sequence[float] = (0.0, 0.0, 0.0)) -> Iterator[Systems]:
        """turning: the angular velocity (rad/s, global) of the axes along which free bodies and balls on the ground are
        looked at. Runs that are not there or not finite have none."""
        chosen: dict[tuple[int, ...], tuple[Array, Array]] = {}
        for first in range(0, len(states.labels), AT_ONCE):
            some = states.part(slice(first, first + AT_ONCE))
            with np.errstate(all="ignore"):
                blocks, seen, bodies = self._blocks(some, turning)
            good = some.good & np.isfinite(blocks.M).all(axis=(1, 2))
            good &= np.isfinite(blocks.F["q"]).all(axis=(1, 2)) & np.isfinite(blocks.F["v"]).all(axis=(1, 2))
            ranks = np.stack([blocks.places.rows.rank, blocks.rates.rows.rank], axis=1)
            for rank in np.unique(ranks[good], axis=0):
                own, kind = np.flatnonzero(good & (ranks == rank).all(axis=1)), tuple(rank.tolist())
                of_kind = _of(blocks, own)
                found = reduced(of_kind, chosen.get(kind))
                chosen[kind] = found.chosen
                looked = {name: x[own] for name, x in seen.items()}
                yield _system(own + first, of_kind, found, looked, bodies[own])

    def seen(self, states: States) -> Array:
        """The quantities that are looked at (runs, ...), where nothing accelerates."""
        n, m = len(self.equations.columns["a"]), len(self.equations.columns["mu"])
        with np.errstate(all="ignore"):
            values = self._at(self.equations.only((), ("seen",)), states, [0.0] * n, [0.0] * m)
        return values.vector("seen", len(states.labels))

    def solved(self, states: States) -> tuple[list[Array], list[Array]]:
        """The accelerations and multipliers of all runs, each number (runs,); of redundant rows the least ones."""
        n, m, runs = len(self.equations.columns["a"]), len(self.equations.columns["mu"]), len(states.labels)
        still = self._at(self.equations.only(("a", "mu")), states, [0.0] * n, [0.0] * m)
        M, constraints = -still.dense("along", "a", runs), Constraints.of(-still.dense("rows", "a", runs))
        rank, force = constraints.rows.rank, still.vector("along", runs)[:, :, None]
        if not m:
            return list(accelerations(M, force, rank, 0.0)[:, :, 0].T), []
        Q, Qt = constraints.rows.Q, turned(constraints.rows.Q)
        a = constraints.least(still.vector("rows", runs)[:, :, None])
        left = product(Qt, force - product(M, a))
        a += product(Q, accelerations(product(Qt, product(M, Q)), left, rank, 0.0))
        mu = constraints.multipliers(force - product(M, a))
        return list(a[:, :, 0].T), list(mu[:, :, 0].T)

    def _at(self, equations: Equations, states: States, a: Sequence[Any], mu: Sequence[Any]) -> Linear:
        return equations.of_runs(states.rows, states.t, a, mu, RunsNumbers(states.numbers, len(states.labels)))

    def _blocks(self, states: States, turning: Sequence[float]) -> tuple[Blocks, dict[str, Array], Array]:
        """What is to be reduced, what is seen, and how bodies move with the rates, along the axes looked at."""
        a, mu = self.solved(states)
        found = self._at(self.equations, states, a, mu)
        T, gamma, carried = self._axes(found, states, turning)
        turns, back = bool(turning_links(self.tracer.tree(self.tracer.graph()[1]))), turned(T)

        def looked(x: Array) -> Array:
            return product(x, back) if turns else x

        def blocks(of: str) -> dict[str, Array]:
            every = {by: found.dense(of, by, len(states.labels)) for by in (*BY, "a", "mu")}
            return every | {by: looked(every[by]) for by in ("q", "v", "a")}

        levels = [c.level != "velocity" for c in constraints_of(self.tracer.graph()[1]) for _ in c.kinds]
        held = np.array([levels[row] for row in self.equations.used], bool)
        F = {by: product(T, x) if turns else x for by, x in blocks("along").items()}
        G, P = blocks("rows"), -found.dense("positions", "inputs", len(states.labels))
        rates = Constraints.of(-G["a"])
        places = rates if held.all() else Constraints.of(np.where(held[:, None], -G["a"], 0.0))
        P = np.where(held[:, None], P, 0.0)
        scale = self._scale(found, states, a, mu)
        made = Blocks(-F["a"], places, rates, F, G, blocks("rates"), P, gamma, carried, blocks("laws"), scale)
        return made, blocks("seen"), looked(found.dense("bodies", "v", len(states.labels)))

    def _scale(self, found: Linear, states: States, a: Sequence[Any], mu: Sequence[Any]) -> Array:
        """See `rounding.scale`."""
        runs, moving = len(states.labels), self.tracer.velocity_rows(self.tracer.graph()[1])
        terms = self.equations.only((), ("along",)).terms
        force = self._at(terms, states, a, mu).vector("along", runs)
        rates = np.array([np.broadcast_to(states.rows[n], (runs,)) for n in moving]).reshape(-1, runs).T
        return scale(force, found, rates, np.ones((runs, len(a))))

    def _axes(self, found: Linear, states: States, turning: Sequence[float]) -> tuple[Array, Array, Array]:
        """The turn of all coordinates into the axes looked at, and what remains of the turning of these (see
        `reduction`): balls and free bodies are looked at along the axes of what they hang on."""
        runs, n = len(states.labels), len(self.equations.columns["q"])
        T = np.broadcast_to(np.eye(n), (runs, n, n)).copy()
        gamma, carried = np.zeros_like(T), np.zeros_like(T)
        axes = found.vector("axes", len(states.labels))
        for k, link in enumerate(turning_links(self.tracer.tree(self.tracer.graph()[1]))):
            end = link.first_rate + link.move.freedoms
            turns, own = slice(end - 3, end), axes[:, 12 * k : 12 * (k + 1)]
            frame = tuple(turning) if link.parent == GROUND else (0.0, 0.0, 0.0)
            away = -np.reshape(so3.hat(frame), (3, 3))
            T[:, turns, turns] = own[:, :9].reshape(-1, 3, 3)
            carried[:, turns, turns] = _hats(own[:, 9:]) + away
            gamma[:, turns, turns] = away
            if isinstance(link.move, Free):
                shifts = slice(end - 6, end - 3)
                gamma[:, shifts, shifts] = carried[:, shifts, shifts] = away
        return T, gamma, carried


def _system(runs: Array, blocks: Blocks, found: Reduced, seen: Mapping[str, Array], bodies: Array) -> Systems:
    size = found.A.shape[1]
    laws = size - sum(map(len, found.chosen))
    whole = [np.concatenate(x, axis=2) for x in (found.q, found.v, found.a, found.mu)]
    parts = [product(seen[by], x) for by, x in zip(("q", "v", "a", "mu"), whole, strict=True)]
    total = parts[0] + parts[1] + parts[2] + parts[3]
    total[:, :, size - laws : size] += seen["laws"]
    total[:, :, size:] += seen["inputs"]
    y, z = map(len, found.chosen)
    moves = Moves(blocks.M, found.q[0], found.v[0], found.a[0], slice(y, y + z))
    return Systems(
        runs, found.A, found.B, total[:, :, :size], total[:, :, size:], product(bodies, found.q[0]), found.chosen,
        blocks.scale, moves,
    )  # fmt: skip


def _of(blocks: Blocks, runs: Array) -> Blocks:
    def some(x: Any) -> Any:
        if isinstance(x, Constraints):
            return x.part(runs)
        return {name: y[runs] for name, y in x.items()} if isinstance(x, dict) else x[runs]

    return replace(blocks, **{field.name: some(getattr(blocks, field.name)) for field in fields(Blocks)})


def _hats(w: Array) -> Array:
    found: Array = np.zeros((len(w), 3, 3))
    for n, x in enumerate(so3.hat(tuple(w.T))):
        found[:, n // 3, n % 3] = x
    return found
