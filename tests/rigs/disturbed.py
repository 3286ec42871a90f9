"""Sweeps that are disturbed, and what is the same in them all the same."""

from typing import Any

import numpy as np

from lienumba.scenario.reading.loading import load
from tests.rigs.places import SCENARIOS

TOP = SCENARIOS / "heavy_top_monte_carlo.toml"
FULL: dict[str, Any] = {"every": 0.01}
SUMMARY: dict[str, Any] = {
    "every": 0.005, "mode": "summary", "full_runs": "3:20,30", "summary": {"position": ["max", "rms"]},
}  # fmt: skip


def sweep(runs: int = 40, end: float = 0.05, sampler: str = "random", **output: Any) -> dict[str, Any]:
    """Heavy tops, a few chunks of them."""
    data = load(TOP)
    data["integrator"]["end_time"] = end
    data["sweep"] |= {"runs": runs, "sampler": sampler}
    data["quantities"] = [{"name": "tip", "type": "point", "body": "top", "point": [0, 0.2, 0]}]
    data["measures"] = [{"name": "lowest tip", "value": "min(tip.z)"}, {"name": "leaning", "value": "mean(tip.x)"}]
    return data | {"output": output or FULL}


def assert_same_data(a: Any, b: Any) -> None:
    """The same variables and coordinates with the same bits and attributes."""
    assert set(a.variables) == set(b.variables)
    for name in a.variables:
        x, y = a[name], b[name]
        assert x.dims == y.dims, name
        if x.dtype.kind in "OU" and y.dtype.kind in "OU":  # a file gives texts as objects
            assert x.values.tolist() == y.values.tolist(), name
        else:
            assert x.values.dtype == y.values.dtype, name
            assert x.values.tobytes() == y.values.tobytes(), name
        assert {key: np.asarray(v).tolist() for key, v in x.attrs.items()} == {
            key: np.asarray(v).tolist() for key, v in y.attrs.items()
        }, name
