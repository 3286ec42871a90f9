"""From a resolved scenario and its samples to the model and its start.

The checked keys get the numbers of the runs in place of their own, and each element becomes a part of the model by
itself. A number is a float, or an array (runs,) where the sweep varies it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import floor
from typing import NamedTuple, NoReturn

import numpy as np

from lienumba.errors import NOTHING, ScenarioError
from lienumba.keys.conversions import inertia_of, rotation_of, timed3, vec3
from lienumba.keys.facts import facts, is_positive
from lienumba.keys.types import COORDINATE_KINDS
from lienumba.mechanics.elements.events import ENGAGE, LOCK, RELEASE, UNLOCK
from lienumba.mechanics.elements.forces import law_of
from lienumba.mechanics.elements.forces.compliant import forces_of
from lienumba.mechanics.elements.inputs import written
from lienumba.mechanics.elements.inputs.state import with_stops
from lienumba.mechanics.elements.joints import JOINTS, JointType, Own
from lienumba.mechanics.elements.locks import lockable, locks_of
from lienumba.mechanics.elements.quantities import is_input
from lienumba.mechanics.mechanism import model as m
from lienumba.mechanics.mechanism.courses import Recorded, Recursion
from lienumba.mechanics.mechanism.massless import is_massless
from lienumba.mechanics.mechanism.model import GROUND, JointStart, Model, Pose, Start
from lienumba.mechanics.mechanism.tables import Numbers, Samples
from lienumba.mechanics.tolerances import SAME_TIME_RTOL
from lienumba.numerics.number import Vector
from lienumba.scenario.base import paths
from lienumba.scenario.base.code import function_of
from lienumba.scenario.checks.integrator import may_change
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.schema.scenario import Body, ModelSection, StartSection, StartState
from lienumba.sweep.distributions.base import NUMBER
from lienumba.sweep.noise import Courses, RecordedCourses
from lienumba.words import listed

SWITCHES = (RELEASE.name, ENGAGE.name)
Sampled = Mapping[str, np.ndarray] | Mapping[str, float]


def build(scenario: Scenario, samples: Sampled, labels: Sequence[int] | None = None) -> tuple[Model, Start]:
    """The model, and what is known of its start; `samples` maps canonical paths to arrays (runs,), as `design.draw`
    has them; labels: of these runs, None for the nominal one."""
    with np.errstate(divide="ignore", invalid="ignore"):  # `unphysical` finds the NaN of such runs
        held = scenario.parameters.held_values(samples)
        noise, parameters = _Noise.of(scenario, labels), scenario.parameters
        model, start = _Builder(numbered(scenario, samples), scenario.data.files, held, noise).build()
        if scenario.data.files:
            from lienumba.scenario.start.code import check_derivatives

            check_derivatives(model, scenario.data.integrator)
        if model.quantities and may_change(scenario.data.integrator):
            model = with_stops(model)
        values = parameters.values(samples)
        measures = (
            x.to_model(lambda formula: parameters.number(formula, values)) for x in parameters.measures.values()
        )
        return replace(model, measures=tuple(measures)), start


def geometry(scenario: Scenario, samples: Sampled) -> tuple[Model, Start]:
    """Bodies, joints between two of them and contacts: what can be drawn, without code of the user's own."""
    return _Builder(numbered(scenario, samples), scenario.data.files).geometry()


def numbered(scenario: Scenario, samples: Sampled) -> ModelSection:
    """The keys of the model with the numbers of these samples, and functions of time and state where they are."""
    numbers: dict[paths.Tokens, object] = {**scenario.parameters.at_places(samples)}
    varied = {name for name in samples if not name.startswith("parameters.")}
    for path, kind in scenario.data.sweep.vary.items():
        names = kind.columns(path)
        if kind.shape != NUMBER and names[0] in samples:  # whatever its form in the file
            numbers[tuple(paths.parse(path))] = [samples[name] for name in names]
            varied -= {*names}
    numbers |= {tuple(paths.parse(name)): samples[name] for name in samples if name in varied}
    return paths.with_values(scenario.data.model, numbers)


