"""A URDF file as a Robot, with what it says beyond bodies and joints as notes."""

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import cast

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.importing.markup import LARGEST, Element
from lienumba.importing.notes import Note
from lienumba.importing.urdf.elements import Place
from lienumba.importing.urdf.robot import JOINT_TYPES, Inertial, Joint, JointType, Link, Mimic, Robot, Shape
from lienumba.words import suggestion

# The elements that are read, by what they stand in.
KNOWN = {
    "robot": {"link", "joint", "material"},
    "link": {"inertial", "visual", "collision"},
    "joint": {"parent", "child", "origin", "axis", "limit", "dynamics", "mimic"},
    "inertial": {"origin", "mass", "inertia"},
    "visual": {"origin", "geometry", "material"},
    "collision": {"origin", "geometry", "material"},
    "geometry": {"box", "sphere", "cylinder", "capsule", "mesh"},
    "material": {"color", "texture"},
}
LEFT_OUT = {  # what URDF has for others than a simulator
    "transmission": "<transmission>: what a motor is wired to; efforts act on joints directly",
    "gazebo": "<gazebo>: settings of another simulator",
    "sensor": "<sensor>: no part of the motion",
    "safety_controller": "<safety_controller>: soft limits, kept by a robot's own controller",
    "contact": "<contact>: settings of another simulator",
    "calibration": "<calibration>: of encoders",
    "mujoco": "<mujoco>: settings of another simulator",
    "verbose": "<verbose>: a label",
}
COLOURS = tuple[float, float, float, float]


def parse(root: Element, file: Path) -> tuple[Robot, list[Note]]:
    """What the file says."""
    place, notes = Place(file, root), list[Note]()
    colours = {x.element.get("name", ""): c for x in place.all("material") if (c := _colour(x)) is not None}
    for element in root.iter():
        if element.tag.startswith("xacro:"):
            macro = Place(file, cast(Element, element))
            raise macro.error("belongs to xacro, and may stand for links and joints", "expand the file by xacro first")
    links = _named(place, "link")
    joints = _named(place, "joint")
    if not links:
        remedy = "expand it by xacro first" if root.get("xmlns:xacro") else "give a robot of at least one link"
        raise ScenarioError.at("", f"{file} has no <link>", remedy)
    found = {name: _link(name, x, colours) for name, x in links.items()}
    held = {name: _joint(name, x, found, notes) for name, x in joints.items()}
    for name, x in joints.items():
        mimic = held[name].mimic
        if mimic is not None and mimic.joint not in held:
            rule = "is not the name of a joint"
            raise x.needed("mimic", "").error(rule, suggestion(mimic.joint, held), "joint", mimic.joint)
    settings = root.find("mujoco/compiler")
    folder = settings.get("meshdir", "") if settings is not None else ""
    return Robot(root.get("name", ""), found, held, folder), [*_aside(root), *notes]


def _named(place: Place, tag: str) -> dict[str, Place]:
    """The links or joints by their names."""
    named: dict[str, Place] = {}
    for x in place.all(tag):
        name = Place(x.file, x.element, f"a <{tag}>").text("name", "give it a name of its own")
        owned = Place(x.file, x.element, f'{tag} "{name}"')
        if name in named:
            raise owned.error(f"has the name of the {tag} on line {named[name].element.line}", "rename one of them")
        named[name] = owned
    return named


def _link(name: str, place: Place, colours: dict[str, COLOURS]) -> Link:
    shapes = [
        shape
        for tag in ("visual", "collision")
        for x in place.all(tag)
        if (shape := _shape(x, tag == "visual", colours)) is not None
    ]
    return Link(name, place.element.line, _inertial(place), tuple(shapes))


def _inertial(link: Place) -> Inertial | None:
    """None where there is no mass: a frame only."""
    place = link.inner("inertial")
    if place is None:
        return None
    remedy = 'give <mass value="..."/> in kg, or no <inertial> for a frame without mass'
    mass = place.needed("mass", remedy)
    value = mass.number("value")
    if value < 0:
        raise mass.error("must be at least 0", "give the mass in kg", "value", value)
    x = place.inner("inertia")
    if x is None and value > 0:
        raise place.error(f"has a mass of {value:g} kg and no <inertia>", "give it in kg m²")
    if x is None:
        return None
    xx, yy, zz = (x.number(key) for key in ("ixx", "iyy", "izz"))
    xy, xz, yz = (x.number(key, 0.0) for key in ("ixy", "ixz", "iyz"))
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if value == 0 and not tensor.any():
        return None
    return Inertial(value, tensor, place.pose())


def _shape(place: Place, drawn: bool, colours: dict[str, COLOURS]) -> Shape | None:
    geometry = place.inner("geometry")
    forms = list(geometry.element) if geometry is not None else []
    if geometry is None or not forms:
        return None
    form, pose = Place(place.file, cast(Element, forms[0]), place.owner), place.pose()
    rgba = _material(place, colours) if drawn else None
    match form.element.tag:
        case "box":
            return Shape("box", tuple(0.5 * x for x in form.numbers("size", 3)), pose, drawn, rgba)
        case "sphere":
            return Shape("sphere", form.numbers("radius", 1), pose, drawn, rgba)
        case "cylinder" | "capsule" as kind:
            return Shape(kind, (form.number("radius"), 0.5 * form.number("length")), pose, drawn, rgba)
        case "mesh":
            scale = form.numbers("scale", 3, (1.0, 1.0, 1.0))
            return Shape("mesh", (), pose, drawn, rgba, form.text("filename", "give the file's path"), scale)
    known = ("box", "sphere", "cylinder", "capsule", "mesh")
    raise form.error("is not a known shape", suggestion(form.element.tag, known))


