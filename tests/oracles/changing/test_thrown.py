"""What is thrown gains no energy by friction or impacts, and sinks nowhere: one body, few points, many ways."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import lienumba
from lienumba.mechanics.system.switched import turning
from tests.oracles.changing import scenarios
from tests.rigs import parts

G = 9.81


def thrown(points: list[Any], inertia: list[float], end: float, mass: float = 1.0, **contact: Any) -> dict[str, Any]:
    """A body whose points may touch a floor; its state is for a sweep to vary."""
    body = parts.resting("b", mass, inertia)
    model = {"gravity": [0, 0, -G], "bodies": [body], "contacts": parts.feet("b", points, **contact)}
    output = {"every": end / 60, "variables": ["position", "rotation", "energy", "velocity", "angular_velocity"]}
    return {"model": model, "integrator": scenarios.settings(end, 1e-9), "output": output}


def varied(data: dict[str, Any], **columns: Any) -> Any:
    """position=(n, 3) and so on, of the body."""
    table = {f"bodies.b.{key}[{i}]": x for key, of in columns.items() for i, x in enumerate(np.array(of).T.tolist())}
    return lienumba.run(data | {"sweep": scenarios.table(table)}, progress=False)


def lowest(ds: Any, points: list[Any]) -> Any:
    """Of all points at all times (m)."""
    R, x = ds.rotation.values[:, :, 0], ds.position.values[:, :, 0]
    return min((x[..., 2] + (R @ np.array(p))[..., 2]).min() for p in points)


@pytest.mark.parametrize(("friction", "end"), [(1.2, 0.008), (1.5, 0.012)])
def test_a_corner_that_begins_to_slide_does_so_against_its_friction(friction: float, end: float) -> None:
    """Pressed ever less, it reaches the limit of its friction. Whatever rounding has left of its speed, and wherever
    that points, it slides where it would be pushed without friction: elsewhere friction would push it on."""
    p, w = np.array([0.082, -0.056, 0.055]), np.array([10.1, 0.32, 0.19])
    q = np.array([-0.0742, -0.4777, 0.8641, 0.1402])
    q /= np.linalg.norm(q)
    a, u = q[0], q[1:]
    turn = lambda v: v + 2 * np.cross(u, np.cross(u, v) + a * v)  # noqa: E731
    angles = np.arange(9) * math.pi / 4
    left = 1e-10 * np.array([np.cos(angles), np.sin(angles), 0 * angles]).T * (angles < 6.0)[:, None]
    data = thrown([p.tolist()], [3.0e-4, 4.8e-4, 4.8e-4], end, 0.147, friction=friction)
    start = {"rotation": q, "angular_velocity": w, "position": -turn(p)}
    data["model"]["bodies"][0] |= {key: x.tolist() for key, x in start.items()}
    ds = varied(data, velocity=left - turn(np.cross(w, p)))
    assert (ds.status == 0).all()
    assert (scenarios.kinds(ds, "slid").sum(axis=1) == 1).all()
    energy = ds.energy.values
    assert np.diff(energy).max() < 1e-12
    assert (energy[:, 0] - energy[:, -1] > 1e-7).all()
    np.testing.assert_allclose(ds.position.values[:, -1], ds.position.values[-1:, -1].repeat(9, axis=0), atol=1e-9)


@pytest.mark.filterwarnings("ignore:.*feeds energy in", "ignore:.*nothing uses it")
@pytest.mark.parametrize(("coulomb", "sets"), [("0.5 - t", None), ("c", {"c": -1.0}), ("c", {"c": "-t"})])
def test_friction_that_becomes_negative_ends_a_run(coulomb: str, sets: dict[str, Any] | None) -> None:
    """It went on as a success, faster and faster."""
    rail = parts.slide("r", "b", displacement=0.0, speed=2.0)
    brake = {"type": "friction", "joint": "r", "coulomb": coulomb, "static": 0.6}
    for integrator in ({"tolerance": 1e-8}, {"method": "rk4", "step": 0.01}):
        ds = lienumba.run(
            {
                "parameters": {"c": 0.5},
                "model": {"bodies": [parts.body("b", 1.0, 1)], "joints": [rail], "forces": [brake]},
                "events": [{"name": "e", "when": "t > 0.6", "action": "set", "parameters": sets}] if sets else [],
                "integrator": integrator | {"end_time": 1.5},
            }
        )  # fmt: skip
        assert scenarios.statuses(ds) == ["friction_energy_gain"]
        assert 0.5 < float(ds.end_time[0]) < 1.0


def test_a_run_in_which_friction_pushes_does_not_succeed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Made up: nothing is known that slides along its friction."""
    data = thrown([[0, 0, 0]], [0.1, 0.1, 0.1], 0.3, friction=0.25)
    data["model"]["bodies"][0]["velocity"] = [1, 0, 0]
    assert (lienumba.run(data, progress=False).status == 0).all()
    data["model"]["gravity"] = [0.1, 0, -G]  # another program
    monkeypatch.setattr(turning, "friction_speeds", lambda model, now, mu: [1e-5])
    ds = lienumba.run(data, progress=False)
    assert scenarios.statuses(ds) == ["friction_energy_gain"]
    assert np.isnan(ds.energy.values[0, -1])


