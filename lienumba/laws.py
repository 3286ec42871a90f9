"""What a law of one's own is written with: bodies, joints, vectors, and functions of numbers.

A law is a plain Python function. It is run once on symbols, and what it computes is compiled like the laws that are
built in; so it may use loops, lists and other functions, but neither a Python `if` on a number that the state decides
(write `where`) nor functions of NumPy or `math` (use those below). Lengths in m, angles in rad, forces in N.

>>> def spring(a, b, *, stiffness, length):
...     d = b.position - a.position
...     pull = stiffness * (d.norm() - length) / d.norm()
...     return a.force(pull * d), b.force(-pull * d)
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

from lienumba.groups import so3
from lienumba.numerics.functions import FUNCTIONS
from lienumba.numerics.grammar import CONSTANTS
from lienumba.numerics.number import Condition, Number
from lienumba.numerics.operations import absolute, atan2, cos, exp, log, maximum, minimum, sin, sqrt, tanh, where

__all__ = [
    "Body", "Joint", "Load", "Memory", "Vector", "absolute", "acos", "asin", "atan", "atan2", "ceil", "clip", "cos",
    "cosh", "deg", "exp", "floor", "hypot", "log", "maximum", "minimum", "mod", "pi", "rpm", "sign", "sin", "sinc",
    "sinh", "sqrt", "tan", "tanh", "where",
]  # fmt: skip

deg, rpm = CONSTANTS["deg"], CONSTANTS["rpm"]
acos, asin, atan, clip, sign, tan = (FUNCTIONS[name][2] for name in ("acos", "asin", "atan", "clip", "sign", "tan"))
ceil, floor, mod = (FUNCTIONS[name][2] for name in ("ceil", "floor", "mod"))
cosh, hypot, sinc, sinh = (FUNCTIONS[name][2] for name in ("cosh", "hypot", "sinc", "sinh"))


class Vector:
    """Three numbers, with + - * / and dot, cross, norm.

    Parameters
    ----------
    x, y, z : number
        Its components: numbers, or what stands for them while a law is compiled.
    """

    __slots__ = ("x", "y", "z")
    __array_ufunc__ = None

    def __init__(self, x: Number, y: Number, z: Number) -> None:
        self.x, self.y, self.z = x, y, z

    @staticmethod
    def of(numbers: "Vector | Sequence[Number]") -> "Vector":
        """A vector of three numbers.

        Parameters
        ----------
        numbers : Vector or sequence
            Three of them.

        Returns
        -------
        Vector
            Of these.
        """
        return Vector(*numbers)

    def __iter__(self) -> Iterator[Number]:
        return iter((self.x, self.y, self.z))

    def __len__(self) -> int:
        return 3

    def __getitem__(self, i: Any) -> Any:
        return (self.x, self.y, self.z)[i]

    def __bool__(self) -> bool:
        raise TypeError("a kernel may not branch on a vector")

    def __eq__(self, other: object) -> bool:
        raise TypeError("a kernel may not branch on a vector")

    __hash__ = None  # type: ignore[assignment]

    def where(self, condition: Condition, x: "Vector | Sequence[Number]", y: "Vector | Sequence[Number]") -> "Vector":
        """Choose between two vectors.

        Parameters
        ----------
        condition : condition
            Such as t < 1.
        x, y : Vector or sequence
            Three numbers each.

        Returns
        -------
        Vector
            x where the condition holds, else y.
        """
        return Vector(*(where(condition, a, b) for a, b in zip(x, y, strict=True)))

    def __add__(self, other: Any) -> "Vector":
        if isinstance(other, int) and other == 0:  # where sum() begins
            return self
        return Vector(*so3.add(tuple(self), tuple(other)))

    __radd__ = __add__

    def __sub__(self, other: "Vector | Sequence[Number]") -> "Vector":
        return Vector(*so3.subtract(tuple(self), tuple(other)))

    def __rsub__(self, other: "Vector | Sequence[Number]") -> "Vector":
        return Vector.of(other) - self

    def __neg__(self) -> "Vector":
        return Vector(-self.x, -self.y, -self.z)

    def __mul__(self, number: Number) -> "Vector":
        return Vector(*so3.scale(number, tuple(self)))

    __rmul__ = __mul__

    def __truediv__(self, number: Number) -> "Vector":
        return Vector(self.x / number, self.y / number, self.z / number)

    def dot(self, other: "Vector | Sequence[Number]") -> Number:
        """The scalar product.

        Parameters
        ----------
        other : Vector or sequence
            Three numbers.

        Returns
        -------
        number
            Their scalar product.
        """
        return so3.dot(tuple(self), tuple(other))

    def cross(self, other: "Vector | Sequence[Number]") -> "Vector":
        """The vector product.

        Parameters
        ----------
        other : Vector or sequence
            Three numbers.

        Returns
        -------
        Vector
            This one times the other.
        """
        return Vector(*so3.cross(tuple(self), tuple(other)))

    def norm(self) -> Number:
        """The length. At length 0 it has no derivative.

        Returns
        -------
        number
            The root of the sum of squares.
        """
        return sqrt(self.dot(self))

    def __repr__(self) -> str:
        return f"Vector({self.x!r}, {self.y!r}, {self.z!r})"


class Memory:
    """Numbers of a sampled law that every run keeps from sample to sample. They are 0 at the start.

    A law reads and writes them by whole numbers (`line[0]`, `line[1:]`). A function with `lienumba.jit` or
    `lienumba.batched` gets them as an array, and what it writes there is kept.

    Parameters
    ----------
    numbers : sequence
        What it holds.
    """

    def __init__(self, numbers: Iterable[Number]) -> None:
        self.numbers = list(numbers)

    def __len__(self) -> int:
        return len(self.numbers)

    def __iter__(self) -> Iterator[Number]:
        return iter(self.numbers)

    def __getitem__(self, i: Any) -> Any:
        return self.numbers[i]

    def __setitem__(self, i: Any, value: Any) -> None:
        replaced = self.numbers.copy()
        replaced[i] = value
        if len(replaced) != len(self):
            raise ValueError(f"a memory of {len(self)} numbers would get {len(replaced)}")
        self.numbers[:] = replaced


@dataclass(frozen=True)
class Load:
    """What a law does to a body or a joint; made by their methods.

    Attributes
    ----------
    kind : str
        "force" (N) at a point of a body, "torque" (N m) on a body, or "effort" along a coordinate of a joint.
    target : int
        The index of the body or joint.
    value : tuple
        Three numbers; one for an effort.
    frame : str
        The axes of the value, "global" or "body".
    at : tuple
        The point in m, body frame.
    coordinate : str
        "angle" or "displacement" of an effort.
    """

    kind: str
    target: int
    value: tuple[Number, ...]
    frame: str = "global"
    at: tuple[Number, ...] = (0.0, 0.0, 0.0)
    coordinate: str = ""


@dataclass(frozen=True)
class Body:
    """A body as it is now.

    Attributes
    ----------
    index : int
        Its number in the mechanism; -1 for the ground.
    position : Vector
        Of the mass centre in m, global frame.
    rotation : tuple
        Body to global, nine numbers row by row.
    velocity : Vector
        Of the mass centre in m/s, global frame.
    angular_velocity : Vector
        In rad/s, body frame.
    """

    index: int
    position: Vector
    rotation: tuple[Number, ...]
    velocity: Vector
    angular_velocity: Vector

    def point(self, p: Vector | Sequence[Number]) -> Vector:
        """The position of a point of the body.

        Parameters
        ----------
        p : Vector or sequence
            The point in m, body frame.

        Returns
        -------
        Vector
            In m, global frame.
        """
        return self.position + self.to_global(p)

    def velocity_of(self, p: Vector | Sequence[Number]) -> Vector:
        """The velocity of a point of the body.

        Parameters
        ----------
        p : Vector or sequence
            The point in m, body frame.

        Returns
        -------
        Vector
            In m/s, global frame.
        """
        return self.velocity + self.to_global(self.angular_velocity.cross(p))

    def to_global(self, v: Vector | Sequence[Number]) -> Vector:
        """Turn a vector from the body's axes to the global ones.

        Parameters
        ----------
        v : Vector or sequence
            Along the body's axes.

        Returns
        -------
        Vector
            R v.
        """
        return Vector(*so3.rotate(self.rotation, tuple(v)))

    def to_body(self, v: Vector | Sequence[Number]) -> Vector:
        """Turn a vector from the global axes to the body's.

        Parameters
        ----------
        v : Vector or sequence
            Along the global axes.

        Returns
        -------
        Vector
            R^T v.
        """
        return Vector(*so3.rotate_back(self.rotation, tuple(v)))

    def force(
        self, value: Vector | Sequence[Number], at: Vector | Sequence[Number] = (0.0, 0.0, 0.0), frame: str = "global"
    ) -> Load:
        """A force on the body.

        Parameters
        ----------
        value : Vector or sequence
            In N.
        at : Vector or sequence
            The point where it acts, in m, body frame; the mass centre by default.
        frame : str
            The axes of the value, "global" or "body".

        Returns
        -------
        Load
            To be returned by the law.

        Raises
        ------
        ValueError
            For another frame.
        """
        return Load("force", self.index, tuple(value), _checked(frame), tuple(at))

    def torque(self, value: Vector | Sequence[Number], frame: str = "global") -> Load:
        """A torque on the body.

        Parameters
        ----------
        value : Vector or sequence
            In N m.
        frame : str
            The axes of the value, "global" or "body".

        Returns
        -------
        Load
            To be returned by the law.

        Raises
        ------
        ValueError
            For another frame.
        """
        return Load("torque", self.index, tuple(value), _checked(frame))


class Joint:
    """A joint as it is now.

    Attributes
    ----------
    index : int
        Its number in the mechanism.
    angle, rate : number
        In rad, over all turns, and rad/s, where it has an angle.
    displacement, speed : number
        In m and m/s, where it has a displacement.
    """

    def __init__(self, index: int, **coordinates: Number) -> None:
        self.index, self._coordinates = index, coordinates

    def __getattr__(self, name: str) -> Number:
        if name in self._coordinates:
            return self._coordinates[name]
        has = f"it has {' and '.join(self._coordinates)}" if self._coordinates else "it has no coordinates"
        raise AttributeError(f"the joint has no {name} here; {has}")

    def effort(self, value: Number, coordinate: str | None = None) -> Load:
        """A torque about the joint's axis or a force along it, on the second body, and the opposite on the first.

        Parameters
        ----------
        value : number
            In N m or N.
        coordinate : str, optional
            "angle" or "displacement", where it has both; by default the angle.

        Returns
        -------
        Load
            To be returned by the law.

        Raises
        ------
        ValueError
            For another coordinate.
        AttributeError
            For one that the joint does not have.
        """
        kind = coordinate or ("angle" if "angle" in self._coordinates else "displacement")
        if kind not in ("angle", "displacement"):
            raise ValueError(f'coordinate = {kind!r}: must be "angle" or "displacement"')
        getattr(self, kind)
        return Load("effort", self.index, (value,), coordinate=kind)


def _checked(frame: str) -> str:
    if frame not in ("global", "body"):
        raise ValueError(f'frame = {frame!r}: must be "global" or "body"')
    return frame
