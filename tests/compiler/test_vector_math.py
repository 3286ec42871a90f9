"""sin, cos, exp, atan2: at most 2 ulp from the exact value, the same bits on arrays and on lanes, IEEE at the edges."""

import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest

from lienumba import vector_math

from .evaluation import assert_same_bits, on_arrays, on_lanes, traced

EXACT = {"sin": mpmath.sin, "cos": mpmath.cos, "exp": mpmath.exp, "atan2": mpmath.atan2}
SHAPES = {"sin": (0,), "cos": (0,), "exp": (0,), "atan2": (0, 0)}
WAYS = ("arrays", "lanes", "symbols")


@pytest.fixture(scope="module")
def evaluate() -> Callable[[str, str, np.ndarray], np.ndarray]:
    """Evaluate a function in one of the three ways; each is compiled once."""
    made: dict[tuple[str, str], Callable[[np.ndarray], np.ndarray]] = {}

    def run(way: str, name: str, *x: np.ndarray) -> np.ndarray:
        if (way, name) not in made:
            function, shape = getattr(vector_math, name), SHAPES[name]
            ways = {"arrays": on_arrays, "symbols": traced, "lanes": lambda f, s: on_lanes(f, s, 0)}
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
def test_arrays_and_lanes_give_the_same_bits(evaluate, name):
    """Neither contracts a product and a sum, whatever the CPU."""
    x = np.concatenate([angles(), beside_multiples_of_a_quarter_turn(), np.linspace(-750.0, 750.0, 999)])
    assert_same_bits(evaluate("arrays", name, x), evaluate("lanes", name, x))


@pytest.mark.parametrize("name", ["sin", "cos", "exp"])
def test_zero_is_exact(evaluate, name):
    for way in WAYS:
        assert evaluate(way, name, np.zeros(1))[0] == (0.0 if name == "sin" else 1.0)
