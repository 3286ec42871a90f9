"""Runs with something on all the time: a lock makes one body of two, friction brakes as Coulomb says."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from lienumba.compiler.rows import W
from lienumba.integrators import layout
from lienumba.integrators.tracing import state_kernels
from lienumba.integrators.tracing.joint.tracer import JointTracer
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import UNIQUE
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.mechanism.kinematics import OFF
from lienumba.mechanics.mechanism.model import Contact, Coordinate, Force, Limit, Lock
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.mechanics.system.switched import turning
from lienumba.mechanics.system.switches import FRICTION, JOINT, LOCK
from tests.compiler.evaluation import machine_code
from tests.facade import GROUND, Body, Instant, Joint, Model
from tests.rigs import switching
from tests.rigs.modes import SLIDE, STICK, integrate
from tests.rigs.random_trees import close

G = 9.81
UPRIGHT = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0))  # x, y, z of a frame whose axis is -y


def bar(name: str) -> Body:
    return Body(name, 2.0, (0.2, 0.2, 0.01, 0.0, 0.0, 0.0))


def at(r: Any, v: Any = (0.0, 0.0, 0.0), w: Any = (0.0, 0.0, 0.0)) -> tuple[float, ...]:
    return (*r, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, *v, *w)


def hinge(name: str, a: int, b: int, p: Any, q: Any, kind: str = "revolute") -> Joint:
    return Joint(name, kind, (a, b), (p, q), (UPRIGHT, UPRIGHT))


def pendulum(kind: str = "revolute", locks: tuple[Lock, ...] = ()) -> Model:
    """Two bars in a plane, 1 m each, hanging down."""
    up, down = (0.0, 0.0, 0.5), (0.0, 0.0, -0.5)
    joints = (hinge("first", GROUND, 0, (0.0, 0.0, 0.0), up), hinge("second", 0, 1, down, up, kind))
    return Model((0.0, 0.0, -G), (bar("a"), bar("b")), joints, locks=locks)


SWINGING = Instant((at((0.0, 0.0, -0.5), (-0.5, 0.0, 0.0), (0.0, 1.0, 0.0)),
                    at((0.0, 0.0, -1.5), (-1.5, 0.0, 0.0), (0.0, 1.0, 0.0))))  # fmt: skip


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_lock_makes_one_body_of_two(coordinates: str) -> None:
    lock = Lock("second", 1, ("angle",))
    status, locked = integrate(pendulum(locks=(lock,)), SWINGING, {"second": (STICK, (0.0,))}, 1e-3, 400, coordinates)
    welded = pendulum("fixed")
    _, expected = integrate(welded, SWINGING, {}, 1e-3, 400, coordinates)
    assert status == 0
    for name in ("position", "velocity", "joint_force", "joint_torque"):
        np.testing.assert_allclose(locked[name], expected[name], atol=1e-10)
    assert abs(locked["energy_residual"]) < 1e-9
    assert abs(locked["position_violation"]) < 1e-12


def test_stage_by_stage_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    lock = Lock("second", 1, ("angle",))
    model, on = pendulum(locks=(lock,)), {"second": (STICK, (0.0,))}
    _, whole = integrate(model, SWINGING, on, 1e-3, 50)
    monkeypatch.setattr("lienumba.integrators.tracing.step_kernels.INLINE", 0)
    _, staged = integrate(model, SWINGING, on, 1e-3, 50)
    for name, x in whole.items():
        np.testing.assert_allclose(staged[name], x, atol=1e-13)


SLOPE = (0.5 * G, 0.0, -(0.75**0.5) * G)  # 30 degrees, along x


def block(kinetic: float = 0.3) -> Model:
    """A point mass, nearly, on a plane."""
    contact = Contact(
        "floor", "point_plane", (0, GROUND), ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), (0.0, 0.0, 1.0), None, {},
        0.0, 0.8, kinetic, 1e-3,
    )  # fmt: skip
    return Model(SLOPE, (bar("block"),), contacts=(contact,))


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_friction_brakes_against_the_sliding(coordinates: str) -> None:
    """Across the slope, too: the direction turns. In axes along and across: v' = g sin - mu g cos d."""
    v = np.array([0.2, 1.5])
    now = Instant((at((0.0, 0.0, 0.0), (*v, 0.0)),))
    d = tuple(v / np.hypot(*v))
    status, found = integrate(block(), now, {"floor": (SLIDE, d)}, 1e-3, 300, coordinates)
    assert status == 0

    def rate(v: np.ndarray) -> np.ndarray:
        return np.array([SLOPE[0], 0.0]) + 0.3 * SLOPE[2] * v / np.hypot(*v)

    h = 1e-4
    for _ in range(3000):
        k1 = rate(v)
        k2 = rate(v + 0.5 * h * k1)
        k3 = rate(v + 0.5 * h * k2)
        v = v + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(v + h * k3))
    np.testing.assert_allclose(found["velocity"][0], [*v, 0.0], atol=1e-9)
    assert abs(found["energy_residual"]) < 1e-9


