"""The last stored time, where interval and end are no decimals."""

import math
from typing import Any

import numpy as np
import pytest

import lienumba

G = 9.81


@pytest.mark.parametrize("output", [{"every": 0.03 * math.sqrt(2)}, {"times": [0.0, 0.1, 0.3 * math.sqrt(2) + 6e-17]}])
@pytest.mark.parametrize(
    "settings", [{"tolerance": 1e-9}, {"method": "radau5", "tolerance": 1e-9}, {"method": "taylor", "tolerance": 1e-9}]
)
def test_something_is_stored_at_the_end(settings: dict[str, Any], output: dict[str, Any]) -> None:
    body = {"name": "b", "mass": 1.0, "inertia": [0.1] * 3, "position": [0, 0, 0]}
    end = 0.3 * math.sqrt(2)
    height = {"name": "p", "type": "point", "body": "b"}
    scenario = {
        "model": {"gravity": [0, 0, -G], "bodies": [body], "quantities": [height]},
        "integrator": settings | {"end_time": end}, "output": output | {"summary": {"p.z": ["final"]}},
    }  # fmt: skip
    ds = lienumba.run(scenario, progress=False).isel(run=0)
    assert float(ds.time[-1]) == end
    assert float(ds.position[-1, 0, 2]) == pytest.approx(-0.5 * G * end**2, abs=1e-12)
    assert float(ds["p.z_final"]) == float(ds.position[-1, 0, 2])
    assert not np.isnan(ds.position.values).any()
