"""Boxes that slide, turn, stand and drop, against MuJoCo with ever harder contacts; renews a table of docs/changes.md.

    .venv/bin/python scripts/boxes_against_mujoco.py

MuJoCo is no dependency (docs/decisions/0033-changes.md): it has to be installed for this alone. Its contacts give way:
`solref` says with which time constant. Fifty steps fit into each, so that the error of its steps, too, shrinks.

Its cone of friction is convex: what slides with v is pushed off the floor by mu b v, b being the damping along the
floor, and flies wherever its sag does not make up for that. `LEVELS` keep what slides down, by contacts that sag (an
impedance d far below 1) and a b of their own; `STIFF` is what one would take without knowing it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import lienumba
from document import markdown, renew

DOCUMENT = Path(__file__).parents[1] / "docs" / "changes.md"
HALF = (0.1, 0.1, 0.05)  # m
MASS, MU, G = 1.0, 0.3, 9.81
BALL = 0.01  # m, the radius of balls to stand on
STEPS = 50  # in a time constant


@dataclass(frozen=True)
class Softness:
    """Of MuJoCo's contacts: time constant (s), impedance d, damping b along the floor (1/s), if not that across it."""

    constant: float
    impedance: float
    damping: float | None = None

    @property
    def words(self) -> str:
        return f"{1e3 * self.constant:g} ms" + ("" if self.damping else ", stiff")


LEVELS = (Softness(0.005, 3e-4, 400.0), Softness(0.0025, 1e-4, 1200.0), Softness(0.00125, 3e-5, 4000.0))
STIFF = Softness(0.00125, 0.9999)


@dataclass(frozen=True)
class Case:
    """words: what it does, and what is looked at; end: when (s); slope: the tangent of the angle of the floor; height
    (m) of the mass centre above its rest, tilt about y (rad); v, w: at the start (m/s, rad/s); tripod: whether it
    stands on three balls, which share its weight in one way alone, and not on four corners."""

    words: str
    end: float
    slope: float = 0.0
    height: float = 0.0
    tilt: float = 0.0
    v: tuple[float, float, float] = (0.0, 0.0, 0.0)
    w: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tripod: bool = False

    @property
    def feet(self) -> list[list[float]]:
        """The corners below, or the middles of the balls (m)."""
        if not self.tripod:
            return [[x * HALF[0], y * HALF[1], -HALF[2]] for x in (-1, 1) for y in (-1, 1)]
        angles = 2 * np.pi / 3 * np.arange(3)
        return [[HALF[0] * float(np.cos(a)), HALF[1] * float(np.sin(a)), BALL - HALF[2]] for a in angles]

    @property
    def gravity(self) -> list[float]:
        angle = float(np.arctan(self.slope))
        return [G * float(np.sin(angle)), 0.0, -G * float(np.cos(angle))]

    @property
    def start(self) -> tuple[list[float], list[float]]:
        """The position, and the rotation as w, x, y, z."""
        lowest = HALF[0] * abs(np.sin(self.tilt)) + HALF[2] * np.cos(self.tilt)
        turn = [float(np.cos(self.tilt / 2)), 0.0, float(np.sin(self.tilt / 2)), 0.0]
        return [0.0, 0.0, float(lowest) + self.height], turn


CASES = (
    Case("slides to rest", 1.0, v=(2.0, 0.0, 0.0)),
    Case("slides and turns on three balls to rest", 1.0, v=(1.5, 0.0, 0.0), w=(0.0, 0.0, 6.0), tripod=True),
    Case("slides and turns on four corners to rest", 1.0, v=(1.5, 0.0, 0.0), w=(0.0, 0.0, 6.0)),
    Case("slides down a slope of 0.4", 1.0, slope=0.4),
    Case("stands on a slope of 0.25", 1.0, slope=0.25),
    Case("drops on an edge, and rocks to rest", 0.6, height=0.05, tilt=0.3),
)


def rigid(case: Case) -> np.ndarray:
    """Where lienumba has the mass centre at the end (m)."""
    position, rotation = case.start
    inertia = [MASS / 3 * (sum(x * x for x in HALF) - x * x) for x in HALF]
    data: dict[str, Any] = {
        "model": {
            "gravity": case.gravity,
            "bodies": [{
                "name": "box", "mass": MASS, "inertia": inertia, "position": position, "rotation": rotation,
                "velocity": list(case.v), "angular_velocity": list(case.w),
            }],
            "contacts": [{
                "name": f"foot_{n}", "bodies": ["box", "ground"], "normal": [0, 0, 1], "points": [foot, [0, 0, 0]],
                "friction": MU,
            } | ({"type": "sphere_plane", "radius": BALL} if case.tripod else {"type": "point_plane"})
                for n, foot in enumerate(case.feet)],
        },
        "integrator": {"method": "dop853", "tolerance": 1e-10, "end_time": case.end},
        "output": {"every": case.end},
    }  # fmt: skip
    run = lienumba.run(data, progress=False).isel(run=0)
    if int(run.status):
        raise SystemExit(f"{case.words}: status {int(run.status)}")
    return np.asarray(run.position.values[-1, 0])


def yielding(case: Case, soft: Softness) -> np.ndarray:
    """Where MuJoCo has it."""
    position, rotation = (" ".join(map(str, x)) for x in case.start)
    inertia = " ".join(str(MASS / 3 * (sum(x * x for x in HALF) - x * x)) for x in HALF)
    geoms = [f'type="box" size="{" ".join(map(str, HALF))}"']
    if case.tripod:
        geoms = [f'size="{BALL}" pos="{" ".join(map(str, foot))}"' for foot in case.feet]
    damping = f'solreffriction="-1 {-soft.damping * soft.impedance}"' if soft.damping else ""
    solimp = f'solimp="{soft.impedance} {soft.impedance} 0.001"'
    contact = f'condim="3" friction="{MU} {MU} 0 0 0" solref="{soft.constant} 1" {solimp} {damping}'
    xml = f"""<mujoco>
      <option timestep="{soft.constant / STEPS}" gravity="{" ".join(map(str, case.gravity))}" cone="elliptic"
        impratio="{10 / soft.impedance}" solver="Newton" tolerance="1e-14" iterations="200" integrator="implicitfast"/>
      <worldbody>
        <geom name="floor" type="plane" size="10 10 1"/>
        <body pos="{position}" quat="{rotation}">
          <freejoint/><inertial pos="0 0 0" mass="{MASS}" diaginertia="{inertia}"/>
          {"".join(f'<geom name="part_{n}" {geom}/>' for n, geom in enumerate(geoms))}
        </body>
      </worldbody>
      <contact>{"".join(f'<pair geom1="floor" geom2="part_{n}" {contact}/>' for n in range(len(geoms)))}</contact>
    </mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qvel[:] = [*case.v, *case.w]
    for _ in range(round(case.end / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return np.array(data.qpos[:3])


def lines() -> Iterator[list[str]]:
    for case in CASES:
        here = rigid(case)
        apart = [1e3 * np.linalg.norm(yielding(case, level) - here) for level in (*LEVELS, STIFF)]
        yield [
            case.words,
            *(f"{1e3 * x + 0.0:.3f}".replace("-0.000", "0.000") for x in here),
            *(f"{x:.2g}" for x in apart),
        ]


if __name__ == "__main__":
    head = ["a box", "x (mm)", "y (mm)", "z (mm)", *(level.words for level in (*LEVELS, STIFF))]
    renew(DOCUMENT, {"boxes": lambda: markdown(head, list(lines()))})