def test_what_sticks_stays() -> None:
    status, found = integrate(block(), Instant((at((0.0, 0.0, 0.0)),)), {"floor": (STICK, (1.0, 0.0))}, 1e-2, 50)
    assert status == 0
    np.testing.assert_allclose(found["position"][0], 0.0, atol=1e-13)


def test_friction_goes_on_where_the_sliding_turns_round() -> None:
    """Beyond the stop, until the change is located: as if friction pushed on."""
    now = Instant((at((0.0, 0.0, 0.0), (-0.1, 0.0, 0.0)),))
    _, found = integrate(block(), now, {"floor": (SLIDE, (-1.0, 0.0))}, 1e-2, 20)
    a = SLOPE[0] - 0.3 * SLOPE[2]
    np.testing.assert_allclose(found["velocity"][0, 0], -0.1 + a * 0.2, rtol=1e-12)


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_joint_with_friction_slides_or_holds(coordinates: str) -> None:
    force = Force(
        "brake",
        "friction",
        (GROUND, 0),
        coordinate=Coordinate(0, "angle"),
        numbers={"viscous": 0.0, "coulomb": 3.0, "static": 4.0, "velocity": 1e-3},
    )
    model = replace(pendulum(), bodies=(bar("a"),), joints=pendulum().joints[:1], forces=(force,), gravity=(0.0,) * 3)
    now = Instant((at((0.0, 0.0, -0.5), (-0.5, 0.0, 0.0), (0.0, 1.0, 0.0)),))
    _, found = integrate(model, now, {"brake": (SLIDE, (-1.0,))}, 1e-3, 100, coordinates)
    rate = 1.0 - 3.0 / (0.2 + 2.0 * 0.25) * 0.1  # the axis of the hinge points along -y
    np.testing.assert_allclose(np.hypot(*found["velocity"][0, [0, 2]]), 0.5 * rate, rtol=1e-9)
    assert abs(found["energy_residual"]) < 1e-10
    rest = Instant((at((0.0, 0.0, -0.5)),))
    gravity = replace(model, gravity=(3.0, 0.0, 0.0))
    _, held = integrate(gravity, rest, {"brake": (STICK, (1.0,))}, 1e-2, 10, coordinates)
    np.testing.assert_allclose(held["velocity"], 0.0, atol=1e-14)


def test_a_stop_holds_against_what_pulls() -> None:
    limit = Limit("stop", Coordinate(0, "angle"), 1.0, 0.0, 0.0, 0.0)
    model = replace(
        pendulum(), bodies=(bar("a"),), joints=pendulum().joints[:1], limits=(limit,), gravity=(3.0, 0.0, 0.0)
    )
    rest = Instant((at((0.0, 0.0, -0.5)),), angles={0: 0.0})
    status, held = integrate(model, rest, {"stop": (SLIDE, ())}, 1e-2, 10)
    assert status == 0
    np.testing.assert_allclose(held["velocity"], 0.0, atol=1e-14)
    np.testing.assert_allclose(np.abs(held["joint_torque"][0]), [0.0, 3.0, 0.0], rtol=1e-12)


@pytest.fixture(scope="module", params=["lie", "joint"])
def traced(request: Any) -> Any:
    """A small mechanism with all kinds of switches somewhere, its tracer, and its state as rows."""
    case = switching.somewhere(switching.mechanism(1, kinds=["revolute", "prismatic"]), 1)
    model, values = split(case.model)
    make = JointTracer if request.param == "joint" else Tracer
    tracer = make(model, Method("rk4", "local", "mass", coordinates=request.param), UNIQUE, True)
    held, now = tracer.augmented, case.now
    first = [float(x) for x in case.posture.z] if request.param == "joint" else [x for body in now.bodies for x in body]
    behind = [now.angles[which] for which in held.angles] + [0.25] * held.work
    modes = [mode.on for mode in now.modes.values()], [x for mode in now.modes.values() for x in mode.memory]
    state = [*first, *behind, *case.mask[held.permanent :], *modes[0], *modes[1]]
    arrays = {
        "state": np.repeat(np.array(state)[:, None], W, 1),
        "parameters": np.repeat(np.array(values)[:, None], W, 1),
    }
    clock = {"clock": np.zeros((layout.CLOCK, W))}
    return case, tracer, {**arrays, **clock}


