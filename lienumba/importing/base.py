"""The free joint of a robot in MJCF, given or taken."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

from lienumba.errors import ScenarioError
from lienumba.importing.notes import Note

FREE, BALL = 0, 1  # mjtJoint
WIDTH = {FREE: (7, 6), BALL: (4, 3)}  # of qpos and qvel; of other joints 1 each


def delete(spec: Any, element: Any) -> None:
    """Take an element out of a model that is being made."""
    if hasattr(spec, "delete"):
        spec.delete(element)
    else:
        element.delete()


def rebased(spec: Any, file: Path, base: Literal["fixed", "free"], notes: list[Note]) -> None:
    """Give the robot's root a free joint, or take it; keyframes follow.

    Of several bodies that stand on the ground, the robot is the one that carries the most joints.
    """
    roots = list(spec.worldbody.bodies)
    if not roots:
        return
    root = max(roots, key=_size)  # the first of several
    own = [joint for joint in root.joints if int(joint.type) == FREE]
    name = f'body "{root.name}"'
    if base == "fixed":
        if own:
            _keyframes(spec, roots[: roots.index(root)], remove=True)
            delete(spec, own[0])
        elif root.joints:
            names = ", ".join(f'"{joint.name}"' for joint in root.joints)
            notes.append(Note(f"is no free base, and moves by its own joints {names} still", (name,), lost=False))
    elif root.joints and not own:
        names = ", ".join(f'"{joint.name}"' for joint in root.joints)
        raise ScenarioError.at(
            f"{file}: {name}", f"cannot be a free base, it moves by joints of its own, {names}", "import it as it is"
        )
    elif not own:
        _keyframes(spec, roots[: roots.index(root)], remove=False, at=(*root.pos, *root.quat))
        root.add_freejoint(name=_unused(spec))
    others = [x for x in roots if x is not root and any(int(j.type) == FREE for j in x.joints) == (base == "fixed")]
    if others:
        what = f"stays as it is: the base that is {base} is that of {name}"
        notes.append(Note(what, tuple(f'body "{x.name}"' for x in others), lost=False))


def _size(root: Any) -> tuple[int, int]:
    """How many joints and bodies hang together; a free joint is that of a thing as well as of a robot."""
    joints = [joint for body in _below(root) for joint in body.joints if int(joint.type) != FREE]
    return len(joints), len(list(_below(root)))


def _below(body: Any) -> Iterator[Any]:
    """A body and all that it carries, in the order of coordinates."""
    yield body
    for child in body.bodies:
        yield from _below(child)


def _unused(spec: Any) -> str:
    """A name that no joint has."""
    taken, name = {joint.name for joint in spec.joints}, "floating_base"
    while name in taken:
        name += "_"
    return name


def _keyframes(spec: Any, before: list[Any], *, remove: bool, at: tuple[float, ...] = ()) -> None:
    """Coordinates of a free joint behind those of the bodies before it."""
    widths = [WIDTH.get(int(joint.type), (1, 1)) for root in before for body in _below(root) for joint in body.joints]
    starts = [sum(w[i] for w in widths) for i in (0, 1)]
    for key in spec.keys:
        for field, start, width, new in zip(("qpos", "qvel"), starts, WIDTH[FREE], (at, (0.0,) * 6), strict=True):
            values = list(getattr(key, field))
            if values:
                values[start : start + width if remove else start] = () if remove else new
                setattr(key, field, values)
