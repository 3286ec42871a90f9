"""Implicit steps: their order does not care how stiff a mechanism is, and lanes do not see each other."""

import numpy as np
import pytest

import lienumba
from lienumba.scenario.reading.loading import load
from tests.facade import ScenarioError
from tests.rigs.places import SCENARIOS
from tests.rigs.scenarios import TOP, exact_top, scenario

END = 0.32


def bars(stiffness: float, damping: float) -> lienumba.System:
    """Two bars in space: one on a ball joint, the other on it by a bushing."""
    system = lienumba.System("bars")
    about = {"rotation": [1.0, 0.0, 0.0, 0.0]}
    moving = {"velocity": [0.45, 0.0, -3.0], "angular_velocity": [2.0, 1.0, 0.3]}
    system.body("upper", mass=1.0, inertia=[0.09, 0.01, 0.09], position=[0.0, -0.5, 0.0], **about)
    system.body("lower", mass=1.0, inertia=[0.09, 0.01, 0.09], position=[0.0, -1.5, 0.0], **about, **moving)
    system.joint(
        "ball", "spherical", ["ground", "upper"], points=[[0, 0, 0], [0, 0.5, 0]], angular_velocity=[2.0, 1.0, 0.3]
    )
    system.force(
        "bush", type="bushing", bodies=["upper", "lower"], points=[[0, -0.5, 0], [0, 0.5, 0]],
        stiffness=[stiffness] * 3, damping=[damping] * 3, rotational_stiffness=[0.0] * 3, rotational_damping=[0.0] * 3,
    )  # fmt: skip
    return system.integrator(method="radau5", coordinates="joint", step=END / 8, end_time=END)


@pytest.mark.parametrize(("stiffness", "damping"), [(1e12, 1e4), (0.0, 1e6)])
def test_steps_do_not_care_how_stiff_it_is(stiffness: float, damping: float) -> None:
    system = bars(stiffness, damping)
    ways = {"integrator.step": None, "output.every": END}
    fine, rough = (lienumba.run(system, overrides=ways | {"integrator.tolerance": x}) for x in (1e-9, 1e-6))
    assert (fine.status == 0).all()
    assert (rough.status == 0).all()
    assert rough.steps[0] < 200
    assert abs(rough.position - fine.position).max() < 1e-6


@pytest.mark.parametrize(("stiffness", "damping", "counts"), [(1e12, 1e4, (60, 80, 120)), (0.0, 1e6, (16, 32, 64))])
def test_the_order_is_full_however_stiff_it_is(stiffness: float, damping: float, counts: tuple[int, ...]) -> None:
    """Of steps of which hardly any is made in parts."""
    system = bars(stiffness, damping)
    exact = lienumba.run(
        system, overrides={"integrator.step": None, "integrator.tolerance": 1e-10, "output.every": END}
    ).position.values[0, -1]
    errors = []
    for steps in counts:
        found = lienumba.run(system, overrides={"integrator.step": END / steps, "output.every": END})
        assert int(found.status[0]) == 0
        assert found.rejected_steps[0] <= 1
        errors.append(abs(found.position.values[0, -1] - exact).max())
    orders = np.log(np.divide(errors[:-1], errors[1:])) / np.log(np.divide(counts[1:], counts[:-1]))
    np.testing.assert_allclose(orders, 5, atol=0.2)


def test_it_comes_through_a_singular_position_of_a_loop() -> None:
    data = load(SCENARIOS / "n_four_bar.toml")
    data["integrator"] = {"method": "radau5", "tolerance": 1e-6, "coordinates": "joint", "end_time": 2.0}
    data["output"] = {"every": 0.1}
    found = lienumba.run(data)
    exact = lienumba.run(data, overrides={"integrator.method": "dop853", "integrator.tolerance": 1e-9})
    assert int(found.status[0]) == int(exact.status[0]) == 0
    assert abs(found.position - exact.position).max() < 1e-6