def _material(place: Place, colours: dict[str, COLOURS]) -> COLOURS | None:
    material = place.inner("material")
    if material is None:
        return None
    return _colour(material) or colours.get(material.element.get("name", ""))


def _colour(material: Place) -> COLOURS | None:
    colour = material.inner("color")
    return cast(COLOURS, colour.numbers("rgba", 4)) if colour is not None else None


def _joint(name: str, place: Place, links: dict[str, Link], notes: list[Note]) -> Joint:
    kind = _type(place)
    ends = []
    for tag in ("parent", "child"):
        end = place.needed(tag, f'give <{tag} link="..."/>')
        link = end.text("link", "give the name of a link")
        if link not in links:
            raise end.error("is not the name of a link", suggestion(link, links), "link", link)
        ends.append(link)
    damping, friction = _resistance(place)
    limits, effort = _limits(place, kind, notes)
    return Joint(
        name, place.element.line, kind, ends[0], ends[1], place.pose(), _axis(place, kind), limits, effort, damping,
        friction, _mimic(place, kind),
    )  # fmt: skip


def _type(place: Place) -> JointType:
    text = place.text("type", "known are " + ", ".join(JOINT_TYPES))
    for known in JOINT_TYPES:
        if text == known:
            return known
    raise place.error("is not a type of joint", suggestion(text, JOINT_TYPES), "type", text)


def _axis(place: Place, kind: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    x = place.inner("axis")
    if x is None or kind in ("fixed", "floating"):
        return np.array([1.0, 0.0, 0.0])
    axis = np.array(x.numbers("xyz", 3, (1.0, 0.0, 0.0)))
    length = float(np.linalg.norm(axis))
    if length < 1e-6:
        raise x.error("has no direction", "give 3 numbers that are not all 0", "xyz", x.element.get("xyz"))
    return axis if abs(length - 1.0) < 1e-15 else axis / length


def _resistance(place: Place) -> tuple[float, float]:
    x = place.inner("dynamics")
    if x is None:
        return 0.0, 0.0
    found = x.number("damping", 0.0), x.number("friction", 0.0)
    for key, value in zip(("damping", "friction"), found, strict=True):
        if value < 0:
            raise x.error("must be at least 0", "check its sign", key, value)
    return found


def _limits(place: Place, kind: str, notes: list[Note]) -> tuple[tuple[float, float] | None, float]:
    """(lower, upper), None for none; effort, infinite for none."""
    x = place.inner("limit")
    if x is None or kind not in ("revolute", "continuous", "prismatic"):
        if kind in ("revolute", "prismatic"):
            notes.append(Note("no <limit>, which URDF asks for: the joint has no limits", (place.owner,), lost=False))
        return None, inf
    effort = x.unbounded("effort", 1, (0.0,))[0]
    if effort < 0:
        notes.append(Note(f"limit of effort {effort:g}, which is below 0: none", (place.owner,), lost=False))
    if not 0 < effort < LARGEST:
        effort = inf
    if 0 < x.unbounded("velocity", 1, (0.0,))[0] < LARGEST:
        notes.append(Note("limit of velocity: kept by a robot's own controller, left out", (place.owner,), lost=False))
    if kind == "continuous":
        return None, effort
    lower, upper = x.unbounded("lower", 1, (0.0,))[0], x.unbounded("upper", 1, (0.0,))[0]
    if lower <= -LARGEST and upper >= LARGEST:
        return None, effort
    if not lower < upper:
        what = f"its limits, {lower:g} and {upper:g}, leave no room: left out"
        notes.append(Note(what, (place.owner,)))
        return None, effort
    return (max(lower, -LARGEST), min(upper, LARGEST)), effort


def _mimic(place: Place, kind: str) -> Mimic | None:
    x = place.inner("mimic")
    if x is None or kind not in ("revolute", "continuous", "prismatic"):
        return None
    return Mimic(x.text("joint", "give the name of a joint"), x.number("multiplier", 1.0), x.number("offset", 0.0))


def _aside(root: Element) -> list[Note]:
    """A note for each kind of elements that are left out, with how many there are; those that are not known may say
    something of the motion."""
    unread = list(_unread(root, ""))
    notes = []
    for tag, count in Counter(tag for tag, _ in unread).items():
        places = dict.fromkeys(place for found, place in unread if found == tag and place)
        if tag in LEFT_OUT:
            notes.append(Note(f"{LEFT_OUT[tag]}; {count} left out", lost=False))
        else:
            notes.append(Note(f"<{tag}>: unknown; {count} left out", tuple(places)))
    return notes


def _unread(element: ET.Element, owner: str) -> Iterator[tuple[str, str]]:
    """The tags of elements that are not read, each with the link or joint in which it stands."""
    for x in element:
        if x.tag not in KNOWN.get(element.tag, ()):
            yield x.tag, owner
        else:
            yield from _unread(x, f'{x.tag} "{x.get("name")}"' if element.tag == "robot" else owner)
