"""Calls of compiled functions in kernels: the same bits on floats, in lanes, and wherever a kernel is cut."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

import lienumba
from lienumba.compiler import emit, segments
from lienumba.compiler.derivatives import partials
from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.compiler.tape import Tape
from lienumba.compiler.value_types import DOUBLE, VECTOR
from lienumba.errors import ScenarioError
from lienumba.laws import tanh
from tests.compiler.evaluation import assert_same_bits, call
from tests.rigs.places import ROOT

TABLE = np.array([0.5, 2.0, -1.0, 4.0])
CHILD = "from tests.compiler.foreign.test_calls import digest; print(digest())"


@lienumba.jit
def saturated(x, limits):
    """Raises beyond 9; loops, branches, and reads a table."""
    if x > 9.0:
        raise ValueError("too large")
    total = 0.0
    for n in range(len(TABLE)):
        total += TABLE[n] * x / (n + 1.0)
    if total > limits[1]:
        return limits[1], 1
    return max(total, limits[0]), 0


@lienumba.jit
def lagged(x, y):
    return 0.75 * x + 0.25 * tanh(y)


def given(rows: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(rows, 8)) * 4.0


def digest() -> str:
    """Of what the functions return for many numbers."""
    x, y = np.random.default_rng(2).normal(size=(2, 5000)) * 3.0
    found = np.array([*saturated(x, (-6.0, 5.0)), lagged(x, y)])
    return hashlib.sha256(found.tobytes()).hexdigest()


@pytest.mark.parametrize("values", [VECTOR, DOUBLE])
def test_each_lane_is_as_on_floats_and_fails_alone(values, monkeypatch):
    monkeypatch.setattr(emit, "VALUES", values)
    graph = Graph()
    x, y, low = *graph.inputs("state", 2), graph.input("parameters", 0)
    value, full = saturated(x * y, (low, 3.0))
    kernel = Kernel("main", (value, full, lagged(value, 1.0) - full), 1)
    state, parameters = given(2), np.full((1, 8), -2.0)
    state[:, 3], state[:, 5] = 4.0, np.inf
    found = call(kernel, state=state, parameters=parameters)
    assert np.isnan(found).all(axis=0).tolist() == [lane in (3, 5) for lane in range(8)]
    for lane in (0, 1, 2, 4, 6, 7):
        value, full = saturated(float(state[0, lane] * state[1, lane]), (-2.0, 3.0))
        assert_same_bits(found[:, lane], [value, full, lagged(value, 1.0) - full])
    order = [7, 3, 0, 5, 1, 2, 6, 4]
    assert_same_bits(call(kernel, state=state[:, order], parameters=parameters), found[:, order])


def test_what_depends_on_parameters_alone_is_called_once():
    graph = Graph()
    x, p = graph.input("state", 0), graph.input("parameters", 0)
    value, full = saturated(p, (-1.0, 1.0))
    kernel = Kernel("main", (x * value, full), 1)
    assert "call i32" not in kernel.text().partition("@main_prepare")[0]
    found = call(kernel, state=np.ones((1, 8)), parameters=np.full((1, 8), 0.125))
    assert_same_bits(found[:, 0], saturated(0.125, (-1.0, 1.0)))


@pytest.mark.parametrize("long", [0, 10**6])
def test_calls_stay_with_their_outputs_in_kernels_that_are_cut(long, monkeypatch):
    """Into equal segments, or by size. Segments that differ in the function alone are two."""
    monkeypatch.setattr(emit, "LONG", long)
    monkeypatch.setattr(emit, "REPEATED", 1.0)
    monkeypatch.setattr(segments, "SHORTEST", 1)
    monkeypatch.setattr(segments, "LONGEST", 5)
    graph = Graph()
    x, late = list(graph.inputs("state", 3)), []
    for n in range(60):
        value, full = saturated(x[n], (-1.0 - n, 1.0))
        x.append(x[n + 1] - 0.5 * (lagged(value, n) if n % 2 else lagged(n, value)))
        late.append(full)  # is needed at the end
    outputs = [*x[3:], *late]
    kernel, state = Kernel("main", tuple(outputs), 0), given(3)
    found = call(kernel, state=state)
    tape = Tape.of(outputs)
    for lane in (0, 5):
        for _ in range(13):  # also as a function
            exact = tape.replayed(lambda array, row, lane=lane: float(state[row, lane]))
        np.testing.assert_allclose(found[:, lane], exact, rtol=1e-12, atol=1e-12)
    other = Graph()
    again = Tape.of(x[3:6]).replayed(other.input)
    assert_same_bits(call(Kernel("main", tuple(again), 0), state=state), found[:3])


def test_it_has_no_derivative():
    graph = Graph(analytic=True)
    x, y = graph.inputs("state", 2)
    assert partials([x * lagged(y, 1.0)], [{x: 1.0}])
    with pytest.raises(ScenarioError, match=r"the function lagged: is not traced and so has no"):
        partials([x * lagged(y, 1.0)], [{y: 1.0}])


@pytest.mark.release
def test_the_same_bits_for_an_old_cpu():
    """A loop that is vectorised, sums, and a function of `lienumba.laws`."""
    environment = os.environ | {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    done = subprocess.run([sys.executable, "-c", CHILD], cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.stdout.strip() == digest(), done.stderr