def test_the_order_is_full_on_se3_too() -> None:
    system, errors = lienumba.System("bar on a bushing"), []
    system.body(
        "bar", mass=1.0, inertia=[0.09, 0.01, 0.09], position=[0, -0.5, 0], rotation=[1, 0, 0, 0],
        velocity=[0.15, 0.0, -1.0], angular_velocity=[2.0, 1.0, 0.3],
    )  # fmt: skip
    system.force(
        "bush", type="bushing", bodies=["ground", "bar"], points=[[0, 0, 0], [0, 0.5, 0]],
        stiffness=[1e9] * 3, damping=[1e3] * 3, rotational_stiffness=[0.0] * 3, rotational_damping=[0.0] * 3,
    )  # fmt: skip
    system.integrator(method="radau5", group="SE3", step=END / 8, end_time=END).output(every=END)
    exact = lienumba.run(system, overrides={"integrator.step": END / 256}).position.values[0, -1]
    for steps in (8, 16):
        found = lienumba.run(system, overrides={"integrator.step": END / steps})
        assert int(found.status[0]) == 0
        errors.append(abs(found.position.values[0, -1] - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(5, abs=0.2)


def test_on_se3_joints_to_ground_need_no_projection() -> None:
    """The algebra of a subgroup is left by no combination of its elements."""
    projection = {"projection.position": "none", "projection.velocity": "none"}
    ways = {"integrator.method": "radau5", "integrator.group": "SE3", "integrator.step": 5e-3}
    found = lienumba.run(scenario(TOP, 5e-3, 0.5), overrides=ways | projection)
    assert float(found.max_position_violation[0]) < 1e-13
    assert float(found.max_velocity_violation[0]) < 1e-9


@pytest.mark.parametrize(("coordinates", "group"), [("lie", "R3xSO3"), ("lie", "SE3"), ("joint", "R3xSO3")])
def test_where_nothing_is_stiff_it_agrees_with_the_exact_motion(coordinates: str, group: str) -> None:
    ways = {"integrator.method": "radau5", "integrator.coordinates": coordinates, "integrator.group": group}
    end = lienumba.run(scenario(TOP, 1e-4, 0.1), overrides=ways).position.values[0, -1, 0]
    assert abs(end - exact_top(0.1).r).max() < 1e-9


@pytest.mark.parametrize(("method", "order"), [("radau3", 3), ("radau5", 5), ("radau9", 9)])
def test_the_order_holds_where_bodies_turn_in_space(method: str, order: int) -> None:
    body = {"name": "b", "mass": 1.0, "inertia": [0.1, 0.2, 0.3], "position": [0, 0, -1]}
    pivot = {"name": "p", "type": "spherical", "bodies": ["ground", "b"], "at": [0, 0, 0]}
    high = order == 9
    moving = body | {"angular_velocity": [0.9, 3.0, 1.5] if high else [0.3, 1.0, 0.5]}

    def end(method: str, step: float) -> np.ndarray:
        data = {
            "model": {"bodies": [moving], "joints": [pivot]},
            "integrator": {"method": method, "coordinates": "joint" if high else "lie", "step": step, "end_time": 1.0},
            "output": {"every": 1.0},
        }
        found = lienumba.run(data)
        return np.concatenate([found[name].values[0, -1].ravel() for name in ("rotation", "angular_velocity")])

    exact = end("dop853", 0.01)
    errors = [abs(end(method, step) - exact).max() for step in ((1 / 6, 1 / 12) if high else (0.05, 0.025, 0.0125))]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), order, atol=0.2 if high else 0.1)
    if order == 5:
        assert abs(end(method, 0.005) - exact).max() < 1e-11


def test_neighbours_change_no_bit() -> None:
    ways = {"integrator.step": None, "integrator.tolerance": 1e-6, "output.every": END / 4}
    sweep = {
        "sweep": {
            "runs": 11,
            "seed": 3,
            "vary": {"forces.bush.stiffness[0]": {"distribution": "uniform", "low": 1e2, "high": 1e12}},
        }
    }
    system = bars(1e6, 10.0)
    every = lienumba.run(system, overrides=ways | sweep)
    assert (every.status == 0).all()
    assert len({int(n) for n in every.steps}) > 3
    alone = lienumba.run(system, overrides=ways | sweep, runs=[4])
    np.testing.assert_array_equal(every.position.values[4], alone.position.values[0])


def test_what_it_cannot_do_is_refused() -> None:
    ways = {"integrator.method": "radau5", "integrator.coordinates": "quaternion"}
    with pytest.raises(ScenarioError, match=r'integrator\.coordinates = "quaternion": has no implicit steps'):
        lienumba.run(scenario(TOP, 5e-4, 0.1), overrides=ways)
