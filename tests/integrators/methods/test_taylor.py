"""Series in time: their order, the steps they choose, branches, tables, samples, events, loops, both coordinates."""

import copy
import tomllib
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.integrators.methods.taylor import order_for
from tests.facade import ScenarioError, resolve
from tests.integrators.drivers.test_discontinuities import END, exact, off, rod
from tests.laws.rigs import own, pendulum
from tests.rigs.places import SCENARIOS
from tests.rigs.scenarios import TOP, exact_top

COORDINATES = ["lie", "joint"]
SWEEP: dict[str, Any] = {
    "runs": 11,
    "seed": 3,
    "vary": {"bodies.top.angular_velocity[1]": {"distribution": "uniform", "low": 5.0, "high": 200.0}},
}


def run(data: Any, overrides: Any = None, **options: Any) -> Any:
    ds = lienumba.run(data, overrides=overrides, **{"workers": 1, **options})
    assert (ds.status == 0).all()
    return ds


def top(**integrator: Any) -> dict[str, Any]:
    return copy.deepcopy(TOP) | {
        "integrator": {"method": "taylor", "end_time": 0.1, **integrator},
        "output": {"every": 0.05},
    }


def errors(ds: Any) -> tuple[float, float, float, float]:
    """Of the top at the end: r, R, v, w."""
    end, truth = ds.isel(run=0, time=-1, body=0), exact_top(float(ds.time[-1]))
    return tuple(
        float(np.abs(end[name].values - x.reshape(end[name].shape)).max())
        for name, x in zip(
            ("position", "rotation", "velocity", "angular_velocity"),
            (truth.r, truth.R, truth.v, truth.omega),
            strict=True,
        )
    )  # type: ignore[return-value]


@pytest.mark.parametrize("coordinates", COORDINATES)
@pytest.mark.parametrize("order", [3, 6])
def test_the_order_is_the_one_that_is_given(coordinates: str, order: int) -> None:
    step = {3: 2.5e-4, 6: 2.5e-3}[order]
    found = [errors(run(top(order=order, step=step / n, coordinates=coordinates)))[1] for n in (1, 2)]
    assert np.log2(found[0] / found[1]) == pytest.approx(order, abs=0.2), found


@pytest.mark.parametrize("coordinates", COORDINATES)
def test_a_tolerance_is_kept_from_coarse_to_fine(coordinates: str) -> None:
    steps = []
    for tolerance in (1e-4, 1e-8, 1e-12):
        ds = run(top(tolerance=tolerance, coordinates=coordinates))
        assert max(errors(ds)) < max(50 * tolerance, 1e-11)
        steps.append(int(ds.steps[0]))
        R = ds.rotation.values.reshape(-1, 3, 3)
        assert np.abs(R @ R.transpose(0, 2, 1) - np.eye(3)).max() < 1e-15  # on the group, whatever the tolerance
    assert steps[2] < 1.2 * steps[0]  # the order grows instead
    assert (order_for(1e-4), order_for(1e-8), order_for(1e-12)) == (8, 15, 22)


def test_no_run_feels_another() -> None:
    data = top(tolerance=1e-9, coordinates="joint") | {"sweep": SWEEP}
    alone, pair = run(data), run(data, workers=2)
    some = run(data, runs=[7, 3])
    assert len({*alone.steps.values.tolist()}) > 5
    for name in ("position", "rotation", "angular_velocity", "joint_force"):
        assert np.array_equal(alone[name], pair[name])
        assert np.array_equal(alone[name].sel(run=[7, 3]), some[name])


def test_outputs_move_no_step_and_are_as_exact() -> None:
    few, many = (run(top(tolerance=1e-10, coordinates="joint"), {"output.every": x}) for x in (0.1, 0.005))
    assert int(few.steps[0]) == int(many.steps[0])
    assert np.array_equal(few.rotation[0, -1], many.rotation[0, -1])
    middle = exact_top(0.055)
    assert np.abs(many.position.sel(time=0.055, method="nearest")[0, 0].values - middle.r).max() < 1e-9


@pytest.mark.parametrize("kind", ["hold", "linear"])
def test_steps_end_on_the_points_of_tables(kind: str) -> None:
    data = rod(1e-3, kind)
    data["integrator"] = {"method": "taylor", "tolerance": 1e-11, "end_time": END}
    assert off(run(data), exact(kind)).max() < 1e-10


