"""The kernels of implicit steps by collocation.

guess      state, iterate -> iterate            stages on the polynomial of the step before
newton     state, iterate -> iterate, change, whether it is regular     one iteration of Newton's method
step       state, iterate -> state, slopes, code, margin              the end, and what the continuous extension reads
close      state, new state, slopes -> the error, damped, and the factor of the controller

An iterate has of every stage its coordinates u, the accelerations a, the rates of laws' states and the multipliers mu.
Newton's method asks for accelerations and multipliers, such that a bushing of any stiffness is a term of its matrix;
the kinematics u = h A k, which are not stiff, are iterated beside it.
"""

from collections.abc import Sequence
from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.compiler.loops.composite import Composite
from lienumba.compiler.loops.elimination import EliminatingKernel
from lienumba.integrators import layout
from lienumba.integrators.codes import verdict
from lienumba.integrators.methods import munthe_kaas, step_control
from lienumba.integrators.tracing.extension_kernels import allowed, work_error_square
from lienumba.integrators.tracing.implicit import loops, stage_system
from lienumba.integrators.tracing.implicit.stage_system import Blocks, Factors
from lienumba.integrators.tracing.implicit.stages import SWEEPS, Stages, improved, right_of
from lienumba.integrators.tracing.linear.equations import Equations
from lienumba.integrators.tracing.step_kernels import Reports, augmented_after
from lienumba.integrators.tracing.tracer import Tracer, flat
from lienumba.mechanics.system import dynamics
from lienumba.numerics.number import Number
from lienumba.numerics.operations import maximum, minimum, where

FIRST_SWEEPS, LAST_SWEEPS = 5, 5  # of the kinematics before the first iteration, and behind the last one
PASSING = 0.1  # of the error of steps next to singular positions counts: it is noise, of which shorter ones have more
FARTHEST = 2.0  # how far a polynomial is followed, in lengths of its step


def rows_of(tracer: Tracer) -> int:
    """Of an iterate."""
    own = tracer.chart.size * tracer.elements + sum(stage_system.unknowns(tracer))
    return len(tracer.tableau.layers) * own


def kernels(tracer: Tracer, loops_allowed: bool = True) -> dict[str, Kernel | Composite]:
    """All of them; `tracer.sizes` has the rows of an iterate, and gets those of an eliminated matrix. loops_allowed:
    whether large systems are eliminated by loops, which are no graph."""
    equations, found = Equations.of(tracer), dict[str, Kernel | Composite](guess=_guess(tracer))
    stages, place = len(tracer.tableau.layers), layout.factors_row(tracer.sizes)
    blocks = Blocks.of(tracer, equations, stages, place) if loops_allowed else None
    if blocks:
        newton = found["newton"] = loops.iteration(tracer, equations, blocks, "newton")
        found["simplified"] = loops.iteration(tracer, equations, blocks, "simplified")
        memory = newton.memory
    else:
        found["newton"], factors = _iteration(tracer, equations, None)
        found["simplified"], _ = _iteration(tracer, equations, factors)
        memory = len(factors.kept)
    tracer.sizes = tracer.sizes._replace(factors=memory)
    found["step"] = _step(tracer)
    if tracer.method.adaptive:
        found["close"] = _close(tracer, equations)
        found |= {"close_along": _close(tracer, equations, along=True)} if tracer.weakens else {}
    return found


def _guess(tracer: Tracer) -> Kernel:
    """The unknowns on the polynomial of the last step, as far as that is to be trusted; else 0."""
    step = Stages.of(tracer)
    graph, first = step.graph, layout.iterate_row(tracer.sizes)
    _, unknown = step.iterate("extra", first)
    since, span = (graph.input("extra", first + tracer.sizes.iterate + row) for row in (layout.SINCE, layout.SPAN))
    known = span > 0.0
    over = where(known, 1.0 / where(known, span, 1.0), 0.0)
    guessed = []
    for c in step.nodes:
        x = minimum(((step.clock(layout.TIME) - since) + c * step.h) * over, FARTHEST)
        weights = []
        for layer in tracer.tableau.layers:
            total: Any = float(layer[-1])
            for w in reversed(layer[:-1]):
                total = total * x + float(w)
            weights.append(total)
        extrapolated = munthe_kaas.weighted(weights, [tuple(own) for own in unknown])
        guessed.append([where(known, y, 0.0) for y in extrapolated])
    zero = [[munthe_kaas.origin(tracer.chart)] * tracer.elements for _ in step.nodes]
    u, _ = step.swept(zero, guessed, FIRST_SWEEPS)
    following = layout.following_row(tracer.sizes)
    rows = step.rows(u, guessed)
    return tracer.kernel("guess", rows, range(following, following + len(rows)))