def outputs(kernel: Any, arrays: Any) -> np.ndarray:
    found: np.ndarray = machine_code(kernel.hoisted_from(len(arrays["parameters"])))(**arrays)[:, 0]
    return found


def test_what_the_kernels_say_lies_where_drivers_look(traced: Any) -> None:
    case, tracer, arrays = traced
    model, now, sizes, first = case.model, case.now, tracer.sizes, constraints.permanent_rows(case.model)
    border = outputs(state_kernels.border(tracer), arrays)
    assert len(border) == layout.border_rows(sizes)
    S, b = dynamics.border(model, kkt.Structure.of(model), case.posture.resting().now, case.mask)
    for i in range(sizes.switched):
        for j in range(i + 1):
            close(border[layout.border_place(i, j)], S[i][j], 1e-9)

    def part(start: Any, rows: int) -> np.ndarray:
        return border[start(sizes) : start(sizes) + rows]

    q = sizes.switched
    close(part(layout.border_accelerations, q), b, 1e-9)
    w = constraints.rates(model, now)[first:]
    close(part(layout.border_rates, q), w)
    close(part(layout.border_gaps, q), constraints.residual(model, now)[first:])
    close(part(layout.border_alone, q), turning.alone(model, now))
    numbers = turning.numbers(model, now, w, b)
    close(part(layout.border_numbers, layout.CONTACT_NUMBERS * sizes.switches), numbers, 1e-9)
    close(part(layout.border_memory, sizes.memory), turning.memory(model, now, w))

    impulses = np.random.default_rng(3).standard_normal(q)
    kick = outputs(state_kernels.kick(tracer), {**arrays, "extra": np.repeat(impulses[:, None], W, 1)})
    assert len(kick) == layout.kick_rows(sizes)
    dv = dynamics.kicked(model, kkt.Structure.of(model), now, case.mask, impulses).x
    after = [
        (*x[:12], *(u + d for u, d in zip(x[12:], dv[6 * i : 6 * i + 6], strict=True)))
        for i, x in enumerate(now.bodies)
    ]
    there = replace(now, bodies=tuple(after))
    gained = dynamics.energies(model, there)[0] - dynamics.energies(model, now)[0]
    close(kick[layout.kick_energy(sizes)], gained, 1e-9)
    close(kick[layout.kick_rates(sizes) : layout.kick_rates(sizes) + q], constraints.rates(model, there)[first:], 1e-9)
    work = layout.element_rows(sizes) + len(tracer.augmented.angles)
    close(kick[work], 0.25 + gained, 1e-9)
    assert (
        kick[layout.mask_row(sizes) : layout.state_rows(sizes)] == arrays["state"][layout.mask_row(sizes) :, 0]
    ).all()


def test_conditions_of_what_is_on(traced: Any) -> None:
    case, tracer, arrays = traced
    events = outputs(state_kernels.events(tracer), arrays)
    a, mu = switching.exact(case)
    assert len(events) == layout.event_rows(tracer.sizes)
    close(
        events[: layout.pushing_row(tracer.sizes)],
        turning.contact_guards(case.model, case.now, mu.tolist(), a.tolist(), [float(m) for m in case.mask], True),
        1e-8,
    )
    along, w, k = (
        events[layout.pushing_row(tracer.sizes) :],
        constraints.rates(case.model, case.now),
        len(mu) - tracer.sizes.switched,
    )
    for switch, fast in zip(tracer.augmented.switches, along, strict=True):
        rows = slice(k + switch.first + switch.rows - switch.tangents, k + switch.first + switch.rows)
        force, mode = -mu[rows], case.now.modes[switch.key]
        if switch.what == FRICTION and mode.on == SLIDE:
            force = -np.array(mode.memory)
        size = np.linalg.norm(force) if switch.tangents else 0.0
        expected = max(force @ np.array(w)[rows], 0.0) / size if size else 0.0
        if switch.what in (JOINT, LOCK) and mode.on != OFF:  # of what holds: rows that are not used
            own = range(k + switch.first, k + switch.first + switch.rows)
            expected = max((abs(w[i]) for i in own if not case.mask[i]), default=0.0)
        close(fast, expected, 1e-8)
