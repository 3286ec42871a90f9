"""Friction of joints that sticks beside contacts that stick: a cart on a rail with a pendulum that leans on a wall, an
arm that comes down on a floor, a trunk on two legs. Whether forces within all limits hold them is a linear programme;
which of them begins to slip follows from trying."""

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, linprog
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs import parts
from tests.rigs.parts import quaternion

LEAN, LONG, RADIUS = -0.08, 0.3, 0.1  # of the pendulum: rad, m to its mass centre, m
CART, BOB, SWING = 1.0, 0.5, 0.004  # kg, kg, kg m^2
SLIDING = 1.9, 0.015  # N of the cart, N m of its hinge
NAMES = "parameters.gx", "contacts.wall.friction", "forces.dry.static", "forces.stiff.static"
FINE = 1e4
DOP853 = {"method": "dop853", "tolerance": 1e-9}
WAYS = [{**DOP853, "coordinates": "joint"}, DOP853, {"method": "rk4", "step": 1e-3, "coordinates": "joint"}]


def turned(R: Rotation, *vector: float) -> list[float]:
    return [float(x) for x in R.apply(vector)]


def cart(R: Rotation, rate: float, wall: bool, integrator: dict[str, Any], **more: Any) -> dict[str, Any]:
    """At rest, with a weight of (gx + rate t, 0, -9.6) m/s^2 along axes that are turned."""
    lean = R * Rotation.from_rotvec([0.0, LEAN, 0.0])
    bob = lean.apply([0.0, 0.0, -LONG])
    tip = lean.apply([0.0, 0.0, -2 * LONG]) + R.apply([RADIUS, 0.0, 0.0])
    up, along = R.apply([0.0, 0.0, 1.0]), R.apply([1.0, 0.0, 0.0])
    contact = parts.sphere("wall", "bob", RADIUS, [0.0, 0.0, -LONG], tip.tolist(), friction=0.2)
    contact["normal"] = turned(R, -1.0, 0.0, 0.0)
    bob_shape = [SWING, SWING, 0.001]
    return {
        "parameters": {"gx": 0.5},
        "model": {
            "gravity": [f"{along[i]}*(gx + {rate}*t) + {-9.6 * up[i]}" for i in range(3)],
            "bodies": [
                parts.body("cart", CART, 0.01, position=[0, 0, 0], rotation=quaternion(R)),
                parts.body("bob", BOB, bob_shape, position=bob.tolist(), rotation=quaternion(lean)),
            ],
            "joints": [
                parts.joint("rail", "prismatic", "cart", at=[0, 0, 0], axis=along.tolist()),
                parts.hinge("hinge", "bob", axis=turned(R, 0.0, 1.0, 0.0), to="cart"),
            ],
            "forces": [parts.dry("rail", SLIDING[0], 2.5), parts.dry("hinge", SLIDING[1], 0.03, "stiff")],
            "contacts": [contact] if wall else [],
            "quantities": [{"name": f"{x}_at", "type": "joint", "joint": x} for x in ("rail", "hinge")],
        },
        "integrator": {"end_time": 1.2, **integrator},
        "output": {"every": 0.05},
        **more,
    }  # fmt: skip


def varied(runs: int, **ranges: tuple[float, float]) -> dict[str, Any]:
    names = dict(zip(("gx", "mu", "dry", "stiff"), NAMES, strict=True))
    return {"sweep": parts.sweep(runs, {names[x]: ends for x, ends in ranges.items()}, seed=3)}


def numbers(ds: Any, run: int) -> list[float]:
    return [float(ds[x][run]) if x in ds else np.nan for x in NAMES]


def holds(gx: float, mu: float, dry: float, stiff: float) -> bool:
    """Whether there are a normal force, one along the wall, one of the rail and a torque of the hinge."""
    x, z = -2 * LONG * np.sin(LEAN) + RADIUS, -2 * LONG * np.cos(LEAN)
    xm, zm = -LONG * np.sin(LEAN), -LONG * np.cos(LEAN)
    balance = [[-1, 0, 1, 0], [-z, -x, 0, 1]]
    loads = [-(CART + BOB) * gx, -(zm * BOB * gx + xm * BOB * 9.6)]
    cone, bounds = [[-mu, 1, 0, 0], [-mu, -1, 0, 0]], [(0, None), (None, None), (-dry, dry), (-stiff, stiff)]
    fine = [tuple(x if x is None else FINE * x for x in pair) for pair in bounds]  # it is exact to 1e-7
    return bool(linprog([0] * 4, cone, [0, 0], balance, FINE * np.array(loads), fine).status == 0)


