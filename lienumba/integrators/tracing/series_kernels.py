"""The kernels of a step that is a power series in time (`lienumba.compiler.series`) of the state itself.

expand     state -> coefficients of what is integrated; how long a step may be
step       state, coefficients -> state, code, margin     their sum at the end of a step
defect     state, coefficients -> error                   how far F there is from the sum's derivative
dense      state, coefficients -> state                   and at a fraction of it

Rows of a rotation move by R' = R w^, each for itself, so that those which nothing asks for but the state at the end are
spared: two of them say it all. Where a sum of the series ends beside the group, within the tolerance, the rotation is
made upright again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.compiler.loops.convolutions import SeriesKernel
from lienumba.compiler.series import Orders, branches, orders
from lienumba.compiler.symbols import Graph, Symbol, live
from lienumba.groups import so3
from lienumba.integrators import layout
from lienumba.integrators.codes import HUGE, verdict
from lienumba.integrators.methods import gaps, taylor
from lienumba.integrators.tracing.tracer import Part, Tracer, flat
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import dynamics
from lienumba.mechanics.system.switches import FRICTION, switches_of
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import maximum, minimum, sqrt, where

BEYOND, LEAST_BEYOND = 0.5, 4e-15  # how far behind a kink a step ends, of what the tolerance leaves, and of the time
STRICTER = 1e4  # of what a step may be wrong by, where functions branch
BEFORE = 8.0  # how many times this before a kink F is that of the first branch


@dataclass(frozen=True)
class Expansion:
    """places: which series is that of a row of the elements; work: that of the work; angles: the first of those that
    are counted; gaps: those of what changes its sign where a law takes another branch; rows: of the coefficients and
    what belongs to them."""

    kernel: SeriesKernel
    places: dict[int, int]
    work: int
    angles: int
    gaps: range

    @property
    def rows(self) -> int:
        return self.kernel.rows


def kernels(tracer: Tracer) -> tuple[dict[str, Any], int]:
    """All of them, and the rows of the coefficients."""
    made = _expand(tracer)
    every = {"expand": made.kernel, "step": _step(tracer, made), "dense": _dense(tracer, made)}
    if tracer.method.adaptive:
        every["defect"] = _defect(tracer, made)
    return every, made.rows


def _expand(tracer: Tracer) -> Expansion:
    graph, model = tracer.graph(Graph(analytic=True))
    sizes, augmented, state = tracer.sizes, tracer.augmented_rows(graph), tracer.state(graph, "state")
    t, within = graph.input("clock", layout.TIME), graph.input("clock", layout.MIDDLE)
    posture = tracer.posture(model, state, augmented, t, within)
    expected, linear = tracer.augmented.expected(augmented), None
    if implicit := tracer.moving_implicitly(graph, model, posture, tracer.mask(augmented)):
        F, found, linear = implicit
    else:
        F, found = tracer.moving(model, posture, tracer.mask(augmented), expected)
    rates = tracer.rates(model, state, F)
    power = [dynamics.power(model, posture.now, found.multipliers)] if tracer.augmented.work else []
    angles = tracer.augmented.counted(model, posture.now)
    rest = linear.rest if linear else []
    rows = _integrated(tracer, model, rates, [*power, *angles, *rest])
    inputs = [graph.input("state", row) for row in rows]
    compared = _gaps(tracer, graph, model, [*(rates[row] for row in rows), *power, *rest])
    asked = [found.nonsingular, found.margin, *angles, *compared]
    made = orders([*inputs, t], [*(rates[row] for row in rows), 1.0, *power], asked, tracer.method.order, linear)
    places = {row: n for n, row in enumerate(rows)}
    work = len(rows) + 1
    nonsingular = work + len(power)
    every = live([x for x in (*rates, *rest) if isinstance(x, Symbol)])
    size, uncut = _lengths(tracer, places, made, STRICTER if any(map(branches, every)) else 1.0)
    control = layout.control_row(sizes)
    outputs = [
        (control + layout.ERROR, 0.0), (control + layout.FACTOR, size), (control + layout.REMEMBERED, uncut),
    ]  # fmt: skip
    kernel = SeriesKernel("expand", made, tracer.method.order, layout.series_row(sizes), outputs)
    behind = nonsingular + 2 + len(angles)
    return Expansion(kernel, places, work, nonsingular + 2, range(behind, behind + len(compared)))


def compared(
    tracer: Tracer, graph: Graph, model: Model, t: Number, within: Number | None, values: Sequence[Any]
) -> list[Symbol]:
    """What values compare, of the mechanism at a state, in an analytic graph: where one changes, another branch
    begins. What chooses among forms of one number, and what an elimination compares without any force, does not
    count."""

    def found(values: Sequence[Any]) -> dict[int, Symbol]:
        return {x.id: x for x in live(values) if x.op in ("<", "<=") and x.id not in graph.alike}

    every, known = found(values), dict[int, Symbol]()
    if every and tracer.structure.looped:
        rubs = {switch.index for switch in switches_of(model) if switch.what == FRICTION}  # and so has rows of its own
        free = replace(model, forces=tuple(force for n, force in enumerate(model.forces) if n in rubs))
        augmented = tracer.augmented_rows(graph)
        posture = tracer.posture(free, tracer.state(graph, "state"), augmented, t, within)
        _, bare = tracer.moving(free, posture, tracer.mask(augmented), tracer.augmented.expected(augmented))
        known = found([*bare.accelerations, *bare.multipliers])
    return [node for id_, node in every.items() if id_ not in known]


def _gaps(tracer: Tracer, graph: Graph, model: Model, values: Sequence[Any]) -> list[Any]:
    """The differences of all numbers that laws compare: where one changes its sign, another branch begins."""
    t, within = graph.input("clock", layout.TIME), graph.input("clock", layout.MIDDLE)
    return [_gap(node) for node in compared(tracer, graph, model, t, within, values)]


def _gap(node: Symbol) -> Any:
    """Of a comparison: below 0 where, and only where, it is something else than where both sides are equal."""
    x, y = node.args
    return x - y if node.op == "<" else y - x


def _integrated(tracer: Tracer, model: Model, rates: Sequence[Any], others: Sequence[Any]) -> list[int]:
    """The rows of the elements whose series are needed: all that move, but of a rotation matrix two rows, or all three
    where something else reads them."""
    matrices = [part.rows for part in tracer.parts(model) if len(part.rows) == len(so3.IDENTITY)]
    own = {row: (matrix, n // 3) for matrix in matrices for n, row in enumerate(matrix)}
    needed: dict[tuple[range, int], None] = {}
    read = _read([*others, *(rate for row, rate in enumerate(rates) if row not in own)])
    needed = dict.fromkeys(own[row] for row in read if row in own)
    for matrix in matrices:
        for n in range(2, -1, -1):
            if sum(which in needed for which in ((matrix, 0), (matrix, 1), (matrix, 2))) < 2:
                needed[matrix, n] = None
    return [
        row for row, rate in enumerate(rates)
        if (own[row] in needed if row in own else isinstance(rate, Symbol) or rate != 0.0)
    ]  # fmt: skip


def _read(values: Sequence[Any]) -> list[int]:
    """The rows of the state that these depend on."""
    return sorted({int(x.args[1]) for x in live(values) if x.op == "input" and x.args[0] == "state"})


def _lengths(tracer: Tracer, places: dict[int, int], made: Orders, stricter: float) -> tuple[Number, Number]:
    """How long a step may be, from the last two coefficients, and the same within what is left of the run, or until F
    jumps: a series that ends by itself, as in a fall, has endless steps."""
    graph, model = tracer.graph()
    tolerance = graph.inputs("clock", layout.TOLERANCES, layout.TOLERANCE)
    found = []
    for order in (tracer.method.order - 1, tracer.method.order):
        worst: Number = 0.0
        for part in tracer.parts(model):
            rows = [row for row in part.rows if row in places]
            if not rows:
                continue
            coefficients = [graph.input("extra", made.stride * places[row] + order) for row in rows]
            numbers = [graph.input("state", row) for row in rows]
            worst = maximum(_square(coefficients) * stricter**2 / _allowed(tolerance, part, numbers), worst)
        found.append((order, worst))
    size, t, within = taylor.length(found), graph.input("clock", layout.TIME), graph.input("clock", layout.MIDDLE)
    return size, minimum(size, 2.0 * (within - t))


def _square(numbers: Sequence[Number]) -> Number:
    total: Number = 0.0
    for x in numbers:
        total = total + x * x
    return total


def _allowed(tolerance: Vector, part: Part, numbers: Sequence[Number]) -> Number:
    """The square of what the tolerance allows for a part of a state."""
    allowed = tolerance[1 + part.kind]
    if part.kind != taylor.ROTATION:
        allowed = allowed + tolerance[0] * sqrt(_square(numbers))
    return allowed * allowed


def _sums(tracer: Tracer, graph: Graph, made: Expansion, h: Number) -> dict[int, Number]:
    """Of every series (by its place) the sum at h."""
    return {place: _sum(tracer, graph, made, place, h) for place in range(made.gaps.start)}


def _sum(tracer: Tracer, graph: Graph, made: Expansion, place: int, h: Number) -> Number:
    first = layout.series_row(tracer.sizes) + made.kernel.orders.stride * place
    total: Number = graph.input("extra", first + tracer.method.order)
    for k in range(tracer.method.order - 1, -1, -1):
        total = graph.input("extra", first + k) + h * total
    return total


def _moved(tracer: Tracer, graph: Graph, model: Model, made: Expansion, h: Number) -> tuple[list[Vector], list[Number]]:
    """The elements at h, and what is augmented there but for what loops need."""
    sums = _sums(tracer, graph, made, h)
    x: list[Number] = list(graph.inputs("state", tracer.element * tracer.elements))
    for row, place in made.places.items():
        x[row] = sums[place]
    for part in tracer.parts(model):
        _upright(x, part, made)
    size = tracer.element
    new = [tuple(x[size * i : size * (i + 1)]) for i in range(tracer.elements)]
    augmented = list(tracer.augmented_rows(graph))
    count = len(tracer.augmented.angles)
    near = (*(sums[made.angles + n] for n in range(count)), *augmented[count:])
    t = graph.input("clock", layout.TIME)
    augmented[:count] = tracer.augmented.counted(model, tracer.posture(model, new, near, t + h).now)
    if tracer.augmented.work:
        augmented[count] = augmented[count] + sums[made.work]
    return new, augmented


def _upright(x: list[Any], part: Part, made: Expansion) -> None:
    """A rotation on the group, from those of its rows that are integrated."""
    rows = part.rows
    if part.kind != taylor.ROTATION or (rows[0] not in made.places and rows[-1] not in made.places):
        return
    if len(rows) == 2:
        c, s = (x[row] for row in rows)
        over = 1.0 / sqrt(c * c + s * s)
        x[rows[0]], x[rows[1]] = over * c, over * s
        return
    i, j = [n for n in range(3) if rows[3 * n] in made.places][-2:]
    a, b = so3.upright(*(tuple(x[row] for row in rows[3 * n : 3 * n + 3]) for n in (i, j)))
    third = so3.cross(a, b) if j - i == 1 else so3.cross(b, a)
    for n, own in ((i, a), (j, b), (3 - i - j, third)):
        for c, row in zip(own, rows[3 * n : 3 * n + 3], strict=True):
            x[row] = c


def _step(tracer: Tracer, made: Expansion) -> Kernel:
    graph, model = tracer.graph()
    h = graph.input("clock", layout.LENGTH)
    new, augmented = _moved(tracer, graph, model, made, h)
    first, old = layout.series_row(tracer.sizes), tracer.augmented_rows(graph)
    place = made.angles - 2
    nonsingular, margin = (graph.input("extra", first + made.kernel.orders.stride * (place + n)) for n in range(2))
    square: Number = 0.0
    for element in new:
        for c in element:
            square = square + c * c
    if tracer.augmented.accelerations:
        count = len(tracer.augmented.angles) + tracer.augmented.work
        after = tracer.augmented.after(old, _accelerations(tracer, graph, model, made, h), h)
        augmented[count : count + len(after)] = after
    if tracer.augmented.masks:
        largest = tracer.augmented.first_mode - 1
        augmented[largest] = maximum(margin, old[largest])
    outputs = [x for element in new for x in element] + augmented
    outputs += [verdict(0.0, square, nonsingular, nonsingular), *([margin] if tracer.augmented.masks else [])]
    rows = list(range(len(outputs)))
    if made.gaps:
        control = layout.first_slope(tracer.sizes) + layout.control_row(tracer.sizes)
        rows += [control + row for row in (layout.ERROR, layout.FACTOR, layout.REMEMBERED)]
        outputs += _cut(tracer, graph, made, h)
    return tracer.kernel("step", outputs, rows)


def _cut(tracer: Tracer, graph: Graph, made: Expansion, h: Number) -> tuple[Number, Number, Number]:
    """What is said of a step in which another branch begins: it is to end directly behind, within what the tolerance
    leaves of a step that nothing cuts. 2, and the factor to its length; 0 where it already ends so; and how far the
    first branch certainly holds (s)."""
    t, tolerance = graph.input("clock", layout.TIME), graph.input("clock", layout.TOLERANCE)
    uncut = graph.input("extra", layout.control_row(tracer.sizes) + layout.REMEMBERED)
    beyond = BEYOND * tolerance * uncut
    beyond = maximum(beyond, LEAST_BEYOND * (t + h))
    first: Number = 2.0 * h
    end: Number = 2.0 * h
    for place in made.gaps:
        closes, by = gaps.crossing(partial(_sum, tracer, graph, made, place), h, beyond)
        first, end = minimum(closes, first), minimum(by, end)
    late = h - end > beyond
    holds = where(first <= h, maximum(first - BEFORE * beyond, 0.0), h)
    return where(late, 2.0, 0.0), where(late, end / h, 1.0), holds


def _defect(tracer: Tracer, made: Expansion) -> Kernel:
    """How far the derivative of the sum is from F at the end of a step, or before the kink behind which it ends: the
    last terms of a series do not tell of what is narrow and far from its start."""
    graph, model = tracer.graph()
    sizes, control = tracer.sizes, layout.control_row(tracer.sizes)
    t, h, within = (graph.input("clock", row) for row in (layout.TIME, layout.LENGTH, layout.MIDDLE))
    if made.gaps:
        h = graph.input("extra", control + layout.REMEMBERED)
        state, augmented = _moved(tracer, graph, model, made, h)
    else:
        rows = graph.inputs("extra", layout.state_rows(sizes), -layout.first_slope(sizes))  # the new state
        elements = range(0, layout.element_rows(sizes), sizes.element)
        state, augmented = [rows[n : n + sizes.element] for n in elements], list(rows[layout.element_rows(sizes) :])
    posture = tracer.posture(model, state, tuple(augmented), t + h, within)
    mask, expected = tracer.mask(tuple(augmented)), tracer.augmented.expected(tuple(augmented))
    rates = tracer.rates(model, state, tracer.moving(model, posture, mask, expected)[0])
    every, tolerance = flat(state), graph.inputs("clock", layout.TOLERANCES, layout.TOLERANCE)
    worst: Number = 0.0
    for part in tracer.parts(model):
        moving = [row for row in part.rows if row in made.places]
        if part.kind > taylor.ROTATION and moving:
            lacking = [rates[row] - _derivative(tracer, graph, made, made.places[row], h) for row in moving]
            numbers = [every[row] for row in moving]
            worst = maximum(_square(lacking) / _allowed(tolerance, part, numbers), worst)
    own = worst * (h / (tracer.method.order * taylor.DEFECT)) ** 2
    own = where(own >= 0.0, minimum(own, HUGE), 0.0)  # of an F that cannot be, the next series tells
    said, factor = (graph.input("extra", control + row) for row in (layout.ERROR, layout.FACTOR))
    shorter = where(own <= 1.0, factor, taylor.SHORTER)
    outputs = maximum(said, own), where(said > 0.0, factor, shorter)
    return tracer.kernel("defect", outputs, [control + layout.ERROR, control + layout.FACTOR])


def _accelerations(tracer: Tracer, graph: Graph, model: Model, made: Expansion, h: Number) -> list[Number]:
    """At h: the derivatives of the velocities."""
    rows = tracer.velocity_rows(model)
    return [_derivative(tracer, graph, made, made.places[row], h) if row in made.places else 0.0 for row in rows]


def _derivative(tracer: Tracer, graph: Graph, made: Expansion, place: int, h: Number) -> Number:
    """Of the sum of a series, at h."""
    first = layout.series_row(tracer.sizes) + made.kernel.orders.stride * place
    total: Number = 0.0
    for k in range(tracer.method.order, 0, -1):
        total = float(k) * graph.input("extra", first + k) + h * total
    return total


def _dense(tracer: Tracer, made: Expansion) -> Kernel:
    graph, model = tracer.graph()
    h = graph.input("clock", layout.FRACTION) * graph.input("clock", layout.LENGTH)
    new, augmented = _moved(tracer, graph, model, made, h)
    return tracer.kernel("dense", (*(x for element in new for x in element), *augmented))
