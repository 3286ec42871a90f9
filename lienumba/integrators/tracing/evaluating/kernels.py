"""The right-hand side, the equations of motion and chosen output variables of a mechanism, each as one kernel."""

from collections.abc import Sequence
from dataclasses import dataclass

from lienumba.compiler import native
from lienumba.compiler.emit import Kernel
from lienumba.compiler.foreign.calls import linked
from lienumba.compiler.symbols import uncollected
from lienumba.integrators.methods.charts import JOINT
from lienumba.integrators.tracing import observed as observing
from lienumba.integrators.tracing import state_kernels
from lienumba.integrators.tracing.joint.tracer import JointTracer
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import RowSelection
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints, dynamics
from lienumba.numerics.number import Number

Wanted = Sequence[tuple[str, int]]  # variables of the dataset, each with the number of one of its components


@dataclass(frozen=True)
class Evaluating:
    """addresses, rows: of each kernel, and of what it writes; prepares: addresses of the functions that fill hoisted
    rows; engines: which hold the code; bodies, constraints: how many bodies there are, and rows of C; parameters: rows
    of them with what is hoisted; hoists: those on which hoisted ones depend; work_rows: that the kernels need."""

    addresses: dict[str, int]
    rows: dict[str, int]
    prepares: tuple[int, ...]
    engines: tuple[object, ...]
    bodies: int
    constraints: int
    parameters: int
    hoists: frozenset[int]
    work_rows: int


@uncollected()
def compiled(model: Model, method: Method, selection: RowSelection, wanted: Wanted, parameters: int) -> Evaluating:
    """Trace and compile the kernels; parameters: rows of them that other kernels use."""
    made = JointTracer if method.coordinates == JOINT else Tracer
    tracer = made(split(model)[0], method, selection, True)
    kernels = [_rhs(tracer), _equations(tracer), *([_observe(tracer, wanted)] if wanted else [])]
    addresses, prepares, engines, work = {}, [], [], 0
    for kernel in kernels:
        moved = kernel.hoisted_from(parameters)
        parameters += len(moved.hoisted)
        text = linked(moved.text())
        engine, found = native.load(native.compile_text(text), [kernel.name, f"{kernel.name}_prepare"])
        addresses[kernel.name] = found[kernel.name]
        prepares.append(found[f"{kernel.name}_prepare"])
        engines.append(engine)
        work = max(work, moved.work_rows)
    hoists = frozenset[int]().union(*(kernel.hoists for kernel in kernels))
    bodies, constraints = tracer.k, tracer.structure.rows
    n = 6 * bodies
    rows = {kernel.name: len(kernel.outputs) for kernel in kernels}
    rows["equations"] = (n + 1) * (n + constraints)
    tracer.close()
    return Evaluating(addresses, rows, tuple(prepares), tuple(engines), bodies, constraints, parameters, hoists, work)


def _rhs(tracer: Tracer) -> Kernel:
    """Accelerations of all bodies and multipliers of all rows of C; with joint coordinates also those of the rates."""
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    expected = observing.expected(tracer, graph)
    accelerations, multipliers = tracer.observed(model, posture, mask, expected)
    outputs = [*accelerations, *multipliers]
    if isinstance(tracer, JointTracer):
        outputs += tracer.moving(model, posture, mask, expected)[1].accelerations
    return tracer.kernel("rhs", outputs)


def _equations(tracer: Tracer) -> Kernel:
    """M, C, Q and xi (Terze et al. 2015, eqs. 10-15), one behind the other, M and C by rows; what is zero by the
    structure is not written."""
    graph, model = tracer.graph()
    now, n = tracer.now(graph, model)[0].now, 6 * tracer.k
    entries = {(i, j): x for (i, j), x in dynamics.mass_matrix(model, now).items()}
    entries |= {(j, i): x for (i, j), x in entries.items()}
    entries |= {(n + row, j): x for (row, j), x in constraints.jacobian(model, now).items()}
    columns = [*dynamics.loads(model, now), *constraints.required(model, now, tracer.method.baumgarte)]
    first = n * (n + tracer.structure.rows)
    rows = [*(n * i + j for i, j in entries), *range(first, first + len(columns))]
    return tracer.kernel("equations", [*entries.values(), *columns], rows)


def _observe(tracer: Tracer, wanted: Wanted) -> Kernel:
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    named: dict[str, list[Number]] = state_kernels.named(tracer, graph, model, posture, mask)
    for n, part in enumerate((range(3), range(3, 12), range(12, 15), range(15, 18))):
        own = [body[row] for body in posture.now.bodies for row in part]
        named[("position", "rotation", "velocity", "angular_velocity")[n]] = own
    return tracer.kernel("observe", [named[name][component] for name, component in wanted])
