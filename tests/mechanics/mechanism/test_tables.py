"""Tables against NumPy and SciPy, on every kind of number."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from lienumba.compiler.emit import Kernel
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph
from lienumba.mechanics.mechanism.model import Law
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.mechanism.tables import INTERPOLATIONS, Table
from lienumba.numerics.jets import Jet, lift
from tests.compiler.evaluation import assert_same_bits, machine_code
from tests.compiler.interpreter import interpret
from tests.facade import Model

SIZES = [2, 3, 4, 5, 8, 9, 33, 5000]


def points(n, seed=0):
    rng = np.random.default_rng(seed + n)
    return np.cumsum(rng.uniform(0.1, 1.0, n)) - 2.0, rng.standard_normal(n)


def table(n, kind):
    x, y = points(n)
    return Table.of(x.tolist(), y.tolist(), kind)


def held(x, y, at):
    """The value of the last point at or before; that of the first one before it."""
    return y[np.maximum(np.searchsorted(x, at, side="right") - 1, 0)]


ORACLES = {
    "hold": held,
    "linear": lambda x, y, at: np.interp(at, x, y),
    "cubic": lambda x, y, at: CubicSpline(x, y)(np.clip(at, x[0], x[-1])),
}


def places(x):
    """The points themselves, the numbers next to them, between them and beyond both ends."""
    rng = np.random.default_rng(3)
    near = [x, np.nextafter(x, -np.inf), np.nextafter(x, np.inf), 0.5 * (x[1:] + x[:-1])]
    return np.concatenate([*near, rng.uniform(x[0] - 3.0, x[-1] + 3.0, 200), [-1e9, 1e9]])


@pytest.mark.parametrize("kind", INTERPOLATIONS)
@pytest.mark.parametrize("n", SIZES)
def test_values_between_before_and_behind_the_points(n, kind):
    (x, y), f = points(n), table(n, kind)
    at = places(x)
    size = 1e-11 * max(1.0, np.abs(y).max())
    np.testing.assert_allclose(f(at, at), ORACLES[kind](x, y, at), rtol=0, atol=size)
    np.testing.assert_array_equal(f(x, x)[:-1], y[:-1])
    assert f(x[-1], x[-1]) == pytest.approx(y[-1], rel=1e-12)
    floats = [f(float(t), float(t)) for t in at[:300]]
    assert_same_bits(np.array(floats), f(at, at)[:300])


@pytest.mark.parametrize("n", [2, 3, 4, 7, 40])
def test_the_spline_is_not_a_knot_and_reproduces_cubics(n):
    x, _ = points(n)
    degree = min(n - 1, 3)
    cubic = np.polynomial.Polynomial([0.3, -1.2, 0.7, 0.4][: degree + 1])
    f, at = Table.of(x, cubic(x), "cubic"), np.linspace(x[0], x[-1], 101)
    np.testing.assert_allclose(f(at, at), cubic(at), rtol=0, atol=1e-11 * np.abs(cubic(at)).max())


@pytest.mark.parametrize("n", [2, 3, 6, 50])
@pytest.mark.parametrize("kind", INTERPOLATIONS)
def test_jets(n, kind):
    """Along a parabola; beyond the ends nothing changes any more."""
    (x, y), f = points(n), table(n, kind)
    s = np.random.default_rng(1).uniform(x[0] - 1.0, x[-1] + 1.0, 300)
    jet = f(Jet(s, -1.7, 0.6), Jet(s, -1.7, 0.6))
    inside = (s > x[0]) & (s < x[-1])
    if kind == "cubic":
        spline = CubicSpline(x, y)
        first, second = spline(s, 1), spline(s, 2)
    else:
        first = (np.diff(y) / np.diff(x))[np.clip(np.searchsorted(x, s) - 1, 0, n - 2)] * (kind == "linear")
        second = 0.0 * s
    first, second = first * inside, second * inside
    np.testing.assert_allclose(jet.a, ORACLES[kind](x, y, s), rtol=0, atol=1e-12)
    np.testing.assert_allclose(jet.b, -1.7 * first, rtol=0, atol=1e-10)
    np.testing.assert_allclose(jet.c, 1.7**2 * second + 0.6 * first, rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", INTERPOLATIONS)
def test_what_is_not_finite(kind):
    f = table(9, kind)
    assert np.isnan(f(np.nan, np.nan))
    assert np.isnan(f(np.array([0.3, np.nan]), np.array([0.3, np.nan]))).tolist() == [False, True]
    assert np.isnan(f(np.nan, 0.3))


@pytest.mark.parametrize("kind", INTERPOLATIONS)
def test_the_piece_is_that_of_the_second_argument(kind):
    """At a point the function of the piece in front of it continues, where this is asked for."""
    (x, y), f = points(6), table(6, kind)
    before, after = 0.5 * (x[2] + x[3]), 0.5 * (x[3] + x[4])
    if kind == "hold":
        assert (f(x[3], before), f(x[3], after)) == (y[2], y[3])
        return
    assert f(x[3], after) == y[3]
    assert f(x[3], before) == pytest.approx(y[3], abs=1e-13)
    slopes = [lift(f(Jet(float(x[3]), 1.0), float(at))).b for at in (before, after)]
    if kind == "linear":
        np.testing.assert_allclose(slopes, np.diff(y)[2:4] / np.diff(x)[2:4], rtol=1e-13)
    else:
        np.testing.assert_allclose(slopes, CubicSpline(x, y)(x[3], 1), rtol=1e-11)


def test_where_steps_have_to_land():
    x, _ = points(6)
    assert table(6, "hold").knots == table(6, "linear").knots == tuple(x)
    assert table(6, "cubic").knots == (x[0], x[-1])
    assert table(6, "cubic").last == x[-1]


def outputs(f, jets=False):
    """A table at state[0] on symbols; its address is parameters[0]."""
    graph = Graph()
    model = Model((Law(lambda t, f: f(t, t), {"f": f}), 0.0, 0.0), ())
    x, law = (
        graph.input("state", 0),
        map_numbers(model, lambda x, _: x, lambda x: graph.input("parameters", 0)).gravity[0],
    )
    y = lift(law(Jet(x, -1.7, 0.6) if jets else x))
    return (y.a, y.b, y.c) if jets else (y.a,)


def on_symbols(f, at, run):
    """Values at these arguments; run: of the rows of lanes `state` and `parameters`."""
    address = np.full((1, W), f.data.address)
    padded = np.resize(at, (-(-len(at) // W), W))
    return np.concatenate([run(state=row[None], parameters=address) for row in padded], axis=1)[:, : len(at)]


@pytest.mark.parametrize("kind", INTERPOLATIONS)
@pytest.mark.parametrize("n", [2, 3, 8, 9, 5000])
def test_kernels_give_the_bits_of_floats(n, kind):
    """Every lane reads its own piece, beyond the ends, too; but for fused multiply-adds, which round once less."""
    f, at = table(n, kind), places(points(n)[0])[-250:]
    found = on_symbols(f, at, machine_code(Kernel("table", outputs(f), 1)))
    assert_same_bits(found, on_symbols(f, at, lambda **rows: interpret(outputs(f), **rows)))
    plain = np.array([f(float(x), float(x)) for x in at])
    if kind == "hold":
        assert_same_bits(found[0], plain)
    np.testing.assert_allclose(found[0], plain, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("kind", ["hold", "linear", "cubic"])
def test_kernels_keep_nan(kind):
    f = table(8, kind)
    found = on_symbols(f, np.array([np.nan, 0.3]), machine_code(Kernel("table", outputs(f), 1)))
    assert np.isnan(found[0]).tolist() == [True, False]


@pytest.mark.parametrize("kind", INTERPOLATIONS)
def test_kernels_of_jets(kind):
    f, at = table(12, kind), np.random.default_rng(2).uniform(-3, 6, 64)
    wanted = f(Jet(at, -1.7, 0.6), Jet(at, -1.7, 0.6))
    rows = on_symbols(f, at, machine_code(Kernel("table", outputs(f, jets=True), 1)))
    for found, x in zip(rows, (wanted.a, wanted.b, wanted.c), strict=True):
        np.testing.assert_allclose(found, np.broadcast_to(x, at.shape), rtol=1e-12, atol=1e-12)


def test_another_table_of_the_same_length_compiles_nothing():
    def text(f):
        return Kernel("table", outputs(f), 1).text()

    x, y = points(9, seed=4)
    assert text(table(9, "linear")) == text(Table.of(x, y, "linear"))
    assert len(text(table(5000, "linear"))) < 4 * len(text(table(9, "linear")))  # 13 and 4 steps of bisection


@pytest.mark.parametrize("kind", ["linear", "cubic"])
def test_the_last_point_still_has_the_rate_in_front_of_it(kind):
    """A driver that ends there does not stop there."""
    f = Table.of([0, 1, 2], [0, 0, 1], kind)
    rate = {"linear": 1.0, "cubic": 1.5}[kind]
    assert lift(f(Jet(2.0, 1.0), 2.0)).b == pytest.approx(rate, abs=1e-15)
    assert lift(f(Jet(2.0000001, 1.0), 2.0000001)).b == 0.0
