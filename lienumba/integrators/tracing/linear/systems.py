"""The linear systems of all runs at one time, from the partial derivatives of the trace."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from lienumba.compiler.memo import Memo, content
from lienumba.groups import so3
from lienumba.groups.state import ELEMENT
from lienumba.integrators.tracing.compiled import key_of
from lienumba.integrators.tracing.linear.algebra import Array, NullSpace, eigenvalues
from lienumba.integrators.tracing.linear.equations import Equations, Linear, RunsNumbers
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.linear.outputs import LinearOutputs, turning_links
from lienumba.integrators.tracing.linear.reduction import Blocks, Reduced, reduced
from lienumba.integrators.tracing.row_selection import UNIQUE
from lienumba.keys.registry import Registry
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import GROUND, Model, at_time
from lienumba.mechanics.mechanism.moves import Free
from lienumba.mechanics.system.constraints import constraints_of
from lienumba.numerics.operations import sqrt

REDUNDANT_RTOL = 1e-9  # relative to the largest diagonal element of R: a smaller one is of a redundant row
AT_ONCE = 2048  # runs, so that what is computed for them stays in the cache
BY = ("q", "v", "laws", "inputs")
STILL = (0.0, 0.0, 0.0)
RECORDED: Memo[Equations] = Memo(4)  # the equations used last; large ones take tens of MiB


@dataclass(frozen=True)
class States:
    """Runs at a time t (s): good: whether a run is there at all (runs,), rows: of the state, and the numbers of the
    model, each a float or an array (runs,); origin: see `linear_layout.ORIGINS`."""

    good: np.ndarray
    t: float
    rows: list[Any]
    numbers: list[Any]
    origin: int = 0

    def part(self, which: slice | np.ndarray) -> "States":
        """Return the states of these runs alone."""
        rows, numbers = ([x[which] if np.ndim(x) else x for x in own] for own in (self.rows, self.numbers))
        return States(self.good[which], self.t, rows, numbers, self.origin)

    def bodies(self, tracer: FreedomTracer, model: Model) -> np.ndarray:
        """The states of all bodies (runs, k, 18); NaN where a run is not there."""
        now = tracer.instant(model, self.rows, self.t)
        numbers = [np.broadcast_to(x, self.good.shape) for body in now.bodies for x in body]
        whole = np.stack(numbers, axis=1).reshape(len(self.good), -1, ELEMENT)
        return np.where(self.good[:, None, None], whole, np.nan)


@dataclass(frozen=True)
class Systems:
    """The systems x' = A x + B u, outputs = C x + D u of some runs (indices) whose constraints have the same rank.

    bodies: the shifts and turns (global axes, 6 per body) of all bodies that go with x; chosen: which coordinates and
    rates of the tree the first numbers of x are; scale (runs,): the largest rate, and the frequency (1/s) of a pendulum
    of the mechanism's size.
    """

    runs: Array
    A: Array
    B: Array
    C: Array
    D: Array
    bodies: Array
    chosen: tuple[Array, Array]
    scale: Array

    def eigenvalues(self) -> Array:
        """The eigenvalues of A (runs, n)."""
        return eigenvalues(self.A, self.scale)


@dataclass(frozen=True)
class Recorded:
    """A mechanism whose equations are recorded; swing: the square (1/s^2) of the frequency of a pendulum of its size, a
    float or an array (runs,)."""

    tracer: FreedomTracer
    equations: Equations
    swing: Any

    @staticmethod
    def of(tracer: FreedomTracer, outputs: LinearOutputs, model: Model) -> "Recorded":
        """Record a mechanism; model: with all numbers, floats or arrays (runs,)."""
        return Recorded(tracer, _equations(tracer, outputs), gravity_of(model) / size_of(model))

    def systems(self, states: States, turning: Sequence[Any] = STILL) -> Iterator[Systems]:
        """Linearise at these states. Runs that are not there or not finite have no system.

        Parameters
        ----------
        states : States
            Of N runs.
        turning : three floats or arrays (N,)
            The angular velocity (rad/s, global) of the axes along which free bodies and balls on the ground are seen.
        """
        chosen: list[tuple[Array, Array]] = []
        rates = [states.rows[n] for n in self.tracer.velocity_rows(self.tracer.graph()[1])]
        fastest = [np.abs(x) for x in rates] + [np.sqrt(np.abs(self.swing))]
        scale = np.max([np.broadcast_to(x, states.good.shape) for x in fastest], axis=0)
        axes = np.stack([np.broadcast_to(np.asarray(x, float), states.good.shape) for x in turning], axis=1)
        for first in range(0, len(states.good), AT_ONCE):
            part = slice(first, first + AT_ONCE)
            some = states.part(part)
            with np.errstate(all="ignore"):
                blocks, seen, bodies = self._blocks(some, axes[part])
            good = some.good & np.isfinite(blocks.M).all(axis=(1, 2))
            good &= np.isfinite(blocks.F["q"]).all(axis=(1, 2)) & np.isfinite(blocks.F["v"]).all(axis=(1, 2))
            for runs, independent in _by_coordinates(blocks, np.flatnonzero(good), chosen):
                own = {name: x[runs] for name, x in seen.items()}
                yield _system(runs + first, reduced(_of(blocks, runs), independent), own, bodies[runs], scale)

    def moving(self, system: Systems) -> Systems:
        """Without the states of laws that stand still, as those that are sampled or held."""
        first = system.A.shape[1] - len(self.equations.outputs["laws"])
        kept = np.concatenate([np.arange(first), first + self.equations.moving])
        return replace(system, A=system.A[:, kept][:, :, kept], bodies=system.bodies[:, :, kept])

    def _solved(self, states: States) -> tuple[list[Array], list[Array]]:
        """The accelerations and multipliers of all runs, each number (runs,); of redundant rows the shortest ones."""
        n, m, runs = len(self.equations.columns["a"]), len(self.equations.columns["mu"]), len(states.good)
        still = self._at(self.equations.only(("a", "mu")), states, [0.0] * n, [0.0] * m)
        M, space = -still.dense("along", "a", runs), NullSpace.of(-still.dense("rows", "a", runs), REDUNDANT_RTOL)
        a, mu = space.motion(M, still.vector("along", runs)[:, :, None], still.vector("rows", runs)[:, :, None])
        return list(a[:, :, 0].T), list(mu[:, :, 0].T)

    def _at(self, equations: Equations, states: States, a: Sequence[Any], mu: Sequence[Any]) -> Linear:
        return equations.of_runs(states.rows, states.t, a, mu, RunsNumbers(states.numbers, len(states.good)))

    def _blocks(self, states: States, turning: Array) -> tuple[Blocks, dict[str, Array], Array]:
        """What is to be reduced, the derivatives of outputs, and how bodies move with the rates, along the axes."""
        a, mu = self._solved(states)
        linear, runs = self._at(self.equations, states, a, mu), len(states.good)
        T, gamma, carried = self._axes(linear, turning)
        turns, back = bool(turning_links(self.tracer.tree(self.tracer.graph()[1]))), T.mT

        def along_axes(x: Array) -> Array:
            return x @ back if turns else x

        def blocks(of: str) -> dict[str, Array]:
            every = {by: linear.dense(of, by, runs) for by in (*BY, "a", "mu")}
            return every | {by: along_axes(every[by]) for by in ("q", "v", "a")}

        levels = [c.level != "velocity" for c in constraints_of(self.tracer.graph()[1]) for _ in c.kinds]
        held = np.array([levels[row] for row in self.equations.used], bool)[:, None]
        F = {by: T @ x if turns else x for by, x in blocks("along").items()}
        G, P = blocks("rows"), -linear.dense("positions", "inputs", runs)
        rates = NullSpace.of(-G["a"], REDUNDANT_RTOL)
        places = rates if held.all() else NullSpace.of(np.where(held, -G["a"], 0.0), REDUNDANT_RTOL)
        P = np.where(held, P, 0.0)
        made = Blocks(-F["a"], places, rates, F, G, blocks("rates"), P, gamma, carried, blocks("laws"))
        return made, blocks("seen"), along_axes(linear.dense("bodies", "v", runs))

    def _axes(self, linear: Linear, turning: Array) -> tuple[Array, Array, Array]:
        """The rotation of all coordinates into the axes along which they are seen, and what remains of the turning of
        these (see `reduction`): balls and free bodies are seen along the axes of what they hang on."""
        runs, n = len(turning), len(self.equations.columns["q"])
        T = np.broadcast_to(np.eye(n), (runs, n, n)).copy()
        gamma, carried = np.zeros_like(T), np.zeros_like(T)
        axes = linear.vector("axes", runs)
        for k, link in enumerate(turning_links(self.tracer.tree(self.tracer.graph()[1]))):
            end = link.first_rate + link.move.freedoms
            turns, own = slice(end - 3, end), axes[:, 12 * k : 12 * (k + 1)]
            away = -_hats(turning) if link.parent == GROUND else np.zeros((runs, 3, 3))
            T[:, turns, turns] = own[:, :9].reshape(-1, 3, 3)
            carried[:, turns, turns] = _hats(own[:, 9:]) + away
            gamma[:, turns, turns] = away
            if isinstance(link.move, Free):
                shifts = slice(end - 6, end - 3)
                gamma[:, shifts, shifts] = carried[:, shifts, shifts] = away
        return T, gamma, carried


def _equations(tracer: FreedomTracer, outputs: LinearOutputs) -> Equations:
    """Record the equations of a mechanism and differentiate them, once per structure and process, whatever its
    numbers."""
    key = key_of(tracer.template, tracer.method, UNIQUE, False)
    if key is None:
        return Equations.of(tracer, outputs)
    key = Registry.changes, type(tracer), key, content(outputs)
    return RECORDED.get(key, lambda: Equations.of(tracer, outputs))


def gravity_of(model: Model) -> Any:
    """The size of gravity (m/s^2) at t = 0, a float or an array (runs,)."""
    with np.errstate(all="ignore"):
        return np.sqrt(sum(np.square(np.asarray(at_time(x, 0.0), float)) for x in model.gravity))


def size_of(model: Model) -> Any:
    """How large (m) the mechanism is: its bodies, and how far its joints and contacts are from their mass centres."""
    with np.errstate(all="ignore"):
        own = [sqrt(sum(body.inertia[:3]) / body.mass) for body in with_lent_masses(model).bodies]
    points = [p for joint in model.joints for p in joint.points or ()]
    points += [p for contact in model.contacts for p in contact.points]
    reach = [abs(np.asarray(x)) for p in points for x in p]
    reach += [x for contact in model.contacts for x in contact.numbers.values()]
    return np.max(np.broadcast_arrays(*(np.asarray(x, float) for x in (*own, *reach))), axis=0)


def _by_coordinates(
    blocks: Blocks, runs: Array, chosen: list[tuple[Array, Array]]
) -> Iterator[tuple[Array, tuple[Array, Array]]]:
    """Split runs by the coordinates that are far from dependent in them: some that are chosen already, or their own."""
    for independent in tuple(chosen):
        fits = blocks.fits(runs, independent)
        if fits.any():
            yield runs[fits], independent
        runs = runs[~fits]
    while len(runs):
        chosen.append(blocks.independent(runs[0]))
        fits = blocks.fits(runs, chosen[-1])
        fits[0] = True
        yield runs[fits], chosen[-1]
        runs = runs[~fits]


def _system(runs: Array, own: Reduced, seen: Mapping[str, Array], bodies: Array, scale: Array) -> Systems:
    size, laws = own.size, own.size - sum(map(len, own.chosen))
    outputs = sum((seen[by] @ x for by, x in own.motion.items()), np.zeros(()))
    outputs[:, :, size - laws : size] += seen["laws"]
    outputs[:, :, size:] += seen["inputs"]
    A, B = own.slopes[:, :, :size], own.slopes[:, :, size:]
    shapes = bodies @ own.motion["q"][:, :, :size]
    return Systems(runs, A, B, outputs[:, :, :size], outputs[:, :, size:], shapes, own.chosen, scale[runs])


def _of(blocks: Blocks, runs: Array) -> Blocks:
    def some(x: Any) -> Any:
        if isinstance(x, NullSpace):
            return x.part(runs)
        return {name: y[runs] for name, y in x.items()} if isinstance(x, dict) else x[runs]

    return replace(blocks, **{field.name: some(getattr(blocks, field.name)) for field in fields(Blocks)})


def _hats(w: Array) -> Array:
    """The matrices of cross products with vectors (runs, 3)."""
    hats: Array = np.zeros((len(w), 3, 3))
    for n, x in enumerate(so3.hat(tuple(w.T))):
        hats[:, n // 3, n % 3] = x
    return hats