class _Noise(NamedTuple):
    """What the courses of noise depend on beside their types; labels (runs,); end: of the runs (s)."""

    seed: int
    end: float
    labels: np.ndarray | None

    @staticmethod
    def of(scenario: Scenario, labels: Sequence[int] | None) -> "_Noise":
        data = scenario.data
        return _Noise(data.sweep.seed, data.integrator.end_time, None if labels is None else np.asarray(labels))

    def samples(self, name: str, source: Recursion | Recorded, every: float | None, held: bool) -> Samples:
        """The courses by the name of their stream."""
        number = 0 if every is None else floor(self.end / every * (1.0 + SAME_TIME_RTOL)) + 1
        knots = tuple(k * (every or 0.0) for k in range(1, number + 1))
        if self.labels is None:
            return Samples(Numbers(np.zeros(number + 1)), every or 1.0, float(number), held, knots)
        courses = (
            RecordedCourses.of(name, source, self.labels, number + 1)
            if isinstance(source, Recorded)
            else Courses(name, self.seed, self.labels, number + 1, source)
        )
        return Samples(courses, every or 1.0, float(number), held, knots)


class _Builder:
    """Knows the indices behind the names."""

    def __init__(
        self,
        data: ModelSection,
        files: Mapping[str, str],
        held: Mapping[str, m.Number] | None = None,
        noise: _Noise | None = None,
    ) -> None:
        self.data, self.files, self.held, self.noise = data, files, dict(held or {}), noise
        self.bodies = {body.name: i for i, body in enumerate(data.bodies)} | {"ground": GROUND}
        self.joints = {joint.name: i for i, joint in enumerate(data.joints)}
        self.drivers = {driver.name: i for i, driver in enumerate(data.drivers)}
        asked = [(str(x.joint), x.coordinate) for x in data.events if x.action in (LOCK.name, UNLOCK.name)]
        locked = [joint.name for joint in data.joints if joint.locked]
        kinds = {joint.name: joint.type for joint in data.joints}
        self.locks = locks_of(asked, kinds, locked) if asked or locked else ()

    def build(self) -> tuple[Model, Start]:
        data = self.data
        inputs = {name: x for name, value in data.inputs.items() if (x := written(value)) is not None}
        signals = [x.to_model(name, self) for name, x in inputs.items()]
        laws = [x.law(name) for name, x in inputs.items()]
        yielding = [force for x in data.contacts if x.compliant for force in forces_of(x, self)]
        model = Model(
            gravity=timed3(data.gravity),
            bodies=self.masses(),
            joints=tuple(map(self.joint, data.joints)),
            drivers=tuple(x.to_model(self) for x in data.drivers),
            forces=(*(x.to_model(self) for x in data.forces), *yielding, *filter(None, laws)),
            quantities=(*(x.to_model(self) for x in (*data.quantities, *data.noise)), *signals),
            events=tuple(y for x in data.events for y in x.to_model(self.joints, self.locks, [*self.held])),
            locks=self.locks,
            limits=tuple(limit for x in data.limits for limit in x.to_model(self)),
            contacts=tuple(contact for x in data.contacts if not x.compliant for contact in x.to_model(self)),
            held=self.held,
        )
        poses, joints = tuple(map(self.pose, data.bodies)), tuple(map(self.joint_start, data.joints))
        if self.files:
            from lienumba.scenario.start.code import tried

            model = tried(model)
        return model, Start(poses, joints, self.rotation())

    def joint(self, joint: JointType) -> m.Joint:
        """A joint, and whether events switch it."""
        switched = any(x.joint == joint.name and x.action in SWITCHES for x in self.data.events)
        return replace(joint.to_model(self), active=joint.active is not False, switched=switched)

    def geometry(self) -> tuple[Model, Start]:
        drawn = [joint for joint in self.data.joints if joint.has_points or joint.sides]
        touching = tuple(contact for x in self.data.contacts for contact in x.to_model(self))
        model = Model((0.0, 0.0, 0.0), self.masses(), tuple(x.to_model(self) for x in drawn), contacts=touching)
        return model, Start((), tuple(x.start() for x in drawn))

    def masses(self) -> tuple[m.Body, ...]:
        none = (0.0,) * 6
        return tuple(
            m.Body(body.name, body.mass, none if body.inertia is None else inertia_of(body.inertia))
            for body in self.data.bodies
        )

    # ---------------------------------------------------------------- what elements ask for
    def ends(self, joint: str) -> tuple[int, ...]:
        return self.data.joints[self.joints[joint]].ends(self)

    def touching(self, contact: str) -> tuple[int, ...]:
        found = next(x for x in self.data.contacts if x.name == contact)
        return tuple(self.bodies[name] for name in found.bodies)

    def limited(self, limit: str) -> int:
        return self.joints[next(x.joint for x in self.data.limits if x.name == limit)]

    def coordinate(self, joint: str, kind: str | None, among: Sequence[str] = COORDINATE_KINDS) -> m.Coordinate:
        index = self.joints[joint]
        return m.Coordinate(index, kind or next(x for x in self.data.joints[index].coordinate_kinds if x in among))

    def code(
        self,
        place: str,
        reference: str,
        seen: Sequence[str],
        parameters: Iterable[str],
        *,
        returns: str,
        level: str = "position",
        joints: tuple[int, ...] = (),
        states: Sequence[str] = (),
        memory: Sequence[tuple[str, int]] = (),
        every: float | None = None,
    ) -> m.Code:
        known = [seen.name for seen in (*self.data.quantities, *self.data.noise)]
        known += [force.name for force in self.data.forces if getattr(force, "states", None)]
        from lienumba.scenario.start.code import code_of

        code = m.Code(
            function_of(place, reference, self.files), returns, level, joints,
            states=tuple(states), memory=tuple(memory), every=every,
        )  # fmt: skip
        return code_of(place, reference, code, seen, list(parameters), known)

    def samples(self, name: str, source: Recursion | Recorded, every: float | None, held: bool) -> Samples:
        assert self.noise is not None
        return self.noise.samples(f"noise.{name}", source, every, held)

    # ---------------------------------------------------------------- the start
    def pose(self, body: Body) -> Pose:
        base = self.bodies[body.relative_to or "ground"]
        guess = None if body.guess is None else _pose(body.guess)
        if base == GROUND and (guess is None or guess.rotation is None):
            guess = replace(guess or Pose(), rotation=self.prescribed_rotation(body.name))
        return replace(_pose(body), relative_to=None if base == GROUND else base, guess=guess)

    def rotation(self) -> m.Vec3 | None:
        start = self.data.start
        if start is None or not start.resting:
            return None
        return (0.0, 0.0, 0.0) if start.rotation is None else vec3(start.rotation)

    def joint_start(self, joint: JointType) -> JointStart:
        """What is known of a joint's coordinates; what [start] says stands over its own keys."""
        says, start, labelled = joint.start(), self.data.start or StartSection(), joint.labelled(joint.name)
        known, places = dict(says.known), dict(says.places)
        for key, given in (("q", start.q), ("qd", start.qd)):
            several = given.get(joint.name)
            for n, (label, x) in enumerate(labelled.items()):
                value = several[n] if isinstance(several, list) else given.get(label)
                if value is not None:
                    name = x.name if key == "q" else x.rate
                    known[name], places[name] = value, f"start.{key}.{label}"
        if joint.locked:
            still = _at_rest(joint, known, places)
            known, places = still | known, dict.fromkeys(still, f"model.joints.{joint.name}.locked") | places
        return replace(says, known=known, places=places)

    def prescribed_rotation(self, name: str) -> Vector | None:
        """The rotation that a driver prescribes at the start: half a turn away its equations hold, too."""
        prescribed = [driver.rotation_at_start() for driver in self.data.drivers]
        return next((rotation for body, rotation in filter(None, prescribed) if body == name), None)


