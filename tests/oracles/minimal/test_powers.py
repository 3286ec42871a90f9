"""Forces that are powers of what may be 0, such as Hertz's, wherever they begin: against SciPy and closed forms."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.rigs import parts

G, K, DROP = 9.81, 1e4, 0.1
METHODS = {
    "dop853": {"tolerance": 1e-11},
    "radau5": {"tolerance": 1e-10},
    "radau9": {"tolerance": 1e-11},
    "taylor": {"tolerance": 1e-11},
    "generalized_alpha": {"step": 1e-4},
}
EXACT = {"generalized_alpha": 1e-4}


def slide(force: str, **more: Any) -> dict[str, Any]:
    """1 kg on a vertical slide, from 0 m."""
    return {
        "model": {
            "gravity": [0, 0, -G],
            "bodies": [parts.body("ball", 1.0, position=[0, 0, 0])],
            "joints": [parts.joint("s", "prismatic", "ball", at=[0, 0, 0], axis=[0, 0, 1])],
            "quantities": [{"name": "q", "type": "joint", "joint": "s"}],
            "forces": [{"type": "actuator", "joint": "s", "value": force}],
        },
        **more,
    }


def fallen(n: float, end: float) -> float:
    def f(t: float, y: Any) -> list[float]:
        return [y[1], -G + K * max(-DROP - y[0], 0.0) ** n * (1.0 - 0.1 * y[1])]

    touches = np.sqrt(2 * DROP / G)
    start = [-DROP, -G * touches]
    left, t = start, touches
    while t < end:  # from bend to bend

        def passes(t: float, y: Any) -> float:
            return float(y[0] + DROP)

        passes.terminal = True  # type: ignore[attr-defined]
        passes.direction = 1.0 if left[1] < 0 else -1.0  # type: ignore[attr-defined]
        found = solve_ivp(f, (t, end), left, method="DOP853", rtol=1e-13, atol=1e-14, events=passes)
        t, left = found.t[-1], found.y[:, -1]
    return float(left[0])


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("exponent", ["1.5", "n", "2.2"])
def test_what_falls_on_a_spring_of_hertz(method: str, coordinates: str, exponent: str) -> None:
    """The spring is 0 until it touches: so is what its force changes by, with an exponent that is swept, too."""
    n = 1.5 if exponent == "n" else float(exponent)
    force = f"{K}*max({-DROP} - q.displacement, 0)**{exponent}*(1 - 0.1*q.speed)"
    settings = {"method": method, **METHODS[method], "end_time": 0.4, "coordinates": coordinates}
    more: dict[str, Any] = {"integrator": settings}
    if exponent == "n":
        more["parameters"] = {"n": 1.5}
        more["sweep"] = {"runs": 3, "vary": {"parameters.n": {"distribution": "uniform", "low": 1.3, "high": 1.9}}}
    ds = lienumba.run(slide(force, **more), progress=False)
    exponents = ds["parameters.n"].values if exponent == "n" else [n]
    assert (ds.status == 0).all()
    expected = [fallen(float(x), 0.4) for x in exponents]
    np.testing.assert_allclose(ds.position.values[:, -1, 0, 2], expected, atol=EXACT.get(method, 1e-8))


@pytest.mark.parametrize("n", [0.7, 1.5, 2.5])
def test_rest_and_modes_on_it(n: float) -> None:
    """m g = k d^n, and a stiffness of n k d^(n-1), from above and from a start on it."""
    force = f"{K}*max({-DROP} - q.displacement, 0)**{n} - 5*q.speed"
    more = {"integrator": {"method": "radau5", "tolerance": 1e-9, "end_time": 1.0}}
    found = lienumba.equilibrium(slide(force, **more))
    deep = (G / K) ** (1.0 / n)
    assert found.status.item() == 0
    assert found.position.values[0, 0, 2] == pytest.approx(-DROP - deep, abs=1e-12)
    modes = lienumba.modes(slide(force, **more, start={"from": "equilibrium"}))
    square = n * K * deep ** (n - 1.0)
    s = np.roots([1.0, 5.0, square])
    np.testing.assert_allclose(
        np.sort_complex((modes.growth + 1j * modes.angular_frequency).values.ravel()),
        np.sort_complex(s[s.imag >= 0]),
        rtol=1e-8,
    )


@pytest.mark.parametrize(("n", "soft", "status"), [(1.5, 2.0, 0), (1.5, -2.0, 2), (2.5, 2.0, 0), (2.5, -2.0, 2)])
def test_rest_exactly_where_it_begins(n: float, soft: float, status: int) -> None:
    """There its stiffness is 0, and what is beside it decides."""
    force = f"{G} - {K}*abs(q.displacement)**{n}*sign(q.displacement) - {soft}*q.displacement - q.speed"
    found = lienumba.equilibrium(slide(force, integrator={"method": "radau5", "tolerance": 1e-9, "end_time": 1.0}))
    assert found.status.item() == status
    assert found.position.values[0, 0, 2] == 0.0
    if status == 2:
        assert found.growth.item() == pytest.approx(-0.5 + np.sqrt(0.25 - soft), rel=1e-9)


@pytest.mark.parametrize("method", ["dop853", "radau5", "taylor"])
@pytest.mark.parametrize("law", ["atan2(q.speed, abs(q.displacement) + 0.5)", "hypot(q.displacement, q.speed)",
                                 "atan2(q.displacement**3, q.speed**2)", "abs(q.speed)**1.2"])  # fmt: skip
def test_what_begins_where_an_angle_or_a_length_is_0(method: str, law: str) -> None:
    """As the slip of a wheel at rest, which has no angle, nor a derivative there."""
    force = f"{G} + 0.3*sin(3*t) - 2*q.displacement - {law}"
    settings = {"method": method, "tolerance": 1e-10, "end_time": 1.5}
    ds = lienumba.run(slide(force, integrator=settings, output={"every": 1.5}), progress=False)
    names = {"atan2": np.arctan2, "hypot": np.hypot, "abs": abs}

    def f(t: float, y: Any) -> list[float]:
        known = law.replace("q.displacement", "y[0]").replace("q.speed", "y[1]")
        return [y[1], 0.3 * np.sin(3 * t) - 2 * y[0] - eval(known, {"y": y}, names)]

    expected = solve_ivp(f, (0.0, 1.5), [0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13).y[0, -1]
    assert ds.status.item() == 0
    assert ds.position.values[0, -1, 0, 2] == pytest.approx(expected, abs=1e-7)
    rest = {**slide(f"{G} - 2*q.displacement - {law}"), "integrator": settings}
    assert lienumba.equilibrium(rest).status.item() in (0, 3)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_spring_without_free_length_between_points_that_coincide(method: str) -> None:
    """It has no direction there, but its stiffness, in all of them."""
    spring = {"type": "spring_damper", "bodies": ["ground", "ball"], "points": [[1, 2, 3], [0, 0, 0]],
              "stiffness": 40.0, "free_length": 0.0}  # fmt: skip
    ball = {"name": "ball", "mass": 2.0, "inertia": [0.1, 0.2, 0.3], "position": [1, 2, 3]}
    settings = {"method": method, "tolerance": 1e-10, "end_time": 1.0}
    model: dict[str, Any] = {"gravity": [0, 0, 0], "bodies": [ball], "forces": [spring]}
    found = lienumba.equilibrium({"model": model, "integrator": settings})
    modes = lienumba.modes({"model": model, "integrator": settings})
    assert found.status.item() == 0  # it may turn
    w = np.sqrt(40.0 / 2.0)
    np.testing.assert_allclose(modes.angular_frequency.values.ravel(), [0, 0, 0, w, w, w], rtol=1e-12, atol=1e-12)
    model["bodies"] = [{**ball, "velocity": [0.3, -0.2, 0.1]}]
    ds = lienumba.run({"model": model, "integrator": settings, "output": {"every": 1.0}}, progress=False)
    moved = ds.position.values[0, -1, 0] - [1, 2, 3]
    np.testing.assert_allclose(moved, np.array([0.3, -0.2, 0.1]) * np.sin(w) / w, atol=1e-8)


@pytest.mark.parametrize(
    "damper",
    ["s.speed*sqrt(abs(s.speed))", *(f"sign(s.speed)*abs(s.speed)**{power}" for power in (1.2, 1.5, 1.8, 2.5))],
)
def test_series_pass_where_powers_have_none(damper: str) -> None:
    """A mass on a spring with a damper of |v|^p, whose speed passes 0 several times, with every tolerance."""
    law = f"-4*s.displacement - {damper}"
    along: Any = {"points": [[0, 0, 0]] * 2, "axes": [[1, 0, 0]] * 2, "speed": 0.2}

    def run(method: str, tolerance: float) -> Any:
        return lienumba.run(
            {
                "model": {
                    "gravity": [0, 0, 0],
                    "bodies": [parts.body("mass", 1.0, position=[0.5, 0, 0])],
                    "joints": [parts.joint("s", "prismatic", "mass", **along)],
                    "forces": [{"type": "actuator", "joint": "s", "value": law}],
                },
                "quantities": parts.observed("joint", "s"),
                "integrator": {"method": method, "tolerance": tolerance, "end_time": 5.0, "coordinates": "joint"},
                "output": {"every": 1.0},
            },
            progress=False,
        )  # fmt: skip

    exact = run("radau9", 1e-13)["s.displacement"].values
    for tolerance in 10.0 ** -np.arange(5.0, 12.6, 0.5):
        found = run("taylor", float(tolerance))
        assert found.status.item() == 0, tolerance
        assert found.steps.item() < 1000, tolerance
        np.testing.assert_allclose(found["s.displacement"].values, exact, atol=max(10.0 * tolerance, 1e-10))
