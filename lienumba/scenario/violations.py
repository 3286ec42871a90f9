"""What the start of a run does not fulfil, one sentence each: the joint, the size, the limit, what to free."""

from lienumba.mechanics.assembly import Assembly, Condition
from lienumba.mechanics.joints import JOINT_TYPES
from lienumba.mechanics.model import Start

HAPPENS = {"spherical": "its points do not meet", "distance": "its points are not at its length"}
FREE = (
    "correct the {things} or the position and rotation of {bodies}, or omit those that shall be solved for; where all "
    "are omitted, give a guess near the joints"
)


def violations(done: Assembly, start: Start, run: int) -> list[str]:
    """Of one run of an assembled start, or none if all is well."""
    if not done.position_violations.size and not done.velocity_violations.size:
        return []
    found = [
        f"model.joints.{joint.name}: its two points coincide at the start, so its length is 0 and it must be above 0; "
        "move a point or a body, or use a spherical joint"
        for joint in done.model.joints
        if joint.type == "distance" and not _number(joint.length, run) > 0.0
    ]
    return found or [sentence for c in done.conditions for sentence in _sentences(done, c, run)]


def _number(x: object, run: int) -> float:
    import numpy as np

    values = np.asarray(x, float)
    return float(values if values.ndim == 0 else values[run])


def _sentences(done: Assembly, c: Condition, run: int) -> list[str]:
    """The worst row of a condition that is not met: its position, else its velocity."""
    rows = range(c.rows.start, c.rows.stop)
    bodies = " and ".join(done.model.bodies[i].name for i in c.bodies if i >= 0)
    for left, limits, level in (
        (done.position_violations[run], done.position_limits[run], "position"),
        (done.velocity_violations[run], done.velocity_limits[run], "velocity"),
    ):
        bad = [row for row in rows if not left[row] <= limits[row]]
        if bad:
            worst = max(bad, key=lambda row: left[row] / limits[row] if limits[row] > 0.0 else left[row])
            turning = c.kinds[worst - c.rows.start] == "r"
            return [_sentence(done, c, level, float(left[worst]), float(limits[worst]), turning, bodies)]
    return []


def _sentence(done: Assembly, c: Condition, level: str, size: float, limit: float, turning: bool, bodies: str) -> str:
    unit = ("rad" if turning else "m") + ("/s" if level == "velocity" else "")
    allowed = f"at most {limit:.1g} {unit} is allowed"
    if c.what in ("angle", "displacement", "rate", "speed"):
        state = "position and rotation" if c.what in ("angle", "displacement") else "velocity and angular_velocity"
        return (
            f"model.joints.{c.name}.{c.what}: contradicts what else is given for the start, by {size:.3g} {unit}, "
            f"{allowed}; correct it or the {state} of {bodies}, or omit one of them"
        )
    kind = "driver" if c.what == "driver" else next(j.type for j in done.model.joints if j.name == c.name)
    where = f"model.{'drivers' if c.what == 'driver' else 'joints'}.{c.name}"
    if level == "position":
        if c.what == "driver":
            return (
                f"{where}: prescribes another position at t = 0 than the start has, they differ by {size:.3g} {unit}, "
                f"{allowed}; correct its value or the position and rotation of {bodies}, or omit those that shall be "
                "solved for"
            )
        verb = "differ by" if turning else "miss by"
        happens, things = HAPPENS.get(kind, "its points do not meet"), "points"
        if turning:
            happens, things = "its axes do not fit together", "axes"
        elif kind not in HAPPENS and not JOINT_TYPES.get(kind, JOINT_TYPES["cylindrical"]).rows.startswith("mmm"):
            happens = "its points are not where it allows them"
        if kind in ("gear", "coupler"):
            happens, things = "its coordinates do not have its ratio and offset", "offset"
        free = FREE.format(things=things, bodies=bodies)
        return f"{where}: {happens} at t = 0: they {verb} {size:.3g} {unit}, {allowed}; {free}"
    if c.what == "driver":
        happens = "prescribes another velocity at t = 0 than the start has: they differ by"
        return (
            f"{where}: {happens} {size:.3g} {unit}, {allowed}; correct its value, or velocity and angular_velocity of "
            f"{bodies}, or omit one so that it is solved for"
        )
    subject = "its bodies turn apart" if turning else "its points separate"
    return (
        f"{where}: the initial velocities contradict it: {subject} at {size:.3g} {unit}, {allowed}; "
        f"correct velocity and angular_velocity of {bodies}, or omit one so that it is solved for"
    )
