"""Wheels, capsules and balls that roll: steady motions by vectors, inclines in closed form, and tangents that jump."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.closed_forms import rolls_down

G, UP = 9.81, np.array([0.0, 0.0, 1.0])


def steady(radius: float, lean: float, turning: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The spin with which a thin disc of 1 kg rolls on a circle, its axis (z) turned from the vertical about x by
    `lean`, everything turning about the vertical with `turning`: angular velocity, velocity, and the place of the
    centre over that of the circle; global frame. q x F = L' and F = m (v' + g), where v' and L' are those of vectors
    that turn."""
    axis = Rotation.from_rotvec([lean, 0, 0]).apply(UP)
    down = -radius * (UP - (UP @ axis) * axis) / np.linalg.norm(UP - (UP @ axis) * axis)
    A, C = radius**2 / 4, radius**2 / 2
    way = np.cross(down, UP) / np.linalg.norm(np.cross(down, UP))

    def motion(spin: float) -> tuple[np.ndarray, np.ndarray]:
        w = turning * UP + spin * axis
        return w, -np.cross(w, down)

    def missing(spin: float) -> float:
        w, v = motion(spin)
        L = A * w + (C - A) * (w @ axis) * axis
        force = turning * np.cross(UP, v) + G * UP
        return float((np.cross(down, force) - turning * np.cross(UP, L)) @ way)

    w, v = motion(brentq(missing, -1e3, 1e3, xtol=1e-15, rtol=1e-15))
    return w, v, np.cross(UP, v) * -1 / turning - down[2] * UP


def test_a_disc_rolls_on_its_circle() -> None:
    cases = [(0.1, 1.2, 3.0), (0.25, 0.7, -4.0), (0.1, 1.9, 2.0)]
    columns: dict[str, Any] = {"contacts.floor.radius": [], "contacts.floor.friction": [2.0, 5.0, 3.0]}
    known = [steady(*case) for case in cases]
    for name in ("position", "velocity", "angular_velocity"):
        columns |= {f"bodies.disc.{name}[{i}]": [] for i in range(3)}
    columns |= {f"bodies.disc.rotation[{i}]": [] for i in range(4)} | {
        f"bodies.disc.inertia[{i}]": [] for i in range(3)
    }
    for (radius, lean, _), (w, v, r) in zip(cases, known, strict=True):
        R = Rotation.from_rotvec([lean, 0, 0])
        q = R.as_quat()
        rows = {"position": r, "velocity": v, "angular_velocity": R.inv().apply(w), "rotation": [q[3], *q[:3]]}
        rows["inertia"] = np.array([0.25, 0.25, 0.5]) * radius**2
        for name, row in rows.items():
            for i, x in enumerate(row):
                columns[f"bodies.disc.{name}[{i}]"].append(x)
        columns["contacts.floor.radius"].append(radius)
    body = {"name": "disc", "mass": 1, "inertia": [0.25, 0.25, 0.5], "position": [0, 0, 1], "rotation": [1, 0, 0, 0]}
    floor = {"name": "floor", "type": "cylinder_plane", "bodies": ["disc", "ground"], "axis": [0, 0, 1], "radius": 0.1}
    data = {
        "title": "A disc that rolls",
        "model": {"gravity": [0, 0, -G], "bodies": [body | scenarios.AT_REST], "contacts": [floor | {"friction": 3.0}]},
        "integrator": scenarios.settings(2.0),
        "output": {"times": [0, 1.0, 2.0]},
        "sweep": scenarios.table({name: np.array(x) for name, x in columns.items()}),
    }
    ds = lienumba.run(data)
    assert (ds.status == 0).all()
    assert (ds.last_mode == 1).all()
    for run, ((_, _, turning), (_, v, r)) in enumerate(zip(cases, known, strict=True)):
        for time in (1, 2):
            turned = Rotation.from_rotvec(turning * float(ds.time[time]) * UP)
            np.testing.assert_allclose(ds.position[run, time, 0], turned.apply(r), rtol=0, atol=1e-9)
            np.testing.assert_allclose(ds.velocity[run, time, 0], turned.apply(v), rtol=0, atol=1e-9)
    assert abs(ds.energy_residual).max() < 1e-10


