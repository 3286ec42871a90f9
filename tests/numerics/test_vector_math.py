"""sin, cos, exp, log, atan2: at most 2 ulp from the exact value, IEEE at the edges.

And what stands on them: tanh, powers."""

import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest

from lienumba.numerics import operations, vector_math
from tests.compiler.evaluation import assert_same_bits, on_arrays, traced

EXACT = {"sin": mpmath.sin, "cos": mpmath.cos, "exp": mpmath.exp, "log": mpmath.log, "atan2": mpmath.atan2}
SHAPES = {"sin": (0,), "cos": (0,), "exp": (0,), "log": (0,), "atan2": (0, 0)}
WAYS = ("arrays", "symbols")


@pytest.fixture(scope="module")
def evaluate() -> Callable[[str, str, np.ndarray], np.ndarray]:
    """Evaluate a function in one of the two ways; each is compiled once."""
    made: dict[tuple[str, str], Callable[[np.ndarray], np.ndarray]] = {}

    def run(way: str, name: str, *x: np.ndarray) -> np.ndarray:
        if (way, name) not in made:
            function, shape = getattr(vector_math, name), SHAPES[name]
            ways = {"arrays": on_arrays, "symbols": traced}
            made[way, name] = ways[way](function, shape)
        return made[way, name](np.array(x))[0]

    return run


def ulps(name: str, y: np.ndarray, *x: np.ndarray) -> np.ndarray:
    """The distance of y from the exact value, in units of the last place of that value."""
    with mpmath.workprec(240):
        result = []
        for value, *arguments in zip(y.tolist(), *(a.tolist() for a in x), strict=True):
            exact = EXACT[name](*(mpmath.mpf(a) for a in arguments))
            result.append(abs(float((mpmath.mpf(value) - exact) / math.ulp(float(exact)))))
    return np.array(result)


def angles() -> np.ndarray:
    rng = np.random.default_rng(1)
    x = np.concatenate([rng.uniform(0.0, 1e5, 2000), 10.0 ** rng.uniform(-300, 5, 1000), [1e5, 5e-324, 2.0**-27]])
    return np.concatenate([x, -x, [0.0]])


def beside_multiples_of_a_quarter_turn() -> np.ndarray:
    """The doubles nearest to k pi/2, and their neighbours: where sin or cos all but vanishes."""
    count = int(1e5 / (math.pi / 2))
    k = np.unique(np.concatenate([np.arange(1, 400), np.linspace(1, count, 1500).astype(int), 2 ** np.arange(16)]))
    with mpmath.workprec(160):
        nearest = np.array([float(int(i) * mpmath.pi / 2) for i in k])
    return np.concatenate([nearest, np.nextafter(nearest, 0.0), np.nextafter(nearest, np.inf), -nearest])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ["sin", "cos"])
@pytest.mark.parametrize("points", [angles, beside_multiples_of_a_quarter_turn])
def test_sin_and_cos_are_within_2_ulp(evaluate, name, points, way):
    x = points()
    error = ulps(name, evaluate(way, name, x), x)
    assert error.max() <= 2.0, f"{name}({x[error.argmax()]!r}) is off by {error.max():.2f} ulp"


@pytest.mark.parametrize("way", WAYS)
def test_exp_is_within_2_ulp_from_the_smallest_to_the_largest_result(evaluate, way):
    rng = np.random.default_rng(2)
    x = np.concatenate(
        [
            rng.uniform(-745.13, 709.78, 3000),
            rng.uniform(-745.13, -708.0, 500),  # denormal results
            rng.uniform(-1.0, 1.0, 500),
            rng.choice([-1.0, 1.0], 300) * 10.0 ** rng.uniform(-320, -1, 300),
            np.log(2.0) * (np.arange(-1070, 1023) + 0.5),  # where the reduction jumps
            [709.782712893384, -745.1332191019411, -708.3964185322641, 0.0, 5e-324],
        ]
    )
    error = ulps("exp", evaluate(way, "exp", x), x)
    assert error.max() <= 2.0, f"exp({x[error.argmax()]!r}) is off by {error.max():.2f} ulp"


def positive() -> np.ndarray:
    """From the smallest denormal to the largest double; beside 1, and where the reduction jumps."""
    rng = np.random.default_rng(4)
    powers = 2.0 ** np.arange(-1074, 1024)
    jumps = np.concatenate([powers[1:], math.sqrt(2.0) * powers[:-1][powers[:-1] > 1e-300]])
    beside = 10.0 ** rng.uniform(-16, -0.4, 1000)
    x = np.concatenate([10.0 ** rng.uniform(-323, 308, 3000), rng.uniform(0.3, 3.0, 2000), 1.0 + beside, 1.0 - beside])
    edges = [5e-324, 1e-323, 2.2250738585072014e-308, 2.225073858507201e-308, np.finfo(float).max]
    x = np.concatenate([x, jumps, np.nextafter(jumps, 0.0), np.nextafter(jumps, np.inf), edges])
    return x[(x > 0.0) & np.isfinite(x) & (x != 1.0)]


@pytest.mark.parametrize("way", WAYS)
def test_log_is_within_1_ulp_from_the_smallest_to_the_largest_number(evaluate, way):
    x = positive()
    error = ulps("log", evaluate(way, "log", x), x)
    assert error.max() <= 1.0, f"log({x[error.argmax()]!r}) is off by {error.max():.2f} ulp"


@pytest.mark.parametrize("way", WAYS)
def test_log_at_the_edges(evaluate, way):
    x = np.array([1.0, 0.0, -0.0, -5e-324, -1.0, np.inf, -np.inf, np.nan])
    nan, inf = np.nan, np.inf
    assert_same_bits(evaluate(way, "log", x), np.array([0.0, -inf, -inf, nan, nan, inf, nan, nan]))


