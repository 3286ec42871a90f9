"""MuJoCo's model of a robot of URDF: the same frames, masses as they are written, motors on the joints."""

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.groups import so3
from lienumba.importing.mapping.source import Source
from lienumba.importing.notes import Note
from lienumba.importing.urdf.masses import check_masses
from lienumba.importing.urdf.robot import Array, Inertial, Joint, Link, Pose
from lienumba.importing.urdf.shapes import Shapes
from lienumba.importing.urdf.tree import WORLD, Tree, mimics

if TYPE_CHECKING:
    import mujoco

LENT = 1.0  # mass and moments that a body has while MuJoCo compiles, where it would refuse its own


class Builder:
    """Makes the model of a tree."""

    def __init__(self, tree: Tree, file: Path, notes: list[Note]) -> None:
        import mujoco

        self.tree, self.file, self.notes = tree, file, notes
        self.spec = mujoco.MjSpec()
        self.spec.modelname = tree.robot.name or file.stem
        self.spec.compiler.degree = False
        self.spec.compiler.autolimits = False
        self.shapes = Shapes(self.spec, tree.robot, file, self.notes)
        self.bodies: dict[str, Any] = {}
        self.inertias: dict[str, tuple[float, Array]] = {}  # mass and moments by name of body
        self.names: dict[str, str] = {}  # of bodies by link

    def build(self) -> tuple["mujoco.MjModel", frozenset[str]]:
        """The compiled model, as MuJoCo computes it, but for masses and moments that it refuses; and the bodies without
        mass that move."""
        import mujoco

        root = self.tree.root
        if root == WORLD and not self.tree.free:
            self.bodies[root], self.names[root] = self.spec.worldbody, WORLD
            self.shapes.add(self.spec.worldbody, self.tree.robot.links[root])
        else:
            body = self.body(self.spec.worldbody, self.tree.robot.links[root])
            body.pos, body.quat = self.tree.placed.at, self.tree.placed.quaternion
            if self.tree.free:
                body.add_freejoint(name=self.unused("floating_base"))
        for joint in self.tree.joints:
            self.joint(joint)
        for name, other, multiplier, offset in mimics(self.tree.robot, self.file):
            mimic = self.spec.add_equality(name=self.unused(f"{name}_mimic"), type=mujoco.mjtEq.mjEQ_JOINT)
            mimic.objtype, mimic.name1, mimic.name2 = mujoco.mjtObj.mjOBJ_JOINT, name, other
            mimic.data[:5] = offset, multiplier, 0.0, 0.0, 0.0
        model = self.shapes.compiled()
        for name, (mass, moments) in self.inertias.items():
            i = model.body(name).id
            model.body_mass[i], model.body_inertia[i] = mass, moments
        none = np.zeros(0)
        source = Source(model, model.qpos0, none, none, none)
        bodies = {link: model.body(name).id for link, name in self.names.items()}
        massless = check_masses(self.tree, source, bodies, self.file, self.notes)
        mujoco.mj_setConst(model, mujoco.MjData(model))
        return model, frozenset(self.names[link] for link in massless)

    def unused(self, name: str) -> str:
        """A name that no joint has."""
        while name in self.tree.robot.joints:
            name += "_"
        return name

    def body(self, parent: Any, link: Link) -> Any:
        """A body for a link."""
        name = link.name
        if name == WORLD:
            name = f"{WORLD}_link"
            self.notes.append(
                Note(f'named "{name}", as the ground is called "{WORLD}"', (f'link "{WORLD}"',), lost=False)
            )
        self.names[link.name] = name
        body = parent.add_body(name=name)
        self.bodies[link.name] = body
        inertial = link.inertial or Inertial(0.0, np.zeros((3, 3)), Pose())
        tensor, at = inertial.tensor, inertial.pose
        moments, axes = np.diag(tensor), None
        if (tensor != np.diag(moments)).any():
            moments, axes = np.linalg.eigh(tensor)
            axes = axes * np.sign(np.linalg.det(axes))
        body.explicitinertial = True
        body.ipos = at.at
        body.iquat = at.quaternion if axes is None else so3.to_quaternion(tuple((at.rotation @ axes).ravel()))
        body.mass, body.inertia = LENT, [LENT] * 3
        self.inertias[name] = inertial.mass, moments
        self.shapes.add(body, link)
        return body

    def joint(self, joint: Joint) -> None:
        """The body of a joint's child, and its ways to move."""
        import mujoco

        parent = self.bodies[joint.parent]
        body = self.body(parent, self.tree.robot.links[joint.child])
        body.pos, body.quat = joint.pose.at, joint.pose.quaternion
        x, y, z = np.eye(3)
        hinge, slide, ball = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_BALL
        if joint.has_coordinate:
            self.moving(body, joint, slide if joint.type == "prismatic" else hinge)
        elif joint.type == "floating" and parent is self.spec.worldbody:
            body.add_freejoint(name=joint.name)
        elif joint.type == "floating":
            for name, axis in zip("xyz", (x, y, z), strict=True):
                body.add_joint(name=self.unused(f"{joint.name}_{name}"), type=slide, axis=axis)
            body.add_joint(name=joint.name, type=ball)
        elif joint.type == "planar":
            along, across = _in_plane(joint.axis)
            for name, axis in zip("xy", (along, across), strict=True):
                self.resisting(body.add_joint(name=self.unused(f"{joint.name}_{name}"), type=slide, axis=axis), joint)
            body.add_joint(name=joint.name, type=hinge, axis=joint.axis)

    def moving(self, body: Any, joint: Joint, kind: Any) -> None:
        """A joint of one coordinate, and its motor."""
        import mujoco

        made = body.add_joint(name=joint.name, type=kind, axis=joint.axis)
        self.resisting(made, joint)
        if joint.limits is not None:
            made.limited, made.range = True, joint.limits
        if joint.mimic is None:
            motor = self.spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            if isfinite(joint.effort):
                motor.forcelimited, motor.forcerange = True, [-joint.effort, joint.effort]

    @staticmethod
    def resisting(made: Any, joint: Joint) -> None:
        """Its damping and friction."""
        made.frictionloss = joint.friction
        polynomial = np.ndim(made.damping) == 1  # of the rate, in newer versions
        made.damping = [joint.damping, 0.0, 0.0] if polynomial else joint.damping


def _in_plane(normal: Array) -> tuple[Array, Array]:
    """Two axes across a normal: x and y where that is z."""
    along = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    if np.linalg.norm(along) < 0.5:
        along = np.array([0.0, 1.0, 0.0]) - normal[1] * normal
    along = along / np.linalg.norm(along)
    return along, np.cross(normal, along)
