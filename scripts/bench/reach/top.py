"""The heavy top for heyoka: reduced to its pivot by hand, with a quaternion or with two rows of R, and in maximal
coordinates with its multiplier. Inertias are any along the axes of the body; nothing is made of their being equal."""

from typing import Any

import numpy as np

from bench import engine
from bench.reach.problems import Array, Form, Problem, rows, started
from bench.reach.serial import add, cross, plus, scale, times

G = -engine.GRAVITY[2]
ARM = 1.0  # m, from the pivot to the mass centre along y
VARIED = ("bodies.top.mass", "bodies.top.angular_velocity[1]", "bodies.top.angular_velocity[2]")


def data() -> dict[str, Any]:
    """The paper's, 1 % of scatter in mass and spin."""
    body = {"name": "top", "mass": engine.MASS, "inertia": list(engine.INERTIA), "rotation": [1, 0, 0, 0],
            "angular_velocity": list(engine.SPIN)}  # fmt: skip
    joint = {
        "name": "pivot",
        "type": "spherical",
        "bodies": ["ground", "top"],
        "points": [[0, 0, 0], list(engine.PIVOT)],
    }
    scatter = {path: {"distribution": "normal", "std": 0.01, "relative": True} for path in VARIED}
    return {
        "title": "Heavy top", "model": {"gravity": list(engine.GRAVITY), "bodies": [body], "joints": [joint]},
        "integrator": {"method": "dop853", "tolerance": 1e-9, "end_time": engine.END_TIME},
        "output": {"variables": [], "every": engine.END_TIME}, "sweep": {"runs": 2, "seed": 2015, "vary": scatter},
    }  # fmt: skip


def problem(runs: int) -> Problem:
    scenario = data()
    begun = started(scenario, runs)
    m, J = rows(runs, begun.model.bodies[0].mass)[0], [np.longdouble(x) for x in engine.INERTIA]
    w = rows(runs, *begun.states[:, 15:18].T)
    A, B, C = J[0] + m, J[1] + 0 * m, J[2] + m  # about the pivot, for an arm of 1 m
    euler = [(B - C) / A, (C - A) / B, (A - B) / C, m * G / A, m * G / C]
    halves = [2 * euler[0], 2 * euler[1], 2 * euler[2], euler[3] / 2, euler[4] / 2]
    begin = rows(runs, 0, 0, 1, 1, 0, 0, *w), rows(runs, 1, 0, 0, 0, *(w / 2))
    forms = (
        Form("rows", "reduced by hand, two rows of R", _rows, begin[0], rows(runs, *euler), _of_rows),
        Form("quaternion", "reduced by hand, quaternion", _quaternion, begin[1], rows(runs, *halves), _of_quaternion),
        _maximal_form(runs, m, J, w),
    )
    return Problem("top", "heavy top, 2 s", scenario, engine.END_TIME, runs, forms)


# ------------------------------------------------------------ reduced
def _turning(g: Any, w: Any) -> list[Any]:
    """The rate of a fixed direction, seen from the body."""
    return [a - b for a, b in ((g[1] * w[2], g[2] * w[1]), (g[2] * w[0], g[0] * w[2]), (g[0] * w[1], g[1] * w[0]))]


def _rows(hy: Any) -> list[tuple[Any, Any]]:
    g, e, w = hy.make_vars("gx", "gy", "gz"), hy.make_vars("ex", "ey", "ez"), hy.make_vars("wx", "wy", "wz")
    p = hy.par
    rates = [p[0] * (w[1] * w[2]) - p[3] * g[2], p[1] * (w[2] * w[0]), p[2] * (w[0] * w[1]) + p[4] * g[0]]
    return list(zip([*g, *e, *w], [*_turning(g, w), *_turning(e, w), *rates], strict=True))


def _of_rows(states: Array, _: Array, t: Any) -> Array:
    up, ahead = states[0:3], states[3:6]
    return ARM * np.stack([ahead[1], up[2] * ahead[0] - up[0] * ahead[2], up[1]])[None]


def _quaternion(hy: Any) -> list[tuple[Any, Any]]:
    w, x, y, z = hy.make_vars("q0", "q1", "q2", "q3")
    a, b, c = hy.make_vars("ux", "uy", "uz")  # half the angular velocity
    p = hy.par
    return [
        (w, -(x * a) - y * b - z * c),
        (x, w * a + y * c - z * b),
        (y, w * b + z * a - x * c),
        (z, w * c + x * b - y * a),
        (a, p[0] * (b * c) - p[3] * (1.0 - 2.0 * (x * x + y * y))),
        (b, p[1] * (c * a)),
        (c, p[2] * (a * b) + 2.0 * p[4] * (x * z - w * y)),
    ]


def _of_quaternion(states: Array, _: Array, t: Any) -> Array:
    w, x, y, z = states[:4] / np.sqrt((states[:4] ** 2).sum(axis=0))
    return ARM * np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])[None]


# ------------------------------------------------------------ maximal
def _maximal_form(runs: int, m: Array, J: list[Any], w: Array) -> Form:
    start = rows(runs, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, -w[2], 0, w[0], *w)
    numbers = rows(runs, 1 / (1 / m + 1 / J[2]), m, 1 / (1 / m + 1 / J[0]), 1 / m, *(1 / x for x in J),
                   J[1] - J[2], J[2] - J[0], J[0] - J[1])  # fmt: skip
    return Form("maximal", "maximal coordinates", _maximal, start, numbers, lambda states, _, t: states[None, 0:3])


def _maximal(hy: Any) -> list[tuple[Any, Any]]:
    """The multiplier in the axes of the body, where C M^-1 C^T is constant and, for this arm, diagonal: the least that
    maximal coordinates can cost."""
    r, v, w = (hy.make_vars(*(f"{x}{i}" for i in "xyz")) for x in "rvw")
    R = [hy.make_vars(*(f"R{i}{j}" for j in "xyz")) for i in "xyz"]
    p, arm = hy.par, [0.0, ARM, 0.0]
    free = [x * (w[i - 2] * w[i - 1]) * p[4 + i] for i, x in enumerate((p[7], p[8], p[9]))]  # w' without the joint
    gravity = scale(-G, R[2])
    gap = add(scale(-1.0, gravity), cross(free, arm), cross(w, cross(w, arm)))
    push = [p[i] * gap[i] for i in range(3)]  # the force of the joint, body axes
    turn = cross(scale(-1.0, arm), push)
    rates = [plus(free[i], times(p[4 + i], turn[i])) for i in range(3)]
    lifted = [p[3] * (row[0] * push[0] + row[1] * push[1] + row[2] * push[2]) for row in R]
    lifted[2] = lifted[2] - G
    spun = [x for row in R for x in _turning(row, w)]
    return list(zip([*r, *[x for row in R for x in row], *v, *w], [*v, *spun, *lifted, *rates], strict=True))