@pytest.mark.parametrize("integrator", WAYS, ids=["joint", "lie", "steps"])
@pytest.mark.parametrize(("rate", "gx"), [(3.0, (-0.3, 1.0)), (-3.0, (0.2, 1.0))])
def test_what_forces_can_hold_rests_until_they_cannot(rate: float, gx: Any, integrator: dict[str, Any]) -> None:
    more = varied(12, gx=gx, mu=(0.1, 0.8), dry=(2.0, 4.0), stiff=(0.02, 0.3))
    ds = lienumba.run(cart(Rotation.random(random_state=7), rate, True, integrator, **more))
    assert (ds.status == 0).all()
    tried = 0
    for run in range(12):
        g, mu, dry, stiff = numbers(ds, run)
        slid = ds.change_time[run].values[ds.change_kind[run].values == 8]
        if not holds(g, mu, dry, stiff):
            continue
        low, high = 0.0, 1.2
        while high - low > 1e-10:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if holds(g + rate * middle, mu, dry, stiff) else (low, middle)
        if low < 1.15:
            assert abs(slid[0] - low) < 2e-4, run
            tried += 1
        rests = ds.isel(run=run).sel(time=slice(0, low - 2e-4))
        assert abs(rests["rail_at.displacement"]).max() < 1e-12
        assert abs(rests["hinge_at.angle"] - rests["hinge_at.angle"][0]).max() < 1e-12
    assert tried >= 6


def consistent(gx: float, dry: float, stiff: float) -> list[tuple[int, ...]]:
    """Which of rail and hinge sticks, 0, or slips and where to, such that forces and accelerations fit."""
    xm, zm = -LONG * np.sin(LEAN), -LONG * np.cos(LEAN)
    M = np.array([[CART + BOB, BOB * zm], [BOB * zm, SWING + BOB * LONG**2]])
    f = np.array([(CART + BOB) * gx, BOB * (zm * gx + xm * 9.6)])
    found = []
    for mode in itertools.product((0, 1, -1), repeat=2):
        slips, a = [i for i in (0, 1) if mode[i]], np.zeros(2)
        if slips:
            a[slips] = np.linalg.solve(M[np.ix_(slips, slips)], (f - np.array(SLIDING) * mode)[slips])
        held = M @ a - f
        if all(abs(held[i]) <= (dry, stiff)[i] if not mode[i] else a[i] * mode[i] > 0 for i in (0, 1)):
            found.append(tuple(map(abs, mode)))
    return found


