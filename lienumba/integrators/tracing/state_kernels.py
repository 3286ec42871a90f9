"""The kernels that look at one state, or correct it: velocity projection, selection of rows, what is stored."""

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.integrators import codes, layout
from lienumba.integrators.tracing import law_states
from lienumba.integrators.tracing import observed as observing
from lienumba.integrators.tracing.observed import needs_observed, reads_observed
from lienumba.integrators.tracing.tracer import Posture, Tracer
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import SLIDE, STICK
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints, dynamics, projection
from lienumba.mechanics.system.joint_coordinates import JOINT_COORDINATES
from lienumba.mechanics.system.output_variables import MODE, OUTPUT_VARIABLES, Observation
from lienumba.mechanics.system.switched import turning
from lienumba.mechanics.system.switches import unforced
from lienumba.mechanics.tolerances import SINGULAR_RATE
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero, where


def velocity(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    rows, solution = tracer.velocity_projected(graph, model, posture, mask)
    size = tracer.element
    new = [tuple(rows[size * i : size * (i + 1)]) for i in range(tracer.elements)]
    there = tracer.posture(model, new, tracer.augmented_rows(graph), graph.input("clock", layout.TIME)).now
    counts = tracer.counted(solution, mask, "velocity")
    violation = projection.velocity_violation(model, there, counts)
    code = where(solution.nonsingular > 0.0, 0.0, codes.SINGULAR)
    if tracer.structure.looped:
        lost = projection.lost_rate(model, there, counts)
        code = where(lost < SINGULAR_RATE, code, codes.SINGULAR)
        code = where(projection.branch_energy_excess(model, posture.now, there) > 0.0, codes.SINGULAR, code)
    if not is_zero(excess := projection.leap_speed_excess(model, posture.now)):
        code = where(excess > 0.0, codes.SINGULAR, code)
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
    accelerations = None if observed is None else observed.accelerations
    if not unforced(tracer.augmented.switches):
        expected = observing.expected(tracer, graph)
        multipliers = tracer.moving(model, posture, mask, expected)[1].multipliers
        turns = any(switch.tangents > 1 for switch in tracer.augmented.switches)
        if turns:
            accelerations = tracer.observed(model, posture, mask, expected)[0]
        given = not tracer.method.adaptive and (tracer.tableau.carries or not tracer.tableau.implicit)
        outputs += turning.contact_guards(model, posture.now, multipliers, accelerations or [], used, not given)
        pushing = turning.friction_speeds(model, posture.now, multipliers)
    else:
        outputs += [0.0] * (layout.CONDITIONS * len(tracer.augmented.switches))
        pushing = [0.0] * len(tracer.augmented.switches)
    if accelerations is None and _sped(tracer, model):
        accelerations = tracer.observed(model, posture, mask, observing.expected(tracer, graph))[0]
    everything = kinematics.still(posture.now, tuple(range(len(model.bodies))))
    values = [x for event in model.events for x in event.numbers]
    outputs += [quantities.evaluate(model, x, everything, observed) for x in values]
    if values:
        outputs += dynamics.energies(model, posture.now)
    parting = turning.redundant_speeds(model, posture.now, used)
    outputs += [x + y for x, y in zip(pushing, parting, strict=True)]
    rates = {} if accelerations is None else law_states.rates(model, posture.now)
    return tracer.kernel("events", outputs + quantities.condition_rates(model, posture.now, accelerations, rates))


def _sped(tracer: Tracer, model: Model) -> bool:
    """Whether the rate of a condition follows from accelerations, or from laws, and steps are as long as the motion
    lets them: then it may pass 0 several times in one."""
    if not (tracer.method.adaptive or tracer.tableau.implicit):
        return False
    conditions = [event.when for event in model.events]
    return any(quantities.flows(model, x) and not quantities.moves(model, x) for x in conditions)


def foreseen(tracer: Tracer, model: Model) -> bool:
    """Whether positions and velocities decide about all conditions, and say how fast these change."""
    if _sped(tracer, model):
        return False
    return unforced(tracer.augmented.switches) and not reads_observed(model, [event.when for event in model.events])


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
    observed: dict[str, tuple[int, int]] = {}
    outputs: list[Number] = []
    for name, rows in named(tracer, graph, model, posture, mask).items():
        observed[name] = (len(outputs), len(rows))
        outputs += rows
    return tracer.kernel("observe", outputs), observed


def named(tracer: Tracer, graph: Graph, model: Model, posture: Posture, mask: list[Number]) -> dict[str, list[Number]]:
    """What is stored beside the state, by variable."""
    now, reactions = posture.now, tracer.method.reactions
    own = [quantities.joined(q.name, part.name) for q in model.quantities for part in quantities.parts(model, q)]
    seen = Observation(model, now, lambda: observing.observed(tracer, graph, model, posture, mask))
    found = tracer.shown(now)
    for name, x in OUTPUT_VARIABLES.items():
        if x.rows is not None and (reactions or not x.reaction):
            found[name] = list(x.rows(seen))
    if tracer.method.joint_coordinates:
        found |= {name: list(x.rows(seen)) for name, x in JOINT_COORDINATES.items() if x.rows is not None}
    found |= law_states.variables(model, now)
    if tracer.augmented.switches:
        found[MODE.name] = [where(mode.on > SLIDE, STICK, mode.on) for mode in now.modes.values()]
    found |= quantities.observe(model, now, seen.observed if needs_observed(model, own) else None)
    return found
