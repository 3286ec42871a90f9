"""Noise: variances, covariances and spectra against theory; bits that are a run's own; exact integrals of it."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.signal import welch

import lienumba
from lienumba.mechanics.elements.noise import RandomNoise
from lienumba.mechanics.elements.quantities import NOISES
from lienumba.sweep.noise import Courses
from tests.facade import ScenarioError
from tests.rigs.inputs import INERTIA, at_hinge

EVERY = 0.1
RUNS, COUNT = 4000, 40
ROOT = 3**0.5
BANDS: list[dict[str, Any]] = [
    {"order": 1, "frequency": 0.4},
    {"order": 1},
    *({"order": 2, "frequency": 0.4, "damping": damping} for damping in (0.05, 0.7, 1.0, 1.0 + 1e-9, 3.0)),
    {"order": 2, "frequency": 1e-4},
]
GUSTS = [{"length": 30.0, "speed": 40.0, "direction": direction} for direction in ("along", "across")]
SHAPED = [("band", keys) for keys in BANDS] + [("dryden", keys) for keys in GUSTS]


def noise(type_: str, **keys: Any) -> RandomNoise:
    made: RandomNoise = NOISES[type_].model_validate({"name": "n", "type": type_, "std": 1.0, **keys})
    assert not [*made.faults()]
    return made


def courses(type_: str, runs: int = RUNS, count: int = COUNT, **keys: Any) -> np.ndarray:
    return Courses("noise.n", 7, np.arange(runs), count, noise(type_, **keys).recursion()).rows()


def system_of(type_: str, keys: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, b, c of dx = A x dt + b dW, y = c x, as textbooks have them, not normalised."""
    if type_ == "band":
        w = 2 * np.pi * keys.get("frequency", 0.05 / EVERY)
        if keys["order"] == 1:
            return np.array([[-w]]), np.array([1.0]), np.array([1.0])
        z = keys.get("damping", 0.5**0.5)
        return np.array([[0, 1], [-w * w, -2 * z * w]]), np.array([0.0, 1.0]), np.array([1.0, 0.0])
    tau = keys["length"] / keys["speed"]
    if keys["direction"] == "along":
        return np.array([[-1 / tau]]), np.array([1.0]), np.array([1.0])
    return np.array([[0, 1], [-1 / tau**2, -2 / tau]]), np.array([0.0, 1.0]), np.array([1.0, ROOT * tau])


def covariances(type_: str, keys: dict[str, Any], lags: np.ndarray) -> np.ndarray:
    """Of the stationary process, relative to its variance, by Lyapunov's equation and the exponential of a matrix."""
    A, b, c = system_of(type_, keys)
    P = solve_continuous_lyapunov(A, -np.outer(b, b))
    return np.array([c @ expm(A * lag * EVERY) @ P @ c for lag in lags]) / (c @ P @ c)


