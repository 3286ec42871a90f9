"""The engine's own kernels run as plain Python on floats: what the compiled driver does, in its most readable form."""

from typing import Any

import numpy as np

from lienumba.integrators.methods import munthe_kaas
from lienumba.integrators.methods.charts import R3xSO3
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import UNIQUE
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.system import dynamics, embedded, kkt, projection
from lienumba.mechanics.system.body_axes import Axes
from tests.facade import METHODS, Instant, resolve
from tests.rigs.scenarios import start_of

Bodies = tuple[tuple[float, ...], ...]


def run(data: dict[str, Any]) -> tuple[np.ndarray, tuple[int, int]]:
    """The final state (k, 18) of the nominal run of a scenario, and the most iterations of both projections."""
    resolved = resolve(data)
    settings: Any = resolved.data
    model, states = start_of(data)
    structure = kkt.Structure.of(model)
    axes = Tracer(split(model)[0], Method(settings.integrator.method, "none", "none"), UNIQUE, fixed=True).axes
    x: Bodies = tuple(tuple(body) for body in states.tolist())
    most = (0, 0)
    tableau = METHODS[settings.integrator.method]
    chart = R3xSO3(max(tableau.order - 2, 0))

    def stage(x: Bodies, u: Any, t: float) -> Any:
        def F(bodies: Bodies) -> Any:
            a = dynamics.accelerations(model, structure, Instant(bodies), axes=axes).x
            return tuple((*body[12:18], *a[6 * i : 6 * i + 6]) for i, body in enumerate(bodies))

        return munthe_kaas.slope(chart, x, u, F)

    for n in range(resolved.steps):
        h = settings.integrator.step
        x, *_ = munthe_kaas.step(chart, tableau, x, n * h, h, stage)
        used = (0, 0)
        if settings.projection.position != "none":
            x, positions = project_positions(model, structure, x, settings.projection, axes)
            used = (positions, 0)
        if settings.projection.velocity != "none":
            x, velocities = project_velocities(model, structure, x, settings.projection, axes)
            used = (used[0], velocities)
        most = (max(most[0], used[0]), max(most[1], used[1]))
    return np.array(x), most


def project_positions(
    model: Any, structure: kkt.Structure, hat: Bodies, settings: Any, axes: Axes
) -> tuple[Bodies, int]:
    """By either form; as a chord method with the elimination of the first iteration."""
    state, x, mu, mask = hat, [0.0] * (6 * len(hat)), [0.0] * structure.rows, [1.0] * structure.rows
    first: Any = None
    for iteration in range(1, 20):
        now, again = Instant(state), settings.chord and first is not None
        if settings.position == "local":
            solution = (
                projection.chord_correction(model, first, now, x, mu, mask, axes)
                if again
                else projection.position_correction(model, structure, now, x, mask, axes)
            )
            state = projection.placed(hat, solution.x)
            violation = projection.position_violation(model, Instant(state))
        else:
            solution = (
                embedded.chord_correction(model, first, now, hat, mu, mask)
                if again
                else embedded.correction(model, structure, now, hat, mask)
            )
            state = embedded.placed(state, solution.x)
            violation = max(projection.position_violation(model, Instant(state)), embedded.violation(state))
        first, x, mu = first or solution.by, solution.x, solution.mu
        if violation <= settings.tolerance:
            return state, iteration
    raise RuntimeError(f"left {violation}")


def project_velocities(
    model: Any, structure: kkt.Structure, state: Bodies, settings: Any, axes: Axes
) -> tuple[Bodies, int]:
    for iteration in range(1, 20):
        x = projection.velocity_correction(
            model, structure, Instant(state), projection.WEIGHTS[settings.velocity], [1.0] * structure.rows, axes
        ).x
        state = tuple(
            (*body[0:12], *np.add(body[12:18], x[6 * i : 6 * i + 6]).tolist()) for i, body in enumerate(state)
        )
        violation = projection.velocity_violation(model, Instant(state))
        if violation <= settings.tolerance:
            return state, iteration
    raise RuntimeError(f"left {violation}")


def rows(state: Any) -> np.ndarray:
    """(k, 18) of the twin's r, R, v, w."""
    r, R, v, w = state
    return np.hstack([r, R.reshape(-1, 9), v, w])