@pytest.mark.parametrize("coordinates", COORDINATES)
def test_steps_end_behind_kinks(coordinates: str) -> None:
    """A motor at its limit, an arm that is sampled, and a linkage with a clearance: as by a pair."""
    for name, end in (("arm_pd", 0.2), ("arm_sampled", 0.2)):
        given = {
            "integrator.end_time": end,
            "integrator.step": None,
            "sweep.runs": 2,
            "integrator.coordinates": coordinates,
        }
        given |= {"output.every": end / 2}
        every = [
            run(SCENARIOS / f"{name}.toml", given | {"integrator.method": method, "integrator.tolerance": tolerance})
            for method, tolerance in (("taylor", 1e-10), ("dop853", 1e-13))
        ]
        assert np.abs(every[0].position.values - every[1].position.values).max() < 1e-10
        assert (every[0].steps + every[0].rejected_steps < 0.5 * every[1].steps).all()


@pytest.mark.parametrize(
    "force",
    [
        {"type": "end_stop", "joint": "hinge", "upper": 3.141, "stiffness": 1e6},
        {"type": "force", "body": "rod", "value": [0, 0, "min(tip.z, -0.3)"]},
        {"type": "friction", "joint": "hinge", "viscous": 0.05, "coulomb": 0.5, "velocity": 0.01},
        {"type": "force", "body": "rod", "value": [0, 0, "10*exp(-((t - 1)/0.02)**2)"]},
        {"type": "force", "body": "rod", "value": [0, 0, "-sqrt(v.x*v.x + v.z*v.z)*v.z"]},
    ],
    ids=["touched within a step", "a gap that is linear in the state", "narrow friction", "a pulse", "drag at rest"],
)
def test_what_the_last_terms_of_a_series_do_not_tell(force: dict[str, Any]) -> None:
    """A swing from the horizontal nearly to the horizontal; as by a pair."""
    body = {"name": "rod", "mass": 1.0, "inertia": [0.1, 0.2, 0.3], "position": [1, 0, 0], "rotation": [1, 0, 0, 0]}
    hinge = {"name": "hinge", "type": "revolute", "bodies": ["ground", "rod"], "at": [0, 0, 0], "axis": [0, 1, 0]}
    model = {"gravity": [0, 0, -9.81], "bodies": [body], "joints": [hinge], "forces": [{"name": "law", **force}]}
    ends = []
    for method, tolerance in (("taylor", 1e-10), ("dop853", 1e-12)):
        integrator = {"method": method, "tolerance": tolerance, "end_time": 2.0, "coordinates": "joint"}
        tip = {"name": "tip", "type": "point", "body": "rod"}
        seen = {"quantities": [tip, {**tip, "name": "v", "derivative": 1}], "output": {"every": 0.5}}
        ds = run({"model": model, "integrator": integrator, **seen})
        ends.append(ds.position.values)
        assert ds.steps.item() < {"taylor": 60, "dop853": 10000}[method]
    assert np.abs(ends[0] - ends[1]).max() < 1e-9


def test_a_bushing_begins_relaxed_and_turns_to_and_fro() -> None:
    """Its rotation vector has a series where it is 0, too, and no kink where another component is the largest."""
    body = {"name": "b", "mass": 1.0, "inertia": [0.1, 0.2, 0.25], "position": [0, 0, 0], "velocity": [0, 0, 0]}
    bushing = {
        "name": "mount", "type": "bushing", "bodies": ["ground", "b"], "points": [[0, 0, 0], [0.1, 0, 0]],
        "stiffness": [100.0, 100.0, 100.0], "rotational_stiffness": [3.0, 2.0, 4.0],
    }  # fmt: skip
    model = {"gravity": [0, 0, -9.81], "bodies": [body], "forces": [bushing]}
    for rotation, rate in (([1, 0, 0, 0], [0, 0, 0]), ([0, 0.6, 0.8, 0], [6.0, 2.0, -3.0])):
        body |= {"rotation": rotation, "angular_velocity": rate}
        ends = []
        for method, tolerance in (("taylor", 1e-10), ("dop853", 1e-12)):
            integrator = {"method": method, "tolerance": tolerance, "end_time": 2.0}
            ds = run({"model": model, "integrator": integrator, "output": {"every": 0.5}})
            ends.append(ds.position.values)
            assert ds.status.item() == 0
            assert ds.steps.item() < {"taylor": 80, "dop853": 10000}[method]
        assert np.abs(ends[0] - ends[1]).max() < 1e-9