def _iteration(tracer: Tracer, equations: Equations, kept: Factors | None) -> tuple[Kernel, Factors]:
    """One of Newton's method, by a matrix of its own, which is kept behind what is found, or by one that has been."""
    step, sizes = Stages.of(tracer), tracer.sizes
    u, unknown = step.iterate("extra", layout.iterate_row(sizes))
    u, _ = step.swept(u, unknown, SWEEPS)
    wanted = equations if kept is None else equations.only(())
    stages = [step.linear(wanted, step.state_at(own), c, w) for own, c, w in zip(u, step.nodes, unknown, strict=True)]
    right, place = right_of(step, stages, unknown), layout.factors_row(sizes)
    if kept is None:
        factors = stage_system.factors(tracer, stages, step.A, step.h, step.mask())
    else:
        factors = kept.again(step.graph.inputs("extra", len(kept.kept), place))
    new, *said = improved(step, factors.solved(right))
    outputs, first = [*step.rows(u, new), *said], layout.following_row(sizes)
    rows = list(range(first, first + len(outputs)))
    if kept is None:
        outputs += factors.kept
        rows += range(place, place + len(factors.kept))
    return tracer.kernel("newton" if kept is None else "simplified", outputs, rows), factors


def _step(tracer: Tracer) -> Kernel:
    step = Stages.of(tracer)
    graph, model, sizes = step.graph, step.model, tracer.sizes
    chart, x, augmented = tracer.chart_of(model), tracer.state(graph, "state"), tracer.augmented_rows(graph)
    u, unknown = step.iterate("extra", layout.iterate_row(sizes))
    u, k = step.swept(u, unknown, LAST_SWEEPS)
    n, laws, _ = stage_system.unknowns(tracer)
    square: Number = 0.0
    rotation: Number = 0.0
    for own in u:
        for z in own:
            rotation = maximum(chart.rotation(z), rotation)
    new = []
    for body, z in zip(x, u[-1], strict=True):
        for c in z:
            square = square + c * c
        new.append(chart.settled(chart.moved(body, z)))
    reports = Reports(power=[0.0])
    margin = graph.input("extra", layout.report_row(sizes, 0) + layout.STAGE_MARGIN)
    reports.margin.append(margin)
    mask, t = step.mask(), step.clock(layout.TIME)
    for own, w, c in zip(u, unknown, step.nodes, strict=True):
        at = [chart.moved(body, z) for body, z in zip(x, own, strict=True)]
        posture = tracer.posture(model, at, augmented, t + c * step.h, step.clock(layout.MIDDLE))
        mu: list[Number] = [0.0] * tracer.structure.rows
        for row, m in zip(tracer.used, w[n + laws :], strict=True):
            mu[row] = m
        if tracer.augmented.work:
            every = tracer.reactions(model, posture, mask, mu)
            reports.power.append(dynamics.power(model, posture.now, every))
    reports.accelerations = tracer.carried(model, new, unknown[-1][:n])
    now = tracer.posture(model, new, augmented, t + step.h).now
    after = augmented_after(tracer, model, augmented, now, step.h, reports)
    outputs = [*flat(new), *after, verdict(tracer.strict(rotation), square, 1.0, 1.0)]
    outputs += [margin] if tracer.augmented.masks else []
    rows, behind = list(range(len(outputs))), layout.first_slope(sizes)
    for s, slopes in enumerate(k, 1):
        for i, f in enumerate(slopes):
            outputs += f
            rows += [behind + layout.slope_row(sizes, i, s) + c for c in range(sizes.coordinates)]
        if tracer.augmented.work:
            outputs.append(reports.power[s])
            rows.append(behind + layout.report_row(sizes, s) + layout.POWER)
    return tracer.kernel("step", outputs, rows)


