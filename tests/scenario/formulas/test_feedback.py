"""Quantities that forces and drivers read, what a sweep changes in them, and what they leave as it is."""

import copy
import tomllib
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.interpolate import CubicSpline

import lienumba
from lienumba.integrators.tracing import step_kernels
from tests.facade import resolve
from tests.rigs.observed import TIP, Seen, rig, run
from tests.rigs.pendulum import L, angles, exact, pendulum

STATES = ("position", "rotation", "velocity", "angular_velocity", "energy", "work", "joint_force", "driver_effort")
SHORT = {"integrator": {"step": 1e-3, "end_time": 0.05}, "output": {"every": 0.01}}
PARAMETERS = {"parameters": {"kp": 20}}
POINT = {"name": "spot", "type": "point", "body": "slider", "point": ["reach/3", -0.05, "reach"]}


# ---------------------------------------------------------------- what they leave alone
@pytest.mark.parametrize("joints", [False, True])
def test_more_quantities_change_no_bit_of_the_states(joints):
    plain = run(rig(quantities=[], parameters={"spring": 300}, **SHORT))
    data = rig(**SHORT)
    data["quantities"] = [q for q in data["quantities"] if joints or q["type"] != "joint"]
    more = run(data)
    assert "tip" in more
    for name in STATES:
        np.testing.assert_array_equal(more[name], plain[name], err_msg=name)


def test_a_parameter_in_a_quantity_may_be_swept():
    vary = {"parameters.reach": {"distribution": "uniform", "low": 0.1, "high": 0.5}}
    far = {"name": "far", "type": "expression", "value": "reach*sin(t)"}
    ds = run(rig(quantities=[POINT, far], sweep={"runs": 3, "seed": 1, "vary": vary}, **SHORT))
    assert len(np.unique(ds["parameters.reach"])) == 3
    for n in range(3):
        one, reach = ds.isel(run=n), float(ds["parameters.reach"][n])
        p, _ = Seen(one).point("slider", [reach / 3, TIP[1], reach])
        np.testing.assert_allclose(one["spot"], p, rtol=0, atol=1e-14)
        np.testing.assert_allclose(one["far"], reach * np.sin(one.time), rtol=1e-14)
        np.testing.assert_array_equal(one.position, ds.position[0])


def test_a_quantity_with_a_parameter_may_be_read():
    far = {"name": "far", "type": "expression", "value": "2*spot.x"}
    ds = run(rig(quantities=[POINT, far], **SHORT)).isel(run=0)
    np.testing.assert_array_equal(ds["far"], 2 * ds["spot"].sel(axis="x"))


def test_a_number_of_a_quantity_may_be_swept():
    quantity = POINT | {"point": [0.1, 0, 0]}
    vary = {"quantities.spot.point[0]": {"distribution": "uniform", "low": 0.1, "high": 0.5}}
    ds = run(rig(quantities=[quantity], sweep={"runs": 2, "vary": vary}, parameters={"spring": 300}, **SHORT))
    for n in range(2):
        one = ds.isel(run=n)
        p, _ = Seen(one).point("slider", [float(one["quantities.spot.point[0]"]), 0, 0])
        np.testing.assert_allclose(one["spot"], p, rtol=0, atol=1e-14)


def test_runs_that_fail_see_nothing():
    vary = {"bodies.ball.mass": {"distribution": "normal", "std": 0.6}}
    with pytest.warns(UserWarning, match="will draw a value of 0 or below and fail"):
        ds = lienumba.run(rig(sweep={"runs": 8, "seed": 2, "vary": vary}, **SHORT), workers=1)
    bad = ds.status.values != 0
    assert 0 < bad.sum() < 8
    for name in ("tip", "pointing.angle", "load.force", "shoulder.rate", "bending"):
        assert np.isnan(ds[name].values[bad]).all(), name
        assert np.isfinite(ds[name].values[~bad]).all(), name


def test_only_what_is_asked_for_is_stored(tmp_path):
    data = rig(**SHORT) | {"output": {"every": 0.01, "variables": ["pointing", "load", "energy"]}}
    ds = run(data, output=tmp_path / "some.nc")
    series = {name for name, x in ds.data_vars.items() if "time" in x.dims}
    assert series == {"pointing", "pointing.angle", "load.force", "load.torque", "energy"}
    with xr.open_dataset(tmp_path / "some.nc") as stored:
        for name in series:
            np.testing.assert_array_equal(stored[name], ds[name])
            assert stored[name].attrs == ds[name].attrs


def test_the_hash_is_of_what_decides_a_run():
    def hashed(*quantities: dict[str, Any], **keys: Any) -> str:
        return resolve(pendulum("-kp*pointing.y", list(quantities), **keys) | PARAMETERS).sha256()

    point = {"name": "spot", "type": "point", "body": "rod"}
    assert hashed() == hashed(point) == hashed(point | {"point": [1, 2, 3]})
    assert hashed() != hashed(target={"axis": [0, 1, 0], "angle": 0.1})
    inner = {"name": "inner", "type": "expression", "value": "2*pointing.y"}
    assert hashed(inner) == hashed(inner | {"value": "3*pointing.y"}) == hashed()
    reading = pendulum("-kp*inner", [inner]) | PARAMETERS
    other = pendulum("-kp*inner", [inner | {"value": "3*pointing.y"}]) | PARAMETERS
    assert len({resolve(reading).sha256(), resolve(other).sha256(), hashed()}) == 3