def _pose(state: StartState) -> Pose:
    return Pose(
        position=_optional(state.position),
        rotation=None if state.rotation is None else rotation_of(state.rotation),
        velocity=_optional(state.velocity),
        angular_velocity=_optional(state.angular_velocity),
    )


def _optional(vector: Sequence[float] | None) -> m.Vec3 | None:
    return None if vector is None else vec3(vector)


def unphysical(model: Model, start: Start, samples: Sampled, runs: int) -> np.ndarray:
    """Which of the runs drew what is no number, or a mass, inertia, rotation, length of a joint or number of a force
    that nothing has: (runs,).

    The nominal values are checked with the scenario; a sample may still lie outside, in the tail of a normal
    distribution.
    """
    bad = np.zeros(runs, dtype=bool)
    for values in samples.values():
        bad |= ~np.isfinite(values)
    for body in model.bodies:
        if is_massless(body):
            continue
        xx, yy, zz, xy, xz, yz = body.inertia
        minors = (
            xx,
            xx * yy - xy * xy,
            xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz),
        )
        for number in (body.mass, *minors):
            bad |= ~(np.asarray(number) > 0.0)
    for joint in model.joints:
        kind = JOINTS[joint.type]
        for key in facts(kind, Own):
            if is_positive(kind, key) and joint.numbers[key] is not None:
                bad |= ~(np.asarray(joint.numbers[key]) > 0.0)
        bad |= ~(np.asarray(joint.armature) >= 0.0)
    for force in model.forces:
        for key, number in law_of(force).numbers().items():
            x = force.numbers.get(key)
            if number.sign is not None and number.sign.refused and x is not None and not callable(x):
                bad |= number.sign.broken(np.asarray(x)) | np.isnan(x)
    touching = [*model.contacts, *(force.contact for force in model.forces if force.contact is not None)]
    stops: list[m.Limit | m.Contact] = [*model.limits, *touching]
    for stop in stops:
        bad |= ~((np.asarray(stop.restitution) >= 0.0) & (np.asarray(stop.restitution) <= 1.0))
        if stop.rest_speed is not None:
            bad |= ~(np.asarray(stop.rest_speed) >= 0.0)
    for contact in touching:
        bad |= ~((np.asarray(contact.kinetic) >= 0.0) & np.asarray(contact.static >= contact.kinetic))
        for number in contact.numbers.values():
            bad |= ~(np.asarray(number) > 0.0)
    for quantity in model.quantities:
        if is_input(quantity.name) and "filter" in quantity.numbers:
            bad |= ~(np.asarray(quantity.numbers["filter"]) > 0.0)
    for pose in start.poses:
        for number in pose.rotation or ():
            bad |= ~np.isfinite(number)  # a quaternion or an axis of length 0
    return bad