def _close(tracer: Tracer, equations: Equations, along: bool = False) -> Kernel | Composite:
    """The error h (gamma F_0 + sum e_j f_j), of which (I - h gamma J)^-1 leaves what is not stiff; along: whether
    velocities that the constraints do not allow are left out."""
    step, name = Stages.of(tracer), "close_along" if along else "close"
    behind = layout.first_slope(tracer.sizes)
    _, unknown = step.iterate("extra", behind + layout.iterate_row(tracer.sizes))
    n, laws, count = stage_system.unknowns(tracer)
    places, velocities, states = _rough(step)
    x0 = [*flat(tracer.state(step.graph, "state")), *tracer.augmented_rows(step.graph)]
    stage = step.linear(equations, x0, 0.0, unknown[0])
    right: list[Any] = [0.0] * (n + laws + count)
    given = {"q": [float(tracer.tableau.damping) * step.h * q for q in places]}
    for of, first in (("along", 0), ("laws", n)):
        for (row, c), value in stage.block(of, "q").items():
            right[first + row] = right[first + row] + value * given["q"][c]
    for of, first in (("along", 0), ("rows", n + laws)):
        for (row, c), value in stage.block(of, "a").items():
            right[first + row] = right[first + row] - value * velocities[c]
    for m, x in enumerate(states):
        right[n + m] = right[n + m] + x
    damping = [[float(tracer.tableau.damping)]]
    blocks = Blocks.of(tracer, equations, 1, behind + layout.factors_row(tracer.sizes))
    if blocks is None:
        factors = stage_system.factors(tracer, [stage], damping, step.h, step.mask())
        return tracer.kernel(name, _error(step, factors.solved(right), along))
    matrix = blocks.entries(stage_system.matrix(tracer, [stage], damping, step.h, step.mask()))
    end = Stages.of(tracer)
    found = _error(end, [end.graph.input("extra", row) for row in blocks.vector], along)
    parts = {"matrix": [*zip(blocks.vector, right, strict=True), *matrix], "end": [*enumerate(found)]}
    return EliminatingKernel(name, blocks.elimination, blocks.first, parts)


def _rough(step: Stages) -> tuple[list[Number], list[Number], list[Number]]:
    """The error before it is damped: of places, of velocities, of laws' states."""
    tracer, rough = step.tracer, []
    weights, behind = munthe_kaas.scaled(step.h, tracer.tableau.errors[0]), layout.first_slope(tracer.sizes)
    for i in range(tracer.elements):
        slopes = [
            step.graph.inputs("extra", tracer.chart.size, behind + layout.slope_row(tracer.sizes, i, s))
            for s in range(tracer.sizes.stages)
        ]
        rough.append(munthe_kaas.weighted(weights, slopes))
    return tracer.apart(rough)


def _error(step: Stages, found: Sequence[Any], along: bool) -> list[Number]:
    """What `close` says, of the damped error of velocities and laws' states."""
    tracer, graph, model = step.tracer, step.graph, step.model
    n, laws, _ = stage_system.unknowns(tracer)
    places, beta = _rough(step)[0], float(tracer.tableau.damping) * step.h
    moving = allowed(tracer, graph, model, [*found[:n]]) if along else found[:n]
    moved = [q + beta * v for q, v in zip(places, moving, strict=True)]
    estimates = [[z] for z in tracer.gathered(moved, moving, found[n : n + laws])]
    square = tracer.error_square(graph, model, estimates, tracer.state(graph, "state"), tracer.state(graph, "extra"))
    if tracer.augmented.work:
        work = work_error_square(tracer, graph, model, layout.first_slope(tracer.sizes))
        square = step_control.worst([square, work])
    square = square * (PASSING * PASSING) if along else square
    return [square, *step_control.factor(square, graph.input("clock", layout.MEMORY), tracer.tableau.estimated)]
