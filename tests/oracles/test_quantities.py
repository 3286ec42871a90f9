"""Quantities in the dataset against what NumPy and SciPy make of the stored states."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs.observed import (
    END,
    GRAVITY,
    HAND,
    LINK,
    PUSH,
    QUANTITIES,
    RIG,
    TARGET,
    TIP,
    Seen,
    along,
    back,
    rig,
    run,
    slope,
)

INNER = slice(2, -2)
MASS = {"base": 4.0, "arm": 1.3, "slider": 0.7, "ball": 0.4}
xx, yy, zz, xy, xz, yz = LINK["inertia"]
LINKED = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
INERTIA = {
    "base": np.diag([0.2, 0.3, 0.25]), "arm": LINKED, "slider": LINKED, "ball": np.diag([0.01, 0.012, 0.014]),
}  # fmt: skip


@pytest.fixture(scope="module")
def ds():
    return run(rig()).isel(run=0)


@pytest.fixture(scope="module")
def seen(ds):
    return Seen(ds)


def close(found, wanted, tolerance=1e-12):
    size = max(1.0, float(np.abs(wanted).max()))
    np.testing.assert_allclose(np.asarray(found), wanted, rtol=0, atol=tolerance * size)


def hand(seen):
    """Position and velocity of the hand as the base sees them, along its axes."""
    (p, dp), (r, R, v, w) = seen.point("ball", HAND), seen("base")
    return back(R, p - r), back(R, dp - v - np.cross(w, p - r))


def test_points(ds, seen):
    p, v = seen.point("slider", TIP)
    close(ds["tip"], p)
    close(ds["tip0"], p)
    close(ds["tip1"], back(seen("slider")[1], v))
    place, speed = hand(seen)
    close(ds["hand"], place)
    close(ds["hand0"], back(seen("arm")[1], along(seen("base")[1], place)))
    close(ds["hand1"], back(seen("arm")[1], along(seen("base")[1], speed)))


def test_accelerations_are_the_slopes_of_velocities(ds, seen):
    close(ds["tip2"][INNER], slope(seen.point("slider", TIP)[1]), 2e-6)
    turn = np.einsum("tji,tjk->tik", seen("arm")[1], seen("base")[1])[INNER]
    close(ds["hand2"][INNER], along(turn, slope(hand(seen)[1])), 2e-6)


def test_joints(ds, seen):
    """Angles over several turns, displacements and their rates, from the states of both bodies."""
    for joint, first, second, axis in (
        ("mast", "ground", "base", [0, 0, 1]),
        ("shoulder", "base", "arm", np.array([0, 1, 0.2]) / np.hypot(1, 0.2)),
    ):
        (_, R, _, w), (_, Q, _, u) = seen(first), seen(second)
        turned = Rotation.from_matrix(np.einsum("tji,tjk->tik", R, Q)).as_rotvec() @ axis
        close(ds[f"{joint}.angle"], np.unwrap(turned), 1e-10)
        close(ds[f"{joint}.rate"], np.sum((u - w) * along(R, np.broadcast_to(axis, w.shape)), axis=1), 1e-10)
    assert np.ptp(ds["shoulder.angle"].values) > 3 * np.pi
    close(ds["mast.displacement"], 0.1 * np.sin(4 * ds.time.values), 1e-10)
    close(ds["mast.speed"], 0.4 * np.cos(4 * ds.time.values), 1e-10)
    axis = np.array([0.2, 1, 0.4]) / np.linalg.norm([0.2, 1, 0.4])
    R = seen("arm")[1]
    apart = back(R, seen("slider")[0] - seen("arm")[0]) @ axis
    close(ds["rail.displacement"], apart - apart[0], 1e-10)
    close(ds["rail.speed"][INNER], slope(apart), 1e-6)
    for absent in ("rail.angle", "rail.rate", "shoulder.displacement"):
        assert absent not in ds


def test_attitudes(ds, seen):
    (_, R, *_), (_, Q, *_) = seen("base"), seen("slider")
    goal = Rotation.from_matrix(R) * Rotation.from_rotvec(TARGET["rotation_vector"])
    e = (goal.inv() * Rotation.from_matrix(Q)).as_rotvec()
    close(ds["pointing"], e, 1e-11)
    close(ds["pointing.angle"], np.linalg.norm(e, axis=1), 1e-11)
    close(ds["tilt"], Rotation.from_matrix(R).as_rotvec(), 1e-11)
    w = seen("ball")[3]
    np.testing.assert_array_equal(ds["turning"], ds["angular_velocity"].sel(body="ball"))
    close(ds["turning_global"], w)
    close(ds["turning_seen"], back(R, w - seen("arm")[3]))


def test_momentum(ds, seen):
    def momentum(names, about):
        linear = sum(MASS[n] * seen(n)[2] for n in names)
        moments = [np.cross(seen(n)[0] - about, MASS[n] * seen(n)[2]) for n in names]
        return linear, sum(moments) + sum(along(seen(n)[1] @ INERTIA[n], back(*seen(n)[1::2])) for n in names)

    centre = sum(MASS[n] * seen(n)[0] for n in ("arm", "ball")) / (MASS["arm"] + MASS["ball"])
    for name, of, about in (
        ("swing", list(MASS), 0.0),
        ("swing_arm", ["arm", "slider"], [0.1, 0.2, -0.3]),
        ("swing_own", ["arm", "ball"], centre),
    ):
        linear, angular = momentum(of, about)
        close(ds[f"{name}.linear"], linear)
        close(ds[f"{name}.angular"], angular)


def test_reactions_and_efforts_in_their_frames(ds, seen):
    for name, joint, frame in (("load", "shoulder", "ground"), ("load1", "rail", "arm"), ("load2", "wrist", "ball")):
        for part in ("force", "torque"):
            close(ds[f"{name}.{part}"], back(seen(frame)[1], ds[f"joint_{part}"].sel(joint=joint).values))
    np.testing.assert_array_equal(ds["lifting"], ds.driver_effort.sel(effort="lift"))
    np.testing.assert_array_equal(ds["spinning"].values.T, [ds.driver_effort.sel(effort=f"spin.{c}") for c in "xyz"])


def efforts_on(name, ds, seen):
    """Force on a body, and torque about its mass centre, of reactions, drivers, forces and weight."""
    t = ds.time.values
    r, R, *_ = seen(name)
    force, torque = np.tile(MASS[name] * GRAVITY, (len(t), 1)), np.zeros((len(t), 3))
    for joint in RIG["model"]["joints"]:
        first, second = joint["bodies"]
        at = seen.point("base", [0, 0, 0])[0] if second == "base" else None
        sign = (name == second) - (name == first)
        if not sign:
            continue
        if at is None:  # the point of the second body, which was at `at` in the beginning
            s, Q, *_ = seen(second)
            at = s + Q @ (Q[0].T @ (np.array(joint["at"]) - s[0]))
        F, T = (ds[f"joint_{part}"].sel(joint=joint["name"]).values for part in ("force", "torque"))
        force, torque = force + sign * F, torque + sign * (T + np.cross(at - r, F))
    if name == "base":
        force = force + ds["lifting"].values[:, None] * [0, 0, 1]
    if name == "ball":
        torque = torque + along(R, ds["spinning"].values)
    if name == "arm":
        torque = torque + along(R, np.stack([0 * t + 0.3, -0.2 * t, 0 * t + 0.1], axis=1))
    if name == "slider":
        push = np.stack([2 * np.sin(9 * t), 0 * t, 0 * t + 1], axis=1)
        force, torque = force + push, torque + np.cross(R @ PUSH, push)
    if name in ("arm", "slider"):
        (p, dp), (q, dq) = seen.point("arm", [0, 0, 0]), seen.point("slider", [0, 0.1, 0])
        length = np.linalg.norm(q - p, axis=1)[:, None]
        along_it = (q - p) / length
        pull = (300 * (length - length[0]) + 2 * np.sum((dq - dp) * along_it, axis=1)[:, None]) * along_it
        sign, at = (1, p) if name == "arm" else (-1, q)
        force, torque = force + sign * pull, torque + np.cross(at - r, sign * pull)
    return force, torque


@pytest.mark.parametrize("name", MASS)
def test_reactions_balance_the_motion_of_every_body(name, ds, seen):
    _, R, v, w = seen(name)
    force, torque = efforts_on(name, ds, seen)
    close(force[INNER], MASS[name] * slope(v), 1e-5)
    close(torque[INNER], slope(along(R @ INERTIA[name], back(R, w))), 1e-5)


def test_momentum_grows_by_what_acts_from_outside(ds, seen):
    ground = ds.sel(joint="mast")
    outside = sum(MASS.values()) * GRAVITY + ground.joint_force.values + ds["lifting"].values[:, None] * [0, 0, 1]
    outside = outside + np.stack([2 * np.sin(9 * ds.time.values), 0 * ds.time.values, 0 * ds.time.values + 1], axis=1)
    outside = outside[INNER]
    close(slope(ds["swing.linear"].values), outside, 1e-5)


def test_expressions(ds, seen):
    p = seen.point("slider", TIP)[0]
    far = np.hypot(p[:, 0], p[:, 1]) - 0.3 * ds.time.values
    close(ds["far"], far)
    bending = np.maximum(far, 0) * ds["load.torque"].values[:, 0] + ds["lifting"].values
    close(ds["bending"], bending)


def test_dimensions_units_and_frames(ds):
    wanted = {
        "tip": ("m", "global"), "tip1": ("m s-1", "slider"), "tip2": ("m s-2", "global"), "hand": ("m", "base"),
        "hand1": ("m s-1", "arm"), "mast.angle": ("rad", None), "mast.rate": ("rad s-1", None),
        "mast.displacement": ("m", None), "rail.speed": ("m s-1", None), "pointing": ("rad", "slider"),
        "pointing.angle": ("rad", None), "turning": ("rad s-1", "ball"), "turning_seen": ("rad s-1", "base"),
        "load.force": ("N", "global"), "load1.torque": ("N m", "arm"), "load2.force": ("N", "ball"),
        "lifting": ("N", None), "spinning": ("N m", "ball"), "swing.linear": ("kg m s-1", "global"),
        "swing_own.angular": ("kg m2 s-1", "global"), "far": ("m", None), "bending": ("N m", None),
    }  # fmt: skip
    for name, (units, frame) in wanted.items():
        assert (ds[name].attrs["units"], ds[name].attrs.get("frame")) == (units, frame), name
        vector = frame is not None
        assert ds[name].dims == (("time", "axis") if vector else ("time",))
        assert ds[name].attrs["long_name"]


def test_all_are_in_the_dataset_and_no_more(ds):
    stems = {name.partition(".")[0] for name in ds.data_vars} & {q["name"] for q in QUANTITIES}
    assert stems == {q["name"] for q in QUANTITIES}
    assert ds.time[-1] == END


def test_quantities_in_the_model_and_beside_it_are_all_kept():
    tip = {"name": "tip", "type": "point", "body": "rod"}
    data = {
        "model": {"bodies": [{"name": "rod", "mass": 1.0, "inertia": [1.0, 1.0, 1.0], "position": [0, 0, 0]}],
                  "quantities": [tip]},
        "quantities": [{**tip, "name": "top"}],
        "integrator": {"step": 0.1, "end_time": 0.2},
    }  # fmt: skip
    assert {"tip", "top"} <= set(lienumba.run(data).data_vars)


def test_a_parameter_that_is_not_there_cannot_be_set():
    data = {
        "parameters": {"kp": 2.0},
        "model": {"bodies": [{"name": "rod", "mass": "kp", "inertia": [1.0, 1.0, 1.0], "position": [0, 0, 0]}]},
        "integrator": {"step": 0.1, "end_time": 0.2},
    }
    with pytest.raises(lienumba.ScenarioError) as caught:
        lienumba.run(data, overrides={"parameters.Kp": 3.0})
    assert str(caught.value) == (
        '{"parameters.Kp": 3.0}: the path parameters.Kp is no parameter of the scenario; the nearest known name is "kp"'
    )
