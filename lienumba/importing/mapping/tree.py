"""Links and their joints: bodies, where they start, and the joints between them.

A link with several joints hangs on bodies without mass, one behind each joint but the last, with the axes that the link
has there. Coordinates of hinges and slides are MuJoCo's qpos. Conventions of mj_kinematics: from its place in the
parent's frame a link is moved by its joints one after the other, each in the frame that those before it left.
"""

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lienumba.importing.mapping.draft import GROUND, Draft
from lienumba.importing.mapping.frames import HERE, Frame, about, across, quaternion, rotation, tensor, tidy
from lienumba.importing.mapping.source import BALL, EARTH, FREE, HINGE, Piece, Source


@dataclass
class Tree:
    """pieces: the body of each link; joints: the names of joints of MuJoCo; ends: the two bodies of each."""

    pieces: dict[int, Piece] = field(default_factory=dict)
    joints: dict[int, str] = field(default_factory=dict)
    ends: dict[int, tuple[Piece, Piece]] = field(default_factory=dict)

    def on(self, source: Source, body: int) -> tuple[str, Frame]:
        """The body of the scenario that has a MuJoCo body, and the frame of that in its own."""
        piece = self.pieces.get(source.link_of(body), EARTH)
        frame = source.in_link[body]
        return piece.name, Frame(piece.here(frame.p), frame.R)


def add_tree(source: Source, draft: Draft, looped: Collection[int]) -> Tree:
    """Add all bodies and joints. looped: joints in loops, whose coordinates are solved for."""
    tree = Tree()
    for link in source.links:
        _add_link(source, draft, tree, link, looped)
    return tree


def _add_link(source: Source, draft: Draft, tree: Tree, link: int, looped: Collection[int]) -> None:
    own = source.composites[link]
    name = draft.body_names.new(source.name("body", link))
    if own.mass:
        body = {"name": name, "mass": tidy(own.mass)[0], "inertia": tensor(own.inertia)}
    else:
        body = {"name": name, "mass": 0}
    joints = source.joints_of(link)
    if len(joints) == 1 and source.model.jnt_type[joints[0]] == FREE:
        tree.pieces[link] = Piece(name, own.centre)
        start = _floating(source, joints[0], own.centre)
        draft.bodies.append(body | ({"guess": start} if joints[0] in looped else start))
        return
    before, place = tree.pieces.get(source.parent(link), EARTH), source.at_zero(link)
    for joint in joints:
        if joint == joints[-1]:
            piece = Piece(name, own.centre if own.mass else np.array(source.model.jnt_pos[joint]))
            draft.bodies.append(body)
        else:
            between = draft.body_names.new(f"{source.name('joint', joint)}_frame")
            piece = Piece(between, np.array(source.model.jnt_pos[joint]))
            draft.bodies.append({"name": between, "mass": 0})
        _add_joint(source, draft, tree, joint, before, piece, place, joint in looped)
        before, place = piece, HERE
    tree.pieces[link] = before


def _floating(source: Source, joint: int, centre: np.ndarray) -> dict[str, Any]:
    """The start of a body that nothing holds: MuJoCo's velocity is that of the origin of its frame, global."""
    q, v = source.coordinates(joint), source.rates(joint)
    frame = Frame.of(q[:3], q[3:])
    w = v[3:]
    return {
        "position": tidy(frame.point(centre)),
        "rotation": tidy(quaternion(frame.R)),
        "velocity": tidy(v[:3] + frame.R @ np.cross(w, centre)),
        "angular_velocity": tidy(w),
    }


def _add_joint(
    source: Source, draft: Draft, tree: Tree, joint: int, first: Piece, second: Piece, place: Frame, looped: bool
) -> None:
    """place: of the second body's frame, its coordinate at the reference, in the frame of the first body's link."""
    m, kind = source.model, int(source.model.jnt_type[joint])
    name = draft.joint_names.new(source.name("joint", joint))
    tree.joints[joint], tree.ends[joint] = name, (first, second)
    point, axis = np.array(m.jnt_pos[joint]), np.array(m.jnt_axis[joint])
    there = first.here(place.point(point))
    pair = [first.name, second.name]
    body = draft.bodies[-1]
    if looped:
        body |= _guess(source, joint, first, second, place)
    if kind == BALL:
        points = [tidy(there), tidy(second.here(point))]
        draft.joints.append({"name": name, "type": "spherical", "bodies": pair, "points": points})
        if not looped:
            body |= _ball_start(source, joint, first, place)
        return
    zero, q, rate = source.zero(joint), float(source.coordinates(joint)[0]), float(source.rates(joint)[0])
    x = across(axis)
    if kind == HINGE:
        references = [place.R @ about(axis, -zero) @ x, x]
        start = {"angle": q, "rate": rate}
        type = "revolute"
    else:
        references = [place.R @ x, x]
        there = there - place.R @ axis * zero
        start = {"displacement": q, "speed": rate}
        type = "prismatic"
    keys: dict[str, Any] = {"name": name, "type": type, "bodies": pair}
    keys |= {"points": [tidy(there), tidy(second.here(point))], "axes": [tidy(place.R @ axis), tidy(axis)]}
    keys["references"] = [tidy(x) for x in references]
    if not looped:
        keys |= {key: tidy(value)[0] for key, value in start.items()}
    if armature := source.armature(joint):
        keys["armature"] = tidy(armature)[0]
    draft.joints.append(keys)


def _ball_start(source: Source, joint: int, first: Piece, place: Frame) -> dict[str, Any]:
    keys = {} if first.name == GROUND else {"relative_to": first.name}
    R = place.R @ rotation(source.coordinates(joint))
    return {**keys, "rotation": tidy(quaternion(R)), "angular_velocity": tidy(source.rates(joint))}


def moved(source: Source, joint: int, place: Frame) -> Frame:
    """The frame of a body behind a joint at its start, in the frame of the first body's link."""
    m, q = source.model, source.coordinates(joint)
    point, axis, kind = m.jnt_pos[joint], m.jnt_axis[joint], m.jnt_type[joint]
    if kind in (BALL, HINGE):
        turn = rotation(q) if kind == BALL else about(axis, float(q[0]) - source.zero(joint))
        return place @ Frame(point - turn @ point, turn)
    return place.moved(axis * (float(q[0]) - source.zero(joint)))


def _guess(source: Source, joint: int, first: Piece, second: Piece, place: Frame) -> dict[str, Any]:
    there = moved(source, joint, place)
    keys = {} if first.name == GROUND else {"relative_to": first.name}
    at = {"position": tidy(first.here(there.point(second.centre))), "rotation": tidy(quaternion(there.R))}
    return {**keys, "guess": at}
