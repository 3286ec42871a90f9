"""The kernels that look at one state, or correct it: velocity projection, selection of rows, what is stored."""

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.integrators import codes, layout
from lienumba.integrators.tracing import law_states
from lienumba.integrators.tracing.tracer import Tracer, finite, flat
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model, reads_state
from lienumba.mechanics.system import constraints, dynamics, kkt, projection
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES, Observation
from lienumba.numerics.number import Number
from lienumba.numerics.operations import minimum, where


def velocity(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    now, mask = tracer.now(graph)
    weight = projection.WEIGHTS[tracer.method.velocity]
    solution = projection.velocity_correction(model, tracer.structure, now, weight, mask)
    new = tuple(
        body[0:12] + tuple(v + x for v, x in zip(body[12:18], solution.x[6 * i : 6 * i + 6], strict=True))
        for i, body in enumerate(now.bodies)
    )
    counts = projection.counted(solution, mask, "velocity")
    violation = projection.velocity_violation(model, Instant(new, now.t, now.angles), counts)
    code = where(solution.sound > 0.0, 0.0, codes.SINGULAR)
    if tracer.structure.looped:
        lost = projection.lost_rate(model, Instant(new, now.t, now.angles), counts)
        code = where(lost < projection.LOST_RATE, code, codes.SINGULAR)
    code = where(finite(solution.x), code, codes.NON_FINITE)
    return tracer.kernel("velocity", (*tracer.with_law_states(graph, new), violation, code))


def schur(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    now, _ = tracer.now(graph)
    triangle, scales = kkt.schur_complement(tracer.whole, dynamics.shapes(model), constraints.jacobian(model, now))
    return tracer.kernel("schur", (*triangle, *scales))


def sample(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    now, _ = tracer.now(graph)
    elements = tracer.law_states.placed(law_states.sampled(model, now))
    return tracer.kernel("sample", flat((*now.bodies, *elements)))


def events(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    now, mask = tracer.now(graph)
    read = [name for event in model.events if reads_state(event.when) for name in event.when.quantities]
    needed = any(quantities.level(model, name) == quantities.OBSERVED for name in read)
    observed = _observed(tracer, graph, model, now, mask)[0] if needed else None
    return tracer.kernel("events", quantities.conditions(model, now, observed))


def _observed(
    tracer: Tracer, graph: Graph, model: Model, now: Instant, mask: list[Number]
) -> tuple[quantities.Observed, list[Number]]:
    """What accelerations and multipliers say of a state, and the multipliers."""
    expected = tracer.expected(tracer.augmented_rows(graph), 0.0, graph.input("clock", layout.LENGTH))
    solution = dynamics.accelerations(model, tracer.structure, now, mask, expected, tracer.method.baumgarte)
    mu = solution.mu
    if tracer.whole.masked:
        short = {key: minimum(x, 1.0) for key, x in dynamics.shapes(model).items()}  # in m^2
        mu = kkt.least_multipliers(tracer.whole, short, constraints.jacobian(model, now), mu)
    force, torque = constraints.loads(model, now, mu)
    efforts = [[-x for x in mu[rows]] for rows in constraints.rows_of(model)[len(model.joints) :]]
    return quantities.Observed(solution.x, force, torque, efforts), mu


def observe(tracer: Tracer) -> tuple[Kernel, dict[str, tuple[int, int]]]:
    graph, model = tracer.graph()
    now, mask = tracer.now(graph)
    seen = Observation(model, now, *_observed(tracer, graph, model, now, mask))
    named = {name: list(x.rows(seen)) for name, x in OUTPUT_VARIABLES.items() if x.rows is not None}
    named |= law_states.variables(model, now)
    named |= quantities.observe(model, now, seen.observed)
    observed: dict[str, tuple[int, int]] = {}
    outputs: list[Number] = []
    for name, rows in named.items():
        observed[name] = (len(outputs), len(rows))
        outputs += rows
    return tracer.kernel("observe", outputs), observed
