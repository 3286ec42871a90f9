"""Scenarios of bodies that are thrown on planes: boxes, rods, tripods, tables, balls, capsules and discs, some of them
two with a joint, in random poses, with any spin, friction from 0 to 2 and restitution from 0 to 0.9."""

from dataclasses import dataclass
from typing import Any

import numpy as np

G = 9.81
END = 1.5  # s
TOLERANCE = 1e-8
SHAPES = ("box", "rod", "tripod", "table", "ball", "capsule", "disc")
JOINTS = ("revolute", "spherical", "prismatic")


@dataclass(frozen=True)
class Foot:
    """What of a body may touch: a type of contact, a point of the body (m) and the rest of its keys."""

    type: str
    point: tuple[float, ...]
    keys: dict[str, Any]

    def gap(self, body: np.ndarray, R: np.ndarray, plane: np.ndarray, normal: np.ndarray) -> float:
        """The least distance (m) from a plane, of a body in its pose."""
        middle, radius = float(normal @ (body + R @ self.point - plane)), self.keys.get("radius", 0.0)
        lean = float(normal @ R @ self.keys["axis"]) if "axis" in self.keys else 0.0
        if self.type == "cylinder_plane":
            return middle - radius * float(np.sqrt(max(0.0, 1.0 - lean * lean)))
        return middle - radius - 0.5 * self.keys.get("length", 0.0) * abs(lean)


@dataclass(frozen=True)
class Drop:
    """A scenario, what of its bodies may touch, and the planes: points and normals."""

    title: str
    scenario: dict[str, Any]
    feet: tuple[tuple[Foot, ...], ...]
    planes: tuple[tuple[np.ndarray, np.ndarray], ...]

    def gap(self, positions: np.ndarray, rotations: np.ndarray) -> float:
        """The least distance (m) of anything from any plane. positions (b, 3), rotations (b, 3, 3)."""
        return min(
            foot.gap(x, R, *plane)
            for x, R, feet in zip(positions, rotations, self.feet, strict=True)
            for foot in feet
            for plane in self.planes
        )

    def leans(self, rotations: np.ndarray) -> float:
        """The least sine between the axis of any disc and the normal of any plane; infinite without discs. rotations
        (b, 3, 3)."""
        return min(
            (
                float(np.linalg.norm(np.cross(normal, R @ foot.keys["axis"])))
                for R, feet in zip(rotations, self.feet, strict=True)
                for foot in feet
                for _, normal in self.planes
                if foot.type == "cylinder_plane"
            ),
            default=np.inf,
        )


def drop(seed: int) -> Drop:
    """One of them."""
    rng = np.random.default_rng(seed)
    shape = SHAPES[rng.integers(len(SHAPES))]
    two, many = rng.random() < 0.25, rng.random() < 0.3
    shapes = (shape, ("rod", "ball", "capsule")[rng.integers(3)]) if two else (shape,)
    planes = [(np.zeros(3), np.array([0.0, 0.0, 1.0]))]
    if many and not (two and shape in ("box", "table")):
        planes.append(_wall(rng))
    R = _rotation(rng)
    drawn = [_shape(rng, name) for name in shapes]
    hinge = [rng.uniform(-0.2, 0.2, 3) for _ in shapes]
    positions = [np.zeros(3)] + ([R @ (hinge[0] - hinge[1])] if two else [])
    feet = tuple(feet for feet, _, _ in drawn)
    found = Drop("", {}, feet, tuple(planes))
    height = float(rng.choice([0.01, 0.1, 0.5])) * rng.uniform(0.5, 1.0)
    lift = max(
        (height - foot.gap(x, R, *plane)) / plane[1][2]
        for x, own in zip(positions, feet, strict=True)
        for foot in own
        for plane in planes
    )
    v, w = rng.normal(size=3) * rng.choice([0.0, 1.0]), rng.normal(size=3) * rng.choice([0.0, 1.0, 8.0])
    bodies, contacts = [], []
    friction = [0.0, *rng.uniform(0.05, 2.0, 3)] if rng.random() < 0.3 else [rng.uniform(0.0, 2.0)]
    restitution = rng.uniform(0.0, 0.9) if rng.random() < 0.7 else 0.0
    for n, ((own, mass, inertia), x) in enumerate(zip(drawn, positions, strict=True)):
        bodies.append({
            "name": f"body_{n}", "mass": mass, "inertia": list(inertia), "position": list(x + [0.0, 0.0, lift]),
            "rotation": R.tolist(), "velocity": list(v + np.cross(w, x)), "angular_velocity": list(R.T @ w),
        })  # fmt: skip
        for k, foot in enumerate(own):
            for m, (point, normal) in enumerate(planes):
                contacts.append({
                    "name": f"touch_{n}_{k}_{m}", "type": foot.type, "bodies": [f"body_{n}", "ground"],
                    "points": [list(foot.point), point.tolist()], "normal": normal.tolist(),
                    "friction": float(rng.choice(friction)), "restitution": restitution,
                } | foot.keys)  # fmt: skip
    model: dict[str, Any] = {"gravity": [0, 0, -G], "bodies": bodies, "contacts": contacts}
    if two:
        kind, axis = JOINTS[rng.integers(3)], _unit(rng).tolist()
        joint = {"name": "joint", "type": kind, "bodies": ["body_0", "body_1"], "points": [list(h) for h in hinge]}
        if kind != "spherical":
            joint |= {"axes": [axis, axis]}
        model["joints"] = [joint]
    title = f"{' and '.join(shapes)}, {len(planes)} plane{'s' * (len(planes) > 1)}"
    data = {
        "title": title, "model": model,
        "integrator": {"method": "dop853", "tolerance": TOLERANCE, "end_time": END},
        "output": {"every": END / 60, "variables": ["position", "rotation", "energy", "energy_residual"]},
    }  # fmt: skip
    return Drop(title, data, found.feet, found.planes)