@pytest.mark.parametrize(("type_", "keys"), SHAPED, ids=str)
def test_what_is_shaped_has_the_covariances_of_theory(type_: str, keys: dict[str, Any]) -> None:
    x, lags = courses(type_, every=EVERY, **keys), np.arange(0, COUNT, 6)
    expected = covariances(type_, keys, lags)
    for first in (0, COUNT // 2 - 3):  # stationary from the start
        found = np.array([(x[:, first] * x[:, first + lag]).mean() for lag in lags[: (COUNT - first) // 6]])
        bound = 4.5 * np.sqrt((1 + expected[: len(found)] ** 2) / RUNS)  # of a mean of products of normal numbers
        assert np.all(abs(found - expected[: len(found)]) < bound)


@pytest.mark.parametrize(("type_", "keys"), SHAPED, ids=str)
def test_the_recursion_keeps_the_covariances_of_theory(type_: str, keys: dict[str, Any]) -> None:
    """Without chance: P of the recursion, step by step, and what it says of later samples."""
    made = noise(type_, every=EVERY, **keys).recursion()
    move, kick, start, out = (np.array(x, float) for x in (made.move, made.kick, made.start, made.out))
    P = start @ start.T
    kept = move @ P @ move.T + kick @ kick.T
    np.testing.assert_allclose(kept, P, rtol=0, atol=1e-13)
    lags = np.arange(8)
    found = [out @ np.linalg.matrix_power(move, lag) @ P @ out for lag in lags]
    np.testing.assert_allclose(found, covariances(type_, keys, lags), rtol=0, atol=2e-9)


def test_the_spectrum_of_a_band() -> None:
    x = courses("band", runs=64, count=4096, every=EVERY, frequency=0.4, order=2, damping=0.2)
    f, found = welch(x, fs=1 / EVERY, nperseg=512)
    w, w0 = 2 * np.pi * f, 2 * np.pi * 0.4
    expected = 2 * 4 * 0.2 * w0**3 / ((w0**2 - w**2) ** 2 + (2 * 0.2 * w0 * w) ** 2)  # one-sided
    seen = (f > 0.05) & (f < 1.0)
    np.testing.assert_allclose(found.mean(axis=0)[seen], expected[seen], rtol=0.12)


def test_white_noise_walks_and_biases() -> None:
    white, walk, bias = courses("white", every=EVERY), courses("walk", every=EVERY), courses("bias", count=1)
    assert abs(white.var() - 1) < 0.02
    assert abs((white[:, 1:] * white[:, :-1]).mean()) < 0.015
    assert not walk[:, 0].any()
    np.testing.assert_allclose(walk[:, 1:].var(axis=0), EVERY * np.arange(1, COUNT), rtol=0.1)
    steps = np.diff(walk, axis=1)
    assert abs((steps[:, 1:] * steps[:, :-1]).mean()) < 0.015 * EVERY
    assert abs(bias.var() - 1) < 0.1
    kurtosis = (white**4).mean()
    assert abs(kurtosis - 3) < 0.1


def test_a_course_is_its_runs_own() -> None:
    whole = courses("band", runs=50, every=EVERY, order=2)
    own = Courses("noise.n", 7, np.array([31, -1, 4]), COUNT, noise("band", every=EVERY, order=2).recursion())
    longer = Courses("noise.n", 7, np.array([31]), 2 * COUNT, own.recursion).rows()[0]
    np.testing.assert_array_equal(own.rows(), [whole[31], np.zeros(COUNT), whole[4]])
    np.testing.assert_array_equal(longer[:COUNT], whole[31])
    np.testing.assert_array_equal(own.part(np.array([2])).rows()[0], whole[4])
    np.testing.assert_array_equal(own.gather(np.array([5, 3, 9])), [whole[31, 5], 0.0, whole[4, 9]])
    others = [Courses(*x, np.array([31]), COUNT, own.recursion).rows()[0] for x in (("noise.m", 7), ("noise.n", 8))]
    assert all(abs(np.corrcoef(x, whole[31])[0, 1]) < 0.9 for x in others)


def swung(**integrator: Any) -> tuple[Any, dict[str, Any]]:
    """A wheel under two noises, whose frequency varies from run to run."""
    system = at_hinge("gust + 2*held")
    system.noise("gust", "band", std=0.7, every=0.05, order=2, frequency=1.0, units="N m")
    system.noise("held", "white", std=0.3, every=0.08)
    system.vary("noise.gust.frequency", "uniform", low=0.5, high=2.0)
    system.vary("noise.held.std", "uniform", low=0.1, high=0.5)
    settings = {"method": "rk4", "step": 0.01, "end_time": 2.0, **integrator}
    settings = {key: x for key, x in settings.items() if key != "step" or "tolerance" not in settings}
    return system, {"sweep.runs": 12, "sweep.seed": 5, "integrator": settings}


@pytest.mark.parametrize("way", ["lie", "joint"])
def test_a_wheel_turns_as_its_noise_says(way: str) -> None:
    system, more = swung(coordinates=way)
    ds = lienumba.run(system, overrides=more | {"output.every": 0.01})
    t = ds.time.values
    gust, held = ds.gust.values, ds.held.values
    knots = np.round(t / 0.05 - np.rint(t / 0.05), 9) == 0.0
    line = np.array([np.interp(t, t[knots], x[knots]) for x in gust])
    np.testing.assert_allclose(gust, line, rtol=0, atol=1e-12)
    whole = np.zeros_like(gust)
    whole[:, 1:] = np.cumsum((gust[:, 1:] + gust[:, :-1]) / 2 * 0.01 + 2 * held[:, :-1] * 0.01, axis=1)
    np.testing.assert_allclose(ds["hinge_at.rate"], whole / INERTIA, rtol=0, atol=1e-11)
    assert ds.gust.attrs["units"] == "N m"


def test_bits_are_the_same_alone_and_with_any_workers_and_the_nominal_run_has_none() -> None:
    system, more = swung()
    whole = lienumba.run(system, overrides=more | {"sweep.nominal": True}, workers=1)
    alone = lienumba.run(system, overrides=more | {"sweep.nominal": True}, runs=[7, 2], workers=2)
    for name in ("gust", "held", "hinge_at.rate"):
        np.testing.assert_array_equal(alone[name], whole[name].sel(run=[7, 2]))
        assert not whole[name].sel(run=-1).any()
    assert len(np.unique(whole["hinge_at.rate"].isel(time=-1))) == 13


@pytest.mark.parametrize("method", ["rk4", "dop853", "taylor", "radau5"])
def test_halving_the_step_keeps_the_noise(method: str) -> None:
    values = ("step", 0.05, 0.01) if method == "rk4" else ("tolerance", 1e-6, 1e-9)
    settings = [swung(method=method, **{values[0]: x}) for x in values[1:]]
    first, second = (lienumba.run(system, overrides=more, runs=[3]) for system, more in settings)
    np.testing.assert_allclose(first.gust, second.gust, rtol=0, atol=1e-12)
    np.testing.assert_allclose(first["hinge_at.rate"], second["hinge_at.rate"], rtol=0, atol=1e-11)


EVERY_TYPE: dict[str, dict[str, Any]] = {
    "white": {"every": 0.08},
    "band": {"every": 0.05},
    "dryden": {"every": 0.04, "length": 8.0, "speed": 40.0, "direction": "across"},
    "walk": {"every": 0.25},
    "bias": {},
}


def test_every_type_of_noise_is_kept_when_the_step_is_halved() -> None:
    """Steps of one length, half of it, and those of a tolerance see one course, and the wheel turns by that alone."""
    assert {*EVERY_TYPE, "table"} == {*NOISES}
    system = at_hinge(" + ".join(EVERY_TYPE))
    for type_, keys in EVERY_TYPE.items():
        system.noise(type_, type_, std=0.5, **keys)
    settings: list[dict[str, Any]] = [
        *({"method": "rk4", "step": step} for step in (0.05, 0.025)), {"method": "dop853", "tolerance": 1e-8},
    ]  # fmt: skip
    found = [
        lienumba.run(system, overrides={"sweep.runs": 3, "sweep.seed": 5, "integrator": {"end_time": 2.0, **x}})
        for x in settings
    ]
    for ds in found[1:]:
        for type_ in EVERY_TYPE:
            np.testing.assert_allclose(ds[type_], found[0][type_], rtol=0, atol=1e-12, err_msg=type_)
        np.testing.assert_allclose(ds["hinge_at.rate"], found[0]["hinge_at.rate"], rtol=0, atol=1e-11)
    assert all(found[0][type_].std("run").isel(time=-1) > 0.05 for type_ in EVERY_TYPE)


REFUSED = [
    ({"type": "pink", "std": 1}, 'noise.n.type = "pink": is not known; known here are "white", "band"'),
    ({"type": "white", "std": 1}, "noise.n.every is missing; give the interval between two samples in s, above 0"),
    ({"type": "white", "std": -1, "every": 1}, "noise.n.std = -1: must be at least 0; give the standard deviation"),
    (
        {"type": "band", "std": 1, "every": 0.1, "frequency": 4},
        "noise.n.frequency = 4.0: is above 0.25/every = 2.5, so that samples would miss it; give a smaller every",
    ),
    ({"type": "band", "std": 1, "every": 0.1, "damping": 0.5}, "noise.n.damping = 0.5: has no effect without order"),
    (
        {"type": "dryden", "std": 1, "every": 1.0, "length": 10, "speed": 20},
        "noise.n.every = 1.0: is longer than length/speed = 0.5 s; give a smaller one",
    ),
    ({"type": "white", "std": 1, "every": 1e-100}, "noise.n.every = 1e-100: makes 2e+100 samples until 2 s, at most"),
    ({"type": "bias", "std": 1, "name": "status"}, "the dataset has a variable of this name already"),
    ({"type": "bias", "std": "t"}, "must be a number, not a formula, because it cannot vary in time"),
]


@pytest.mark.parametrize(("keys", "message"), REFUSED, ids=lambda x: str(x)[:40])
def test_what_is_wrong_is_told(keys: dict[str, Any], message: str) -> None:
    system = at_hinge("0")
    system.noise(**{"name": "n", **keys})
    with pytest.raises(ScenarioError) as error:
        lienumba.run(system)
    assert message in str(error.value)


def test_no_driver_follows_noise() -> None:
    system = at_hinge("0").noise("n", "bias", std=1.0)
    system.driver("turn", joint="hinge", value="n")
    with pytest.raises(ScenarioError, match="reads n, a noise, which has no rate, but what a driver prescribes is"):
        lienumba.run(system)
