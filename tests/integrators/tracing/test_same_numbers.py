"""The same kernels in plain Python, under `@njit`, and traced and compiled: the same numbers up to rounding."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from numba import njit

from lienumba.groups import so3, state
from tests.rigs import plain
from tests.rigs.scenarios import LOOP, PENDULUM, TOP, scenario, simulate, start_of, state_at

STEP, STEPS = 1e-3, 100
MASS, INERTIA, POINT = 15.0, (0.234375, 0.46875, 0.234375), (0.0, -1.0, 0.0)
WEIGHT = (0.0, 0.0, -9.81)


# ---------------------------------------------------------------- a user's own loop around lienumba's kernels
def over(a: Any, b: Any) -> Any:
    return (a[0] / b[0], a[1] / b[1], a[2] / b[2])


def times(a: Any, b: Any) -> Any:
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2])


def solve(S: Any, b: Any) -> Any:
    """S x = b for a symmetric 3x3 matrix, by Cramer's rule."""
    p, q, r = S[0:3], S[3:6], S[6:9]
    d = so3.dot(p, so3.cross(q, r))
    return so3.scale(1.0 / d, (so3.dot(b, so3.cross(q, r)), so3.dot(p, so3.cross(b, r)), so3.dot(p, so3.cross(q, b))))


def field(x: Any) -> Any:
    """F of the heavy top: the pivot's force l, body frame, from (I/m - p~ J^-1 p~) l = the points' acceleration."""
    R, v, w = x[3:12], x[12:15], x[15:18]
    gyro = over(so3.cross(times(INERTIA, w), w), INERTIA)
    b = so3.subtract(
        so3.scale(-1.0, so3.rotate_back(R, WEIGHT)),
        so3.add(so3.cross(w, so3.cross(w, POINT)), so3.cross(gyro, POINT)),
    )
    P = so3.hat(POINT)
    D = (1 / INERTIA[0], 0.0, 0.0, 0.0, 1 / INERTIA[1], 0.0, 0.0, 0.0, 1 / INERTIA[2])
    Q = so3.multiply(P, so3.multiply(D, P))
    m = 1.0 / MASS
    S = (m - Q[0], -Q[1], -Q[2], -Q[3], m - Q[4], -Q[5], -Q[6], -Q[7], m - Q[8])
    force = solve(S, b)
    turning = so3.add(gyro, over(so3.cross(POINT, force), INERTIA))
    return v + w + so3.axpy(m, so3.rotate(R, force), WEIGHT) + turning


def plus(s: Any, f: Any, u: Any) -> Any:
    """u + s f of the algebra."""
    return (
        so3.axpy(s, f[0:3], u[0:3]) + so3.axpy(s, f[3:6], u[3:6])
        + so3.axpy(s, f[6:9], u[6:9]) + so3.axpy(s, f[9:12], u[9:12])
    )  # fmt: skip


def slope(x: Any, u: Any) -> Any:
    f = field(state.product(x, state.exp(u)))
    return state.dexpinv((-u[0], -u[1], -u[2], -u[3], -u[4], -u[5], *u[6:12]), f)


def march(x: Any, h: Any, steps: Any) -> Any:
    """Munthe-Kaas RK4."""
    zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for _ in range(steps):
        a = field(x)
        b = slope(x, plus(h / 2, a, zero))
        c = slope(x, plus(h / 2, b, zero))
        d = slope(x, plus(h, c, zero))
        u = plus(h / 6, d, plus(h / 3, c, plus(h / 3, b, plus(h / 6, a, zero))))
        x = state.product(x, state.exp(u))
    return x


@cache
def jitted() -> Any:
    """`march` and all that it calls under `@njit`."""
    compiled: dict[str, Any] = {}
    for function in (over, times, solve, field, plus, slope, march):
        names = {**function.__globals__, **compiled}
        compiled[function.__name__] = njit(type(function)(function.__code__, names, function.__name__))
    return compiled["march"]


def start() -> tuple[float, ...]:
    _, states = start_of(scenario(TOP, STEP, STEPS * STEP))
    return tuple(states[0].tolist())


def test_a_loop_of_kernels_gives_the_same_in_python_and_under_njit() -> None:
    python, machine = march(start(), STEP, STEPS), jitted()(start(), STEP, STEPS)
    np.testing.assert_allclose(machine, python, rtol=0, atol=1e-11)


def test_the_jitted_loop_gives_what_the_engine_gives() -> None:
    """The closed dexpinv in place of the truncated one: the same order, another error; so with smaller steps."""
    steps, h = 20_000, 1e-5
    theirs = np.array(jitted()(start(), h, steps))
    ours = plain.rows(state_at(simulate(TOP, h, steps * h, projection=("none", "none"))))[0]
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=2e-10)


# ---------------------------------------------------------------- the engine's mechanics
@pytest.mark.parametrize("projection", [("none", "none"), ("local", "mass"), ("local", "identity")], ids="+".join)
@pytest.mark.parametrize(
    ("mechanism", "method", "steps", "bound"),
    [(TOP, "rk4", 80, 1e-11), (TOP, "rk38", 60, 1e-11), (PENDULUM, "kutta3", 80, 1e-12), (LOOP, "heun", 80, 1e-12)],
    ids=["top-rk4", "top-rk38", "pendulum-kutta3", "loop-heun"],
)
def test_compiled_and_plain_python_agree(
    mechanism: dict[str, Any], method: str, steps: int, bound: float, projection: tuple[str, str]
) -> None:
    arguments = (mechanism, STEP, steps * STEP)
    python, most = plain.run(scenario(*arguments, method=method, projection=projection))
    dataset = simulate(*arguments, method=method, projection=projection)
    np.testing.assert_allclose(plain.rows(state_at(dataset)), python, rtol=0, atol=bound)
    assert np.abs(plain.rows(state_at(dataset)) - plain.rows(state_at(dataset, 0))).max() > 0.1
    assert (int(dataset["position_iterations"][-1]), int(dataset["velocity_iterations"][-1])) == most
