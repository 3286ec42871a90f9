"""Conditions at a fraction of a step: by one kernel, and from the whole state there."""

import ctypes
from typing import Any

import numpy as np
import pytest

from lienumba.compiler.rows import W
from lienumba.engine import programs
from lienumba.integrators import layout
from lienumba.integrators.tracing.machine import Machine, aligned, prepare
from lienumba.scenario.start.prepare import prepare as prepared_of
from tests.facade import resolve
from tests.oracles.changing import scenarios


def machine(when: str, **more: Any) -> Machine:
    """Of a pendulum with one event."""
    hinge = {"name": "hinge", "type": "spherical", "bodies": ["ground", "rod"], "points": [[0, 0, 0], [0, 0.5, 0]]}
    tip = {"name": "tip", "type": "point", "body": "rod", "point": [0, -0.5, 0]}
    data = {
        "model": {
            "bodies": [{"name": "rod", "mass": 2, "inertia": [0.1, 0.01, 0.1], "position": [0, -0.5, 0]}],
            "joints": [hinge],
        },
        "events": [{"name": "there", "when": when}],
        "quantities": [tip, {"name": "load", "type": "reaction", "joint": "hinge"}],
        "integrator": scenarios.settings(1.0, 1e-9, **more),
    }
    resolved = resolve(data)
    prepared = prepared_of(resolved, range(1))
    return programs.compiled_of(resolved, prepared, True)[1]


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_one_kernel_says_what_the_whole_state_does(coordinates: str) -> None:
    made = machine("tip.x * tip.y > 0.1 + t", coordinates=coordinates)
    sizes, draw = made.sizes, np.random.default_rng(7)
    rows = layout.first_slope(sizes) + layout.series_row(sizes) + 64
    x, slopes, parameters = aligned(rows, W), aligned(rows, W), aligned(1, sizes.parameters, W)
    x[:] = 0.3 * draw.standard_normal(x.shape)
    slopes[:] = 0.3 * draw.standard_normal(slopes.shape)
    parameters[:] = draw.uniform(0.5, 1.5, parameters.shape)
    prepare(made, parameters)
    clock, work = aligned(layout.CLOCK, W), made.buffer()
    clock[layout.TIME], clock[layout.LENGTH], clock[layout.FRACTION] = 0.2, 0.1, draw.uniform(0, 1, W)
    state, apart, together = aligned(rows, W), aligned(rows, W), aligned(rows, W)

    def call(kernel: int, given: np.ndarray, extra: np.ndarray, out: np.ndarray) -> None:
        function = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 6)(int(made.kernels[kernel]))
        function(*(a.ctypes.data for a in (given, parameters, clock, extra, out, work)))

    call(layout.WATCH, x, slopes, together)
    call(layout.DENSE, x, slopes, state)
    clock[layout.TIME] += clock[layout.FRACTION] * 0.1
    call(layout.EVENTS, state, slopes, apart)
    assert np.isfinite(together[0]).all()
    assert np.ptp(together[0]) > 0
    np.testing.assert_array_equal(together[0], apart[0])


def test_what_reactions_decide_needs_the_whole_state() -> None:
    assert not machine("load.force.z > 3").kernels[layout.WATCH]
    assert machine("tip.x > 3").kernels[layout.WATCH]
