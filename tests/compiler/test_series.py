"""Coefficients of compiled series against those that mpmath finds by differences of many digits, and closed forms."""

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import factorial

from lienumba.compiler import native
from lienumba.compiler.loops.convolutions import SeriesKernel
from lienumba.compiler.rows import W
from lienumba.compiler.series import orders
from lienumba.compiler.symbols import Graph
from lienumba.integrators.tracing.machine import aligned
from lienumba.numerics import operations
from lienumba.numerics.operations import atan2, cos, exp, log, power, sin, sqrt, tanh, where

ORDER = 9
Law = Callable[..., Sequence[Any]]


def coefficients(law: Law, start: Sequence[float], parameters: Sequence[float] = (), t: float = 0.0) -> np.ndarray:
    """Of x' = law(x, t, p) in every lane (k, x, W); lane n starts from so many times start."""
    graph = Graph(analytic=True)
    x, p, clock = (
        graph.inputs("state", len(start)),
        graph.inputs("parameters", len(parameters)),
        graph.input("clock", 0),
    )
    made = orders([*x, clock], [*law(x, clock, p), 1.0], [], ORDER)
    kernel = SeriesKernel("series", made, ORDER, 1, []).hoisted_from(len(parameters))
    code = native.compile_text(kernel.text())
    engine, addresses = native.load(code, ["series", "series_prepare"])
    rows = [len(start), len(parameters) + len(kernel.hoisted) + 1, 1, 1, 1 + kernel.rows, kernel.work_rows + 1]
    given = [aligned(n, W) for n in rows]
    given[0][:] = np.array(start)[:, None] * scales()
    given[1][: len(parameters)] = np.array(parameters).reshape(-1, 1)
    given[2][:] = t
    for name in ("series_prepare", "series"):
        function = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 6)(addresses[name])
        function(*(array.ctypes.data for array in given))
    assert engine
    found = given[4][1 : 1 + made.rows].reshape(-1, made.stride, W)[: len(start), : ORDER + 1]
    return found.transpose(1, 0, 2)


def scales() -> np.ndarray:
    return 1.0 + 0.1 * np.arange(W)


FUNCTIONS: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    "1 / (1 + y^2)": (lambda y: 1.0 / (1.0 + y * y), lambda y: 1 / (1 + y * y)),
    "y / (3 - y) of itself": (lambda y: (y / (3.0 - y)) / (1.0 + y), lambda y: y / (3 - y) / (1 + y)),
    "sqrt": (sqrt, mpmath.sqrt),
    "exp": (lambda y: exp(-0.3 * y), lambda y: mpmath.exp(-0.3 * y)),
    "log": (log, mpmath.log),
    "sin": (sin, mpmath.sin),
    "cos of a square": (lambda y: cos(y * y), lambda y: mpmath.cos(y * y)),
    "sin and cos": (lambda y: sin(y) - cos(y), lambda y: mpmath.sin(y) - mpmath.cos(y)),
    "atan2": (lambda y: atan2(y, 1.0 - y * y), lambda y: mpmath.atan2(y, 1 - y * y)),
    "tanh": (tanh, mpmath.tanh),
    "power": (lambda y: power(y, 1.7), lambda y: y ** mpmath.mpf(1.7)),
    "cube": (lambda y: power(y, 3), lambda y: y**3),
    "where": (lambda y: where(y < 0.2, y, y * y), lambda y: y * y),
    "absolute": (lambda y: operations.absolute(0.1 - y), lambda y: y - 0.1),
}


def moved(start: float, s: Any) -> Any:
    """y at 0.25 + s, where y' = -0.5 y + t."""
    a, t = mpmath.mpf(-0.5), mpmath.mpf(0.25)
    return (start + t / a + 1 / a**2) * mpmath.exp(a * s) - (t + s) / a - 1 / a**2


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_of_a_series(name: str) -> None:
    """z' = f(y) along y' = -0.5 y + t, whose solution is known."""
    ours, theirs = FUNCTIONS[name]
    found = coefficients(lambda x, t, p: (p[0] * x[0] + t, ours(x[0])), [0.7, 0.0], [-0.5], t=0.25)
    mpmath.mp.dps = 40
    for lane, scale in enumerate(scales()):
        rate = mpmath.taylor(lambda s, start=0.7 * scale: theirs(moved(start, s)), 0, ORDER - 1)
        expected = [0.0, *(float(c / (k + 1)) for k, c in enumerate(rate))]
        np.testing.assert_allclose(found[:, 1, lane], expected, rtol=2e-12, atol=1e-14, err_msg=name)


def test_functions_of_the_time_have_their_taylor_series() -> None:
    """In closed form: of z' = f(t) the coefficient of order k + 1 is that of f of order k over k + 1."""
    t, k, powers = 0.8, np.arange(ORDER), (0.5, 1.7, -1.0)
    found = coefficients(
        lambda x, t, p: (sin(t), cos(t), exp(t), log(t), sqrt(t), power(t, 1.7), 1.0 / t), [0.0] * 7, t=t
    )
    circle = [np.imag(np.exp(1j * t) * 1j**k), np.real(np.exp(1j * t) * 1j**k)]
    logarithm = [np.log(t), *((-1) ** (n + 1) / (n * t**n) for n in range(1, ORDER))]
    expected = [x / factorial(k) for x in (*circle, np.full(ORDER, np.exp(t)))]
    binomials = [np.cumprod([1.0, *(p - k[:-1]) / k[1:]]) for p in powers]
    expected += [logarithm, *(c * t ** (p - k) for p, c in zip(powers, binomials, strict=True))]
    for n, series in enumerate(expected):
        np.testing.assert_allclose(found[1:, n, 0], series / (k + 1.0), rtol=1e-13, err_msg=str(n))


def test_rounding_and_branches_stay_as_they_are_at_the_start() -> None:
    rounded = operations.vector_math().round_to_integer
    for factor in (1.0, 3.0):  # a product that is rounded is fused with what rounds it
        found = coefficients(lambda x, t, p, f=factor: (rounded(f * x[0]) + 1.0,), [2.2])
        np.testing.assert_array_equal(found[1, 0], np.rint(factor * 2.2 * scales()) + 1.0)
        assert not found[2:].any()


@given(st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3), st.lists(st.floats(0.5, 2.0), min_size=3, max_size=3))
@settings(max_examples=5)
def test_a_free_body_keeps_its_energy_and_its_angular_momentum(start: list[float], inertia: list[float]) -> None:
    """Euler's equations: both are the same at any time, coefficient by coefficient."""

    def euler(x: Any, t: Any, J: Any) -> Sequence[Any]:
        return (
            (J[1] - J[2]) / J[0] * (x[1] * x[2]), (J[2] - J[0]) / J[1] * (x[2] * x[0]),
            (J[0] - J[1]) / J[2] * (x[0] * x[1]),
        )  # fmt: skip

    w = coefficients(euler, start, inertia)
    size = 1.0 + np.abs(w).max()
    for power_of_inertia in (1, 2):
        for k in range(1, ORDER + 1):
            terms = [J**power_of_inertia * w[j, i] * w[k - j, i] for i, J in enumerate(inertia) for j in range(k + 1)]
            assert np.abs(sum(terms)).max() <= 1e-12 * size**3