def _unit(rng: np.random.Generator) -> np.ndarray:
    x = rng.normal(size=3)
    return np.asarray(x / np.linalg.norm(x))


def _rotation(rng: np.random.Generator) -> np.ndarray:
    """Anyhow, or about an axis of the body, so that several points may meet a plane at once."""
    q = rng.normal(size=4)
    if rng.random() < 0.4:
        q[1:] *= np.eye(3)[rng.integers(3)]
    if rng.random() < 0.15:
        q[1:] = 0.0
    a, b, c, d = q / np.linalg.norm(q)
    return np.array([
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ])  # fmt: skip


def _wall(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A slope beside the floor."""
    tilt, turn = rng.uniform(0.3, 1.2), rng.uniform(0.0, 2 * np.pi)
    normal = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    return -rng.uniform(0.0, 0.3) * np.array([np.cos(turn), np.sin(turn), 0.0]), normal


def _shape(rng: np.random.Generator, name: str) -> tuple[tuple[Foot, ...], float, np.ndarray]:
    """What may touch, the mass (kg), and the inertia of a solid of that size (kg m^2)."""
    mass, size = float(10 ** rng.uniform(-1, 1)), float(rng.uniform(0.1, 0.4))
    axis = np.eye(3)[rng.integers(3)]
    if name == "box":
        half = size * rng.uniform(0.2, 1.0, 3)
        corners = [half * s for s in np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, 8).T]
        return _points(corners), mass, mass / 3 * ((half**2).sum() - half**2)
    if name == "rod":
        inertia = mass * size**2 / 3 * np.maximum(1 - axis, 1e-3)
        return _points([size * axis, -size * axis]), mass, inertia
    if name in ("tripod", "table"):
        legs = 3 if name == "tripod" else int(rng.integers(4, 7))
        angles = 2 * np.pi * (np.arange(legs) + (rng.uniform(-0.2, 0.2, legs) if rng.random() < 0.5 else 0.0)) / legs
        radius, height = size * rng.uniform(0.6, 1.2), size * rng.uniform(0.3, 1.2)
        feet = [np.array([radius * np.cos(a), radius * np.sin(a), -height]) for a in angles]
        return _points(feet), mass, mass * size**2 * rng.uniform(0.5, 0.8, 3)
    if name == "ball":
        return (Foot("sphere_plane", (0.0,) * 3, {"radius": size}),), mass, np.full(3, 0.4 * mass * size**2)
    radius = 0.3 * size
    if name == "capsule":
        keys = {"radius": radius, "axis": axis.tolist(), "length": size}
        return (Foot("capsule_plane", (0.0,) * 3, keys),), mass, mass * (radius**2 + size**2 / 12 * (1 - axis))
    keys = {"radius": size, "axis": axis.tolist()}
    rims = tuple(Foot("cylinder_plane", tuple(s * radius * axis), keys) for s in (-0.5, 0.5))
    return rims, mass, mass * size**2 / 4 * (1 + axis)


def _points(places: list[np.ndarray]) -> tuple[Foot, ...]:
    return tuple(Foot("point_plane", tuple(float(x) for x in place), {}) for place in places)
