"""Static equilibria against closed forms, and what is said of those that are none."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.integrators.tracing.linear import equilibrium
from tests.rigs import parts

G = 9.81
SHORT = {"integrator": {"step": 1e-3, "end_time": 0.1}}


def pendulum(angle: float, **sweep: Any) -> dict[str, Any]:
    """A bob of 1.2 kg at 0.5 m on a hinge with a coil spring; angle 0 hangs."""
    bob = parts.body("bob", 1.2, [0.02, 0.02, 0.01])
    pivot = parts.pivot("pivot", "bob", second=[0, 0, 0.5], angle=angle, rate=3.0)
    coil = {"name": "coil", "type": "torsion_spring", "joint": "pivot", "stiffness": 0.0, "free_angle": 0.0}
    seen = {"name": "swing", "type": "joint", "joint": "pivot"}
    model = {"bodies": [bob], "joints": [pivot], "forces": [coil], "quantities": [seen]}
    return {"model": model, **SHORT, "sweep": sweep}


@pytest.mark.parametrize("angle", [0.3, 2.5, 3.1, -3.1])
def test_a_pendulum_comes_to_hang_wherever_it_starts(angle: float) -> None:
    found = lienumba.equilibrium(pendulum(angle))
    assert found.status.item() == 0
    np.testing.assert_allclose(found.position.values, [[[0, 0, -0.5]]], atol=1e-12)


def test_what_stands_upright_is_unstable() -> None:
    found = lienumba.equilibrium(pendulum(np.pi))
    assert found.status.item() == 2
    assert found.growth.item() == pytest.approx(np.sqrt(1.2 * G * 0.5 / (0.02 + 1.2 * 0.25)), rel=1e-10)


def test_every_run_of_a_sweep_rests_at_its_own_place() -> None:
    """k (angle - 1) = -m g a sin(angle)."""
    scenario = pendulum(0.2, sampler="table", table={"columns": {"forces.coil.stiffness": [1.0, 5.0, 40.0]}})
    scenario["model"]["forces"][0] |= {"stiffness": 3.0, "free_angle": 1.0}
    found = lienumba.equilibrium(scenario)
    x, k = found["swing.angle"].values, np.array([1.0, 5.0, 40.0])
    np.testing.assert_allclose(k * (x - 1.0), -1.2 * G * 0.5 * np.sin(x), rtol=1e-12)
    assert found.status.values.tolist() == [0, 0, 0]


def test_a_free_body_on_bushings_and_one_that_nothing_holds() -> None:
    turned = {"axis": [1, 2, 0], "angle": 0.7}
    block = parts.body("block", 3.0, [0.2, 0.3, 0.4], position=[0.1, 0, 0.2], rotation=turned)
    mount = {"name": "mount", "type": "bushing", "bodies": ["ground", "block"], "points": [[0, 0, 0]] * 2,
             "stiffness": [100, 200, 300], "rotational_stiffness": [5, 5, 5]}  # fmt: skip
    found = lienumba.equilibrium({"model": {"bodies": [block], "forces": [mount]}, **SHORT})
    assert found.status.item() == 0
    np.testing.assert_allclose(found.position.values[0, 0], [0, 0, -3.0 * G / 300], atol=1e-12)
    falling = lienumba.equilibrium({"model": {"bodies": [block]}, **SHORT})
    assert falling.status.item() == 1
    assert np.isnan(falling.position.values).all()
    floating = lienumba.equilibrium({"model": {"gravity": [0, 0, 0], "bodies": [block]}, **SHORT})
    assert floating.status.item() == 0


def test_a_loop_with_redundant_rows_comes_to_rest() -> None:
    """A four-bar linkage hangs where its potential energy is least, all rows kept."""
    found = lienumba.equilibrium("scenarios/four_bar.toml")
    assert found.status.item() == 0
    now = lienumba.linearise("scenarios/four_bar.toml").isel(run=0, time=0)
    assert np.linalg.eigvals(now.A.values).real.max() > 0.0  # where it starts it does not rest


def test_a_run_has_the_bits_that_it_has_alone() -> None:
    """Also beside one without an equilibrium of finite forces."""
    stiffness = [5.0, 1e100, 40.0, 3.0]
    scenario = pendulum(0.2, sampler="table", table={"columns": {"forces.coil.stiffness": stiffness}})
    scenario["model"]["forces"][0] |= {"stiffness": 3.0, "free_angle": 1.0}
    found = lienumba.equilibrium(scenario)
    assert found.status.values[[0, 2, 3]].tolist() == [0, 0, 0]
    for run in (0, 2, 3):
        own = lienumba.equilibrium(scenario, runs=[run])
        for name in ("swing.angle", "force", "growth", "rotation"):
            assert own[name].values.tobytes() == found[name].sel(run=[run]).values.tobytes()


def test_what_rests_already_rests_however_stiff_it_is() -> None:
    """Forces of thousands of newtons leave rounding that is no force; the search begins where it ended before."""
    found = lienumba.equilibrium("scenarios/suspension.toml", overrides={"sweep.runs": 12})
    assert found.status.values.tolist() == [0] * 12
    first = lienumba.equilibrium("scenarios/suspension.toml", overrides={"sweep.runs": 12, "start.from": None})
    np.testing.assert_allclose(found.position, first.position, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", ["bennett", "bricard", "n_four_bar"])
def test_overconstrained_loops_come_to_rest(name: str) -> None:
    """Where rows are redundant in a closed loop alone, and next to singular positions."""
    found = lienumba.equilibrium(f"scenarios/{name}.toml")
    assert found.status.item() == (2 if name == "n_four_bar" else 0)
    assert found.force.item() < 1e-12


# ---------------------------------------------------------------- relative to a uniform rotation
def test_a_conical_pendulum() -> None:
    """cos(angle) = m g l / (I w^2), I = m l^2 + A - C; below the least w it hangs."""
    bob = parts.body("bob", 1.3, [0.004, 0.004, 0.002])
    ball = parts.joint("ball", "spherical", "bob", points=[[0, 0, 0], [0, 0, 0.5]], rotation_vector=[0.1, 0.3, 0])
    scenario = {"model": {"bodies": [bob], "joints": [ball]}, **SHORT}
    least = np.sqrt(1.3 * G * 0.5 / (1.3 * 0.25 + 0.004 - 0.002))
    for w in (1.3 * least, 2.0 * least):
        found = lienumba.equilibrium(scenario, rotation=(0, 0, w))
        assert found.status.item() == 0  # it may spin about itself
        assert -found.position.values[0, 0, 2] / 0.5 == pytest.approx((least / w) ** 2, rel=1e-12)
    slow = lienumba.equilibrium(scenario, rotation=(0, 0, 0.9 * least))
    np.testing.assert_allclose(slow.position.values, [[[0, 0, -0.5]]], atol=1e-9)
    assert lienumba.equilibrium(scenario, rotation=(0, 2.0, 0)).status.item() == 1  # gravity would turn against it


def test_a_top_sleeps_where_it_spins_fast_enough() -> None:
    """(C w)^2 > 4 A m g l, A about the pivot; below, growth = sqrt(4 A m g l - (C w)^2) / 2 A."""
    top = parts.body("top", 1.3, [0.15, 0.15, 0.2])
    ball = parts.joint("ball", "spherical", "top", points=[[0, 0, 0], [0, 0, -0.5]], rotation_vector=[0, 0, 0])
    scenario = {"model": {"bodies": [top], "joints": [ball]}, **SHORT}
    fall, A = 1.3 * G * 0.5, 0.15 + 1.3 * 0.25
    for w in (0.0, 10.0, 17.0):
        found = lienumba.equilibrium(scenario, rotation=(0, 0, w))
        assert found.status.item() == 2
        assert found.growth.item() == pytest.approx(np.sqrt(4 * A * fall - (0.2 * w) ** 2) / (2 * A), rel=1e-9)
    fast = lienumba.equilibrium(scenario, rotation=(0, 0, 18.0))
    assert fast.status.item() == 0
    np.testing.assert_allclose(fast.position.values, [[[0, 0, 0.5]]], atol=1e-15)


def governor(w: float, **sweep: object) -> dict[str, Any]:
    """A weight of 2 kg on a hinge at 0.1 m beside a shaft, on a rod of 0.4 m."""
    at = {"axis": [0, 1, 0], "angle": -0.2}
    shaft = parts.body("shaft", position=[0.3, 0, 0], rotation=[1, 0, 0, 0])
    weight = parts.body("weight", 2, [0.03, 0.04, 0.02], guess={"rotation": at})
    bearing = parts.hinge("bearing", "shaft", [0.3, 0, 0], parts.Z)
    hinge = parts.pivot("hinge", "weight", [0.1, 0, 0], [0, 0, 0.4], to="shaft", angle=-0.2)
    seen = {"name": "arm", "type": "joint", "joint": "hinge"}
    return {
        "model": {"bodies": [shaft, weight], "joints": [bearing, hinge], "quantities": [seen], "gravity": [0, 0, -G]},
        "integrator": {"step": 1e-3, "end_time": 0.2},
        "sweep": sweep,
    }


@pytest.mark.parametrize("driven", [False, True])
def test_a_governor_opens_with_its_speed(driven: bool) -> None:
    """m g l sin = (m l (d + l sin) cos + (J_x - J_z) sin cos) w^2 against axes that turn, and its stability there."""
    scenario = governor(6.0)
    if driven:
        scenario["model"]["drivers"] = [{"name": "motor", "joint": "bearing", "rate": 6.0}]
    found = lienumba.equilibrium(scenario, rotation=(0, 0, 6.0))
    assert found.status.item() == 0
    x = -found["arm.angle"].item()
    left = 2 * G * 0.4 * np.sin(x) - 36 * np.cos(x) * (2 * 0.4 * (0.1 + 0.4 * np.sin(x)) + 0.01 * np.sin(x))
    assert abs(left) < 1e-12
    assert x > 0.5
    turned = [0.3 + 0.1 + 0.4 * np.sin(x), 0.0, -0.4 * np.cos(x)]
    np.testing.assert_allclose(found.position.values[0, 1], turned, atol=1e-12)
    assert found.growth.item() < 1e-6
    modes = lienumba.modes(scenario, rotation=(0, 0, 6.0))  # of the start, which is no equilibrium
    assert modes.sizes["mode"] > 0


def driven_hub(axis: list[float], rate: float, gravity: list[float]) -> dict[str, Any]:
    """An arm hangs from a hub that a motor turns about this axis, against a coil spring; nothing else can move."""
    bodies = [
        parts.body("hub", 3.0, position=[0, 0, 0]),
        parts.body("arm", 1.0, [0.01, 0.02, 0.03], position=[0.3, 0.1, -0.3]),
    ]
    joints = [parts.hinge("bearing", "hub", axis=axis), parts.hinge("hinge", "arm", [0.2, 0.1, 0], to="hub")]
    coil = {"name": "coil", "type": "torsion_spring", "joint": "hinge", "stiffness": 0.5, "free_angle": 0}
    motor = {"name": "motor", "joint": "bearing", "rate": rate}
    model = {"gravity": gravity, "bodies": bodies, "joints": joints, "forces": [coil], "drivers": [motor]}
    return {"model": model, **SHORT}


def test_what_a_motor_turns_rests_against_axes_that_turn_as_fast() -> None:
    """Against no others, about whatever axis it is."""
    for axis in ([0, 0, 1], [0.0, 0.6, 0.8]):
        scenario = driven_hub(axis, 7.3, [-G * x for x in axis])
        status = [lienumba.equilibrium(scenario, rotation=[w * x for x in axis]).status.item() for w in (7.3, 3.0, 0.1)]
        assert status == [0, 1, 1], axis


def test_weight_across_a_rotation_turns_against_it_wherever_it_starts() -> None:
    """Also where it has no slope as the hub stands, along the arm or across it."""
    for gravity in ([0, 0, -G], [0, -G, 0]):
        assert lienumba.equilibrium(driven_hub([1, 0, 0], 7.3, gravity), rotation=(7.3, 0, 0)).status.item() == 1
    along = lienumba.equilibrium(driven_hub([1, 0, 0], 7.3, [-G, 0, 0]), rotation=(7.3, 0, 0))
    assert along.status.item() == 0


def test_a_speed_that_is_held_by_a_law_is_held_wherever_the_scene_lies() -> None:
    """What is left of its rate there is rounding of the speed."""
    for axis in np.random.default_rng(1).standard_normal((8, 3)):
        axis = (axis / np.linalg.norm(axis)).tolist()
        scenario = driven_hub(axis, 7.3, [-G * x for x in axis])
        model = scenario["model"]
        del model["drivers"]
        model["quantities"] = [{"name": "turn", "type": "joint", "joint": "bearing"}]
        model["inputs"] = {"i": {"start": 0.6, "rate": "5*(6 - turn.rate)"}}
        motor = {"name": "motor", "type": "actuator", "joint": "bearing"}
        model["forces"] += [motor | {"value": "inputs.i + 2*(6 - turn.rate) - 0.1*turn.rate"}]
        assert lienumba.equilibrium(scenario, rotation=[6.0 * x for x in axis]).status.item() == 0, axis


def test_a_free_body_goes_on_in_its_circle_wherever_its_force_turns_with_it() -> None:
    """On a spring to the axis; a spring to a place beside it is another one half a turn later."""
    ball = parts.body("ball", 2.0, position=[0.7, 0, 0], rotation=[1, 0, 0, 0])
    for place, status in (([0, 0, 0], 0), ([0.2, 0, 0], 1)):
        spring = {"name": "s", "type": "spring_damper", "bodies": ["ground", "ball"], "points": [place, [0, 0, 0]],
                  "stiffness": 50.0, "free_length": 0.5}  # fmt: skip
        model = {"gravity": [0, 0, 0], "bodies": [ball], "forces": [spring]}
        found = lienumba.equilibrium({"model": model, **SHORT}, rotation=(0, 0, 3.0))
        assert (found.status.item() == 0) == (status == 0), (place, found.status.item())


def test_a_rotating_double_pendulum_in_minimal_coordinates() -> None:
    """Two rods in a plane that turns: the least of V - w^2 I(q) / 2, found by SciPy."""
    from scipy.optimize import minimize

    scenario = governor(9.0)
    link = parts.body("link", 0.7, [0.005, 0.006, 0.001], guess={"rotation": [1, 0, 0, 0]})
    second = parts.pivot("second", "link", [0, 0, -0.1], [0, 0, 0.25], to="weight", angle=0.1)
    scenario["model"]["bodies"].append(link)
    scenario["model"]["joints"].append(second)
    scenario["model"]["quantities"].append({"name": "two", "type": "joint", "joint": "second"})

    def effective(q: Any) -> float:
        a, b = -q[0], -q[0] - q[1]
        r1, z1 = 0.1 + 0.4 * np.sin(a), -0.4 * np.cos(a)
        r2, z2 = 0.1 + 0.5 * np.sin(a) + 0.25 * np.sin(b), -0.5 * np.cos(a) - 0.25 * np.cos(b)
        turning = 2 * r1**2 + 0.7 * r2**2
        turning += 0.03 * np.sin(a) ** 2 + 0.02 * np.cos(a) ** 2 + 0.005 * np.sin(b) ** 2 + 0.001 * np.cos(b) ** 2
        return float(2 * G * z1 + 0.7 * G * z2 - 0.5 * 81 * turning)

    best = minimize(effective, [-0.8, 0.0], method="BFGS", options={"gtol": 1e-9})
    found = lienumba.equilibrium(scenario, rotation=(0, 0, 9.0))
    assert found.status.item() == 0
    np.testing.assert_allclose([found["arm.angle"].item(), found["two.angle"].item()], best.x, atol=1e-6)


def test_what_nothing_can_balance_is_not_found() -> None:
    """A motor on a hinge, without and with a weight against it, and what falls; a floor is far, but it is there."""
    scenario = pendulum(0.2, sampler="table", table={"columns": {"gravity[2]": [0.0, -G]}})
    wind = {"name": "wind", "type": "torque", "body": "bob", "frame": "body", "value": [0, 0.7, 0]}
    scenario["model"] |= {"gravity": [0, 0, 0], "forces": [wind]}
    found = lienumba.equilibrium(scenario)
    assert found.status.values.tolist() == [1, 0]
    assert found.force.values[0] == pytest.approx(0.7)
    assert 1.2 * G * 0.5 * np.sin(found["swing.angle"].values[1]) == pytest.approx(0.7)
    ball = parts.body("ball", 2.0, 0.01, position=[0, 0, 1.5])
    floor = parts.sphere("floor", "ball", 0.1, normal=[0, 0, 1], stiffness=1e4)
    drop = lienumba.equilibrium({"model": {"bodies": [ball], "contacts": [floor]}, **SHORT})
    assert drop.status.item() == 0  # it lies, and may roll
    assert drop.position.values[0, 0, 2] == pytest.approx(0.1 - 2.0 * G / 1e4, abs=1e-9)


def test_what_goes_to_and_fro_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """A disc that rolls lies down, from one face on the other."""
    made, step = [], equilibrium._Search.step
    monkeypatch.setattr(equilibrium._Search, "step", lambda *given: made.append(None) or step(*given))
    assert lienumba.equilibrium("scenarios/rolling_disc.toml", runs=[0]).status.item() == 1
    assert len(made) < 100


def test_what_flies_away_is_not_followed_far(monkeypatch: pytest.MonkeyPatch) -> None:
    """A free block that shall turn about an axis beside it: the farther out, the larger the force."""
    taken, search = [], equilibrium._Search
    step = search.step
    monkeypatch.setattr(search, "step", lambda self, which: taken.append(which) or step(self, which))
    block = parts.body("block", 3.0, [0.2, 0.3, 0.4], position=[0.5, 0, 0.2])
    found = lienumba.equilibrium({"model": {"bodies": [block]}, **SHORT}, rotation=(1.0, 0.5, 0.3))
    assert found.status.item() == 1
    assert len(taken) < 100


@pytest.mark.parametrize(("spin", "status"), [(10.0, 2), (300.0, 0)])
def test_growth_is_that_of_the_modes_where_a_driver_turns(spin: float, status: int) -> None:
    """A rotor that a motor turns keeps its stem upright, if it is fast enough: (C spin)^2 > 4 A m g l."""
    stem = parts.body("stem", 0.2, [0.001, 0.001, 0.001], position=[0, 0, 0.1])
    rotor = parts.body("rotor", 1.0, [0.004, 0.004, 0.008], position=[0, 0, 0.2])
    joints = [
        parts.joint("gimbal", "universal", "stem", points=[[0] * 3, [0, 0, -0.1]], axes=[[1, 0, 0], [0, 1, 0]]),
        parts.hinge("axle", "rotor", [0, 0, 0.2], [0, 0, 1], to="stem"),
    ]
    motor = {"name": "motor", "joint": "axle", "rate": spin}
    scenario = {"model": {"bodies": [stem, rotor], "joints": joints, "drivers": [motor]}, **SHORT}
    found, modes = lienumba.equilibrium(scenario), lienumba.modes(scenario)
    whole, weight = 0.005 + 0.2 * 0.01 + 1.0 * 0.04, G * (0.2 * 0.1 + 1.0 * 0.2)
    assert ((0.008 * spin) ** 2 > 4 * whole * weight) == (status == 0)
    assert found.status.item() == status
    assert modes.stable.item() == (status == 0)
    assert found.growth.item() == pytest.approx(np.nanmax(modes.growth.values), rel=1e-9, abs=1e-9)