def planar(px: float, pz: float, mu: float, e: float, vt: float, J: float = 0.05) -> tuple[Any, float]:
    """Rates along normal and tangent after an impact with the rates -1 and vt, of a body of 1 kg whose point (px, pz)
    is hit; and how much energy that gives (J)."""
    S = np.array([[1 + px * px / J, -px * pz / J], [-px * pz / J, 1 + pz * pz / J]])
    r = np.array([-1.0, vt])
    x = np.linalg.solve(S, [1 + e, -vt])
    if not abs(x[1]) <= mu * x[0]:
        for sign in (1, -1):
            normal = (1 + e) / (S[0, 0] - mu * sign * S[0, 1])
            y = np.array([normal, -sign * mu * normal])
            x = y if normal > 0 and sign * (r + S @ y)[1] > 0 else x
    return r + S @ x, float(x @ (2 * r + S @ x)) / 2


def test_restitution_is_as_much_as_energy_allows() -> None:
    """Kane's paradox: friction stops or turns the sliding, and what Newton's rule gives back would be more than there
    was. Less comes back, up to where no energy is gained; where none is, the rule is Newton's."""
    cases = [(0.29, -0.37, -0.6), (-0.37, 0.39, -0.8), (0.36, -0.38, -0.9), (0.1, 0.3, 2.0), (0.3, -0.35, -0.7)]
    inertia, e, mu = 0.05, 0.9, 0.9
    lessened = 0
    for px, pz, vt in cases:
        data = thrown([[px, 0, pz]], [inertia] * 3, 1e-3, friction=mu, restitution=e)
        data["model"]["bodies"][0] |= {"position": [-px, 0, -pz], "velocity": [vt, 0, -1]}
        run = lienumba.run(data, progress=False).isel(run=0)
        least, gain = e, lambda part, px=px, pz=pz, vt=vt: planar(px, pz, mu, part, vt)[1]
        if gain(e) > 0:
            least, lessened = brentq(gain, 0.0, e, xtol=1e-14), lessened + 1
        after, gained = planar(px, pz, mu, least, vt)
        v, w = run.velocity.values[0, 0], run.angular_velocity.values[0, 0]
        np.testing.assert_allclose([v[2] - w[1] * px, v[0] + w[1] * pz], after, atol=1e-10)
        assert float(run.change_energy[0]) == pytest.approx(-gained, abs=1e-11)
    assert lessened >= 3


def test_what_rocks_ever_less_comes_to_rest_and_does_not_sink() -> None:
    """A gap that is noise beside one large force is none beside the next, smaller one."""
    feet = [[-0.08, 0, -0.1], [0.08, 0, -0.1]]
    data = thrown(feet, [0.005, 0.006, 0.004], 1.5, friction=0.9, restitution=0.85)
    data["model"]["bodies"][0]["position"] = [0, 0, 0.11]
    data["integrator"]["tolerance"] = 1e-8
    ds = varied(data, angular_velocity=np.linspace(0.05, 1.0, 64)[:, None] * [[0, 1, 0]])
    assert (ds.status == 0).all()
    assert lowest(ds, feet) > -1e-8
    assert (ds.last_mode == 1).all()
