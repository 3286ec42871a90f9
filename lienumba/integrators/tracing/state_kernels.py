"""The kernels that look at one state, or correct it: velocity projection, selection of rows, what is stored."""

from collections.abc import Iterable
from dataclasses import replace
from math import nan

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.integrators import codes, layout
from lienumba.integrators.methods.step_ends import Ends, Known, added, matters
from lienumba.integrators.tracing import law_states
from lienumba.integrators.tracing import observed as observing
from lienumba.integrators.tracing.observed import needs_observed, reads_observed
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import SLIDE, STICK
from lienumba.mechanics.mechanism.model import INTEGRAL, NONE, Model
from lienumba.mechanics.system import constraints, dynamics, projection
from lienumba.mechanics.system.joint_coordinates import JOINT_COORDINATES
from lienumba.mechanics.system.output_variables import MODE, OUTPUT_VARIABLES, Observation
from lienumba.mechanics.system.switched import turning
from lienumba.mechanics.system.switches import unforced
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero, maximum, where


def velocity(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    rows, solution = tracer.velocity_projected(graph, model, posture, mask)
    size = tracer.element
    new = [tuple(rows[size * i : size * (i + 1)]) for i in range(tracer.elements)]
    there = tracer.posture(model, new, tracer.augmented_rows(graph), graph.input("clock", layout.TIME)).now
    counts = tracer.counted(solution, mask, "velocity")
    violation = projection.velocity_violation(model, there, counts)
    code = where(solution.sound > 0.0, 0.0, codes.SINGULAR)
    if tracer.structure.looped:
        lost = projection.lost_rate(model, there, counts)
        code = where(lost < projection.LOST_RATE, code, codes.SINGULAR)
        code = where(projection.turned(model, posture.now, there) > 0.0, codes.SINGULAR, code)
    if not is_zero(leapt := projection.leapt(model, posture.now)):
        code = where(leapt > 0.0, codes.SINGULAR, code)
    code = where(codes.finite(solution.x), code, codes.NON_FINITE)
    return tracer.kernel("velocity", (*rows, violation, code))


def schur(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    triangle, scales = tracer.schur(model, tracer.now(graph, model)[0])
    return tracer.kernel("schur", (*triangle, *scales))


def sample(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    return tracer.kernel("sample", tracer.sampled(graph, model, tracer.now(graph, model)[0]))


def events(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    used = tracer.augmented.mask(tracer.augmented_rows(graph), tracer.structure.rows)
    asked = [x for event in model.events for x in (event.when, *event.numbers)]
    observed = observing.observed(tracer, graph, model, posture, mask)[0] if reads_observed(model, asked) else None
    outputs = quantities.conditions(model, posture.now, observed)
    if not unforced(tracer.augmented.switches):
        expected = observing.expected(tracer, graph)
        multipliers = tracer.moving(model, posture, mask, expected)[1].multipliers
        turns = any(switch.tangents > 1 for switch in tracer.augmented.switches)
        accelerations = tracer.observed(model, posture, mask, expected)[0] if turns else []
        outputs += turning.conditions(model, posture.now, multipliers, accelerations, used)
        pushing = turning.pushing(model, posture.now, multipliers)
    else:
        outputs += [0.0] * (layout.CONDITIONS * len(tracer.augmented.switches))
        pushing = [0.0] * len(tracer.augmented.switches)
    everything = kinematics.still(posture.now, tuple(range(len(model.bodies))))
    values = [x for event in model.events for x in event.numbers]
    outputs += [quantities.evaluate(model, x, everything, observed) for x in values]
    if values:
        outputs += dynamics.energies(model, posture.now)
    parting = turning.parting(model, posture.now, used)
    return tracer.kernel("events", outputs + [x + y for x, y in zip(pushing, parting, strict=True)])


def foreseen(tracer: Tracer, model: Model) -> bool:
    """Whether positions and velocities decide about all conditions."""
    return unforced(tracer.augmented.switches) and not reads_observed(model, [event.when for event in model.events])


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
    followed = quantities.followed(model)
    after = _at_end(tracer, graph, model, followed | quantities.lasting(model))
    rates = _rates(tracer, graph, model, followed)
    sizes, ends, rows = tracer.sizes, dict[int, Ends](), dict[int, Number]()
    for n in sorted(followed):
        places = [layout.signal_row(sizes, k) + n for k in (0, layout.CHANGES, layout.RATES)]
        before, changed, rate = (graph.input("out", row) for row in places)
        if n in rates:
            ends[n] = Ends(before, after[n], changed, ((until - t) * rate, (until - t) * rates[n]))
            rows[places[2]] = where(picked == 0.0, rate, rates[n])
        else:
            ends[n] = Ends(before, after[n], changed)
            rows[places[1]] = where(picked == 0.0, changed, ends[n].change)
        rows[places[0]] = where(picked == 0.0, before, after[n])
    some: Number = 0.0
    for n, x in enumerate(kept):
        own = layout.KEPT_ROWS * n
        known, value, condition = Known(*graph.inputs("out", 4, own)), ends.get(x.value), ends.get(x.condition)
        gain: Number | None = None
        if x.kind == INTEGRAL and x.value != NONE:
            place = made.index(x.value) if x.value in made else NONE
            gain = nan if place == NONE else graph.input("out", layout.gain_row(sizes) + place)
        opens = matters(x.kind, known, value, condition, gain)
        holds, taken = None if condition is None else condition.after, where(opens > 0.0, 0.0, picked)
        new = added(x.kind, known, after.get(x.value), holds, gain, taken, t, until)
        places = [layout.KEPT_VALUE, layout.KEPT_TIME, layout.KEPT_TRUE, layout.KEPT_UNDEFINED]
        rows |= {own + at: y for at, old, y in zip(places, known, new, strict=True) if y is not old}
        rows[own + layout.KEPT_OPEN] = opens
        some = opens if n == 0 else maximum(some, opens)
    rows[layout.open_row(sizes)] = where(picked > 0.0, some, -picked)
    return replace(tracer.kernel("keep", rows.values(), [*rows]), renews=True)


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
    """Signals at the end of a step, where F has told those that need accelerations, if it is known there."""
    every, first = quantities.signals(model), layout.seen_row(tracer.sizes)
    told = {n for n in wanted if tracer.sizes.seen and reads_observed(model, [every[n]])}
    return _signals(tracer, graph, model, wanted - told) | {n: graph.input("out", first + n) for n in told}


def _signals(tracer: Tracer, graph: Graph, model: Model, wanted: Iterable[int]) -> dict[int, Number]:
    """Signals of all measures, by their numbers among them."""
    posture, mask = tracer.now(graph, model, leans=True)
    asked = {n: x for n, x in enumerate(quantities.signals(model)) if n in wanted}
    reads = reads_observed(model, asked.values())
    observed = observing.observed(tracer, graph, model, posture, mask)[0] if reads else None
    everything = kinematics.still(posture.now, tuple(range(len(model.bodies))))
    return {n: quantities.evaluate(model, x, everything, observed) for n, x in asked.items()}


def border(tracer: Tracer) -> Kernel:
    """All that a change of modes has to know; the sliding friction of joints is no load in it."""
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    S, b = tracer.border(model, posture.resting(), mask, observing.expected(tracer, graph))
    now, first = posture.now, constraints.permanent_rows(model)
    w, gap = constraints.rates(model, now)[first:], constraints.residual(model, now)[first:]
    alone = turning.alone(model, now)
    numbers, memory = turning.numbers(model, now, w, b), turning.memory(model, now, w)
    return tracer.kernel("border", (*turning.triangle(S, alone), *w, *b, *gap, *alone, *numbers, *memory))


def kick(tracer: Tracer) -> Kernel:
    """Impulses along the switched rows, and the work that they and the permanent rows do."""
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    now, augmented, first = posture.now, tracer.augmented_rows(graph), constraints.permanent_rows(model)
    impulses = graph.inputs("extra", tracer.augmented.switched)
    rows, mu = tracer.kicked(graph, model, posture, mask, impulses)
    size = tracer.element
    new = [tuple(rows[size * i : size * (i + 1)]) for i in range(tracer.elements)]
    there = tracer.posture(model, new, augmented, graph.input("clock", layout.TIME)).now
    before, after = (constraints.rates(model, x)[first:] for x in (now, there))
    prescribed = constraints.time_rate(model, now)
    energy: Number = 0.0
    for row, (impulse, old, w) in enumerate(zip(impulses, before, after, strict=True)):
        energy = energy + impulse * (0.5 * (old + w) - prescribed[first + row])
    for multiplier, rate in zip(mu[:first], prescribed[:first], strict=True):
        energy = energy + multiplier * rate
    behind, work = list(augmented), len(tracer.augmented.angles)
    behind[work] = behind[work] + energy
    return tracer.kernel("kick", (*rows, *behind, energy, *after))


def observe(tracer: Tracer) -> tuple[Kernel, dict[str, tuple[int, int]]]:
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    now, reactions = posture.now, tracer.method.reactions
    own = [quantities.joined(q.name, part.name) for q in model.quantities for part in quantities.parts(model, q)]
    seen = Observation(model, now, lambda: observing.observed(tracer, graph, model, posture, mask))
    named = tracer.shown(now)
    for name, x in OUTPUT_VARIABLES.items():
        if x.rows is not None and (reactions or not x.reaction):
            named[name] = list(x.rows(seen))
    if tracer.method.joint_coordinates:
        named |= {name: list(x.rows(seen)) for name, x in JOINT_COORDINATES.items() if x.rows is not None}
    named |= law_states.variables(model, now)
    if tracer.augmented.switches:
        named[MODE.name] = [where(mode.on > SLIDE, STICK, mode.on) for mode in now.modes.values()]
    named |= quantities.observe(model, now, seen.observed if needs_observed(model, own) else None)
    observed: dict[str, tuple[int, int]] = {}
    outputs: list[Number] = []
    for name, rows in named.items():
        observed[name] = (len(outputs), len(rows))
        outputs += rows
    return tracer.kernel("observe", outputs), observed
