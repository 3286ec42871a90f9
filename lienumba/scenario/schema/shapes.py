"""Shapes of bodies, for looking only: what is drawn instead of the solid of equivalent inertia.

A type is one class: its fields are its keys, its `surface` is what is drawn. `SHAPES` knows the types by name.
"""

import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag

from lienumba.errors import BadValueError, Problem, missing
from lienumba.keys.choices import OneOf
from lienumba.keys.conversions import rotation_of
from lienumba.keys.registry import Registry, literal
from lienumba.keys.types import ZERO, Positive, Rotation, Section, Two, Vec3
from lienumba.scenario.meshes import surfaces
from lienumba.scenario.meshes.packing import unpacked
from lienumba.scenario.meshes.surfaces import Surface


def _colour(text: str) -> str:
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", text):
        raise BadValueError("is no colour", 'give red, green and blue in hexadecimal digits, such as "#8090a0"')
    return text.lower()


def _mesh(text: str) -> str:
    unpacked(text)
    return text


Three = Annotated[list[Positive], Field(min_length=3, max_length=3)]
Scale = Annotated[
    Annotated[Positive, Tag("number")] | Annotated[Vec3, Tag("vector")],
    Discriminator(lambda value: "vector" if isinstance(value, list) else "number"),
]


class Shape(Section):
    """A type of shapes, and one shape as a scenario has it."""

    if TYPE_CHECKING:
        type: str
    colour: Annotated[str, AfterValidator(_colour)] | None = Field(
        default=None, description='the colour, such as "#8090a0" (or omit it: that of the body)'
    )
    position: Vec3 = Field(default=ZERO, description="the middle in m, body frame: 3 numbers")
    rotation: Rotation | None = Field(
        default=None,
        description="the rotation from the shape to the body: a quaternion [w, x, y, z], a 3x3 matrix, {axis, angle}, "
        '{euler = "ZYX", angles} or {rotation_vector}, in rad (or omit it: none)',
    )

    def surface(self) -> Surface:
        """Its surface in its own frame."""
        raise NotImplementedError

    def placed(self) -> Surface:
        """Its surface in the frame of the body."""
        vertices, faces = self.surface()
        turned = (
            vertices
            if self.rotation is None
            else vertices @ np.array(rotation_of(self.rotation), float).reshape(3, 3).T
        )
        return turned + np.array(self.position), faces


SHAPES: Registry[type[Shape]] = Registry("shape", literal("type"))


@SHAPES.add
class Box(Shape):
    type: Literal["box"]
    size: Three = Field(description="the lengths of the edges in m: 3 numbers above 0")

    def surface(self) -> Surface:
        return surfaces.box(self.size)


@SHAPES.add
class Sphere(Shape):
    type: Literal["sphere"]
    radius: Positive = Field(description="the radius in m, above 0")

    def surface(self) -> Surface:
        return surfaces.ellipsoid([self.radius] * 3)


@SHAPES.add
class Ellipsoid(Shape):
    type: Literal["ellipsoid"]
    radii: Three = Field(description="the half axes in m: 3 numbers above 0")

    def surface(self) -> Surface:
        return surfaces.ellipsoid(self.radii)


class Long(Shape):
    """Along z of the shape about its position, or between two points of the body."""

    radius: Positive = Field(description="the radius in m, above 0")
    length: Positive | None = Field(
        default=None, description="the length in m along z, without round ends, above 0 (or give ends instead)"
    )
    ends: Two | None = Field(
        default=None, description="the middles of both ends in m, body frame: 2 points (or give length instead)"
    )

    def placed(self) -> Surface:
        if self.ends is None:
            return super().placed()
        first, second = np.array(self.ends, float)
        vertices, faces = self.surface()
        return vertices @ _towards(second - first).T + 0.5 * (first + second), faces

    def faults(self) -> Iterator[Problem]:
        """Either a length, or both ends, which say all of where it is."""
        if self.ends is None:
            if self.length is None:
                yield missing("length", "give the length in m along z, or ends = [[0, 0, 0], [0, 0, 1]]")
            return
        for key in ("length", "position", "rotation"):
            if key in self.model_fields_set and getattr(self, key) not in (None, ZERO):
                yield Problem(key, "the ends say already where it is", "leave out either this or ends")
        if not self.extent > 0.0:
            yield Problem("ends", "are one point", "give two points, or a sphere", self.ends)

    @property
    def extent(self) -> float:
        """From one end to the other in m."""
        if self.ends is None:
            return float(self.length or 0.0)
        first, second = np.array(self.ends, float)
        return float(np.linalg.norm(second - first))


@SHAPES.add
class Cylinder(Long):
    type: Literal["cylinder"]

    def surface(self) -> Surface:
        return surfaces.cylinder(self.radius, self.extent)


@SHAPES.add
class Capsule(Long):
    type: Literal["capsule"]

    def surface(self) -> Surface:
        return surfaces.capsule(self.radius, self.extent)


@SHAPES.add
class Mesh(Shape):
    """file: as people write it; data: as the scenario keeps it, whichever file it came from."""

    type: Literal["mesh"]
    file: str | None = Field(default=None, description="the path of an STL or OBJ file, relative to the scenario")
    scale: Scale = Field(default=1.0, description="the unit of the file in m, above 0, such as 0.001, or 3 numbers")
    data: Annotated[str, AfterValidator(_mesh)] | None = Field(
        default=None, description="the mesh itself, as lienumba keeps it (give a file instead)"
    )

    def faults(self) -> Iterator[Problem]:
        if self.data is None:
            yield missing("file", f"give {Mesh.model_fields['file'].description}")

    def surface(self) -> Surface:
        assert self.data is not None, "read when the scenario was loaded"
        vertices, faces = unpacked(self.data)
        scale = np.array(self.scale, float)
        return vertices * scale, faces[:, ::-1] if scale.prod() < 0.0 and scale.ndim else faces


AnyShapes = list[Annotated[Shape, OneOf(SHAPES)]]


def _towards(way: Sequence[float] | np.ndarray) -> np.ndarray:
    """A rotation matrix that turns z this way."""
    z = np.asarray(way, float) / max(float(np.linalg.norm(way)), 1e-300)
    x = np.cross(np.eye(3)[abs(z).argmin()], z)
    x /= max(float(np.linalg.norm(x)), 1e-300)
    found: Any = np.column_stack([x, np.cross(z, x), z])
    return found
