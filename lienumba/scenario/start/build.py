"""From a resolved scenario and its samples to the model and its start.

A number is a float, or an array (runs,) where the sweep varies it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from lienumba.keys.conversions import inertia_of, rotation_of, timed, vec3
from lienumba.keys.types import Section
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.joints import COORDINATES
from lienumba.mechanics.mechanism import model as m
from lienumba.mechanics.mechanism.model import GROUND, JointStart, Model, Pose, Start
from lienumba.numerics.expressions import Formula
from lienumba.scenario.base import paths
from lienumba.scenario.base.code import PYTHON, function_of
from lienumba.scenario.checks.code import code_of, tried
from lienumba.scenario.resolve import Scenario
from lienumba.sweep.distributions.base import NUMBER

if TYPE_CHECKING:
    import numpy as np

Table = Mapping[str, Any]


def build(scenario: Scenario, samples: Mapping[str, "np.ndarray"]) -> tuple[Model, Start]:
    """The model, and what is known of its start; `samples` maps canonical paths to arrays (runs,), as `design.draw`
    has them."""
    import numpy as np

    with np.errstate(divide="ignore", invalid="ignore"):  # `unphysical` finds the NaN of such runs
        return _builder(scenario, samples).build()


def geometry(scenario: Scenario, samples: Mapping[str, Any]) -> tuple[Model, Start]:
    """Bodies, and the joints between two of them: what can be drawn, without running code of the user's own."""
    return _builder(scenario, samples).geometry()


def _builder(scenario: Scenario, samples: Mapping[str, Any]) -> "_Builder":
    data = scenario.data.model.model_dump()
    scenario.parameters.fill(data, samples)
    for path, kind in scenario.data.sweep.vary.items():
        names = kind.columns(path)
        if kind.shape != NUMBER and names[0] in samples:  # whatever its form in the file
            paths.put(data, paths.parse(path), [None] * len(names))
    for path, values in samples.items():
        if not path.startswith("parameters."):
            paths.put(data, paths.parse(path), values)
    return _Builder(data, scenario.data.files)


class _Builder:
    """Knows the indices behind the names."""

    def __init__(self, data: dict[str, Any], files: dict[str, str]) -> None:
        self.data, self.files = data, files
        self.bodies = {body["name"]: i for i, body in enumerate(data["bodies"])} | {"ground": GROUND}
        self.joints = {joint["name"]: i for i, joint in enumerate(data["joints"])}

    def build(self) -> tuple[Model, Start]:
        data = self.data
        model = Model(
            gravity=_timed3(data["gravity"]),
            bodies=self.masses(),
            joints=tuple(map(self.joint_of, data["joints"])),
            drivers=tuple(map(self.driver, data["drivers"])),
            forces=tuple(map(self.force, data["forces"])),
            quantities=tuple(map(self.quantity, data["quantities"])),
            events=tuple(map(_event, data["events"])),
        )
        return tried(model), Start(tuple(map(self.pose, data["bodies"])), tuple(map(_joint_start, data["joints"])))

    def geometry(self) -> tuple[Model, Start]:
        drawn = [joint for joint in self.data["joints"] if joint["type"] != PYTHON and "joints" not in joint]
        model = Model((0.0, 0.0, 0.0), self.masses(), tuple(map(self.joint_of, drawn)))
        return model, Start((), tuple(map(_joint_start, drawn)))

    def masses(self) -> tuple[m.Body, ...]:
        bodies = self.data["bodies"]
        return tuple(m.Body(body["name"], body["mass"], inertia_of(body["inertia"])) for body in bodies)

    def body(self, name: str) -> int:
        return self.bodies[name]

    def joint(self, name: str) -> int:
        return self.joints[name]

    def ends(self, names: Sequence[str]) -> tuple[int, ...]:
        return tuple(self.bodies[name] for name in names)

    def coordinate(self, joint: str, kind: str | None) -> m.Coordinate:
        index = self.joints[joint]
        return m.Coordinate(index, kind or COORDINATES[self.data["joints"][index]["type"]][0])

    def ends_of_joint(self, name: str) -> tuple[int, ...]:
        return self.ends(self.data["joints"][self.joints[name]]["bodies"])

    def code(self, law: Section, **more: Any) -> m.Code:
        return self.code_at(f"model.forces.{vars(law)['name']}", vars(law), **more)

    def code_at(self, place: str, law: Table, **more: Any) -> m.Code:
        known = [quantity["name"] for quantity in self.data["quantities"]]
        known += [force["name"] for force in self.data["forces"] if force.get("states")]
        return code_of(place, law, function_of(place, law["function"], self.files), known, **more)

    def joint_of(self, joint: Table) -> m.Joint:
        name, kind = joint["name"], joint["type"]
        if kind == PYTHON:
            letters = {"m": "m", "rad": "r"}
            rows = "".join(letters[row] for row in joint["rows"] or [])
            code = self.code_at(f"model.joints.{name}", joint, returns=rows, level=joint["level"])
            return m.Joint(name, kind, self.ends(joint["bodies"]), numbers=joint["parameters"], code=code)
        if "joints" not in joint:
            return m.Joint(
                name, kind, self.ends(joint["bodies"]), _optional_pair(joint.get("points")),
                length=joint.get("length"), pitch=joint.get("pitch"),
            )  # fmt: skip
        first, second = map(self.coordinate, joint["joints"], joint["coordinates"] or (None, None))
        ends = dict.fromkeys(i for name in joint["joints"] for i in self.ends_of_joint(name))
        return m.Joint(
            name, kind, tuple(ends), coordinates=(first, second), ratio=joint["ratio"], offset=joint["offset"]
        )

    def driver(self, driver: Table) -> m.Driver:
        if "joint" in driver:
            motion = "rate" if driver["value"] is None else "value"
            which = self.coordinate(driver["joint"], driver["coordinate"])
            ends = self.ends_of_joint(driver["joint"])
            return m.Driver(driver["name"], motion, ends, (timed(driver[motion]),), which)
        point = driver.get("point")
        return m.Driver(
            driver["name"], driver["motion"], self.ends([driver["body"]]), _timed3(driver["value"]),
            point=None if point is None else vec3(point), frame=driver.get("frame", "global"),
        )  # fmt: skip

    def force(self, force: Table) -> m.Force:
        return FORCES[force["type"]].model_construct(**force).to_model(self)

    def quantity(self, quantity: Table) -> m.Quantity:
        given = {key: x for key, x in quantity.items() if x is not None}
        found = m.Quantity(given["name"], given["type"], units=given.get("units", "1"))
        if "body" in given:
            body, base = self.bodies[given["body"]], self.bodies[given["relative_to"]]
            frames = {**self.bodies, "body": body, "global": GROUND, "none": base}
            found = replace(found, bodies=(body,), relative_to=base, frame=frames[given.get("frame", "none")])
        if given["type"] == "momentum":
            about = given["about"] if isinstance(given["about"], list) else None
            every = given.get("bodies") or [body["name"] for body in self.data["bodies"]]
            found = replace(found, bodies=self.ends(every), about=_optional(about))
        if "joint" in given:
            found = replace(found, joint=self.joints[given["joint"]])
            ends = self.ends_of_joint(given["joint"])
            frames = {"first": ends[0], "second": ends[-1], "global": GROUND}
            found = replace(found, frame=frames[given.get("frame", "global")])
        if "driver" in given:
            found = replace(found, driver=[d["name"] for d in self.data["drivers"]].index(given["driver"]))
        return replace(
            found,
            point=vec3(given.get("point", [0.0, 0.0, 0.0])),
            derivative=given.get("derivative", 0),
            target=rotation_of(given["target"]) if "target" in given else None,
            value=timed(given.get("value", 0.0)),
        )

    def pose(self, body: Table) -> Pose:
        base = self.bodies[body["relative_to"] or "ground"]
        guess = None if body["guess"] is None else _pose(body["guess"])
        if base == GROUND and (guess is None or guess.rotation is None):
            guess = replace(guess or Pose(), rotation=self.prescribed_rotation(body["name"]))
        return _pose(body, relative_to=None if base == GROUND else base, guess=guess)

    def prescribed_rotation(self, name: str) -> Any:
        """The rotation that a driver prescribes at the start: half a turn away its equations hold, too."""
        for driver in self.data["drivers"]:
            if driver.get("motion") == "orientation" and driver["body"] == name:
                if any(m.reads_state(x) for x in driver["value"]):
                    return None
                return rotation_of({"rotation_vector": [m.at_time(timed(x), 0.0) for x in driver["value"]]})
        return None