def test_of_several_frictions_those_slip_that_can() -> None:
    more = varied(200, gx=(-2.5, 2.5), dry=(2.0, 4.0), stiff=(0.02, 0.3))
    ds = lienumba.run(cart(Rotation.random(random_state=2), 0.0, False, {**DOP853, "end_time": 0.2}, **more))
    assert (ds.status == 0).all()
    for run in range(200):
        gx, _, dry, stiff = numbers(ds, run)
        slips = tuple(int(x == 2) for x in ds["mode"][run, 1].values)
        assert slips in consistent(gx, dry, stiff), run


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize(("gx", "dry", "stiff"), [(-2.1779, 2.7143, 0.2901), (-2.1, 2.7, 0.285)])
def test_a_cart_rests_while_its_pendulum_falls(gx: float, dry: float, stiff: float, tolerance: float) -> None:
    """It would be pushed against its weight, and past rest, if both began to slip at once."""
    data = cart(Rotation.identity(), 0.0, False, {"method": "dop853", "tolerance": tolerance, "end_time": 0.3})
    data["parameters"]["gx"] = gx
    data["model"]["forces"][0]["static"], data["model"]["forces"][1]["static"] = dry, stiff

    def falls(_: float, y: Any) -> Any:
        xm, zm = -LONG * np.sin(y[0]), -LONG * np.cos(y[0])
        return [y[1], (BOB * (zm * gx + xm * 9.6) - SLIDING[1] * np.sign(y[1] or 1.0)) / (SWING + BOB * LONG**2)]

    def strains(t: float, y: Any) -> float:
        xm, zm = -LONG * np.sin(y[0]), -LONG * np.cos(y[0])
        return abs(BOB * (zm * falls(t, y)[1] - xm * y[1] ** 2) - (CART + BOB) * gx) - dry

    until = solve_ivp(falls, [0, 0.3], [LEAN, 0.0], rtol=1e-12, atol=1e-14, dense_output=True, max_step=1e-3)
    t = brentq(lambda t: strains(t, until.sol(t)), 0.05, 0.29, xtol=1e-13)
    ds = lienumba.run(data).isel(run=0)
    assert abs(ds["rail_at.displacement"].sel(time=slice(0, t))).max() < 1e-9
    slid = ds.change_time.values[ds.change_kind.values == 8]
    assert abs(slid[0] - t) < 10 * max(tolerance, 1e-8) ** 0.75


def arm(R: Rotation, push: float) -> tuple[dict[str, Any], float]:
    """Two links whose tip stands on a rough floor, torques that grow, and when statics says that it slips."""
    length, (a, b), radius, mu = 0.5, (0.6, -0.9), 0.03, 0.4

    def down(angle: float) -> np.ndarray:
        return np.array([np.sin(angle), 0.0, -np.cos(angle)])

    def places(q: Any) -> list[np.ndarray]:
        elbow = length * down(q[0])
        return [0.5 * elbow, elbow + 0.5 * length * down(q[1]), elbow + length * down(q[1])]

    upper, lower, tip = places((a, a + b))
    links = [
        parts.body(name, mass, [0.02, 0.02, 0.001], position=turned(R, *place),
                   rotation=quaternion(R * Rotation.from_rotvec([0, -angle, 0])))
        for name, mass, place, angle in (("upper", 1.0, upper, a), ("lower", 0.7, lower, a + b))
    ]  # fmt: skip
    axis, elbow = turned(R, 0.0, 1.0, 0.0), turned(R, *(length * down(a)))
    floor = parts.sphere("floor", "lower", radius, [0, 0, -0.5 * length], turned(R, *(tip - [0, 0, radius])))
    floor |= {"normal": turned(R, 0.0, 0.0, 1.0), "friction": mu}
    data = {
        "model": {
            "gravity": turned(R, 0.0, 0.0, -9.81),
            "bodies": links,
            "joints": [
                parts.hinge("shoulder", "upper", axis=axis),
                parts.hinge("elbow", "lower", elbow, axis, to="upper"),
            ],
            "forces": [
                {"name": "m", "type": "actuator", "joint": "shoulder", "value": f"{push}*t"},
                {"name": "k", "type": "actuator", "joint": "elbow", "value": "-2"},
            ],
            "contacts": [floor],
        },
        "integrator": {**DOP853, "end_time": 2.0, "coordinates": "joint"},
        "output": {"every": 0.1},
    }

    def statics(t: float) -> float:
        """How much friction there would have to be beyond what there may, along q = (a, a + b)."""
        step, q = 1e-6, np.array([a, a + b])
        slopes = [(np.array(places(q + d)) - places(q - d)) / (2 * step) for d in step * np.eye(2)]
        weight = np.array([-9.81 * (x[0][2] + 0.7 * x[1][2]) for x in slopes])
        torques = -np.array([push * t + 2.0, -2.0])  # angles count about -y; along a + b that of the elbow alone
        normal = np.array([x[2][2] for x in slopes])
        along = np.array([x[2][0] for x in slopes]) + [0.0, radius]
        N, F = np.linalg.solve(np.stack([normal, along], axis=1), -(weight + torques))
        return float(abs(F) - mu * N)

    return data, brentq(statics, 0.0, 2.0, xtol=1e-13)


