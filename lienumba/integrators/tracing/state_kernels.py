"""The kernels that look at one state, or correct it: velocity projection, selection of rows, what is stored."""

from collections.abc import Iterable

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.integrators import codes, layout
from lienumba.integrators.tracing import law_states
from lienumba.integrators.tracing.tracer import Posture, Tracer, finite
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import SLIDE, STICK
from lienumba.mechanics.mechanism.model import Model, reads_state
from lienumba.mechanics.system import constraints, dynamics, kkt, projection
from lienumba.mechanics.system.joint_coordinates import JOINT_COORDINATES
from lienumba.mechanics.system.output_variables import MODE, OUTPUT_VARIABLES, Observation
from lienumba.mechanics.system.switched import turning
from lienumba.mechanics.system.switches import JOINT, LOCK, permanent
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero, minimum, where


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
    code = where(finite(solution.x), code, codes.NON_FINITE)
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
    asked = [x for event in model.events for x in (event.when, *event.numbers)]
    read = [name for x in asked if reads_state(x) for name in x.quantities]
    observed = _observed(tracer, graph, model, posture, mask)[0] if _reads_observed(model, read) else None
    outputs = quantities.conditions(model, posture.now, observed)
    if any(switch.what not in (JOINT, LOCK) for switch in tracer.augmented.switches):
        expected = _expected(tracer, graph)
        multipliers = tracer.moving(model, posture, mask, expected)[1].multipliers
        turns = any(switch.tangents > 1 for switch in tracer.augmented.switches)
        accelerations = tracer.observed(model, posture, mask, expected)[0] if turns else []
        outputs += turning.conditions(model, posture.now, multipliers, accelerations)
        pushing = turning.pushing(model, posture.now, multipliers)
    else:
        outputs += [0.0] * (layout.CONDITIONS * len(tracer.augmented.switches))
        pushing = [0.0] * len(tracer.augmented.switches)
    everything = kinematics.still(posture.now, tuple(range(len(model.bodies))))
    values = [x for event in model.events for x in event.numbers]
    outputs += [quantities.evaluate(model, x, everything, observed) for x in values]
    if values:
        outputs += dynamics.energies(model, posture.now)
    used = tracer.augmented.mask(tracer.augmented_rows(graph), tracer.structure.rows)
    parting = turning.parting(model, posture.now, used)
    return tracer.kernel("events", outputs + [x + y for x, y in zip(pushing, parting, strict=True)])


def measure(tracer: Tracer) -> Kernel:
    """The signals of which something is kept of runs as a whole."""
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    asked = [x for measure in model.measures for x in measure.signals]
    read = [name for x in asked if reads_state(x) for name in x.quantities]
    observed = _observed(tracer, graph, model, posture, mask)[0] if _reads_observed(model, read) else None
    everything = kinematics.still(posture.now, tuple(range(len(model.bodies))))
    return tracer.kernel("measure", [quantities.evaluate(model, x, everything, observed) for x in asked])


def border(tracer: Tracer) -> Kernel:
    """All that a change of modes has to know; the sliding friction of joints is no load in it."""
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    S, b, sound = tracer.border(model, posture.resting(), mask, _expected(tracer, graph))
    now, first = posture.now, constraints.permanent_rows(model)
    w, gap = constraints.rates(model, now)[first:], constraints.residual(model, now)[first:]
    alone = turning.alone(model, now)
    numbers, memory = turning.numbers(model, now, w, b), turning.memory(model, now, w)
    return tracer.kernel("border", (*turning.triangle(S, alone), *w, *b, *gap, *alone, *numbers, *memory, sound))


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


def _reads_observed(model: Model, names: Iterable[str]) -> bool:
    """Whether one of these components needs accelerations or multipliers."""
    return any(quantities.level(model, name) == quantities.OBSERVED for name in names)


def _expected(tracer: Tracer, graph: Graph) -> list[Number] | None:
    return tracer.expected(tracer.augmented_rows(graph), 0.0, graph.input("clock", layout.LENGTH))


def _observed(
    tracer: Tracer, graph: Graph, model: Model, posture: Posture, mask: list[Number]
) -> tuple[quantities.Observed, list[Number]]:
    """What accelerations and multipliers say of a state, and the multipliers."""
    now = posture.now
    accelerations, mu = tracer.observed(model, posture, mask, _expected(tracer, graph))
    if tracer.whole.masked:
        short = {key: minimum(x, 1.0) for key, x in dynamics.shapes(model).items()}  # in m^2
        always = permanent(model)
        least = kkt.least_multipliers(tracer.whole, short, constraints.jacobian(always, now), mu[: tracer.whole.rows])
        mu = [*least, *mu[tracer.whole.rows :]]
    force, torque = constraints.loads(model, now, mu)
    efforts = [[-x for x in mu[rows]] for rows in constraints.rows_of(model)[len(model.joints) :][: len(model.drivers)]]
    reactions = [-x for x in mu[constraints.permanent_rows(model) :]]
    switches = {x.key: reactions[x.first : x.first + x.rows] for x in tracer.augmented.switches}
    return quantities.Observed(accelerations, force, torque, efforts, switches), mu


def observe(tracer: Tracer) -> tuple[Kernel, dict[str, tuple[int, int]]]:
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    now, reactions = posture.now, tracer.method.reactions
    own = [quantities.joined(q.name, part.name) for q in model.quantities for part in quantities.parts(model, q)]
    seen = Observation(model, now, lambda: _observed(tracer, graph, model, posture, mask))
    named = tracer.shown(now)
    for name, x in OUTPUT_VARIABLES.items():
        if x.rows is not None and (reactions or not x.reaction):
            named[name] = list(x.rows(seen))
    if tracer.method.joint_coordinates:
        named |= {name: list(x.rows(seen)) for name, x in JOINT_COORDINATES.items() if x.rows is not None}
    named |= law_states.variables(model, now)
    if tracer.augmented.switches:
        named[MODE.name] = [where(mode.on > SLIDE, STICK, mode.on) for mode in now.modes.values()]
    named |= quantities.observe(model, now, seen.observed if _reads_observed(model, own) else None)
    observed: dict[str, tuple[int, int]] = {}
    outputs: list[Number] = []
    for name, rows in named.items():
        observed[name] = (len(outputs), len(rows))
        outputs += rows
    return tracer.kernel("observe", outputs), observed
