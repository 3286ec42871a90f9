"""The kernels that look at one state, or correct it: projections, exchange of rows, what is stored."""

from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.groups.state import ELEMENT
from lienumba.integrators import carried as carried_
from lienumba.integrators import codes
from lienumba.integrators.charts import LARGEST_STAGE, promised
from lienumba.integrators.tracer import Tracer, finite, flat
from lienumba.mechanics import constraints, dynamics, kkt, projection, quantities
from lienumba.mechanics.motion import Instant
from lienumba.operations import maximum, minimum, where


def position(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    hat, now = tracer.now(graph)[0], tracer.state(graph, "extra")
    held = tracer.held_rows(graph)
    mask = tracer.held.mask(held, tracer.structure.rows)
    x = graph.inputs("extra", 6 * tracer.k, ELEMENT * tracer.elements)
    at = tracer.instant(now, held, hat.t)
    solution = projection.position_correction(model, tracer.structure, at, list(x), mask)
    rotation: Any = 0.0
    for i in range(tracer.k):
        rotation = maximum(promised(solution.x[6 * i + 3 : 6 * i + 6]), rotation)
    new = projection.placed(hat.bodies, solution.x)
    counts = projection.counted(solution, mask, "position")
    violation = projection.position_violation(model, tracer.instant(new, held, hat.t), counts)
    code = where(rotation < LARGEST_STAGE, 0.0, codes.NOT_CONVERGED)
    if tracer.structure.looped:
        lost = projection.lost(model, tracer.instant(new, held, hat.t), counts)
        code = where(lost < projection.LOST, code, codes.SINGULAR)
    code = where(solution.sound > 0.0, code, codes.SINGULAR)
    code = where(finite(solution.x), code, codes.NON_FINITE)
    rest = [0.0] * (6 * tracer.carried.elements)
    return tracer.kernel("position", (*tracer.with_carried(graph, new), *solution.x, *rest, violation, code))


def velocity(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    now, mask = tracer.now(graph)
    solution = projection.velocity_correction(model, tracer.structure, now, tracer.method.velocity, mask)
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
    return tracer.kernel("velocity", (*tracer.with_carried(graph, new), violation, code))


def exchange(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    now, _ = tracer.now(graph)
    triangle, scales = kkt.exchange(tracer.whole, dynamics.shapes(model), constraints.jacobian(model, now))
    return tracer.kernel("exchange", (*triangle, *scales))


def sample(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    now, _ = tracer.now(graph)
    carried = tracer.carried.placed(carried_.sampled(model, now))
    return tracer.kernel("sample", flat((*now.bodies, *carried)))


def observe(tracer: Tracer) -> tuple[Kernel, dict[str, tuple[int, int]]]:
    graph, model = tracer.graph()
    now, mask = tracer.now(graph)
    expected = tracer.expected(tracer.held_rows(graph), 0.0)
    solution = dynamics.accelerations(model, tracer.structure, now, mask, expected, tracer.method.baumgarte)
    mu = solution.mu
    if tracer.whole.masked:
        short = {key: minimum(x, 1.0) for key, x in dynamics.shapes(model).items()}  # in m^2
        mu = kkt.least_multipliers(tracer.whole, short, constraints.jacobian(model, now), mu)
    kinetic, potential = dynamics.energies(model, now)
    force, torque = constraints.loads(model, now, mu)
    efforts = [[-x for x in mu[rows]] for rows in constraints.rows_of(model)[len(model.joints) :]]
    named = {
        "kinetic_energy": [kinetic],
        "potential_energy": [potential],
        "position_violation": [constraints.largest(constraints.residual(model, now))],
        "velocity_violation": [constraints.largest(constraints.rate_and_bias(model, now)[0])],
        "multiplier": mu,
        "joint_force": force,
        "joint_torque": torque,
        "driver_effort": [x for rows in efforts for x in rows],
    }
    named |= carried_.variables(model, now)
    named |= quantities.observe(model, now, quantities.Observed(solution.x, force, torque, efforts))
    observed: dict[str, tuple[int, int]] = {}
    outputs: list[Any] = []
    for name, rows in named.items():
        observed[name] = (len(outputs), len(rows))
        outputs += rows
    return tracer.kernel("observe", outputs), observed
