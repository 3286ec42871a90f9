"""The kernels that look at signals at one state, and say what the end of a step adds to what is kept."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import reduce
from math import nan

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph, live
from lienumba.integrators import layout
from lienumba.integrators.bounds import finite_size
from lienumba.integrators.methods.step_ends import Ends, Known, Past, added, matters
from lienumba.integrators.tracing.measuring.signals import said_itself
from lienumba.integrators.tracing.observed import observed, reads_observed
from lienumba.integrators.tracing.series_kernels import compared
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.model import INTEGRAL, NONE, Kept, Model
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, maximum, where

SIGNAL_ROWS = (0, *range(layout.CHANGES, layout.LARGEST_RATES + 1))  # of what is followed
NEARER = 10.0  # times, or more, is a sum than the estimate of its error says, which is of a lower order


def measure(tracer: Tracer) -> Kernel:
    """The signals of which something is kept of runs as a whole."""
    graph, model = tracer.graph()
    wanted = range(len(quantities.signals(model)))
    return tracer.kernel("measure", _signals(tracer, graph, model, wanted).values())


def keep(tracer: Tracer) -> Kernel:
    """What the end of a step adds to what is kept of runs, at `out`; extra: what drivers know of lanes, PICKED 1 where
    a step is over, -1 where it is left before its end. Where what is between its ends may matter, nothing is added, and
    KEPT_OPEN says so."""
    graph, model = tracer.graph()
    t, until, picked = (graph.input("extra", row) for row in (layout.T, layout.UNTIL, layout.PICKED))
    kept, made = quantities.kept(model), tracer.integrands
    followed, turning = quantities.followed(model), quantities.turning(model)
    after = _at_end(tracer, graph, model, followed | quantities.lasting(model))
    rates = _rates(tracer, graph, model, followed)
    sizes, ends, rows = tracer.sizes, dict[int, Ends](), dict[int, Number]()
    length, even = until - t, _smooth(tracer, followed - {*rates})
    lengths = graph.inputs("out", layout.PAST, layout.length_row(sizes))
    for n, (old, new) in enumerate(zip(lengths, (length, *lengths), strict=False) if even else ()):
        rows[layout.length_row(sizes) + n] = where(picked == 0.0, old, new)
    for n in sorted(followed):
        places = [layout.signal_row(sizes, k) + n for k in SIGNAL_ROWS]
        before, changed, earlier, rate, size, fastest = (graph.input("out", row) for row in places)
        past = Past((changed, earlier), (length, *lengths))
        if n in rates:
            fast = maximum(absolute(rates[n]), fastest)  # NaN is none
            both = (length * rate, length * rates[n])
            ends[n] = Ends(before, after[n], past, both, size=size, turn=length * fast)
            rows[places[3]] = where(picked == 0.0, rate, rates[n])
            rows[places[5]] = where(picked == 0.0, fastest, fast)
        else:
            ends[n] = Ends(before, after[n], past, None, n in even, size)
            rows[places[1]] = where(picked == 0.0, changed, ends[n].change)
            rows |= {places[2]: where(picked == 0.0, earlier, changed)} if n in even else {}
        rows[places[0]] = where(picked == 0.0, before, after[n])
        rows[places[4]] = where(picked == 0.0, size, maximum(finite_size(after[n]), size))
    gains = _gains(tracer, graph, kept)
    if tracer.method.adaptive:
        rows |= {layout.gain_row(sizes) + made.index(n): gain for n, gain in gains.items()}
    some: Number = 0.0
    for n, x in enumerate(kept):
        own = layout.KEPT_ROWS * n
        known, value, condition = Known(*graph.inputs("out", 5, own)), ends.get(x.value), ends.get(x.condition)
        gain: Number | None = None
        if x.kind == INTEGRAL and x.value != NONE:
            gain = gains.get(x.value, nan)
        bends, turns = ([ends[k] for k in turning.get(signal, ())] for signal in (x.value, x.condition))
        opens = matters(x.kind, known, value, condition, gain, bends, turns)
        holds, taken = None if condition is None else condition.after, where(opens > 0.0, 0.0, picked)
        new = added(x.kind, known, after.get(x.value), holds, gain, taken, t, until)
        if holds is not None:
            size = maximum(finite_size(holds), known.size)
            new = new._replace(size=where(picked == 0.0, known.size, size))
        places = [layout.KEPT_VALUE, layout.KEPT_TIME, layout.KEPT_PEAK, layout.KEPT_UNDEFINED, layout.KEPT_SIZE]
        rows |= {own + at: y for at, old, y in zip(places, known, new, strict=True) if y is not old}
        rows[own + layout.KEPT_OPEN] = opens
        some = opens if n == 0 else maximum(some, opens)
    rows[layout.open_row(sizes)] = where(picked > 0.0, some, -picked)
    return replace(tracer.kernel("keep", rows.values(), [*rows]), renews=True)


def _gains(tracer: Tracer, graph: Graph, kept: Sequence[Kept]) -> dict[int, Number]:
    """What the step says that it adds to the integrals of signals, by their numbers; NaN where a tolerance chooses
    steps, and this is not as exact as that would demand of a state of which it were the change."""
    gains, first, apart = dict[int, Number](), layout.gain_row(tracer.sizes), tracer.sizes.integrands
    for place, signal in enumerate(tracer.integrands):
        gains[signal] = graph.input("out", first + place)
        if tracer.method.adaptive:
            square, most = (graph.input("out", first + n * apart + place) for n in (1, 2))
            mine = (n for n, x in enumerate(kept) if x.kind == INTEGRAL and x.value == signal)
            known = (graph.input("out", layout.KEPT_ROWS * n + layout.KEPT_VALUE) for n in mine)
            largest = reduce(maximum, (absolute(x) for x in known), most)
            allowed = NEARER * graph.input("clock", layout.TOLERANCE) * largest
            gains[signal] = where(square <= allowed * allowed, gains[signal], nan)
    return gains


def _rates(tracer: Tracer, graph: Graph, model: Model, wanted: Iterable[int]) -> dict[int, Number]:
    """The rates of those signals of which they are known at the end of a step."""
    every = quantities.signals(model)
    if tracer.sizes.seen:
        first = layout.seen_row(tracer.sizes)
        return {n: graph.input("out", first + n) for n in wanted if quantities.has_rate(model, every[n])}
    now = tracer.now(graph, model)[0].now
    view = kinematics.moving(kinematics.still(now, tuple(range(len(model.bodies)))))
    asked = {n: every[n] for n in wanted if quantities.moves(model, every[n])}
    return {n: lift(quantities.evaluate(model, x, view)).b for n, x in asked.items()}


def _at_end(tracer: Tracer, graph: Graph, model: Model, wanted: set[int]) -> dict[int, Number]:
    """Signals at the end of a step, of which F has told some, if it is known there."""
    every = quantities.signals(model)
    first = layout.seen_row(tracer.sizes) + len(every)
    told = {n for n in wanted if tracer.sizes.seen and said_itself(model, every[n])}
    return _signals(tracer, graph, model, wanted - told) | {n: graph.input("out", first + n) for n in told}


def _signals(tracer: Tracer, graph: Graph, model: Model, wanted: Iterable[int]) -> dict[int, Number]:
    """Signals of all measures, by their numbers among them."""
    posture, mask = tracer.now(graph, model, leans=True)
    asked = {n: x for n, x in enumerate(quantities.signals(model)) if n in wanted}
    reads = reads_observed(model, asked.values())
    known = observed(tracer, graph, model, posture, mask)[0] if reads else None
    everything = kinematics.still(posture.now, tuple(range(len(model.bodies))))
    return {n: quantities.evaluate(model, x, everything, known) for n, x in asked.items()}


def _smooth(tracer: Tracer, wanted: set[int]) -> set[int]:
    """The wanted signals (by their numbers) without kinks and jumps."""
    if not wanted:
        return set()
    graph, model = tracer.graph(Graph(analytic=True))
    values = _signals(tracer, graph, model, wanted)
    t, lean = (graph.input("clock", row) for row in (layout.TIME, layout.LEAN))
    plain = {n for n, x in values.items() if not any(node.op == "gather" for node in live([x]))}
    return {n for n in plain if not compared(tracer, graph, model, t, t + lean, [values[n]])}
