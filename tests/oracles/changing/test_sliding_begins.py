"""Sliding that begins, by explicit steps of given length: across its direction it is stiff as long as it is slow."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba

G, SLOPE = 9.81, 0.5
FEET = ((0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5))


def box(load: tuple[str | float, str | float], feet: tuple[tuple[float, float], ...]) -> lienumba.System:
    """On rough feet at the height of its mass centre, so that each carries the same all the time."""
    system = lienumba.System("box")
    system.parameter("mu", 0.5)
    system.body("box", mass=2.0, inertia=[0.1, 0.1, 0.1], position=[0, 0, 0])
    for n, (x, y) in enumerate(feet):
        points = [[x, y, 0], [0, 0, 0]]
        system.contact(f"foot{n}", "point_plane", ["box", "ground"], points=points, normal=[0, 0, 1], friction="mu")
    system.force("load", type="force", body="box", value=[*load, 0])
    return system.output(every=0.05)


@pytest.mark.parametrize("step", [2e-3, 1e-3])
@pytest.mark.parametrize("changes", [False, True], ids=["alone", "beside other changes"])
def test_a_box_slides_straight_down_a_slope(step: float, changes: bool) -> None:
    """Where friction nearly holds it, it is slow for long, and rounding across the sliding grew to centimetres."""
    weight = 2.0 * G
    system = box((weight * np.sin(SLOPE), 0.0), FEET).sweep(runs=8, seed=3)
    system.gravity = [0, 0, -G * float(np.cos(SLOPE))]
    system.vary("parameters.mu", "uniform", low=0.45, high=0.545).integrator(step=step, end_time=1.0)
    if changes:
        system.parameter("aside", 0.0).force("more", type="force", body="box", value=[0, 0, "aside*0"])
        for n in range(1, 4):
            system.event(f"set{n}", when=f"t > {0.0031 * n}", action="set", parameters={"aside": float(n)})
    ds = lienumba.run(system, progress=False)
    assert (ds.status == 0).all()
    faster = G * (np.sin(SLOPE) - ds["parameters.mu"].values * np.cos(SLOPE))
    expected = faster[:, None] * ds.time.values**2 / 2
    np.testing.assert_allclose(ds.position.values[:, :, 0, 0], expected, atol=1e-9)
    np.testing.assert_allclose(ds.position.values[:, :, 0, 1], 0.0, atol=1e-9)


def pushed_round(mu: float, times: np.ndarray) -> np.ndarray:
    """Where it is (n, 2): in minimal coordinates, from when the push reaches the limit of friction on."""
    limit = mu * G

    def push(t: float) -> np.ndarray:
        return np.array([PUSH * t * np.cos(2.0 * t), PUSH * t * np.sin(2.0 * t)])

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[2:], push(t) - limit * y[2:] / np.hypot(*y[2:])])

    begin = limit / PUSH
    start = np.concatenate([np.zeros(2), 1e-8 * push(begin) / limit])
    found = solve_ivp(rates, (begin, times[-1]), start, "Radau", t_eval=times[times > begin], rtol=1e-10, atol=1e-12)
    return np.concatenate([np.zeros((int((times <= begin).sum()), 2)), found.y[:2].T])


PUSH = 19.62  # m/s^3


def test_where_the_push_turns_sliding_follows_to_second_order() -> None:
    errors = []
    for step in (2e-3, 1e-3):
        system = box((f"{2 * PUSH}*t*cos(2*t)", f"{2 * PUSH}*t*sin(2*t)"), FEET).sweep(runs=8, seed=3)
        system.vary("parameters.mu", "uniform", low=0.3, high=0.55).integrator(step=step, end_time=0.6)
        ds = lienumba.run(system, progress=False)
        assert (ds.status == 0).all()
        expected = [pushed_round(float(mu), ds.time.values) for mu in ds["parameters.mu"]]
        errors.append(np.abs(ds.position.values[:, :, 0, :2] - expected).max(axis=(1, 2)))
        assert errors[-1].max() < 60.0 * step**2
    assert np.median(np.log2(errors[0] / errors[1])) == pytest.approx(2.0, abs=0.2)
