"""The stages of an implicit step on symbols, for straight-line code and for loops."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from lienumba.compiler.symbols import Graph
from lienumba.integrators import layout
from lienumba.integrators.codes import finite
from lienumba.integrators.methods import munthe_kaas
from lienumba.integrators.methods.charts import Coordinates
from lienumba.integrators.tracing.implicit import stage_system
from lienumba.integrators.tracing.linear.equations import Equations, Linear
from lienumba.integrators.tracing.tracer import Tracer, flat
from lienumba.mechanics.mechanism.model import Model
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, maximum, where

SWEEPS = 3  # of the kinematics in an iteration

Iterate = tuple[list[list[Any]], list[list[Any]]]  # of every stage u by element, and the unknowns


@dataclass(frozen=True)
class Stages:
    """A step on symbols. A: of the implicit stages; nodes: c of these."""

    tracer: Tracer
    graph: Graph
    model: Model

    @staticmethod
    def of(tracer: Tracer) -> "Stages":
        return Stages(tracer, *tracer.graph())

    @property
    def A(self) -> list[list[float]]:
        return [[float(x) for x in row[1:]] for row in self.tracer.tableau.A[1:]]

    @property
    def nodes(self) -> list[float]:
        return [float(c) for c in self.tracer.tableau.c[1:]]

    def clock(self, row: int) -> Any:
        return self.graph.input("clock", row)

    @property
    def h(self) -> Any:
        return self.clock(layout.LENGTH)

    def iterate(self, array: str, first: int) -> Iterate:
        """From these rows."""
        size, elements = self.tracer.chart.size, self.tracer.elements
        stages, every = [], []
        for moved, unknown in self.places(first):
            stages.append([self.graph.inputs(array, size, moved.start + size * e) for e in range(elements)])
            every.append(list(self.graph.inputs(array, len(unknown), unknown.start)))
        return stages, every

    def places(self, first: int) -> list[tuple[range, range]]:
        """Of every stage the rows of u and those of the unknowns, in an iterate from a row on."""
        moved, unknown = self.tracer.chart.size * self.tracer.elements, sum(stage_system.unknowns(self.tracer))
        starts = (first + i * (moved + unknown) for i in range(len(self.nodes)))
        return [(range(n, n + moved), range(n + moved, n + moved + unknown)) for n in starts]

    def rows(self, u: Sequence[Sequence[Coordinates]], unknown: Sequence[Sequence[Any]]) -> list[Any]:
        return [x for own, more in zip(u, unknown, strict=True) for x in (*flat(own), *more)]

    def swept(self, u: list[list[Any]], unknown: list[list[Any]], sweeps: int) -> Any:
        """u = h A k, so many times, and k."""
        tracer, chart, x = self.tracer, self.tracer.chart_of(self.model), self.tracer.state(self.graph, "state")
        n, laws, _ = stage_system.unknowns(tracer)
        k: list[list[Coordinates]] = []
        for _ in range(sweeps):
            k = []
            for own, w in zip(u, unknown, strict=True):
                at = tuple(chart.moved(body, z) for body, z in zip(x, own, strict=True))
                F = tracer.field(self.model, at, w[:n], w[n : n + laws])
                k.append([chart.slope(*each) for each in zip(x, own, at, F, strict=True)])
            u = [
                [
                    munthe_kaas.weighted([self.h * w for w in row], [slopes[e] for slopes in k])
                    for e in range(tracer.elements)
                ]
                for row in self.A
            ]
        return u, k

    def state_at(self, u: Sequence[Coordinates]) -> list[Any]:
        """All rows of the state of a stage."""
        chart, x = self.tracer.chart_of(self.model), self.tracer.state(self.graph, "state")
        moved = [chart.moved(body, z) for body, z in zip(x, u, strict=True)]
        return [*flat(moved), *self.tracer.augmented_rows(self.graph)]

    def linear(self, equations: Equations, state: list[Any], c: float, unknown: list[Any]) -> Linear:
        n, laws, _ = stage_system.unknowns(self.tracer)
        t = self.clock(layout.TIME) + c * self.h
        a, mu = unknown[:n], unknown[n + laws :]
        parameter = partial(self.graph.input, "parameters")
        return equations.at(state, t, a, mu, parameter, within=self.clock(layout.MIDDLE))

    def mask(self) -> list[Number]:
        return self.tracer.mask(self.tracer.augmented_rows(self.graph))


def right_of(step: Stages, stages: Sequence[Linear], unknown: Sequence[Sequence[Any]]) -> list[Any]:
    """What the equations of all stages leave over."""
    n, laws, _ = stage_system.unknowns(step.tracer)
    mask, right = step.mask(), list[Any]()
    for stage, w in zip(stages, unknown, strict=True):
        right += stage.along
        right += [rate - x for rate, x in zip(stage.laws, w[n : n + laws], strict=True)]
        rows = zip(stage.rows, step.tracer.used, w[n + laws :], strict=True)
        right += [r - (1.0 - mask[row]) * mu for r, row, mu in rows]
    return right


def improved(step: Stages, changes: Sequence[Any]) -> tuple[list[list[Any]], Any, Any]:
    """The unknowns of all stages after these changes, the size of these, and whether they are numbers."""
    _, unknown = step.iterate("extra", layout.iterate_row(step.tracer.sizes))
    size = len(changes) // len(unknown)
    by_stage = [changes[size * i : size * (i + 1)] for i in range(len(unknown))]
    new = [[x + dx for x, dx in zip(w, own, strict=True)] for w, own in zip(unknown, by_stage, strict=True)]
    return new, _size(step, by_stage), where(finite([x for own in new for x in own]), 1.0, 0.0)


def _size(step: Stages, changes: Sequence[Sequence[Any]]) -> Any:
    """The change of the worst stage, of each coordinate, squared, as a fraction of what the tolerance allows."""
    tracer, x = step.tracer, step.tracer.state(step.graph, "state")
    n, laws, _ = stage_system.unknowns(tracer)
    moving = [[step.h * sum(w * own[m] for w, own in zip(row, changes, strict=True)) for m in range(n + laws)]
              for row in step.A]  # fmt: skip
    largest: list[Any] = [0.0] * (2 * n + laws)
    for row, own in zip(step.A, moving, strict=True):
        places = [step.h * sum(w * other[m] for w, other in zip(row, moving, strict=True)) for m in range(n)]
        largest = [maximum(absolute(y), z) for y, z in zip([*places, *own], largest, strict=True)]
    estimates = [[z] for z in tracer.gathered(largest[:n], largest[n : 2 * n], largest[2 * n :])]
    return tracer.error_square(step.graph, step.model, estimates, x, x)
