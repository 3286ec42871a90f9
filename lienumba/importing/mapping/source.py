"""A compiled MuJoCo model as links: bodies with all that is welded to them."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lienumba.importing.mapping.draft import GROUND
from lienumba.importing.mapping.frames import HERE, Frame

if TYPE_CHECKING:
    import mujoco

FREE, BALL, SLIDE, HINGE = range(4)  # mjtJoint
JOINT, IN_PARENT = range(2)  # mjtTrn
LETTERS = {FREE: 7, BALL: 4, SLIDE: 1, HINGE: 1}  # elements of qpos


@dataclass(frozen=True)
class Link:
    """mass (kg), centre (3,) in m and inertia (3, 3) in kg m^2 about it, in the frame of the MuJoCo body."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True)
class Source:
    """A model, its coordinates and rates, inputs and their states at the start. massless: names of bodies whose mass
    counts as none."""

    model: "mujoco.MjModel"
    qpos: np.ndarray
    qvel: np.ndarray
    ctrl: np.ndarray
    act: np.ndarray
    massless: frozenset[str] = frozenset()

    def name(self, kind: str, index: int) -> str:
        """The name of a "body", "joint", ..., or one made of its index."""
        import mujoco

        found = mujoco.mj_id2name(self.model, getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), index)
        return found or f"{kind}_{index}"

    def place(self, kind: str, index: int) -> str:
        """Where something is, as messages say it."""
        return f'{kind} "{self.name(kind, index)}"'

    def link_of(self, body: int) -> int:
        """The body to which a body is welded; 0 for the ground."""
        return int(self.model.body_weldid[body])

    def joints_of(self, body: int) -> range:
        first = int(self.model.body_jntadr[body])
        return range(first, first + int(self.model.body_jntnum[body]))

    @cached_property
    def links(self) -> list[int]:
        """The bodies that move, those that carry others first."""
        return [b for b in range(1, self.model.nbody) if self.link_of(b) == b]

    @cached_property
    def in_link(self) -> list[Frame]:
        """The frame of each body in that of its link; of those that stand still, in the global one."""
        found: list[Frame] = [HERE]
        for b in range(1, self.model.nbody):
            found.append(HERE if self.link_of(b) == b else found[self.model.body_parentid[b]] @ self._beside(b))
        return found

    def at_zero(self, link: int) -> Frame:
        """The frame of a link in that of the link that carries it, its joints at their reference."""
        return self.in_link[self.model.body_parentid[link]] @ self._beside(link)

    def parent(self, link: int) -> int:
        """The link that carries it."""
        return self.link_of(int(self.model.body_parentid[link]))

    def _beside(self, body: int) -> Frame:
        return Frame.of(self.model.body_pos[body], self.model.body_quat[body])

    @cached_property
    def composites(self) -> dict[int, Link]:
        """Of each link: its own mass and that of all that is welded to it."""
        members: dict[int, list[int]] = {link: [] for link in self.links}
        for b in range(1, self.model.nbody):
            if self.link_of(b) and self.name("body", b) not in self.massless:
                members[self.link_of(b)].append(b)
        return {link: self._composite(bodies) for link, bodies in members.items()}

    def _composite(self, bodies: list[int]) -> Link:
        m = self.model
        masses = np.array([m.body_mass[b] for b in bodies])
        mass = float(masses.sum())
        at = [self.in_link[b] @ Frame.of(m.body_ipos[b], m.body_iquat[b]) for b in bodies]
        weighed = sum((x * frame.p for x, frame in zip(masses, at, strict=True)), np.zeros(3))
        centre = weighed / mass if mass else np.zeros(3)
        J = np.zeros((3, 3))
        for b, x, frame in zip(bodies, masses, at, strict=True):
            r = frame.p - centre
            J += frame.R @ np.diag(m.body_inertia[b]) @ frame.R.T + x * (r @ r * np.eye(3) - np.outer(r, r))
        return Link(mass, centre, J)

    def coordinates(self, joint: int) -> np.ndarray:
        """Of a joint at the start, as qpos has them."""
        first = int(self.model.jnt_qposadr[joint])
        return self.qpos[first : first + LETTERS[int(self.model.jnt_type[joint])]]

    def rates(self, joint: int) -> np.ndarray:
        """Of a joint at the start, as qvel has them."""
        first, kind = int(self.model.jnt_dofadr[joint]), int(self.model.jnt_type[joint])
        return self.qvel[first : first + {FREE: 6, BALL: 3}.get(kind, 1)]

    def armature(self, joint: int) -> float:
        """Of a hinge or slide, with that of its actuators."""
        return float(self.model.dof_armature[self.model.jnt_dofadr[joint]]) + self._of_actuators("armature", joint)

    def damping(self, joint: int) -> float:
        """Of a hinge or slide, with that of its actuators."""
        return float(self.model.dof_damping[self.model.jnt_dofadr[joint]]) + self._of_actuators("damping", joint)

    def _of_actuators(self, what: str, joint: int) -> float:
        """What actuators add along a joint, times the square of their gears."""
        m = self.model
        own = getattr(m, f"actuator_{what}", None)  # newer models have it
        if own is None:
            return 0.0
        along = (m.actuator_trntype <= IN_PARENT) & (m.actuator_trnid[:, 0] == joint)
        return float((own * m.actuator_gear[:, 0] ** 2)[along].sum())

    def zero(self, joint: int) -> float:
        """The coordinate of a hinge or slide at which bodies are where the model has them."""
        return float(self.model.qpos0[self.model.jnt_qposadr[joint]])


@dataclass(frozen=True)
class Piece:
    """A body of the scenario. centre: its origin in the frame of the link that it is (a part of the way to)."""

    name: str
    centre: np.ndarray

    def here(self, point: np.ndarray) -> np.ndarray:
        """A point of the link in the frame of the body."""
        return point - self.centre


EARTH = Piece(GROUND, np.zeros(3))
