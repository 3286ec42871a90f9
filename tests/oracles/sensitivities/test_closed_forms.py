"""Derivatives through bounces, impacts, friction, locks, releases and `set`, against formulas."""

import math
from typing import Any

import numpy as np
import pytest
from mpmath import asin, atan, ellipf, ellipk, mp, mpf, pi, sin, sqrt

from tests.oracles.changing import scenarios
from tests.oracles.changing.scenarios import G
from tests.oracles.sensitivities.differences import apart, derivatives, of_formula
from tests.rigs import parts

EXACT = 1e-10  # relative, with steps of tolerance 1e-12
TOLERANCE = 1e-12


def timed(data: dict[str, Any], **events: str) -> dict[str, Any]:
    """The scenario with events that only tell their times."""
    return data | {"events": [{"name": name, "when": when} for name, when in events.items()]}


# ---------------------------------------------------------------- impacts
def dropped(end: float) -> dict[str, Any]:
    """A point 1 m above a floor off which it bounces."""
    floor = parts.foot("floor", "ball", restitution=0.8, rest_speed=1e-3)
    body = parts.resting("ball", position=[0, 0, 1])
    model = {"gravity": [0, 0, -G], "bodies": [body], "contacts": [floor]}
    return scenarios.scenario("A ball", model, end)


def bounced(n: int, t: float) -> Any:
    """How high a ball is at a time after n bounces, by its restitution and the height of its drop."""

    def height(e: Any, h: Any) -> Any:
        v = sqrt(2 * mpf(G) * h)
        since = t - v / G * (1 + 2 * sum(e**k for k in range(1, n)))
        return e**n * v * since - mpf(G) * since**2 / 2

    return height


@pytest.mark.parametrize(("n", "t"), [(1, 0.9), (3, 2.1), (6, 2.95)])
def test_the_height_after_bounces_by_the_restitution_and_the_drop(n: int, t: float) -> None:
    at = {"contacts.floor.restitution": 0.8, "bodies.ball.position[2]": 1.0}
    ds = derivatives(dropped(t), ["position"], at)
    assert int(ds.changes) == n
    expected = of_formula(bounced(n, t), 0.8, 1.0)
    np.testing.assert_allclose(ds.d_position[-1, 0, 2], expected, rtol=EXACT)
    assert int(ds.sensitivity_flags) == 0


def test_the_time_of_an_impact_by_the_drop() -> None:
    """An event at the floor, and another one on the way."""
    data = timed(dropped(0.6), lands="floor.gap < 0", half="floor.gap < 0.5")
    data["quantities"] = parts.observed("contact", "floor")
    ds = derivatives(data, ["event_time"], {"bodies.ball.position[2]": 1.0, "gravity[2]": -G})
    for n, fall in enumerate((1.0, 0.5)):
        expected = of_formula(lambda h, g, fall=fall: sqrt(2 * (h - 1 + fall) / -g), 1.0, -G)
        np.testing.assert_allclose(ds.d_event_time[n], expected, rtol=EXACT)
        np.testing.assert_allclose(ds.event_rate[n], math.sqrt(2 * G * fall), rtol=EXACT)


# ---------------------------------------------------------------- pendulums
def pendulum(end: float, coordinates: str) -> dict[str, Any]:
    place = parts.frames(parts.Y, second=[0, 0, 0.5]) | {"angle": 1.2, "rate": 0}
    joints = [parts.joint("pivot", "revolute", "bob", **place)]
    model = {"gravity": [0, 0, -G], "bodies": [parts.body("bob", 1, 0.3)], "joints": joints}
    return scenarios.scenario("A pendulum", model, end, coordinates=coordinates) | {
        "quantities": parts.observed("joint", "pivot")
    }


def quarter(length: Any, m: Any, J: Any, amplitude: Any) -> Any:
    """When it first hangs straight down."""
    return ellipk(sin(amplitude / 2) ** 2) / sqrt(m * mpf(G) * length / (J + m * length**2))


