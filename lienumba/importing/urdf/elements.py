"""Numbers, names and places of the elements of a URDF file."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, isfinite, sin
from pathlib import Path

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.importing.markup import LARGEST, Element
from lienumba.importing.urdf.robot import Pose


@dataclass(frozen=True)
class Place:
    """An element of a file, and the link or joint to which it belongs."""

    file: Path
    element: Element
    owner: str = ""

    def __str__(self) -> str:
        tag = "" if self.element.tag in ("link", "joint", "robot") else f"<{self.element.tag}>"
        whose = " ".join(x for x in (self.owner, tag) if x)
        return f"{self.file}, line {self.element.line}" + (f": {whose}" if whose else "")

    def error(self, rule: str, remedy: str, key: str = "", value: object = None) -> ScenarioError:
        """What is wrong with it, or with an attribute of it."""
        if not key:
            return ScenarioError.at(str(self), rule, remedy)
        return ScenarioError.at(f"{self} {key}", rule, remedy, value)

    def inner(self, tag: str) -> "Place | None":
        """The first element of a kind within it."""
        found = self.element.find(tag)
        return Place(self.file, found, self.owner) if isinstance(found, Element) else None

    def all(self, tag: str) -> "Iterator[Place]":
        """Those of a kind within it."""
        for found in self.element.findall(tag):
            assert isinstance(found, Element)
            yield Place(self.file, found, self.owner)

    def needed(self, tag: str, remedy: str) -> "Place":
        """The first element of a kind, which must be there."""
        found = self.inner(tag)
        if found is None:
            raise self.error(f"has no <{tag}>", remedy)
        return found

    def text(self, key: str, remedy: str) -> str:
        """An attribute that must be there."""
        text = self.element.get(key, "").strip()
        if not text:
            raise self.error(f'has no {key}="..."', remedy)
        return text

    def numbers(self, key: str, count: int, default: tuple[float, ...] | None = None) -> tuple[float, ...]:
        """Finite numbers of an attribute, of ordinary size; a default where it is missing."""
        found = self.unbounded(key, count, default)
        if any(abs(x) > LARGEST for x in found):
            raise self.error(f"must be at most {LARGEST:g} in SI units", "check it", key, self.element.get(key))
        return found

    def unbounded(self, key: str, count: int, default: tuple[float, ...] | None = None) -> tuple[float, ...]:
        """Numbers of an attribute, which may be infinite."""
        text = self.element.get(key)
        words = (text or "").split()
        if not words:
            if default is None:
                raise self.error(f'has no {key}="..."', f"give {_many(count)}")
            return default
        try:
            found = tuple(float(word) for word in words)
        except ValueError:
            remedy = "expand the file by xacro first" if "$" in (text or "") else f"give {_many(count)}"
            raise self.error(f"is not {_many(count)}", remedy, key, text) from None
        if len(found) != count:
            raise self.error(f"must be {_many(count)}, and is {len(found)}", f"give {count}", key, text)
        if any(x != x for x in found) or (count > 1 and not all(map(isfinite, found))):
            raise self.error("is not finite", f"give {_many(count)}", key, text)
        return found

    def number(self, key: str, default: float | None = None) -> float:
        """A finite number of ordinary size."""
        return self.numbers(key, 1, None if default is None else (default,))[0]

    def pose(self) -> Pose:
        """Its <origin>; nowhere else than its frame without one."""
        origin = self.inner("origin")
        if origin is None:
            return Pose()
        at = np.array(origin.numbers("xyz", 3, (0.0, 0.0, 0.0)))
        if origin.element.get("quat_xyzw") is not None:
            x, y, z, w = origin.numbers("quat_xyzw", 4)
            quaternion = np.array([w, x, y, z])
            length = float(np.linalg.norm(quaternion))
            if length < 1e-6:
                raise origin.error("has no direction", "give 4 numbers of length 1", "quat_xyzw", quaternion.tolist())
            return Pose(at, quaternion / length)
        return Pose(at, _turned(*origin.numbers("rpy", 3, (0.0, 0.0, 0.0))))


def _many(count: int) -> str:
    return "a number" if count == 1 else f"{count} numbers"


def _turned(roll: float, pitch: float, yaw: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The quaternion (4,) of turns about fixed axes x, y, z, one after the other."""
    (a, b, c), (d, e, f) = [[fun(0.5 * x) for x in (roll, pitch, yaw)] for fun in (cos, sin)]
    return np.array([a * b * c + d * e * f, d * b * c - a * e * f, a * e * c + d * b * f, a * b * f - d * e * c])
