"""What accelerations and multipliers say of a state: quantities that are seen, or measured, and need more than it."""

from collections.abc import Iterable, Sequence

from lienumba.compiler.symbols import Graph
from lienumba.integrators import layout
from lienumba.integrators.tracing.tracer import Posture, Tracer
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model, Timed, reads_state
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.mechanics.system.switches import permanent, switches_of
from lienumba.numerics.number import Number
from lienumba.numerics.operations import minimum


def reads_observed(model: Model, numbers: Iterable[Timed]) -> bool:
    """Whether one of these needs accelerations or multipliers."""
    return needs_observed(model, (name for x in numbers if reads_state(x) for name in x.quantities))


def needs_observed(model: Model, names: Iterable[str]) -> bool:
    """Whether one of these components of quantities needs accelerations or multipliers."""
    return any(quantities.level(model, name) == quantities.OBSERVED for name in names)


def expected(tracer: Tracer, graph: Graph) -> list[Number] | None:
    """The accelerations to be expected where the clock is."""
    return tracer.expected(tracer.augmented_rows(graph), 0.0, graph.input("clock", layout.LENGTH))


def observed(
    tracer: Tracer, graph: Graph, model: Model, posture: Posture, mask: list[Number]
) -> tuple[quantities.Observed, list[Number]]:
    """What accelerations and multipliers say of a state, and the multipliers."""
    known = tracer.observed(model, posture, mask, expected(tracer, graph))
    return said(tracer.whole, model, posture.now, *known)


def said(
    whole: kkt.Structure, model: Model, now: Instant, accelerations: Sequence[Number], mu: Sequence[Number]
) -> tuple[quantities.Observed, list[Number]]:
    """What is observed where the accelerations of all bodies (6 k) and the multipliers of all rows are known, and the
    multipliers; whole: the structure of all permanent rows."""
    multipliers = list(mu)
    if whole.masked:
        short = {key: minimum(x, 1.0) for key, x in dynamics.shapes(model).items()}  # in m^2
        always, rows = permanent(model), whole.rows
        jacobian = constraints.jacobian(always, now)
        multipliers[:rows] = kkt.least_multipliers(whole, short, jacobian, multipliers[:rows])
    force, torque = constraints.loads(model, now, multipliers)
    drives = constraints.rows_of(model)[len(model.joints) :][: len(model.drivers)]
    efforts = [[-x for x in multipliers[rows]] for rows in drives]
    reactions = [-x for x in multipliers[constraints.permanent_rows(model) :]]
    switches = {x.key: reactions[x.first : x.first + x.rows] for x in switches_of(model)}
    return quantities.Observed([*accelerations], force, torque, efforts, switches), multipliers
