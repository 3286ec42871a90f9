"""Four links on hinges about y and z in turn, for heyoka in minimal coordinates."""

from typing import Any

import numpy as np

from bench.reach.problems import Array, Form, Problem, rows, started
from bench.reach.serial import Link, Moving, accelerations, centres

LINKS = 4
END = 2.0  # s
HALF = 0.125  # m, of a link along x
INERTIA = (0.0002, 0.0053, 0.0054)
ANGLES, RATES = (0.3, 0.5, -0.4, 0.2), (1.0, -2.0, 1.5, 0.5)
GRAVITY = -9.81


def data() -> dict[str, Any]:
    """Masses scatter by 1 %, inertias too."""
    bodies = [{"name": f"link{i}", "mass": 1.0, "inertia": list(INERTIA)} for i in range(LINKS)]
    joints, scatter = [], {"distribution": "normal", "std": 0.01, "relative": True}
    for i in range(LINKS):
        axis, along = [[0, 1, 0], [0, 0, 1]][i % 2], [1, 0, 0]
        joints.append({
            "name": f"hinge{i}", "type": "revolute", "bodies": [f"link{i - 1}" if i else "ground", f"link{i}"],
            "points": [[HALF if i else 0, 0, 0], [-HALF, 0, 0]], "axes": [axis, axis], "references": [along, along],
            "angle": ANGLES[i], "rate": RATES[i],
        })  # fmt: skip
    vary = {f"bodies.link{i}.{what}": scatter for i in range(LINKS) for what in ("mass", "inertia[1]", "inertia[2]")}
    return {
        "title": "Chain of four", "model": {"gravity": [0, 0, GRAVITY], "bodies": bodies, "joints": joints},
        "integrator": {"method": "dop853", "tolerance": 1e-9, "end_time": END},
        "output": {"variables": [], "every": END}, "sweep": {"runs": 2, "seed": 4, "vary": vary},
    }  # fmt: skip


def problem(runs: int) -> Problem:
    scenario = data()
    bodies = started(scenario, runs).model.bodies
    numbers = rows(runs, *(x for body in bodies for x in (body.mass, *body.inertia[:3])))
    start = rows(runs, *ANGLES, *RATES)
    forms = (Form("minimal", "minimal coordinates", _equations, start, numbers, _centres, long=True),)
    return Problem("chain", "chain of four hinges, 2 s", scenario, END, runs, forms)


def _links(numbers: Any) -> list[Link]:
    return [
        Link("hinge", 1 + i % 2, (2 * HALF if i else 0.0, 0.0, 0.0), (HALF, 0.0, 0.0),
             numbers[4 * i], [numbers[4 * i + 1 + k] for k in range(3)])
        for i in range(LINKS)
    ]  # fmt: skip


def _moving(turns: Any, rates: Any) -> Moving:
    return Moving(turns, [0.0] * LINKS, rates, (0.0, 0.0, -GRAVITY))


def _equations(hy: Any) -> list[tuple[Any, Any]]:
    q, v = hy.make_vars(*(f"q{i}" for i in range(LINKS))), hy.make_vars(*(f"v{i}" for i in range(LINKS)))
    faster = accelerations(_links(hy.par), _moving([(hy.cos(x), hy.sin(x)) for x in q], v))
    return list(zip([*q, *v], [*v, *faster], strict=True))


def _centres(states: Array, numbers: Array, t: Any) -> Array:
    now = _moving([(np.cos(x), np.sin(x)) for x in states[:LINKS]], states[LINKS:])
    at = centres(_links(numbers), now, (), (0.0, 0.0, 0.0))
    return np.stack([rows(states.shape[1], *r) for r in at])
