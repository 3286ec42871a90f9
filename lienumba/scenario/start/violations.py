"""What the start of a run does not fulfil: the joint, the size, the limit, what to free."""

from math import hypot, pi

import numpy as np

from lienumba.errors import Problem
from lienumba.groups import so3
from lienumba.keys.formulas import LARGEST
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.drivers import type_of
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.joints.keys import PARALLEL, sine
from lienumba.mechanics.mechanism.kinematics import Instant, still
from lienumba.mechanics.mechanism.model import Joint, Model, Start
from lienumba.mechanics.start import joint_frames
from lienumba.mechanics.start.assembly import Assembly, Condition
from lienumba.mechanics.system import rank
from lienumba.numerics.number import Number
from lienumba.words import listed

POSE, TWIST = ("position", "rotation"), ("velocity", "angular_velocity")

NOT_FINITE = Problem(
    "model",
    "the start cannot be computed in finite numbers",
    "look for positions, points, lengths or values of drivers that are far too large or too small",
)


def violations(done: Assembly, start: Start, run: int) -> list[Problem]:
    """Of one run of an assembled start, or none if all is well."""
    return _Run(done, start, run).problems()


class _Run:
    """One run of an assembled start."""

    def __init__(self, done: Assembly, start: Start, run: int) -> None:
        self.done, self.start, self.run = done, start, run
        self.model: Model = rank.nominal(done.model, run)
        self.now: Instant = done.instant(run)

    def problems(self) -> list[Problem]:
        undefined = [x for j in range(len(self.model.joints)) for x in self.undefined(j)]
        if undefined:
            return undefined
        left = (self.done.position_violations[self.run], self.done.velocity_violations[self.run])
        if not all(abs(x) < LARGEST for numbers in (*self.now.bodies, *left) for x in numbers):
            return [NOT_FINITE]
        found = [x for c in self.done.conditions for x in self.unmet(c)]
        return found or [x for j in range(len(self.model.joints)) for x in self.upside_down(j)]

    # ---------------------------------------------------------------- what has no meaning at this start
    def undefined(self, index: int) -> list[Problem]:
        joint, given = self.model.joints[index], self.start.joints[index].references
        at = f"model.joints.{joint.name}"
        if meaningless := JOINTS[joint.type].meaningless(joint):
            return [Problem(at, *meaningless)]
        if given is None or joint.frames is None:
            return []
        references = [[_number(x, self.run) for x in reference] for reference in given]
        rule, remedy = "is parallel to the axis of the joint at the start", "give a direction across it"
        return [
            Problem(f"{at}.references[{side}]", rule, remedy, reference)
            for side, (reference, frame) in enumerate(zip(references, joint.frames, strict=True))
            if sine(reference, list(frame[2])) < PARALLEL
        ]

    def upside_down(self, index: int) -> list[Problem]:
        """The rows of directions vanish half a turn away, too."""
        joint, says = self.model.joints[index], self.start.joints[index]
        compared = JOINTS[joint.type].same_way if says.references else ()
        if not compared:
            return []
        a, b = joint_frames.ends(joint, self.now.bodies)
        if all(so3.dot(joints.direction(joint, 0, a, n), joints.direction(joint, 1, b, n)) > 0.0 for n in compared):
            return []
        given = self.given(joint.bodies, POSE)
        other = f"correct the {given}" if given else f"give a {_guess(self.names(joint.bodies))}"
        rule = "its axes and references are half a turn apart at t = 0"
        return [Problem(f"model.joints.{joint.name}", rule, f"turn round those of one body, or {other}")]

    # ---------------------------------------------------------------- what is not met
    def unmet(self, c: Condition) -> list[Problem]:
        """Its position, else its velocity."""
        for left, limits, level in (
            (self.done.position_violations[self.run], self.done.position_limits[self.run], "position"),
            (self.done.velocity_violations[self.run], self.done.velocity_limits[self.run], "velocity"),
        ):
            rows = range(c.rows.start, c.rows.stop)
            bad = [row for row in rows if not left[row] <= limits[row]]
            if level == "position" and not bad and self.turned(c) > 0.5 * pi:
                bad = list(rows)
            if bad:
                worst = max(bad, key=lambda row: float(left[row]))
                turning = c.kinds[worst - rows.start] == "r"
                return [self.problem(c, level, self.size(c, left, worst, level), float(limits[worst]), turning)]
        return []

    def size(self, c: Condition, left: np.ndarray, worst: int, level: str) -> float:
        """How far it is from being met: all rows of the worst one's kind beside it, as one distance or angle."""
        first = last = worst - c.rows.start
        while first > 0 and c.kinds[first - 1] == c.kinds[first]:
            first -= 1
        while last + 1 < len(c.kinds) and c.kinds[last + 1] == c.kinds[last]:
            last += 1
        size = hypot(*(float(left[c.rows.start + n]) for n in range(first, last + 1)))
        if level == "velocity" or c.what not in ("joint", "driver"):
            return size
        if c.what == "driver":
            return self.turned(c) or size
        joint = self.joint(c.name)
        turning = c.kinds[worst - c.rows.start] == "r"
        return JOINTS[joint.type].missed(joint, still(self.now, joint.bodies), size, turning)

    def turned(self, c: Condition) -> float:
        """The angle (rad) by which a body misses the orientation that a driver prescribes."""
        driver = next((d for d in self.model.drivers if c.what == "driver" and d.name == c.name), None)
        return 0.0 if driver is None else type_of(driver).turned(driver, self.now.bodies[driver.bodies[0]][3:12])

    # ---------------------------------------------------------------- what to say of it
    def names(self, bodies: tuple[int, ...]) -> str:
        return listed([self.model.bodies[i].name for i in bodies if i >= 0])

    def given(self, bodies: tuple[int, ...], keys: tuple[str, str]) -> str:
        """What is given of these bodies; empty if nothing is."""
        given: dict[str, list[str]] = {}
        for i in bodies:
            names = [key for key in keys if i >= 0 and getattr(self.start.poses[i], key) is not None]
            if names:
                given.setdefault(listed(names), []).append(self.model.bodies[i].name)
        return ", the ".join(f"{names} of {listed(of)}" for names, of in given.items())

    def problem(self, c: Condition, level: str, size: float, limit: float, turning: bool) -> Problem:
        unit = ("rad" if turning else "m") + ("/s" if level == "velocity" else "")
        missed = f"{size:.3g} {unit}, at most {limit:.1g} {unit} is allowed"
        given = self.given(c.bodies, POSE if level == "position" else TWIST)
        if c.what not in ("joint", "driver"):
            says = next(s for j, s in zip(self.model.joints, self.start.joints, strict=True) if j.name == c.name)
            every = JOINTS[self.joint(c.name).type].freedoms()
            keys = [x.name if level == "position" else x.rate for x in every]
            others = [key for key in keys if key != c.what and key in says.known]
            rest = others + ([given] if given else [])
            remedy = f"it, or what drivers and other joints make of {self.names(c.bodies)}"
            if rest:
                remedy = f"it or the {listed(rest)}, or omit one of them"
            rule = f"contradicts what else is given for the start, by {missed}"
            return Problem(says.place(c.name, c.what), rule, f"correct {remedy}")
        where = f"model.{'drivers' if c.what == 'driver' else 'joints'}.{c.name}"
        omit = f"or the {given}, or omit what shall be solved for"
        if c.what == "driver":
            remedy = omit if given else f"or what other drivers and joints make of {self.names(c.bodies)}"
            if level == "position" and self.turned(c) > 0.5 * pi and self.start.poses[c.bodies[0]].rotation is None:
                remedy = f"or give a guess of the rotation of {self.names(c.bodies)} that is nearer to it"
            rule = f"prescribes another {level} at t = 0 than the start has: they differ by {missed}"
            return Problem(where, rule, f"correct its value, {remedy}")
        if level == "velocity":
            happens = JOINTS[self.joint(c.name).type].parting(turning)
            remedy = f"correct the {given}, or omit what shall be solved for"
            if not given:
                remedy = f"correct what drivers and other joints make of {self.names(c.bodies)}"
            return Problem(where, f"the initial velocities contradict it: {happens} at {missed}", remedy)
        happens, things = JOINTS[self.joint(c.name).type].unmet(turning)
        things += self.without_references(c.name)
        remedy = omit if given else f"or give a {_guess(self.names(c.bodies))}, near where they fit"
        verb = "differ by" if turning else "miss by"
        return Problem(where, f"{happens} at t = 0: they {verb} {missed}", f"correct the {things} {remedy}")

    def joint(self, name: str) -> Joint:
        return next(j for j in self.model.joints if j.name == name)

    def without_references(self, name: str) -> str:
        """The remedy for angles that begin at 0 because nothing says from where they count."""
        of_angles = [c.joint for c in self.joint(name).coordinates or () if c.kind == "angle"]
        free = [self.model.joints[j].name for j in of_angles if self.start.joints[j].references is None]
        return f", give references to {listed(free)} (without them an angle is 0 at the start)" if free else ""


def _guess(bodies: str) -> str:
    return f"guess of position and rotation for {bodies}"


def _number(x: Number, run: int) -> float:
    """Of one run."""
    values = np.asarray(x, float)
    return float(values if values.ndim == 0 else values[run])
