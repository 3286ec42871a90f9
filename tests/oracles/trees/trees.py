"""A tree of bodies, once as a scenario and once in its joints' coordinates; and the comparison of their motions."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import lienumba
from tests.oracles.trees import dense
from tests.oracles.trees.dense import Array, Mechanism, Motion
from tests.oracles.trees.kinematics import COORDINATES, GROUND, Joint, exponential, relative

G = (0.7, -1.1, -9.5)  # m/s^2
TIMES = (0.0, 0.2, 0.4)


@dataclass(frozen=True)
class Link:
    """A body and the joint that carries it from its base, which comes earlier.

    prescribed: functions of time by the index of the joint's coordinate; size: of a rod, or the pitch of a screw;
    rotor: of a joint of one coordinate.
    """

    name: str
    body: dense.Body
    joint: Joint
    base: str = "ground"
    size: float = 0.0
    prescribed: dict[int, Callable[[Any], Any]] = field(default_factory=dict)
    rotor: float = 0.0

    @property
    def base_is_first(self) -> bool:
        return self.joint.bodies[0] == self.base

    @property
    def free(self) -> list[int]:
        """Which of the joint's coordinates are unknown."""
        return [i for i in range(COORDINATES[self.joint.type]) if i not in self.prescribed]


@dataclass(frozen=True)
class Tree:
    """drivers, joints: more tables of the scenario; closing: what these are in `Mechanism`."""

    links: Sequence[Link]
    gravity: Sequence[float] = G
    drivers: Sequence[dict[str, Any]] = ()
    joints: Sequence[dict[str, Any]] = ()
    closing: dict[str, Any] = field(default_factory=dict)
    reduced: Callable[[list[Array], Any], list[Array]] | None = None  # all free coordinates from fewer, and time

    @property
    def names(self) -> list[str]:
        return [link.name for link in self.links]

    @property
    def mechanism(self) -> Mechanism:
        rotors = [link.rotor for link in self.links for _ in link.free]
        if not any(rotors):  # `reduced` writes them by fewer
            rotors = []
        return Mechanism([link.body for link in self.links], self.place, self.gravity, rotors=rotors, **self.closing)

    def place(self, q: list[Array], t: Any) -> dense.Places:
        places = {"ground": GROUND}
        unknown = iter(q if self.reduced is None else self.reduced(q, t))
        for link in self.links:
            count = len(link.free) + len(link.prescribed)
            c = [link.prescribed[i](t) if i in link.prescribed else next(unknown) for i in range(count)]
            there = relative(link.joint.type, c, link.size)
            places[link.name] = link.joint.carry(places[link.base], there, link.base_is_first)
        return [places[name] for name in self.names]

    def beyond(self, name: str) -> list[int]:
        """The indices of a body and of all that it carries."""
        carried = {name}
        for link in self.links:
            if link.base in carried:
                carried.add(link.name)
        return [i for i, link in enumerate(self.links) if link.name in carried]

    def load(self, here: Motion, link: Link) -> tuple[Array, Array]:
        """All that acts across a joint on its second body, at its point there."""
        joint = link.joint
        second, point = joint.bodies[1], np.array(joint.points[1], float)
        if second != "ground":
            i = self.names.index(second)
            point = here.r[i] + here.R[i] @ point
        force, torque = dense.net_load(self.mechanism, here, self.beyond(link.name), point)
        if link.rotor:  # acts along the coordinate, beside the joint
            place = sum(len(other.free) for other in self.links[: self.links.index(link)])
            axis = joint.frames[1][:, 2] if second == "ground" else here.R[i] @ joint.frames[1][:, 2]
            pull = link.rotor * here.qdd[place] * axis * (1.0 if link.base_is_first else -1.0)
            force, torque = (force + pull, torque) if joint.type == "prismatic" else (force, torque + pull)
        return (force, torque) if link.base_is_first else (-force, -torque)


def scenario(tree: Tree, start: Motion, omit: Sequence[str] = (), step: float = 1e-3) -> dict[str, Any]:
    """omit: which of position, rotation, velocity, angular_velocity are left to the joints."""
    bodies = []
    for i, link in enumerate(tree.links):
        J = link.body.inertia
        given = {
            "position": start.r[i].tolist(),
            "rotation": start.R[i].tolist(),
            "velocity": start.v[i].tolist(),
            "angular_velocity": (start.R[i].T @ start.w[i]).tolist(),
        }
        known = {key: value for key, value in given.items() if key not in omit}
        bodies.append({"name": link.name, "mass": link.body.mass, "inertia": J.tolist(), **known})
    joints = [table(link) for link in tree.links]
    model = {
        "gravity": list(tree.gravity),
        "bodies": bodies,
        "joints": joints + list(tree.joints),
        "drivers": list(tree.drivers),
    }
    return {
        "model": model,
        "integrator": {"method": "rk4", "step": step, "end_time": TIMES[-1]},
        "output": {"times": list(TIMES), "also": ["multiplier"]},
    }