@pytest.mark.parametrize("seed", [None, 1, 2, 3])
@pytest.mark.parametrize("push", [-4.0, -8.0])
def test_friction_in_a_plane_does_not_depend_on_how_it_lies(push: float, seed: int | None) -> None:
    """Two tangents of which the motion leaves one: their force is along it."""
    data, slips = arm(Rotation.identity() if seed is None else Rotation.random(random_state=seed), push)
    ds = lienumba.run(data).isel(run=0)
    slid = ds.change_time.values[ds.change_kind.values == 8]
    assert abs(slid[0] - slips) < 1e-8


def trunk(R: Rotation, hips: float) -> dict[str, Any]:
    """On two legs that lean towards each other, in a plane, with dry hips."""
    long, spread, axis = 0.3, 0.3, turned(R, 0.0, 1.0, 0.0)
    high, sides = long * np.cos(spread) + 0.02, {"left": 1.0, "right": -1.0}
    legs, hinges, dry, feet, seen = [], [], [], [], []
    up, along = R.apply([0.0, 0.0, 1.0]), R.apply([1.0, 0.0, 0.0])
    for leg, side in sides.items():
        lean, hip, own = R * Rotation.from_rotvec([0, side * spread, 0]), R.apply([0.1 * side, 0, high]), f"hip_{leg}"
        place = (hip + lean.apply([0, 0, -0.5 * long])).tolist()
        legs.append(parts.body(leg, 0.3, [0.003, 0.003, 0.0003], position=place, rotation=quaternion(lean)))
        hinges.append(parts.hinge(own, leg, hip.tolist(), axis, to="trunk"))
        dry.append(parts.dry(own, hips, hips, f"dry_{leg}"))
        sole = parts.sphere(f"foot_{leg}", leg, 0.02, [0, 0, -0.5 * long], normal=up.tolist(), friction=0.8)
        feet.append(sole)
        seen.append({"name": f"at_{leg}", "type": "contact", "contact": f"foot_{leg}"})
    body = parts.body("trunk", 2.0, [0.02, 0.03, 0.03], rotation=quaternion(R), position=(high * up).tolist())
    plane = parts.joint("plane", "planar", "trunk", at=[0, 0, 0], axis=axis)
    return {
        "parameters": {"gx": 0.5},
        "model": {
            "gravity": [f"{along[i]}*gx + {-9.81 * up[i]}" for i in range(3)],
            "bodies": [body, *legs],
            "joints": [*hinges, plane],
            "forces": dry,
            "contacts": feet,
            "quantities": seen,
        },
        "integrator": {**DOP853, "end_time": 0.4, "coordinates": "joint"},
        "output": {"every": 0.01},
        "sweep": parts.sweep(24, {"parameters.gx": (-1.5, 1.5), "bodies.trunk.mass": (0.5, 5.0)}, seed=1),
    }


def test_legs_with_dry_hips_give_way() -> None:
    """Each start has one answer, though friction couples contacts and hips so strongly that iterations diverge; later
    feet that slide may have none."""
    ds = lienumba.run(trunk(Rotation.random(random_state=3), 1.0))
    assert (ds.end_time > 0.0).all()
    assert np.isin(ds.status, [0, 12]).all()
    assert (ds.status == 0).sum() >= 22
    good = ds.isel(run=ds.status.values == 0)
    for foot in ("left", "right"):
        normal, along = good[f"at_{foot}.normal"], good[f"at_{foot}.friction"]
        assert normal.min() > -1e-9
        assert (along <= 0.8 * normal + 1e-6).all()
    moved = abs(good.position - good.position.isel(time=0)).max(["time", "body", "axis"])
    assert (moved > 1e-3).sum() > 10


def test_legs_with_hips_that_hold_are_those_with_locked_hips() -> None:
    dry = trunk(Rotation.random(random_state=3), 25.0)
    locked = trunk(Rotation.random(random_state=3), 25.0)
    locked["model"]["forces"] = []
    for hip in locked["model"]["joints"][:2]:
        hip["locked"] = True
    one, other = lienumba.run(dry), lienumba.run(locked)
    assert (one.status == 0).all()
    np.testing.assert_allclose(one.position, other.position, rtol=0, atol=1e-8)
