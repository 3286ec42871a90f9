"""Drivers as plain Python, lanes in NumPy, against the same drivers compiled: equal bits."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.compiler import flat
from lienumba.integrators.tracing import machine
from lienumba.integrators.tracing.compiled import PROGRAMS
from tests.integrators.drivers.test_events import LEFT, LOW, pendulum
from tests.rigs import parts

TOP = {
    "extends": "scenarios/heavy_top.toml",
    "integrator": {"end_time": 0.02},
    "output": {"every": 0.01},
    "measures": [{"name": "highest", "value": "max(E)"}],
    "quantities": [{"name": "E", "type": "expression", "value": "t*t", "units": "s2"}],
}
BOUNCES = {
    "model": {
        "gravity": [0, 0, -9.81],
        "bodies": [parts.body("b", 2.0, [0.3, 0.6, 0.4], position=[0, 0, 0.3], velocity=[1, 0.2, 0])],
        "contacts": [parts.foot("c", "b", restitution=0.5, friction=0.3)],
    },
    "integrator": {"end_time": 0.6, "tolerance": 1e-6},
    "output": {"every": 0.1},
}


@pytest.mark.parametrize(
    "scenario", [TOP, pendulum(LOW, LEFT, method="dp54", tolerance=1e-6), pendulum(LOW, step=0.125), BOUNCES]
)
def test_plain_python_gives_the_bits_of_the_compiled_driver(scenario: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = lienumba.run(scenario, workers=1, progress=False)
    monkeypatch.setenv("LIENUMBA_DRIVERS", "python")
    made: list[Any] = []
    plain = flat.plain

    def noted(module: str, name: str) -> Any:
        made.append(plain(module, name))
        return made[-1]

    monkeypatch.setattr(machine, "plain", noted)
    PROGRAMS.clear()
    python = lienumba.run(scenario, workers=1, progress=False)
    PROGRAMS.clear()
    assert made
    for name, values in compiled.data_vars.items():
        np.testing.assert_array_equal(values, python[name], err_msg=str(name))