def test_the_resolved_text_keeps_quantities_and_tables():
    data = pendulum("-kp*pointing.y + kd*push(t)", [POINT | {"body": "rod", "point": ["kp/100", 0, 0]}])
    data["tables"] = {"push": {"times": [0, 1], "values": [1.0, 2.0], "interpolation": "hold"}}
    scenario = resolve(data)
    text = scenario.to_toml()
    assert "[[quantities]]" in text
    assert "push = {" in text
    again = resolve(tomllib.loads(text))
    assert (again.to_toml(), again.sha256()) == (text, scenario.sha256())
    other = copy.deepcopy(data)
    other["tables"]["push"]["values"] = [1.0, 2.5]
    assert resolve(other).sha256() != scenario.sha256()


# ---------------------------------------------------------------- feedback
CLIPPED = "clip(-kp*pointing.y - kd*rate.y, -5, 5)"


@pytest.mark.parametrize("staged", [False, True])
def test_a_closed_loop_agrees_with_scipy(staged, monkeypatch):
    if staged:
        monkeypatch.setattr(step_kernels, "INLINE", 0)
    law = {"name": "law", "type": "expression", "value": CLIPPED, "units": "N m"}
    vary = {"parameters.kp": {"distribution": "uniform", "low": 10, "high": 30}}
    data = pendulum("law", [law], step=2e-4) | {"sweep": {"runs": 3, "vary": vary}}
    ds = run(data)
    for n in range(3):
        kp = float(ds["parameters.kp"][n])

        def torque(t, q, dq, kp=kp):
            return np.clip(-kp * q - kp / 10 * dq, -5, 5)

        q, dq = exact(torque, ds.time.values)
        np.testing.assert_allclose(angles(ds)[n], q, rtol=0, atol=2e-6)
        np.testing.assert_allclose(ds["rate"][n, :, 1], dq, rtol=0, atol=2e-5)
        np.testing.assert_allclose(ds["law"][n], torque(0, q, dq), rtol=0, atol=1e-4)
    assert (np.abs(ds["law"]) == 5).any()
    inline = run(pendulum(CLIPPED, step=2e-4) | {"sweep": data["sweep"]})
    np.testing.assert_allclose(inline.position, ds.position, rtol=0, atol=1e-12)


def test_a_smooth_loop_has_the_order_of_the_method():
    def torque(t, q, dq):
        return -20 * q - 2 * dq * np.cos(q) + np.sin(5 * t)

    errors = []
    for step in (0.02, 0.01, 0.005):
        ds = run(pendulum("-kp*pointing.y - kd*rate.y*cos(pointing.angle) + sin(5*t)") | {
            "integrator": {"step": step, "end_time": 0.8}})  # fmt: skip
        errors.append(np.abs(angles(ds)[0] - exact(torque, ds.time.values)[0]).max())
        assert np.abs(ds.energy_residual).max() < 1e5 * step**4
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 4, atol=0.25)


def test_a_spring_whose_stiffness_follows_the_mechanism():
    """The potential changes with what the formula reads; what that takes is accounted for as work."""
    data = pendulum("0*t", [{"name": "tip", "type": "point", "body": "rod"}])
    data["model"]["forces"] = [{"name": "coil", "type": "torsion_spring", "joint": "hinge", "stiffness": "9 + 20*tip.x",
                                "free_angle": "0.3*tip.z"}]  # fmt: skip

    def torque(t, q, dq):
        return -(9 - 20 * L * np.sin(q)) * (q - 1.0 + 0.3 * L * np.cos(q))  # the angle is 0 at the start

    found = []
    del data["parameters"]
    for step in (0.01, 0.005):
        ds = run(data | {"integrator": {"step": step, "end_time": 0.8}})
        found.append(float(np.abs(ds.energy_residual).max()))
    assert np.abs(ds.work).max() > 0.1
    assert np.log2(found[0] / found[1]) > 3.7
    np.testing.assert_allclose(angles(ds)[0], exact(torque, ds.time.values)[0], rtol=0, atol=1e-6)


def test_a_table_of_an_angle():
    """A spring known at points: nothing has to land, and the energy that goes in comes out."""
    x, y = np.linspace(-2, 2, 9), [3.0, 4.0, 1.5, 0.5, 0.0, -0.8, -1.0, -4.0, -3.5]
    spline = CubicSpline(x, y)
    data = pendulum("map(first.angle + 1.0)", [{"name": "first", "type": "joint", "joint": "hinge"}])
    del data["parameters"]
    data["tables"] = {"map": {"times": x.tolist(), "values": y, "interpolation": "cubic"}}
    ds = run(data)
    assert not resolve(data).warnings
    wanted = exact(lambda t, q, dq: spline(np.clip(q, -2, 2)), ds.time.values)[0]
    np.testing.assert_allclose(angles(ds)[0], wanted, rtol=0, atol=1e-6)


def test_the_work_of_what_follows_an_angle_of_zero_is_a_number():
    data = pendulum("0*t")
    del data["parameters"], data["model"]["bodies"][0]["rotation"]
    data["model"]["forces"] = [
        {"name": "coil", "type": "torsion_spring", "joint": "hinge", "stiffness": 3, "free_angle": "pointing.angle"}
    ]
    assert np.isfinite(run(data).work).all()