@pytest.mark.parametrize("coordinates", ["joint", "lie"])
def test_the_period_of_a_pendulum_by_its_length_mass_inertia_and_amplitude(coordinates: str) -> None:
    """A quarter of it, and five of them: the event comes true at every other one."""
    at = {
        "joints.pivot.points[1][2]": 0.5, "bodies.bob.mass": 1.0, "bodies.bob.inertia[1]": 0.3,
        "joints.pivot.angle": 1.2,
    }  # fmt: skip
    data = timed(pendulum(5.0, coordinates), down="pivot.angle < 0", back="pivot.angle > 0 and t > 3")
    ds = derivatives(data, ["event_time", "position"], at)
    expected = np.array(of_formula(quarter, 0.5, 1.0, 0.3, 1.2))
    assert apart(ds.d_event_time[0], expected) < EXACT
    number = round(float(ds.event_time[1] / ds.event_time[0]))
    assert number == 7
    assert apart(ds.d_event_time[1], number * expected) < EXACT


def test_the_time_of_a_pendulum_through_a_stop_by_its_restitution() -> None:
    """It comes back to another angle after it has hit the stop where it hangs straight down."""
    data = timed(pendulum(2.0, "joint"), returns="pivot.angle > 0.5 and t > 0.6")
    data["model"]["limits"] = [{"name": "stop", "joint": "pivot", "low": 0, "restitution": 0.8}]

    def returns(e: Any, length: Any, amplitude: Any) -> Any:
        pulsation = sqrt(mpf(G) * length / (mpf("0.3") + length**2))
        k = e * sin(amplitude / 2)
        rise = ellipf(asin(sin(mpf("0.25")) / k), k**2)
        return quarter(length, mpf(1), mpf("0.3"), amplitude) + rise / pulsation

    at = {"limits.stop.restitution": 0.8, "joints.pivot.points[1][2]": 0.5, "joints.pivot.angle": 1.2}
    ds = derivatives(data, ["event_time"], at)
    assert apart(ds.d_event_time[0], of_formula(returns, 0.8, 0.5, 1.2)) < EXACT


# ---------------------------------------------------------------- friction
def test_where_a_slider_comes_to_rest_by_its_friction() -> None:
    """A block on the floor: contact with Coulomb friction; it sticks for good."""
    foot = parts.foot("floor", "block", friction=0.3, restitution=0)
    body = parts.resting("block", velocity=[2, 1, 0])
    model = {"gravity": [0, 0, -G], "bodies": [body], "contacts": [foot]}
    at = {"contacts.floor.friction": 0.3, "bodies.block.velocity[0]": 2.0, "bodies.block.velocity[1]": 1.0}
    ds = derivatives(scenarios.scenario("A block", model, 1.5), ["position", "velocity"], at)
    assert scenarios.kinds(ds, "stuck").sum() == 1

    def rest(axis: int) -> Any:
        return lambda mu, u, v: (u, v)[axis] * sqrt(u * u + v * v) / (2 * mu * mpf(G))

    expected = [of_formula(rest(axis), 0.3, 2.0, 1.0) for axis in (0, 1)]
    assert apart(ds.d_position[-1, 0, :2], expected) < 1e-8  # the direction in which it slides is unknown at the end
    assert float(np.abs(ds.d_velocity[-1]).max()) < EXACT


