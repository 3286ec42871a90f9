"""The paper's satellite with its manipulator for heyoka, in minimal coordinates: three rates of the shoulder, an angle
and a displacement. The satellite turns as prescribed, so what its shoulder does is a known function of time."""

from pathlib import Path
from typing import Any

import numpy as np

from bench.reach.problems import Array, Form, Problem, rows, started
from bench.reach.serial import Link, Moving, accelerations, centres
from lienumba.scenario.resolve import resolve

SCENARIO = Path(__file__).resolve().parents[3] / "scenarios" / "satellite.toml"
END = 10.0  # s
SPIN = np.array([np.pi / 60, 0.0, np.pi / 30])  # rad/s
SHOULDER = np.array([0.0, 0.0, 1.5])  # m, from the mass centre of the satellite
HALF = 0.75  # m, of a rod
TORQUE, ELBOW, SLIDE = (-1.0, -3.0, -0.1), 0.45, -0.533  # N m, N m, N: nothing pushes back on the slider's rod
ARM = ("base_rod", "slider_rod", "slider")


def data() -> dict[str, Any]:
    """As it stands in the gallery; masses and inertias of the arm scatter by 1 %."""
    scatter = {"distribution": "normal", "std": 0.01, "relative": True}
    vary = {
        f"bodies.{name}.{what}": scatter for name in ARM for what in ("mass", "inertia[0]", "inertia[1]", "inertia[2]")
    }
    found = resolve(SCENARIO).data.model_dump(mode="json", exclude_unset=True)
    integrator = {"method": "dop853", "tolerance": 1e-9, "end_time": END}
    output = {"variables": [], "every": END}
    return found | {"integrator": integrator, "output": output, "sweep": {"runs": 2, "seed": 4, "vary": vary}}


def problem(runs: int) -> Problem:
    scenario = data()
    bodies = started(scenario, runs).model.bodies[1:]
    numbers = rows(runs, *(x for body in bodies for x in (body.mass, *body.inertia[:3])))
    across = _across()
    start = rows(runs, *across[0], *across[1], 1, 0, 0, 0, *SPIN, 0, 0)
    form = Form("minimal", "minimal coordinates", _equations, start, numbers, _centres, long=True)
    return Problem("satellite", "satellite with its arm, 10 s", scenario, END, runs, (form,))


def _across() -> np.ndarray:
    """Two directions across the spin that turn into each other; the first has the shoulder above it. And the spin's."""
    spin = (SPIN / _extended_norm(SPIN)).astype(np.longdouble)
    out = SHOULDER - spin * (spin @ SHOULDER)
    out = out / _extended_norm(out)
    return np.stack([out, np.cross(spin, out), spin])


def _extended_norm(x: Any) -> Any:
    return np.sqrt((np.asarray(x, np.longdouble) ** 2).sum())


RATE = float(_extended_norm(SPIN))
LIFT = -float(_extended_norm(SPIN) ** 2 * (_across()[0] @ SHOULDER))  # m/s2, of the shoulder, along the first direction


def _links(numbers: Any) -> list[Link]:
    own = [(numbers[4 * i], [numbers[4 * i + 1 + k] for k in range(3)]) for i in range(3)]
    none = (0.0, 0.0, 0.0)
    return [
        Link("ball", 0, none, (0.0, 0.0, HALF), *own[0], drive=TORQUE),
        Link("hinge", 1, (0.0, 0.0, 2 * HALF), (0.0, 0.0, HALF), *own[1], drive=ELBOW),
        Link("slide", 2, (0.0, 0.0, HALF), none, *own[2], push=(0.0, 0.0, SLIDE)),
    ]


def _moving(turn: Any, slide: Any, rates: Any, lift: Any) -> Moving:
    return Moving([(1.0, 0.0), turn, (1.0, 0.0)], [0.0, 0.0, slide], [rates[:3], rates[3], rates[4]], lift)


def _equations(hy: Any) -> list[tuple[Any, Any]]:
    g, e = hy.make_vars("gx", "gy", "gz"), hy.make_vars("ex", "ey", "ez")  # the directions, seen from the base rod
    c, s = hy.make_vars("c", "s")  # of the angle by which the satellite has turned
    w, angle, slide, rate, speed = hy.make_vars("wx", "wy", "wz"), *hy.make_vars("angle", "slide", "rate", "speed")
    lift = [LIFT * (c * x + s * y) for x, y in zip(g, e, strict=True)]
    now = _moving((hy.cos(angle), hy.sin(angle)), slide, [*w, rate, speed], lift)
    turning = [a * b - c * d for x in (g, e) for a, b, c, d in
               ((x[1], w[2], x[2], w[1]), (x[2], w[0], x[0], w[2]), (x[0], w[1], x[1], w[0]))]  # fmt: skip
    states = [*g, *e, c, s, angle, slide, *w, rate, speed]
    return list(
        zip(states, [*turning, -RATE * s, RATE * c, rate, speed, *accelerations(_links(hy.par), now)], strict=True)
    )


def _centres(states: Array, numbers: Array, t: Any) -> Array:
    g, e = states[0:3], states[3:6]
    out, side, spin = (x[:, None] for x in _across())
    along = np.cross(g, e, axis=0)
    first = [out * g[k] + side * e[k] + spin * along[k] for k in range(3)]
    angle = _extended_norm(SPIN) * t
    here = _across()
    lever, height = here[0] @ SHOULDER, here[2] @ SHOULDER
    at = height * here[2] + lever * (np.cos(angle) * here[0] + np.sin(angle) * here[1])
    now = _moving((np.cos(states[8]), np.sin(states[8])), states[9], states[10:15], at)
    return np.stack([rows(states.shape[1], *r) for r in centres(_links(numbers), now, first, list(at))])
