"""Parts of mechanisms as dictionaries of a scenario: bodies, contacts, joints, friction, quantities, and sweeps.

Lengths are in m, masses in kg, inertias in kg m^2, times in s. `keys` are further keys of the part; they replace what
the function sets.
"""

import copy
from collections.abc import Iterable
from typing import Any

Part = dict[str, Any]
Vector = Iterable[Any]
ORIGIN = [0, 0, 0]
X, Y, Z = [1, 0, 0], [0, 1, 0], [0, 0, 1]
AT_REST = {"velocity": [0, 0, 0], "angular_velocity": [0, 0, 0]}


def numbers(x: Any) -> list[float]:
    """A vector as a scenario has it."""
    return [float(y) for y in x]


def quaternion(R: Any) -> list[float]:
    """A rotation of SciPy as a scenario has it: w, x, y, z."""
    return numbers(R.as_quat()[[3, 0, 1, 2]])


def body(name: str = "b", mass: Any = 1, inertia: Any = 0.1, **keys: Any) -> Part:
    """A rigid body; inertia: one number for all three axes, or what a scenario may give."""
    inertias = [inertia] * 3 if isinstance(inertia, int | float) else inertia
    return {"name": name, "mass": mass, "inertia": inertias} | keys


def resting(name: str = "b", mass: Any = 1, inertia: Any = 0.1, position: Vector = ORIGIN, **keys: Any) -> Part:
    """A body that starts at rest, its axes along those of the ground."""
    return body(name, mass, inertia, position=list(position), rotation=[1, 0, 0, 0]) | copy.deepcopy(AT_REST) | keys


def foot(name: str, body: str, point: Vector = ORIGIN, on: Vector = ORIGIN, to: str = "ground", **keys: Any) -> Part:
    """A point of a body that may touch a plane through the point `on` of another body."""
    return {"name": name, "type": "point_plane", "bodies": [body, to], "points": [list(point), list(on)]} | keys


def feet(body: str, places: Iterable[Vector], name: str = "foot_", **keys: Any) -> list[Part]:
    """Points of a body that may touch a plane of the ground, named by their numbers."""
    return [foot(f"{name}{n}", body, place, **keys) for n, place in enumerate(places)]


def sphere(
    name: str, body: str, radius: Any, point: Vector = ORIGIN, on: Vector = ORIGIN, to: str = "ground", **keys: Any
) -> Part:
    """A sphere about a point of a body that may touch a plane through the point `on` of another body."""
    return foot(name, body, point, on, to, type="sphere_plane", radius=radius) | keys


def joint(name: str, kind: str, body: str, to: str = "ground", **keys: Any) -> Part:
    """A joint of this type between a body and the ground, or another body; `points` begins with that of `to`."""
    return {"name": name, "type": kind, "bodies": [to, body]} | keys


def hinge(name: str, body: str, at: Vector = ORIGIN, axis: Vector = Y, to: str = "ground", **keys: Any) -> Part:
    """A revolute joint; place and axis are global, as the mechanism starts."""
    return joint(name, "revolute", body, to, at=list(at), axis=list(axis)) | keys


def frames(axis: list[Any], first: Vector = ORIGIN, second: Vector = ORIGIN) -> Part:
    """Keys of a joint whose place and axis are given in both bodies, with references across the axis."""
    return {
        "points": [list(first), list(second)],
        "axes": [list(axis), list(axis)],
        "references": [list(Y if list(axis) == X else X) for _ in range(2)],
    }


def pivot(
    name: str, body: str, first: Vector = ORIGIN, second: Vector = ORIGIN, axis: list[Any] = Y, to: str = "ground",
    **keys: Any,
) -> Part:  # fmt: skip
    """A revolute joint whose place and axis are given in both bodies, first in `to`, then in `body`."""
    return joint(name, "revolute", body, to) | frames(axis, first, second) | keys


def slide(name: str, body: str, axis: list[Any] = X, **keys: Any) -> Part:
    """A prismatic joint along an axis of the ground through its origin and the mass centre of the body."""
    return joint(name, "prismatic", body) | frames(axis) | keys


def dry(joint: str, coulomb: Any, static: Any, name: str = "dry", **keys: Any) -> Part:
    """Dry friction of a joint that sticks (N or N m)."""
    return {"name": name, "type": "friction", "joint": joint, "coulomb": coulomb, "static": static} | keys


def observed(kind: str, *names: str) -> list[Part]:
    """A quantity of this type for each named joint, contact or limit, with its name."""
    return [{"name": name, "type": kind, kind: name} for name in names]


def uniform(low: float, high: float) -> Part:
    """A uniform distribution."""
    return {"distribution": "uniform", "low": low, "high": high}


def sweep(runs: int, ranges: dict[str, tuple[float, float]], **keys: Any) -> Part:
    """A sweep of so many runs in which these numbers are uniform within their ranges."""
    return {"runs": runs, "vary": {path: uniform(*ends) for path, ends in ranges.items()}} | keys


def table(columns: dict[str, Any]) -> Part:
    """A sweep over a table, one run a row."""
    return {"sampler": "table", "table": {"columns": columns}}