def refuse_invalid(scenario: Scenario, samples: Mapping[str, np.ndarray]) -> NoReturn:
    """Raise a ScenarioError that names what makes every run of these samples invalid: an input alone, or all."""
    runs = len(next(iter(samples.values())))
    vary = scenario.data.sweep.vary
    guilty = []
    for path, kind in vary.items():
        own = {name: samples[name] for name in kind.columns(path)}
        if unphysical(*build(scenario, own), own, runs).all():
            guilty.append(path)
    shown = listed(f'"{path}"' for path in guilty or vary)
    example = ", ".join(f"{name} = {values[0]:.6g}" for name, values in samples.items())
    raise ScenarioError.at(
        "sweep.vary",
        (
            f"no run is possible with {shown} varied: every sample has a mass, inertia, length, friction "
            "or rotation that nothing has, or is no finite number"
        ),
        f"give values nearer to the nominal ones. The first run: {example}",
    )


def _at_rest(joint: JointType, known: Mapping[str, m.Number], places: Mapping[str, str]) -> dict[str, m.Number]:
    """The rates of a joint that begins locked."""
    _, together = joint.together or ("", "")
    for x in joint.freedoms():
        rate = known.get(x.rate, 0.0)
        if np.any(np.asarray(rate) != 0.0):
            own = f"model.joints.{joint.name}.{together or x.rate}"
            rule, remedy = "must be 0 where the joint begins locked", "give 0, or leave out one of the two"
            raise ScenarioError.at(places.get(x.rate, own), rule, remedy, NOTHING if np.ndim(rate) else rate)
    return {x.rate: 0.0 for x in lockable(joint.type)}