@pytest.mark.parametrize("tolerance", [1e-5, 1e-10])
def test_what_falls_as_a_polynomial_does_not_fall_through_a_spring(tolerance: float) -> None:
    """From 1 m on a spring that only pushes: z = -a + a cos wt - v/w sin wt while they touch, a = m g/k."""
    body = {"name": "drop", "mass": 2.0, "inertia": [1, 1, 1], "position": [0, 0, 1]}
    spring = {"name": "spring", "type": "force", "body": "drop", "value": [0, 0, "-1000*min(p.z, 0)"]}
    data = {
        "model": {"gravity": [0, 0, -9.81], "bodies": [body], "forces": [spring]},
        "quantities": [{"name": "p", "type": "point", "body": "drop"}],
        "integrator": {"method": "taylor", "tolerance": tolerance, "end_time": 1.0},
        "output": {"every": 1.0},
    }
    w, a, v = 500**0.5, 9.81 / 500, (2 * 9.81) ** 0.5
    touching = (2 * np.pi - 2 * np.arctan2(v, a * w)) / w  # it leaves as fast as it has come
    flight = 1.0 - v / 9.81 - touching
    expected = v * flight - 0.5 * 9.81 * flight**2
    assert float(run(data).position[0, -1, 0, 2]) == pytest.approx(expected, abs=10 * tolerance)


@pytest.mark.parametrize("coordinates", COORDINATES)
def test_laws_with_states_and_many_turns_in_a_step(coordinates: str) -> None:
    """A law that counts turns and has a state, and a rotor that turns more than once in a step."""
    law = own(
        "pid", joints=["hinge"], parameters={"kp": 30, "kd": 2, "target": 1.0, "ki": 25}, states={"integral": 0.1}
    )
    data = pendulum(law, rate=40.0)
    found = []
    for method, tolerance in (("taylor", 1e-11), ("dop853", 1e-13)):
        data["integrator"] = {"method": method, "tolerance": tolerance, "end_time": 1.0, "coordinates": coordinates}
        found.append(run(data))
    for name in ("position", "own.integral", "work"):
        assert np.abs(found[0][name].values - found[1][name].values).max() < 1e-8, name


@pytest.mark.filterwarnings("ignore:model.bodies.slider.inertia")
def test_multipliers_of_drivers_are_unknown_numbers_of_the_series() -> None:
    """Those of the satellite, whose arm is driven; as by a pair."""
    data = tomllib.loads((SCENARIOS / "satellite.toml").read_text(encoding="utf-8"))
    ends = []
    for method, tolerance in (("taylor", 1e-10), ("dop853", 1e-12)):
        data["integrator"] = {"method": method, "tolerance": tolerance, "end_time": 1.0, "coordinates": "joint"}
        ends.append(run(data | {"output": {"every": 0.25}}))
    for name, close in (("position", 1e-13), ("velocity", 1e-12), ("joint_force", 1e-11), ("driver_effort", 1e-11)):
        np.testing.assert_allclose(ends[0][name].values, ends[1][name].values, atol=close)


def test_loops_and_events() -> None:
    given = {"integrator.step": None, "integrator.end_time": 0.2, "output.every": 0.1}
    found = [
        run(SCENARIOS / "four_bar.toml", given | {"integrator.method": method, "integrator.tolerance": tolerance})
        for method, tolerance in (("taylor", 1e-10), ("dop853", 1e-13))
    ]
    assert np.abs(found[0].position.values - found[1].position.values).max() < 1e-9
    data = top(tolerance=1e-10, coordinates="joint")
    data["quantities"] = [{"name": "height", "type": "point", "body": "top"}]
    data["events"] = [{"name": "low", "when": "height.z < -0.001", "action": "stop"}]
    times = []
    for method, coordinates in (("taylor", "joint"), ("dop853", "lie")):
        data["integrator"] |= {"method": method, "coordinates": coordinates}
        times.append(float(lienumba.run(data).event_time[0, 0]))
    assert times[0] == pytest.approx(times[1], abs=1e-10)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"method": "rk4", "step": 1e-3, "order": 6}, "that of a series"),
        ({"method": "taylor", "step": 1e-3, "group": "SE3"}, "makes no difference"),
        ({"method": "taylor", "step": 1e-3, "dexpinv": 3}, "makes no difference"),
        ({"method": "taylor", "step": 1e-3, "order": 41}, "from 2 to 40"),
    ],
)
def test_what_a_series_has_no_use_for_is_told(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        resolve(copy.deepcopy(TOP) | {"integrator": {"end_time": 0.1, **keys}})
