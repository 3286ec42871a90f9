"""The intervals of a fit hold the true values as often as they say: a pendulum that swings onto a stop."""

import numpy as np
import pytest
import xarray as xr

import lienumba

TRUE = {"parameters.friction": 0.03, "limits.stop.restitution": 0.6, "bodies.rod.inertia[1]": 0.06}
NOISE = 2e-3  # rad
REPEATS = 20
MOST_MISSED = 8  # of 60 intervals at 95 %: more are missed by chance once in 250 times


def pendulum() -> lienumba.System:
    system = lienumba.System("A pendulum on a stop")
    system.parameter("friction", TRUE["parameters.friction"])
    turned = {"axis": [0, 1, 0], "angle": 1.0}
    at = [-0.4 * np.sin(1.0), 0, -0.4 * np.cos(1.0)]
    system.body("rod", mass=1.2, inertia=[0.06, 0.06, 0.001], position=at, rotation=turned)
    points, axes = [[0, 0, 0], [0, 0, 0.4]], [[0, 1, 0], [0, 1, 0]]
    system.joint("hinge", "revolute", ["ground", "rod"], points=points, axes=axes)
    system.force("bearing", type="torsion_spring", joint="hinge", stiffness=0.0, damping="friction", free_angle=0.0)
    system.limit("hinge", name="stop", low=-1.2, restitution=TRUE["limits.stop.restitution"])
    system.quantity("swing", "joint", joint="hinge")
    system.integrator(method="dp54", tolerance=1e-8, end_time=2.0, coordinates="joint")
    system.output(every=0.2, variables=["swing"])
    return system


@pytest.mark.release
@pytest.mark.parametrize("seed", [5, 6, 7])
def test_intervals_hold_the_true_values_as_often_as_they_say(seed: int) -> None:
    ready = lienumba.prepare(pendulum())
    course: xr.DataArray = ready.run()["swing.angle"].isel(run=0)
    rng = np.random.default_rng(seed)
    missed = dict.fromkeys(TRUE, 0)
    scatters = []
    for _ in range(REPEATS):
        found = ready.fit(course + rng.normal(0.0, NOISE, course.shape), TRUE)
        assert found.success
        scatters.append(found.scatter)
        for path, (low, high) in found.intervals().items():
            missed[path] += not low <= TRUE[path] <= high
    assert sum(missed.values()) <= MOST_MISSED, missed
    assert np.sqrt(np.mean(np.square(scatters))) == pytest.approx(NOISE, rel=0.2)
