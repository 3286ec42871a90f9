"""What touches, what is at rest and which rebound is none depend on no unit: the same mechanism in mm, m and km."""

import math
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.closed_forms import bouncing
from tests.rigs import parts

G, E = 9.81, 0.5
LENGTHS = np.array([1e-6, 1e-3, 1.0, 1e3])
TIMES = np.sqrt(LENGTHS)


@pytest.fixture(scope="module")
def datasets() -> list[Any]:
    """A ball that spins, dropped on a plane; lengths as above, times as their roots, masses as their cubes."""
    found = []
    for length, time in zip(LENGTHS, TIMES, strict=True):
        data = scenarios.ball(0.1 * length, 0.004 * length**5, 1.7 * time)
        del data["model"]["contacts"][0]["rest_speed"]
        change = {"mass": length**3, "position": [0, 0, 1.1 * length], "velocity": [length / time, 0, 0]}
        data["model"]["bodies"][0] |= change | {"angular_velocity": [0, 3 / time, 0]}
        absolute = {"position": length, "velocity": length / time, "angular_velocity": 1 / time, "state": length**4}
        within = {kind: 1e-12 * size for kind, size in absolute.items()}
        data["integrator"]["tolerance"] = {"relative": 1e-12, "absolute": within}
        data["output"]["max_changes"] = 20
        found.append(lienumba.run(data).isel(run=0))
    return found


def test_bounces_are_the_same_in_all_units(datasets: list[Any]) -> None:
    for ds, time in zip(datasets, TIMES, strict=True):
        assert int(ds.status) == 0
        np.testing.assert_array_equal(ds.change_kind, datasets[2].change_kind)
        np.testing.assert_allclose(ds.change_time / time, datasets[2].change_time, rtol=1e-9)
        assert float(ds.position[-1, 0, 0]) / time**2 == pytest.approx(float(datasets[2].position[-1, 0, 0]), rel=1e-9)


def test_a_rebound_ends_that_would_rise_by_half_a_millionth_of_the_ball(datasets: list[Any]) -> None:
    size = math.sqrt(6 * 3 * 0.004)
    known = bouncing(1.0, E, 1e-3 * math.sqrt(G * size))
    impacts = scenarios.kinds(datasets[2], "impact")
    np.testing.assert_allclose(datasets[2].change_time.values[impacts], known.times, rtol=0, atol=1e-12)


def test_a_mass_changes_no_motion() -> None:
    """A body that is dropped on three balls, rocks and slides to rest: forces have another unit than gaps and rates."""
    masses = np.array([1.0, 1e-6, 1e3, 1e6, 1e9])
    feet = [[0.5, 0.1, -0.1], [-0.5, 0.1, -0.1], [0, -0.2, -0.1]]
    contacts = [parts.sphere(f"foot_{i}", "block", 0.05, p, restitution=0.4, friction=0.3) for i, p in enumerate(feet)]
    turn = {"axis": [0, 1, 0], "angle": 0.2}
    body = parts.resting("block", 1, 0.05, [0, 0, 0.3], velocity=[0.3, 0, 0], rotation=turn)
    columns = {"bodies.block.mass": masses.tolist()}
    columns |= {f"bodies.block.inertia[{i}]": (0.05 * masses).tolist() for i in range(3)}
    ds = lienumba.run({
        "title": "Masses",
        "model": {"gravity": [0, 0, -G], "bodies": [body], "contacts": contacts},
        "integrator": scenarios.settings(1.5, 1e-10), "output": {"every": 0.25, "max_changes": 80},
        "sweep": scenarios.table(columns),
    })  # fmt: skip
    assert (ds.status == 0).all()
    assert (ds.changes == ds.changes[0]).all()
    assert ds.changes[0] > 30
    np.testing.assert_array_equal(ds.change_kind, np.broadcast_to(ds.change_kind[0], ds.change_kind.shape))
    np.testing.assert_allclose(ds.position, np.broadcast_to(ds.position[0], ds.position.shape), rtol=0, atol=1e-9)
    assert (abs(ds.energy_residual).max("time") < 1e-9 * masses).all()
