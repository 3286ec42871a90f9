"""Distances, contacts, limits and locks as quantities, against what was written down for them."""

import numpy as np
import pytest

from lienumba.mechanics.elements.quantities import Observed, components, level, rows
from lienumba.mechanics.elements.quantities.base import OBSERVED, POSITION, VELOCITY
from lienumba.mechanics.mechanism.kinematics import Mode, still
from lienumba.mechanics.mechanism.model import Contact, Coordinate, Force, Limit, Lock, Quantity
from tests.facade import GROUND, Body, Instant, Joint, Model
from tests.mechanics.elements.contacts.test_geometry import at, motion

NUMBERS = {"stiffness": 100.0, "dissipation": 0.5, "velocity": 1e-3}
UNIT = Body("b", 1.0, (1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
FRAME = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
HINGE = Joint("hinge", "revolute", (GROUND, 0), ((0.0,) * 3, (0.0,) * 3), (FRAME, FRAME))
BALL = Joint("ball", "spherical", (GROUND, 0), ((0.0,) * 3, (0.0,) * 3))
FOOT = Contact("foot", "sphere_plane", (0, GROUND), ((0.0,) * 3, (0.0,) * 3), (0.0, 0.0, 1.0), None, {"radius": 0.1},
               static=0.5, kinetic=0.5)  # fmt: skip


def instant(*motions: object, modes: object = None) -> Instant:
    bodies = tuple((*m.r, *m.R, *m.v, *m.w) for m in motions)
    return Instant(bodies, modes=dict(modes or {}))


def upright(angle: float, z: float = 0.0) -> tuple[float, ...]:
    c, s = np.cos(angle), np.sin(angle)
    return (0.0, 0.0, z, c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0, 3.0, 4.0, -1.0, 0.0, 0.0, 2.0)


def seen(model: Model, quantity: Quantity, now: Instant, **switches: object) -> dict[str, float]:
    observed = Observed([], [], [], [], {tuple(key.split("_", 1)): x for key, x in switches.items()})
    numbers = rows(model, quantity, still(now, (0, 1)[: len(now.bodies)]), observed)
    return dict(zip(components(model, quantity), numbers, strict=True))


def test_a_distance_and_its_rate() -> None:
    rng = np.random.default_rng(3)
    a, b = motion(rng), motion(rng)
    points = ((0.1, 0.2, 0.3), (-0.4, 0.0, 0.2))
    model = Model((0.0, 0.0, 0.0), (UNIT, UNIT))
    found = seen(model, Quantity("gap", "distance", (0, 1), points=points), instant(a, b))
    d = at(b, points[1]) - at(a, points[0])

    def speed(m: object, p: object) -> np.ndarray:
        return np.array(m.v) + np.array(m.R).reshape(3, 3) @ np.cross(m.w, p)

    rate = d @ (speed(b, points[1]) - speed(a, points[0])) / np.linalg.norm(d)
    assert found == pytest.approx({"distance": np.linalg.norm(d), "speed": rate})


def test_a_contact_tells_gap_slip_forces_and_whether_it_touches() -> None:
    model = Model((0.0, 0.0, 0.0), (UNIT,), contacts=(FOOT,))
    quantity = Quantity("q", "contact", (0, GROUND), of="foot")
    now = Instant((upright(0.0, 0.15),), modes={("contact", "foot"): Mode(2.0, (1.0, 0.0))})
    found = seen(model, quantity, now, contact_foot=(10.0, -3.0, 4.0))
    assert found == pytest.approx({"gap": 0.0, "slip": 5.0, "normal": 10.0, "friction": 5.0, "on": 1.0})
    open_now = Instant((upright(0.0, 0.15),), modes={("contact", "foot"): Mode(0.0, (1.0, 0.0))})
    assert seen(model, quantity, open_now, contact_foot=(0.0, 0.0, 0.0))["on"] == 0.0
    levels = [level(Model((0.0, 0.0, 0.0), (), quantities=(quantity,)), f"q.{x}") for x in found]
    assert levels == [POSITION, VELOCITY, OBSERVED, OBSERVED, OBSERVED]


def test_a_contact_that_yields_tells_its_own_forces() -> None:
    force = Force(
        "foot", "contact", (0, GROUND), numbers={"stiffness": 100.0, "dissipation": 0.5, "velocity": 1e-3}, contact=FOOT
    )
    model = Model((0.0, 0.0, 0.0), (UNIT,), forces=(force,))
    found = seen(model, Quantity("q", "contact", (0, GROUND), of="foot"), Instant((upright(0.0, 0.08),)))
    push = 100.0 * 0.02 * (1.0 + 0.5 * 1.0)  # it sinks at 1 m/s
    assert found == pytest.approx({"gap": -0.02, "slip": 5.0, "normal": push, "friction": 0.5 * push, "on": 1.0})


def test_a_limit_tells_the_nearer_side_and_its_effort_along_the_coordinate() -> None:
    which = Coordinate(0, "angle")
    limits = (Limit("stop.low", which, 1.0, -0.5), Limit("stop.high", which, -1.0, 0.7))
    model = Model((0.0, 0.0, 0.0), (UNIT,), joints=(HINGE,), limits=limits)
    modes = {("limit", "stop.low"): Mode(0.0), ("limit", "stop.high"): Mode(2.0)}
    now = Instant((upright(0.6),), modes=modes)
    found = seen(
        model, Quantity("q", "limit", joint=0, of="stop"), now, **{"limit_stop.low": (0.0,), "limit_stop.high": (3.0,)}
    )
    assert found == pytest.approx({"gap": 0.0, "effort": -3.0, "on": 1.0})


def test_locks_tell_what_holds_their_coordinates() -> None:
    model = Model((0.0, 0.0, 0.0), (UNIT,), joints=(HINGE, BALL), locks=(
        Lock("hinge.lock", 0, ("angle",)), Lock("ball.lock", 1, ("rx", "ry", "rz")),
    ))  # fmt: skip
    now = Instant((upright(0.0),), modes={("lock", "hinge.lock"): Mode(1.0, (0.0,)), ("lock", "ball.lock"): Mode(0.0)})
    efforts = {"lock_hinge.lock": (2.5,), "lock_ball.lock": (0.0, 0.0, 0.0)}
    assert seen(model, Quantity("q", "lock", joint=0), now, **efforts) == {"effort": 2.5, "on": 1.0}
    ball = seen(model, Quantity("q", "lock", joint=1), now, **efforts)
    assert ball == {"effort.x": 0.0, "effort.y": 0.0, "effort.z": 0.0, "on": 0.0}
