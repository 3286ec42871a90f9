"""Parameters that events set: a pendulum whose spring becomes stiffer on the way, against SciPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba

MASS, ARM, INERTIA, GRAVITY = 1.0, 0.5, 0.02, 9.81
TIMES = np.linspace(0.0, 1.0, 11)


def wound(coordinates: str) -> lienumba.System:
    system = lienumba.System("A pendulum whose spring is wound")
    system.body("bob", mass=MASS, inertia=[INERTIA] * 3)
    system.joint("hinge", "revolute", [system.ground, "bob"], points=[[0, 0, 0], [0, 0, ARM]], axes=[[0, 1, 0]] * 2,
                 references=[[1, 0, 0]] * 2, angle=0.5)  # fmt: skip
    system.parameter("k", 1.0).parameter("a", 1.0).parameter("b", 1.0).parameter("c", 7.0)
    system.parameter("twice", "2*k*a*b*c")
    system.force("spring", type="torsion_spring", joint="hinge", stiffness="twice")
    system.quantity("hinge", "joint", joint="hinge")
    system.event("wind", "hinge.angle < 0.1", "set", parameters={"k": "3*k", "a": 2, "b": 4, "c": 0.125}, once=True)
    system.event("ease", "t > 0.6", "set", parameters={"k": 1.0})
    system.event("too", "t > 0.6", "set", parameters={"a": "b/4"})  # at the same time
    system.event("begin", "t >= 0", "set", parameters={"c": 1.0})
    return system.integrator(method="dop853", tolerance=1e-11, end_time=1.0, coordinates=coordinates).output(every=0.1)


def exact() -> np.ndarray:
    """The angle at TIMES, piece by piece."""

    def rates(k: float):
        return lambda t, y: [y[1], -(GRAVITY * MASS * ARM * np.sin(y[0]) + 2 * k * y[0]) / (INERTIA + MASS * ARM**2)]

    def winds(t, y):
        return y[0] - 0.1

    winds.terminal = True
    given = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "dense_output": True}
    first = solve_ivp(rates(1.0), (0, 1), [0.5, 0.0], events=winds, **given)
    second = solve_ivp(rates(3.0), (first.t[-1], 0.6), first.y[:, -1], **given)
    third = solve_ivp(rates(0.5), (0.6, 1.0), second.y[:, -1], **given)
    pieces = ((first.t[-1], first), (0.6, second), (1.0, third))
    return np.array([next(piece for end, piece in pieces if t <= end).sol(t)[0] for t in TIMES])


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_motion_and_energy(coordinates: str) -> None:
    ds = lienumba.run(wound(coordinates))
    np.testing.assert_allclose(ds["hinge.angle"][0], exact(), atol=1e-9)
    assert ds.event_count.sel(event="ease").values.tolist() == [1]
    times, energy = ds.event_time.values[0], ds.energy.values[0]
    before, wound_, eased = (ds.time < times[0]), (ds.time > times[0]) & (ds.time < 0.6), ds.time > 0.6
    for some in (before, wound_, eased):  # a set number changes the energy of a spring at once, and nothing else does
        assert np.ptp(energy[some]) < 1e-10
    assert ds.work.values[0, 0] == 0.0
    np.testing.assert_allclose(energy[wound_][0] - energy[0], 2 * 0.1**2, atol=1e-9)  # k c^2 by (3 - 1)
    assert abs(ds.energy_residual).max() < 1e-10