def _event(event: Table) -> m.Event:
    when = event["when"] if callable(event["when"]) else Formula(event["when"], condition=True)
    return m.Event(event["name"], when, event["action"] == "stop")


def _pose(state: Table, **more: Any) -> Pose:
    rotation = state["rotation"]
    vectors: Any = {name: _optional(state[name]) for name in ("position", "velocity", "angular_velocity")}
    return Pose(rotation=None if rotation is None else rotation_of(rotation), **vectors, **more)


def _joint_start(joint: Table) -> JointStart:
    axes, axis = joint.get("axes"), joint.get("axis")
    if axes is not None and len(axes) == 1:
        axes = [axes[0], [0.0, 0.0, 1.0]]  # of the first body alone
    if axis is not None:
        axis = tuple(map(vec3, axis)) if isinstance(axis[0], list) else (vec3(axis),)
    return JointStart(
        axes=_optional_pair(axes),
        references=_optional_pair(joint.get("references")),
        at=_optional(joint.get("at")),
        axis=axis,
        **{name: joint.get(name) for name in ("angle", "rate", "displacement", "speed")},
    )


def unphysical(model: Model, start: Start, samples: Mapping[str, "np.ndarray"], runs: int) -> "np.ndarray":
    """Which of the runs drew what is no number, or a mass, inertia, rotation, rod length or number of a force that
    nothing has: (runs,).

    The nominal values are checked with the scenario; a sample may still lie outside, in the tail of a normal
    distribution.
    """
    import numpy as np

    bad = np.zeros(runs, dtype=bool)
    for values in samples.values():
        bad |= ~np.isfinite(values)
    for body in model.bodies:
        xx, yy, zz, xy, xz, yz = body.inertia
        minors = (
            xx,
            xx * yy - xy * xy,
            xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz),
        )
        for number in (body.mass, *minors):
            bad |= ~(np.asarray(number) > 0.0)
    for joint in model.joints:
        if joint.length is not None:
            bad |= ~(np.asarray(joint.length) > 0.0)
    for force in model.forces:
        for key, number in FORCES[force.type].numbers().items():
            x = force.numbers.get(key)
            if number.sign is not None and number.sign.refused and x is not None and not callable(x):
                bad |= number.sign.broken(np.asarray(x)) | np.isnan(x)
    for pose in start.poses:
        for number in pose.rotation or ():
            bad |= ~np.isfinite(number)  # a quaternion or an axis of length 0
    return bad


def _timed3(values: list[Any]) -> tuple[m.Timed, m.Timed, m.Timed]:
    return timed(values[0]), timed(values[1]), timed(values[2])


def _optional(values: list[Any] | None) -> m.Vec3 | None:
    return None if values is None else vec3(values)


def _optional_pair(values: list[list[Any]] | None) -> tuple[m.Vec3, m.Vec3] | None:
    return None if values is None else (vec3(values[0]), vec3(values[1]))
