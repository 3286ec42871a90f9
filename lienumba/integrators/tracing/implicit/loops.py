"""An iteration of Newton's method for a large system: its text does not grow with stages, nor with the elimination.

start      the kinematics of all stages
each       the equations of one stage and their derivatives, on memory of its own
matrix     the entries of the matrix and the right-hand side, which is solved for by loops
end        the improved unknowns
"""

from functools import partial
from typing import Any

from lienumba.compiler.loops.elimination import Each, EliminatingKernel
from lienumba.integrators import layout
from lienumba.integrators.tracing.implicit import stage_system
from lienumba.integrators.tracing.implicit.stage_system import Blocks
from lienumba.integrators.tracing.implicit.stages import SWEEPS, Stages, improved, right_of
from lienumba.integrators.tracing.linear.equations import Equations, Linear
from lienumba.integrators.tracing.tracer import Tracer, flat

Stores = list[tuple[int, Any]]  # rows and values


def iteration(tracer: Tracer, equations: Equations, blocks: Blocks, name: str) -> EliminatingKernel:
    """The kernel `newton`, or `simplified` by the matrix of that."""
    fresh = name == "newton"
    wanted = equations if fresh else equations.only(())
    linear, given = _stage(tracer, wanted)
    start, step = blocks.first + blocks.elimination.memory, Stages.of(tracer)
    terms = blocks.terms(tracer, wanted, step.A, given) if fresh else []
    each = Each([*enumerate(linear.numbers, given)], len(step.A), start, given + len(linear.numbers), terms)
    parts = {"start": _start(tracer, each), "matrix": _matrix(tracer, blocks, linear, each, fresh)}
    return EliminatingKernel(name, blocks.elimination, blocks.first, parts | {"end": _end(tracer, blocks)}, fresh, each)


def _start(tracer: Tracer, each: Each) -> Stores:
    """The kinematics, and what the equations of each stage read."""
    step = Stages.of(tracer)
    u, unknown = step.iterate("extra", layout.iterate_row(tracer.sizes))
    u, _ = step.swept(u, unknown, SWEEPS)
    found: Stores = [(each.factor, step.h)]
    places = step.places(layout.following_row(tracer.sizes))
    for n, (own, w, c) in enumerate(zip(u, unknown, step.nodes, strict=True)):
        found += zip(places[n][0], flat(own), strict=True)
        times = step.clock(layout.TIME) + c * step.h, step.clock(layout.MIDDLE)
        found += enumerate((*times, *step.state_at(own), *w), each.first + each.rows * n)
    return found


def _stage(tracer: Tracer, equations: Equations) -> tuple[Linear, int]:
    """The equations of a stage, and how many rows these read: of its times, its state and its unknowns."""
    graph, _ = tracer.graph()
    n, laws, count = stage_system.unknowns(tracer)
    state = tracer.element * tracer.elements + tracer.augmented.rows
    t, within, *rest = graph.inputs("extra", 2 + state + n + laws + count)
    a, mu = rest[state : state + n], rest[state + n + laws :]
    return equations.at(rest[:state], t, a, mu, partial(graph.input, "parameters"), within=within), 2 + len(rest)


def _matrix(tracer: Tracer, blocks: Blocks, linear: Linear, each: Each, fresh: bool) -> Stores:
    """What the equations of all stages leave over, and what is on the diagonal beside the terms of these."""
    step, stages, equations = Stages.of(tracer), list[Linear](), linear.equations
    n, laws, _ = stage_system.unknowns(tracer)
    for stage in range(each.count):
        behind = each.first + each.rows * (stage + 1) - len(linear.numbers)
        stages.append(Linear(step.graph.inputs("extra", len(equations.values), behind), equations))
    _, unknown = step.iterate("extra", layout.iterate_row(tracer.sizes))
    found: Stores = [*zip(blocks.vector, right_of(step, stages, unknown), strict=True)]
    if fresh:
        off = [1.0 - mask for mask in step.mask()]
        own = [0.0] * n + [1.0] * laws + [off[row] for row in tracer.used]
        found += blocks.entries([{len(own) * i + v: x} for i in range(each.count) for v, x in enumerate(own)])
    return found


def _end(tracer: Tracer, blocks: Blocks) -> Stores:
    """The improved unknowns, and what is said of them."""
    step, first = Stages.of(tracer), layout.following_row(tracer.sizes)
    new, *said = improved(step, [step.graph.input("extra", row) for row in blocks.vector])
    found: Stores = [*enumerate(said, first + tracer.sizes.iterate)]
    for (_, rows), w in zip(step.places(first), new, strict=True):
        found += zip(rows, w, strict=True)
    return found
