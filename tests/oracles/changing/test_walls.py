"""A block on three rough feet beside a smooth wall, pressed to it and drawn away: the feet hold it, too, and the wall
only pushes."""

import numpy as np
import pytest

import lienumba

MU = 0.9
FEET = ([0.2, 0.2, -0.1], [0.2, -0.2, -0.1], [-0.2, 0.0, -0.1])


def block() -> lienumba.System:
    system = lienumba.System("block")
    system.parameter("swing", 1.0).parameter("mean", 0.0)
    system.body("block", mass=1.0, inertia=[0.1, 0.1, 0.1], position=[0, 0, 0.1])
    for n, foot in enumerate(FEET):
        points = [foot, [0, 0, 0]]
        system.contact(f"foot{n}", "point_plane", ["block", "ground"], points=points, normal=[0, 0, 1], friction=MU)
        system.quantity(f"foot{n}_at", "contact", contact=f"foot{n}")
    points = [FEET[2], FEET[2]]
    system.contact("wall", "point_plane", ["block", "ground"], points=points, normal=[1, 0, 0])
    system.quantity("wall_at", "contact", contact="wall")
    system.force("load", type="force", body="block", value=["swing*sin(3*t) + mean", 0, 0], point=[0, 0, -0.1])
    return system.output(every=0.05).sweep(runs=32, seed=5)


@pytest.mark.parametrize("integrator", [{"method": "dop853", "tolerance": 1e-9, "max_step": 0.05}, {"step": 1e-3}])
def test_a_wall_only_pushes_what_feet_hold(integrator: dict[str, object]) -> None:
    system = block().integrator(end_time=3.0, **integrator)
    system.vary("parameters.swing", "uniform", low=0.5, high=2.0).vary("parameters.mean", "uniform", low=-1, high=1)
    ds = lienumba.run(system, progress=False)
    assert (ds.status == 0).all()
    np.testing.assert_allclose(
        ds.position.values[:, :, 0], np.broadcast_to([0, 0, 0.1], ds.position.shape[:2] + (3,)), atol=1e-12
    )
    wall, feet = ds["wall_at.normal"], [ds[f"foot{n}_at.friction"] for n in range(3)]
    assert float(wall.min()) >= 0.0
    assert float(wall.max()) > 0.1
    load = ds["parameters.swing"] * np.sin(3.0 * ds.time) + ds["parameters.mean"]
    held = sum(foot.values for foot in feet)  # all along the load, of which the wall takes what presses at most
    assert (held + wall.values >= np.abs(load.values) - 1e-9).all()
