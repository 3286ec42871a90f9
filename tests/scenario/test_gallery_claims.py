"""What the comments of the gallery say happens."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.facade import resolve
from tests.rigs.places import SCENARIOS

LOAD = 60 * 9.81 * 0.2  # N m, of the hoist at its drum
LOCKED, IMPACT, CLOSED, STUCK = 0, 4, 5, 7  # kinds of change
OTHERS = {  # bodies that weigh otherwise than they are drawn
    ("suspension", "car"): "the box is the corner at which the arms hang, of a car that only goes up and down",
    ("ur5", "wrist_3_link"): "the numbers of the public URDF, with which its cylinder has nothing to do",
    ("ur5_recorded", "wrist_3_link"): "the same",
}


def ran(name: str, **overrides: Any) -> Any:
    return lienumba.run(SCENARIOS / f"{name}.toml", overrides=overrides, progress=False)


def count(ds: Any, kind: int) -> np.ndarray:
    """How many changes of this kind each run has (run,)."""
    return (ds.change_kind.values == kind).sum(axis=1)


def solid(mass: float, shape: Any) -> np.ndarray:
    """The moments of inertia about the axes of its body of a homogeneous box, sphere or cylinder (3,)."""
    if shape.type == "box":
        squares = np.square(shape.size)
        moments = mass / 12 * (squares.sum() - squares)
    elif shape.type == "sphere":
        moments = np.full(3, 0.4 * mass * shape.radius**2)
    else:
        axis = np.array([0.0, 0.0, shape.length]) if shape.ends is None else np.subtract(*shape.ends)
        along, across = mass * shape.radius**2 / 2, mass * (3 * shape.radius**2 + axis @ axis) / 12
        moments = across + (along - across) * axis**2 / (axis @ axis)
    if shape.rotation is None:
        return moments
    turn = Rotation.from_rotvec(np.array(shape.rotation.axis) * shape.rotation.angle).as_matrix()
    return np.diag(turn @ np.diag(moments) @ turn.T)


def test_bodies_weigh_as_they_are_drawn() -> None:
    """Within a factor of 2 of a homogeneous one, where a body is drawn as one box, sphere or cylinder."""
    others = set()
    for file in sorted(SCENARIOS.glob("*.toml")):
        for body in resolve(file).data.model.bodies:
            if len(body.shapes or []) == 1 and body.shapes[0].type in ("box", "sphere", "cylinder"):
                ratios = np.array(body.inertia[:3]) / solid(body.mass, body.shapes[0])
                if not ((ratios > 0.5) & (ratios < 2)).all():
                    others.add((file.stem, body.name))
    assert others == set(OTHERS)


def test_brakes_hold_the_load_or_slip_where_they_are_worn() -> None:
    ds = ran("brake")
    holds = ds["parameters.static"].values > LOAD
    assert (ds.status == 0).all()
    assert 10 < holds.sum() < 60
    np.testing.assert_array_equal(ds.last_mode.values[:, 0], np.where(holds, 1, 2))
    height = ds.position.sel(body="load", axis="z")
    assert (height.max("time") > height.isel(time=0) + 0.1).all()
    assert (ds["drum.rate"].values[~holds, -1] < -1.0).all()
    assert abs(ds["drum.rate"].values[holds, -1]).max() < 1e-12


def test_the_rope_of_the_brake_leaves_the_drum_on_the_side_that_goes_up() -> None:
    ds = ran("brake", **{"sweep.runs": 1})
    spin, lever = ds.angular_velocity.sel(body="drum"), ds.position.sel(body="load") - ds.position.sel(body="drum")
    for axis in ("x", "y"):
        lever.loc[{"axis": axis}] = lever.sel(axis=axis).isel(time=0)
    lever.loc[{"axis": "z"}] = 0.0
    surface = np.cross(spin.values, lever.values)
    np.testing.assert_allclose(surface, ds.velocity.sel(body="load").values, rtol=0, atol=1e-12)


def test_the_probe_is_captured_wherever_it_comes_near_enough() -> None:
    ds = ran("docking")
    assert (ds.status == 0).all()
    t = np.arange(0.0, 20.0, 1e-3)
    speed, aside, turning = (
        ds[f"bodies.chaser.{path}"].values[:, None]
        for path in ("velocity[0]", "position[1]", "angular_velocity[2]")
    )  # fmt: skip
    gap = np.hypot(speed * t - 1.5 + np.cos(turning * t), aside + np.sin(turning * t))
    near = gap.min(axis=1) < 0.02  # on a straight line, turning evenly about z, but for products of inertia
    event = dict(zip(ds.event.values, ds.event_time.values.T, strict=True))
    captured, missed = np.isfinite(event["captured"]), np.isfinite(event["missed"])
    np.testing.assert_array_equal(captured, near)
    np.testing.assert_array_equal(missed, ~near)
    assert 2 <= missed.sum() <= 12
    assert (event["docked"][captured] >= event["captured"][captured]).all()
    np.testing.assert_array_equal(event["attenuates"], event["captured"])
    assert (ds.velocity.sel(body="chaser", axis="x").values[missed, -1] < -0.03).all()
    assert (ds.position.sel(body="chaser", axis="x").values[missed].max(axis=1) < -0.9).all()  # not into the target
    P, L = ds["momentum.linear"].values, ds["momentum.angular"].values
    np.testing.assert_allclose(P[captured], np.broadcast_to(P[captured, :1], P[captured].shape), rtol=0, atol=1e-10)
    for run in np.flatnonzero(captured):
        before, after = ds.time.values < event["captured"][run], ds.time.values > event["captured"][run]
        for part in (before, after):
            assert np.ptp(L[run, part], axis=0).max() < 1e-9
        still = ds.angular_velocity.sel(body="target").values[run, before]
        assert abs(still).max() == 0.0  # nothing acts on it from afar
    assert (ds["askew.angle"].values[captured, -1] < 2e-3).all()
    blows = ds.change_impulse.values[captured, 0]
    assert np.corrcoef(blows, speed[captured, 0])[0, 1] > 0.99


def test_the_door_rests_ajar_or_is_latched_and_slams_where_it_is_fast() -> None:
    ds = ran("door_closer")
    assert (ds.status == 0).all()
    order = np.argsort(ds["forces.closer.stiffness"].values)
    latched, slams = np.isfinite(ds.event_time.values[order, 0]), count(ds, IMPACT)[order]
    degrees = np.degrees(ds["door.angle"].values[order])
    assert 4 <= (~latched).sum() <= 20
    assert not latched[: (~latched).sum()].any()  # the weakest closers
    assert ((degrees[~latched, -1] > 0.8) & (degrees[~latched, -1] < 2)).all()
    assert (degrees[latched, -1] < 0.2 + 1e-9).all()
    assert (slams[latched] == 0).sum() >= 5
    assert (np.diff(slams) >= 0).all()
    bounced = [run for run in range(64) if slams[run] > 1]
    assert len(bounced) >= 5
    for run in bounced:  # off the frame, and back
        struck = ds.change_time.values[order[run], 0]
        assert degrees[run, ds.time.values > struck].max() > 2
    assert abs(ds.energy_residual).max() < 2e-5


def test_the_ball_bounces_then_slides_then_rolls() -> None:
    ds = ran("bouncing_ball")
    assert (ds.status == 0).all()
    assert (count(ds, IMPACT) >= 3).all()
    for kind in (CLOSED, STUCK):
        np.testing.assert_array_equal(count(ds, kind), 1)
    mode = ds["mode"].values[:, :, 0]
    assert ((mode == 2).sum(axis=1) >= 10).all()  # it slides
    assert (mode[:, -1] == 1).all()
    r, mass, inertia = 0.12, 0.6, 0.0058
    v, w = ds.velocity.sel(body="ball", axis="x").values, ds.angular_velocity.sel(body="ball").values
    spin = np.einsum("rtij,rtj->rti", ds.rotation.sel(body="ball").values, w)[:, :, 1]  # about the global y
    np.testing.assert_allclose(v[:, -1], r * spin[:, -1], rtol=0, atol=1e-9)
    # Whatever friction does, it acts at the floor: the angular momentum about it stays.
    final = (mass * r * v[:, 0] + inertia * spin[:, 0]) / (mass * r + inertia / r)
    np.testing.assert_allclose(v[:, -1], final, rtol=0, atol=1e-8)
    assert 5 < (final < 0).sum() < 32  # back to where it came from
    assert (ds.work.values[:, -1] < -ds.energy_lost.values - 0.01).all()  # friction takes some beside the impacts
    falls = ds.change_time.values[:, :3]
    e = ds["contacts.floor.restitution"].values
    np.testing.assert_allclose((falls[:, 2] - falls[:, 1]) / (falls[:, 1] - falls[:, 0]), e, rtol=1e-8)


def test_the_rod_slides_on_and_how_far_is_up_to_friction() -> None:
    ds = ran("falling_rod")
    assert (ds.status == 0).all()
    assert ((ds["mode"].values == 2).any(axis=2).sum(axis=1) >= 5).all()
    assert (ds.last_mode.values[:, :2] == 1).all()
    end = ds.position.sel(body="rod", axis="x").values[:, -1]
    assert np.corrcoef(end, ds["contacts.floor.friction.kinetic"].values)[0, 1] < -0.9
    assert abs(ds.velocity.values[:, -1]).max() < 1e-12


def test_panels_are_plates_that_latch_in_other_orders_and_fold_no_further_than_packed() -> None:
    for body in resolve(SCENARIOS / "solar_array.toml").data.model.bodies[1:]:
        np.testing.assert_allclose(body.inertia[:3], solid(body.mass, body.shapes[0]), rtol=0.15)
    ds = ran("solar_array")
    assert (ds.status == 0).all()
    times = ds.event_time.values
    assert np.isfinite(times).all()
    assert len({tuple(np.argsort(run)) for run in times}) >= 10
    assert len(set(np.argmax(times, axis=1))) >= 4
    for hinge in range(1, 7):
        angle, first = ds[f"at_{hinge}.angle"].values, np.radians(90 if hinge == 1 else 178)
        assert abs(angle).max() < first + 1e-9
        assert abs(angle[:, -1]).max() < 1e-9
        assert (angle * (-1) ** hinge).max() < 1e-9  # on one side: none passes flat
    assert abs(ds["momentum.linear"]).max() < 1e-6
    assert abs(ds["momentum.angular"]).max() < 1e-6
    assert (count(ds, LOCKED) >= 5).all()
    assert int(ds.changes.max()) <= ds.sizes["change"]
    place, turn = ds.position.values, ds.rotation.values
    for panel in range(1, 7):  # no panel swings into the satellite
        for along in np.linspace(-0.48, 0.48, 13):
            point = place[:, :, panel] + along * turn[:, :, panel, :, 0] - place[:, :, 0]
            seen = np.einsum("rtji,rtj->rti", turn[:, :, 0], point)
            assert (abs(seen[:, :, :2]).max(axis=2) > 0.6 - 1e-6).all()


def test_without_winds_the_dish_droops_and_the_encoders_scatter_it() -> None:
    still = {"noise.gust.std": 0.0, "noise.sideways.std": 0.0, "sweep.runs": 24}
    ds = ran("dish_in_gusts", **still)
    late = ds.time.values > 8
    miss = 1e3 * ds.miss.values[:, late]  # mrad
    assert miss.mean() == pytest.approx(3.4, abs=0.1)
    assert 0.1 < miss.std() < 0.3


def test_the_arm_rests_off_its_targets() -> None:
    ds = ran("arm_pd")
    shoulder, elbow = (ds[f"{joint}_angle.angle"].values[:, -1] for joint in ("shoulder", "elbow"))
    assert (shoulder > -0.8).all()  # short of it
    assert (elbow > 1.2).all()  # past it


def test_the_tip_off_rates_depend_on_all_bolts_alike() -> None:
    ds = ran("hold_down")
    assert (ds.status == 0).all()
    rates = ds.angular_velocity.values[:, -1, 0, :2]
    times = ds.event_time.values
    found = np.linalg.lstsq(times - times.mean(axis=0), rates - rates.mean(axis=0), rcond=None)[0]
    sizes = np.linalg.norm(found, axis=1)
    assert sizes.max() < 1.5 * sizes.min()
