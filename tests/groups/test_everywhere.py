"""The same functions on floats, on arrays, under `@njit` and traced on symbols: the same numbers."""

import math

import numpy as np
import pytest

from lienumba.groups import se3, so3, state
from tests.compiler.evaluation import assert_same_bits, on_arrays, on_floats, rows_in, traced, under_njit

FUNCTIONS = {
    "exp": (so3.exp, (3,)),
    "log": (so3.log, (9,)),
    "dexp": (so3.dexp, (3, 3)),
    "dexpinv": (so3.dexpinv, (3, 3)),
    "multiply": (so3.multiply, (9, 9)),
    "rotate": (so3.rotate, (9, 3)),
    "from_quaternion": (so3.from_quaternion, (4,)),
    "to_quaternion": (so3.to_quaternion, (9,)),
    "se3.exp": (se3.exp, (6,)),
    "se3.dexp": (se3.dexp, (6, 6)),
    "se3.dexpinv": (se3.dexpinv, (6, 6)),
    "state.product": (state.product, (18, 18)),
    "state.exp": (state.exp, (12,)),
    "state.log": (state.log, (18,)),
    "state.dexp": (state.dexp, (12, 12)),
    "state.dexpinv": (state.dexpinv, (12, 12)),
    "state.bracket": (state.bracket, (12, 12)),
}
ANGLES = [0.0, 1e-200, 1e-9, 1e-4, 0.3, 0.999, 1.001, 1.5, 2.0, 3.0, math.pi - 1e-9, 3.2, 4.5, 5.9, 6.1, 7.0, 25.0]


def inputs(shape: tuple[int, ...]) -> np.ndarray:
    """(rows, n): rotation vectors of all sizes, rotations, numbers."""
    rng = np.random.default_rng(7)

    def turn(scale: np.ndarray) -> np.ndarray:
        axis = rng.standard_normal((3, scale.size))
        return scale * axis / np.linalg.norm(axis, axis=0)

    def rotation() -> np.ndarray:
        return np.array([so3.exp(tuple(u)) for u in turn(angles).T.tolist()]).T

    angles = np.repeat(ANGLES, 3)
    n = angles.size
    parts = []
    for size in shape:
        if size == 9:
            parts.append(rotation())
        elif size == 18:
            parts += [rng.standard_normal((3, n)), rotation(), rng.standard_normal((6, n))]
        elif size == 6:
            parts += [rng.standard_normal((3, n)), turn(angles)]
        elif size == 12:
            parts += [rng.standard_normal((3, n)), turn(angles), rng.standard_normal((6, n))]
        else:
            parts.append(turn(angles) if size == 3 else rng.standard_normal((size, n)))
    x = np.concatenate(parts)
    assert len(x) == rows_in(shape)
    return x


@pytest.mark.parametrize("name", FUNCTIONS)
def test_floats_arrays_njit_and_symbols_agree(name):
    function, shape = FUNCTIONS[name]
    x = inputs(shape)
    expected = on_floats(function, shape)(x)
    tolerance = 4e-14 * (1.0 + np.abs(expected).max(axis=0))
    arrays = on_arrays(function, shape)(x)
    for way in (arrays, under_njit(function, shape)(x), traced(function, shape)(x)):
        assert way.shape == expected.shape
        worst = (np.abs(way - expected) / tolerance).max(axis=0)
        assert worst.max() < 1.0, f"{name} at {x[:, worst.argmax()]}"


@pytest.mark.parametrize("order", [0, 2, 4, 10])
def test_truncated_dexpinv_agrees(order):
    """The number of terms is a constant of the kernel, not one of its inputs."""

    def fixed(u, w):
        return so3.dexpinv_truncated(u, w, order)

    x = np.clip(inputs((3, 3)), -1.0, 1.0)
    expected = on_floats(fixed, (3, 3))(x)
    assert_same_bits(on_arrays(fixed, (3, 3))(x), expected)
    np.testing.assert_allclose(traced(fixed, (3, 3))(x), expected, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("way", ["arrays", "symbols"])
def test_zero_rotation_is_the_identity_to_the_bit(way):
    evaluate = {"arrays": on_arrays, "symbols": traced}[way](so3.exp, (3,))
    assert (evaluate(np.zeros((3, 8))) == np.array(so3.IDENTITY)[:, None]).all()


def test_zero_velocity_changes_no_bit_of_a_rotation_in_compiled_code():
    def turned(R, u):
        return so3.multiply(R, so3.exp(u))

    x = np.concatenate([inputs((9,)), np.zeros((3, 3 * len(ANGLES)))])
    assert (traced(turned, (9, 3))(x) == x[:9]).all()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_run_feels_nothing_of_its_neighbours(name):
    """NaN in every other lane moves no bit."""
    function, shape = FUNCTIONS[name]
    x = inputs(shape)[:, :16]
    poisoned = x.copy()
    poisoned[:, 1::2] = np.nan
    evaluate = traced(function, shape)
    assert_same_bits(evaluate(poisoned)[:, ::2], evaluate(x)[:, ::2])