def test_when_a_block_on_a_belt_slips_and_sticks_by_its_friction() -> None:
    """A block on a spring that rides on a belt; times of the second cycle by both coefficients and the spring."""
    slide = parts.slide("slide", "block", displacement=0, speed=0.5) | {"bodies": ["belt", "block"]}
    bodies = [parts.body("belt"), parts.body("block")]
    joints = [parts.slide("runs", "belt", displacement=0, speed=0.5), slide | {"speed": 0}]
    spring = {"name": "spring", "type": "spring_damper", "bodies": ["ground", "block"], "stiffness": 50.0}
    spring |= {"points": [[-10, 0, 0], [0, 0, 0]], "free_length": 10.0}
    drives = [{"name": "drive", "joint": "runs", "coordinate": "displacement", "value": "0.5*t"}]
    model = {
        "gravity": [0, 0, 0], "bodies": bodies, "joints": joints, "forces": [spring, parts.dry("slide", 3.0, 4.0)],
        "drivers": drives,
    }  # fmt: skip
    data = scenarios.scenario("A block on a belt", model, 1.2) | {
        "quantities": [{"name": "block", "type": "point", "body": "block", "point": [0, 0, 0]}]
    }
    data = timed(data, far="block.x > 0.079", near="block.x < 0.05 and t > 0.2", again="block.x > 0.079 and t > 0.6")

    def slips(static: Any, k: Any) -> Any:
        return static / k / mpf("0.5")

    def cycle(coulomb: Any, static: Any, k: Any) -> Any:
        """From where it slips to where it slips again."""
        w, reach = sqrt(k), (static - coulomb) / k
        return 2 * (pi - atan(reach * w / mpf("0.5"))) / w + 2 * reach / mpf("0.5")

    at = {"forces.dry.coulomb": 3.0, "forces.dry.static": 4.0, "forces.spring.stiffness": 50.0}
    ds = derivatives(data, ["event_time"], at)
    one = of_formula(lambda f, s, k: slips(s, k) + cycle(f, s, k), 3.0, 4.0, 50.0)
    sticks = of_formula(lambda f, s, k: mpf("0.079") / mpf("0.5") + cycle(f, s, k), 3.0, 4.0, 50.0)
    assert len(one) == 3
    assert apart(ds.d_event_time[2], sticks) < EXACT


# ---------------------------------------------------------------- events that act
def two_wheels() -> dict[str, Any]:
    """Two bodies that turn about one axis, one on a hinge of the other."""
    hinges = [parts.pivot("outer", "drum", axis=parts.Z), parts.pivot("inner", "disc", axis=parts.Z, to="drum")]
    starts = [{"angle": 0, "rate": 3}, {"angle": 0, "rate": 5}]
    joints = [hinge | start for hinge, start in zip(hinges, starts, strict=True)]
    model = {"gravity": [0, 0, 0], "bodies": [parts.body("drum", 1, 0.4), parts.body("disc", 1, 0.1)], "joints": joints}
    return scenarios.scenario("Two wheels", model, 2.0, coordinates="joint") | {
        "quantities": [
            {"name": "drum", "type": "joint", "joint": "outer"},
            {"name": "disc", "type": "joint", "joint": "inner"},
        ]
    }


def test_a_lock_keeps_the_angular_momentum() -> None:
    data = two_wheels()
    data["events"] = [{"name": "catch", "when": "disc.angle > reach", "action": "lock", "joint": "inner"}]
    data["parameters"] = {"reach": 4.0}

    def angle(own: Any, other: Any, rate: Any, relative: Any, reach: Any) -> Any:
        t = reach / relative
        return rate * t + (own * rate + other * (rate + relative)) / (own + other) * (2 - t)

    at = {
        "bodies.drum.inertia[2]": 0.4, "bodies.disc.inertia[2]": 0.1, "joints.outer.rate": 3.0,
        "joints.inner.rate": 5.0, "parameters.reach": 4.0,
    }  # fmt: skip
    ds = derivatives(data, ["drum.angle", "event_time"], at)
    assert apart(ds["d_drum.angle"][-1], of_formula(angle, 0.4, 0.1, 3.0, 5.0, 4.0)) < EXACT
    expected = of_formula(lambda own, other, rate, relative, reach: reach / relative, 0.4, 0.1, 3.0, 5.0, 4.0)
    assert apart(ds.d_event_time[0], expected) < EXACT