@pytest.mark.parametrize("way", WAYS)
def test_atan2_is_within_2_ulp(evaluate, way):
    rng = np.random.default_rng(3)
    angle, radius = rng.uniform(-math.pi, math.pi, 3000), 10.0 ** rng.uniform(-150, 150, 3000)
    y, x = radius * np.sin(angle), radius * np.cos(angle)
    small = 10.0 ** rng.uniform(-200, 0, 500)  # beside the four half-axes
    y = np.concatenate([y, small, np.ones(500), -np.ones(500), small])
    x = np.concatenate([x, np.ones(500), small, small, -np.ones(500)])
    error = ulps("atan2", evaluate(way, "atan2", y, x), y, x)
    at = error.argmax()
    assert error.max() <= 2.0, f"atan2({y[at]!r}, {x[at]!r}) is off by {error.max():.2f} ulp"


@pytest.mark.parametrize("way", WAYS)
def test_what_is_not_finite_keeps_its_meaning(evaluate, way):
    nan, inf = np.nan, np.inf
    for name in ("sin", "cos"):
        assert_same_bits(evaluate(way, name, np.array([nan, inf, -inf])), np.full(3, nan))
    exponents = np.array([nan, inf, -inf, 709.7827128933841, 710.0, 1e308, -745.2, -746.0, -1e308, 0.0, -0.0])
    expected = np.array([nan, inf, 0.0, inf, inf, inf, 0.0, 0.0, 0.0, 1.0, 1.0])
    assert_same_bits(evaluate(way, "exp", exponents), expected)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("y", "x"), [(np.nan, 1.0), (1.0, np.nan), (-1.0, np.nan), (np.nan, -1.0), (np.nan, np.nan)])
def test_atan2_of_nan_is_nan(evaluate, way, y, x):
    assert np.isnan(evaluate(way, "atan2", np.array([y]), np.array([x])))


@pytest.mark.parametrize("way", WAYS)
def test_atan2_on_the_axes(evaluate, way):
    y = np.array([0.0, 0.0, 1.0, -1.0, 0.0, 5e-324, 1e300])
    x = np.array([0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0])
    assert_same_bits(evaluate(way, "atan2", y, x), np.arctan2(y, x))


@pytest.mark.parametrize("name", ["sin", "cos", "exp"])
def test_zero_is_exact(evaluate, name):
    for way in WAYS:
        assert evaluate(way, name, np.zeros(1))[0] == (0.0 if name == "sin" else 1.0)


# ---------------------------------------------------------------- what stands on them
def test_tanh_is_within_4_ulp() -> None:
    """Beside 0, where its two forms meet, and out to where it is 1."""
    rng = np.random.default_rng(6)
    x = np.concatenate(
        [rng.uniform(-25.0, 25.0, 1500), rng.uniform(0.49, 0.51, 1500), 10.0 ** rng.uniform(-323, 0, 1000)]
    )
    x = np.concatenate([x, -x, np.nextafter(0.5, [0.0, 1.0]), [0.5, 5e-324, 1e308]])
    for on in (on_arrays, traced):
        y = on(operations.tanh, (0,))(x[None])[0]
        with mpmath.workprec(240):
            exact = [mpmath.tanh(mpmath.mpf(z)) for z in x.tolist()]
            error = [float(abs(mpmath.mpf(a) - b) / math.ulp(float(b))) for a, b in zip(y.tolist(), exact, strict=True)]
        assert max(error) <= 4.0, f"tanh({x[int(np.argmax(error))]!r}) is off by {max(error):.2f} ulp"
        assert np.abs(y).max() <= 1.0
        edges = on(operations.tanh, (0,))(np.array([[0.0, np.inf, -np.inf, np.nan, 400.0, -750.0]]))[0]
        assert_same_bits(edges, np.array([0.0, 1.0, -1.0, np.nan, 1.0, -1.0]))


@pytest.mark.parametrize("p", [2.0, 3.0, -3.0, 17.0, 64.0, -64.0, 0.5, 1.5, -2.5, 0.3, 10.1])
def test_powers_are_as_accurate_as_their_way_allows(p: float) -> None:
    """By squares an ulp for each factor, else an ulp for each unit of p log x."""
    x = 10.0 ** np.random.default_rng(7).uniform(-4.0, 4.0, 1000)
    bound = 1.0 if p == 0.5 else abs(p) + 1.0 if p.is_integer() else 2.0 + 1.5 * np.abs(p * np.log(x)).max()
    for on in (on_arrays, traced):
        y = on(lambda z: operations.power(z, p), (0,))(x[None])[0]
        with mpmath.workprec(240):
            exact = [mpmath.mpf(z) ** mpmath.mpf(p) for z in x.tolist()]
            error = [float(abs(mpmath.mpf(a) - b) / math.ulp(float(b))) for a, b in zip(y.tolist(), exact, strict=True)]
        assert max(error) <= bound, f"{x[int(np.argmax(error))]!r}**{p} is off by {max(error):.2f} ulp"


def test_powers_at_the_edges() -> None:
    x = np.array([[0.0, 1.0, np.inf, np.nan, -2.0]])
    nan, inf = np.nan, np.inf
    for p, expected in {
        0.0: [1.0] * 5, 2.0: [0.0, 1.0, inf, nan, 4.0], -2.0: [inf, 1.0, 0.0, nan, 0.25],
        0.5: [0.0, 1.0, inf, nan, nan], 2.5: [0.0, 1.0, inf, nan, nan], -2.5: [inf, 1.0, 0.0, nan, nan],
    }.items():  # fmt: skip
        for on in (on_arrays, traced):
            assert_same_bits(on(lambda z, p=p: operations.power(z, p), (0,))(x)[0], np.array(expected))