def test_a_capsule_rolls_down_sideways() -> None:
    """Both ends stick along their common axis, which says the same twice; steeper, both slip."""
    slopes, friction, radius = np.array([0.1, 0.3, 0.8]), 0.2, 0.1
    body = {"name": "rod", "mass": 1, "inertia": [0.02, 0.005, 0.02], "position": [0, 0, radius]}
    floor = {"name": "floor", "type": "capsule_plane", "bodies": ["rod", "ground"], "axis": [0, 1, 0]}
    data = {
        "title": "A capsule",
        "model": {
            "gravity": [1, 0, -G],
            "bodies": [body | scenarios.AT_REST | {"rotation": [1, 0, 0, 0]}],
            "contacts": [floor | {"radius": radius, "length": 0.4, "friction": friction}],
        },
        "integrator": scenarios.settings(1.0),
        "output": {"times": [0, 1.0]},
        "sweep": scenarios.table({"gravity[0]": G * np.sin(slopes), "gravity[2]": -G * np.cos(slopes)}),
    }
    ds = lienumba.run(data)
    for run, slope in enumerate(slopes):
        a, spin = rolls_down(float(slope), friction, 0.5)
        assert float(ds.position[run, -1, 0, 0]) == pytest.approx(0.5 * a, abs=1e-10)
        assert float(ds.angular_velocity[run, -1, 0, 1]) * radius == pytest.approx(spin, abs=1e-10)
    assert abs(ds.energy_residual).max() < 1e-11


@pytest.mark.parametrize("speed", [4.0, 2.0])
def test_tangents_that_jump_do_not_matter(speed: float) -> None:
    """With steps of one length a ball slides, or soon rolls, over another one from above the equator of its frame to
    below, where the tangents jump: by half a turn in the first run, less in the second, not at all in the last."""
    phases = np.array([0.0, 0.4, np.pi / 2])
    turns, rise = [Rotation.from_rotvec(x * UP) for x in phases], 0.05 if speed > 3 else 0.25
    place = np.array([np.cos(rise), 0, np.sin(rise)]) * 0.6
    going, spin = np.array([np.sin(rise), 0, -np.cos(rise)]) * speed, np.array([0.5, 2.0, -1.0])
    columns = {}
    for name, x in ("position", place), ("velocity", going), ("angular_velocity", spin):
        columns |= {f"bodies.ball.{name}[{i}]": [turn.apply(x)[i] for turn in turns] for i in range(3)}
    body = {"name": "ball", "mass": 1, "inertia": [0.004] * 3, "position": [0.6, 0, 0], "rotation": [1, 0, 0, 0]}
    contact = {"name": "touch", "type": "sphere_sphere", "bodies": ["ball", "ground"], "radii": [0.1, 0.5]}
    spring = {"name": "pull", "type": "spring_damper", "bodies": ["ground", "ball"], "points": [[0, 0, 0]] * 2}
    data = {
        "title": "A ball on a ball",
        "model": {
            "gravity": [0, 0, 0],
            "bodies": [body | scenarios.AT_REST],
            "contacts": [contact | {"friction": 0.3}],
            "forces": [spring | {"stiffness": 100, "damping": 0, "free_length": 0}],
        },
        "integrator": {"method": "rk4", "step": 0.001, "end_time": 0.15 if speed < 3 else 0.07},
        "sweep": scenarios.table({name: np.array(x) for name, x in columns.items()}),
    }
    data["output"] = {"times": [0, data["integrator"]["end_time"]]}
    ds = lienumba.run(data)
    assert (ds.last_mode == (2 if speed > 3 else 1)).all()
    ends = [turn.inv().apply(ds.position.values[run, -1, 0]) for run, turn in enumerate(turns)]
    assert ends[0][2] < -0.05
    np.testing.assert_allclose(ends[:2], [ends[2]] * 2, rtol=0, atol=1e-11)
    assert abs(ds.energy_residual).max() < 1e-5  # of the step of fixed length