@pytest.mark.parametrize("lasts", ["release", "release*1"])
def test_where_a_weight_falls_by_the_time_of_its_release(lasts: str) -> None:
    weld = parts.joint("hook", "fixed", "weight", points=[[0, 0, 0], [0, 0, 0]])
    body = parts.resting("weight")
    model = {"gravity": [0, 0, -G], "bodies": [body], "joints": [weld]}
    data = scenarios.scenario("A weight", model, 1.0) | {"parameters": {"release": 0.3}}
    data["events"] = [{"name": "opens", "when": f"t > {lasts}", "action": "release", "joint": "hook"}]
    ds = derivatives(data, ["position", "event_time"], {"parameters.release": 0.3})
    assert float(ds.d_event_time[0, 0]) == pytest.approx(1.0, rel=EXACT)
    assert float(ds.d_position[-1, 0, 2, 0]) == pytest.approx(0.7 * G, rel=EXACT)


def test_what_an_event_sets() -> None:
    """A thrust that ends where a mark is passed; and again by a formula of what the state is there."""
    force = {"name": "thrust", "type": "force", "body": "b", "value": ["push", 0, 0]}
    model = {
        "gravity": [0, 0, 0],
        "bodies": [parts.body("b")],
        "joints": [parts.slide("s", "b", displacement=0, speed=0)],
    }
    data = scenarios.scenario("A thrust", model | {"forces": [force]}, 2.0)
    data |= {"parameters": {"push": 4.0, "mark": 2.0, "left": -1.0}, "quantities": parts.observed("joint", "s")}
    stop = {"name": "passes", "when": "s.displacement > mark", "action": "set", "parameters": {"push": "left*s.speed"}}
    data["events"] = [stop | {"once": True}]

    def place(push: Any, mark: Any, left: Any) -> Any:
        t, v = sqrt(2 * mark / push), sqrt(2 * mark * push)
        return mark + v * (2 - t) + left * v * (2 - t) ** 2 / 2

    at = {"parameters.push": 4.0, "parameters.mark": 2.0, "parameters.left": -1.0}
    ds = derivatives(data, ["position"], at)
    assert apart(ds.d_position[-1, 0, 0], of_formula(place, 4.0, 2.0, -1.0)) < EXACT


# ---------------------------------------------------------------- jumps
@pytest.mark.parametrize("tolerance", [1e-6, 1e-13])
def test_a_stop_whose_damping_acts_at_once(tolerance: float) -> None:
    """The force of an end stop jumps at its contact; steps there are as short as a rounding, or far too long."""
    stop = {"name": "stop", "type": "end_stop", "joint": "s", "upper": 0.0, "stiffness": 20, "damping": 3}
    joints = [parts.slide("s", "b", displacement=-1, speed=1.7)]
    model = {"gravity": [0, 0, 0], "bodies": [parts.body("b")], "joints": joints, "forces": [stop]}

    def place(v: Any) -> Any:
        w, since = sqrt(mpf(20) - mpf(9) / 4), 1 - 1 / v
        return v * mp.exp(-since * 3 / 2) * sin(w * since) / w

    ds = derivatives(
        scenarios.scenario("A stop", model, 1.0, tolerance, coordinates="joint"), ["position"], {"joints.s.speed": 1.7}
    )
    assert float(ds.d_position[-1, 0, 0, 0]) == pytest.approx(of_formula(place, 1.7)[0], rel=10 * tolerance + EXACT)


def test_a_table_that_comes_later() -> None:
    """A thrust of a table begins and ends at times that an input moves."""
    force = {"name": "thrust", "type": "force", "body": "b", "value": ["pulse(t - late)", 0, 0]}
    model = {
        "gravity": [0, 0, 0],
        "bodies": [parts.body("b")],
        "joints": [parts.slide("s", "b", displacement=0, speed=0)],
    }
    data = scenarios.scenario("A pulse", model | {"forces": [force]}, 2.0) | {"parameters": {"late": 0.2}}
    data["tables"] = {
        "pulse": {"times": [0, 0.5, 1.0], "values": [0, 3, 0], "interpolation": "hold", "outside": "hold"}
    }
    ds = derivatives(data, ["position", "velocity"], {"parameters.late": 0.2})
    assert float(ds.d_position[-1, 0, 0, 0]) == pytest.approx(-1.5, rel=EXACT)
    assert abs(float(ds.d_velocity[-1, 0, 0, 0])) < EXACT