def table(link: Link) -> dict[str, Any]:
    """The joint as the scenario has it."""
    joint = link.joint
    found: dict[str, Any] = {"name": joint.name, "type": joint.type, "bodies": list(joint.bodies)}
    if joint.type not in ("parallel_axes", "perpendicular_axes"):
        found["points"] = [list(p) for p in joint.points]
    if joint.type not in ("spherical", "distance"):
        found["axes"] = [list(z) for z in joint.axes]
    if joint.type in ("revolute", "cylindrical", "screw", "prismatic", "fixed"):
        found["references"] = [list(x) for x in joint.references]
    if joint.type == "distance":
        found["length"] = link.size
    if joint.type == "screw":
        found["pitch"] = link.size
    if link.rotor:
        found["armature"] = link.rotor
    return found | joint.says


def run(data: dict[str, Any]) -> Any:
    dataset = lienumba.run(data, workers=1)
    assert (dataset["status"] == 0).all()
    return dataset.isel(run=0)


def compare(tree: Tree, ds: Any, history: Sequence[Motion], bound: float = 1e-8) -> None:
    """States at all times, the kinetic energy, and that the constraints hold and the energy is accounted for."""
    m = tree.mechanism
    names = ds["body"].values.tolist()
    assert names == tree.names
    for time, here in enumerate(history):
        now = ds.isel(time=time)
        assert abs(float(now["time"]) - here.t) < 1e-12
        same(now["position"], here.r, bound, f"position at {here.t}")
        same(now["rotation"], here.R, bound, f"rotation at {here.t}")
        same(now["velocity"], here.v, bound, f"velocity at {here.t}")
        same(now["angular_velocity"], np.einsum("bji,bj->bi", here.R, here.w), bound, f"angular velocity at {here.t}")
        same(now["kinetic_energy"], dense.kinetic(m, here), bound, f"kinetic energy at {here.t}")
        weights = -sum(b.mass * r @ np.array(tree.gravity) for b, r in zip(m.bodies, here.r, strict=True))
        same(now["potential_energy"], weights, bound, f"potential energy at {here.t}")
    settled(ds, bound)


def settled(ds: Any, bound: float = 1e-8) -> None:
    assert float(ds["position_violation"].max()) < 1e-10
    assert float(ds["velocity_violation"].max()) < 1e-10
    assert float(abs(ds["energy_residual"]).max()) < bound * max(1.0, float(abs(ds["kinetic_energy"]).max()))


def reactions(tree: Tree, ds: Any, history: Sequence[Motion], bound: float = 1e-7, skip: Sequence[str] = ()) -> None:
    """Every joint of the tree carries what Newton and Euler ask of all that hangs on it."""
    for link in tree.links:
        if link.joint.name in skip:
            continue
        here = ds.sel(joint=link.joint.name)
        for time, motion in enumerate(history):
            force, torque = tree.load(motion, link)
            same(here["joint_force"][time], force, bound, f"force of {link.joint.name} at {motion.t}")
            same(here["joint_torque"][time], torque, bound, f"torque of {link.joint.name} at {motion.t}")


def same(found: Any, expected: Any, bound: float, what: str) -> None:
    """To a bound relative to the largest of the numbers, or to 1."""
    found, expected = np.asarray(found), np.asarray(expected)
    scale = max(1.0, float(np.abs(expected).max(initial=0.0)))
    np.testing.assert_allclose(found, expected, rtol=0, atol=bound * scale, err_msg=what)


class Random:
    """Bodies and joints without any symmetry, the same for the same words."""

    def __init__(self, *words: Any):
        self.draw = np.random.default_rng([ord(letter) for letter in " ".join(map(str, words))])

    def vector(self, size: float = 1.0, count: int = 3) -> list[float]:
        return self.draw.uniform(-size, size, count).tolist()

    def direction(self) -> list[float]:
        v = self.draw.normal(size=3)
        return (v / np.linalg.norm(v)).tolist()

    def body(self) -> dense.Body:
        turn = exponential(np.array(self.vector(2.0)))
        x, y = self.draw.uniform(0.03, 0.12, 2)
        principal = np.diag([x, y, self.draw.uniform(abs(x - y) + 0.01, x + y)])
        inertia = turn @ principal @ turn.T
        return dense.Body(float(self.draw.uniform(0.5, 2.5)), 0.5 * (inertia + inertia.T))

    def joint(self, name: str, kind: str, bodies: tuple[str, str], **says: Any) -> Joint:
        return Joint(
            name,
            kind,
            bodies,
            (self.vector(0.4), self.vector(0.4)),
            (self.direction(), self.direction()),
            (self.direction(), self.direction()),
            says,
        )

    def start(self, tree: Tree, rate: float = 1.5, count: int | None = None) -> tuple[Array, Array]:
        n = count if count is not None else sum(len(link.free) for link in tree.links)
        return np.array(self.vector(0.5, n)), np.array(self.vector(rate, n))
