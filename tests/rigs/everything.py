"""A small sweep that has numbers of all kinds: a ball that falls on a floor beside a pendulum."""

from typing import Any

from tests.rigs import parts

BALL = parts.body("ball", 0.5, 0.002, position=[0, 0, 0.5], velocity=[0.5, 0, 0])
FLOOR = parts.sphere("floor", "ball", 0.1, normal=[0, 0, 1], restitution=0.8)
HINGE = {
    "name": "hinge", "type": "revolute", "bodies": ["ground", "rod"], "points": [[0, 1, 1], [0, 0, 0.5]],
    "axes": [[0, 1, 0]] * 2, "angle": 0.5, "rate": 0,
}  # fmt: skip
SLOW = {"name": "stays slow", "value": "last_velocity.ball.x", "below": 0.56, "probability": 0.5}
FAR = {"name": "swings far", "value": "max(swing.angle, t > 0.1)", "above": 0.45, "probability": 0.5}
SOON = {"name": "in time", "value": "event_time.fast", "between": [0.05, 0.15], "probability": 0.5}
EVERYTHING: dict[str, Any] = {
    "title": "Everything",
    "parameters": {"push": 0.1},
    "model": {
        "bodies": [BALL, {"name": "rod", "mass": 1.0, "inertia": [0.1, 0.1, 0.01]}],
        "joints": [HINGE],
        "contacts": [FLOOR],
        "forces": [{"name": "shove", "type": "force", "body": "ball", "value": ["push", 0, 0]}],
    },
    "quantities": [
        {"name": "speed", "type": "point", "body": "ball", "derivative": 1},
        {"name": "swing", "type": "joint", "joint": "hinge"},
    ],
    "events": [{"name": "fast", "when": "speed.z < -1"}],
    "measures": [{"name": "peak", "value": "max(swing.angle) + push"}],
    "requirements": [SLOW, FAR, SOON],
    "integrator": {"tolerance": 1e-6, "end_time": 0.4},
    "output": {
        "every": 0.1, "joint_coordinates": True, "also": ["multiplier"], "at_events": ["speed"],
        "summary": {"swing.angle": ["max", "final", "time_of_max"], "speed": ["max", "min"]},
    },
    "sweep": parts.sweep(16, {"parameters.push": (0.0, 0.3), "bodies.ball.velocity[2]": (-0.4, 0.3)}),
}  # fmt: skip
BRIEF = {"output.mode": "summary", "output.full_runs": '"0:2"', "output.also": []}
STOP = {"width": 1.0, "every": 4}
