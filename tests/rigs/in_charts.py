"""Every way in which a state may be advanced, as keys of [integrator], and runs in it."""

from typing import Any

import numpy as np

import lienumba
from tests.rigs.scenarios import scenario

SE3 = {"group": "SE3"}
COMPARATORS = {name: {"coordinates": name} for name in ("matrix", "tait_bryan", "rotation_vector", "quaternion")}
CHARTS: dict[str, dict[str, Any]] = {
    "R3xSO3": {},
    "SE3": SE3,
    "SE3 closed": SE3 | {"dexpinv": "closed"},
    **COMPARATORS,
    "cf4": {"method": "cf4"},
    "cf4 on SE3": {"method": "cf4"} | SE3,
}
NONE, BOTH = ("none", "none"), ("local", "mass")


def run_in(chart: dict[str, Any], mechanism: dict[str, Any], step: float, end: float, **keywords: Any) -> Any:
    """The dataset of the first run of `scenario(...)` in a chart; it must be good."""
    data = scenario(mechanism, step, end, **keywords)
    data["integrator"] |= chart
    dataset = lienumba.run(data, workers=1)
    assert (dataset["status"] == 0).all()
    return dataset.isel(run=0)


def numbers(dataset: Any, time: int = -1) -> np.ndarray:
    """Of a state at one of the stored times."""
    names = ("position", "rotation", "velocity", "angular_velocity")
    return np.concatenate([dataset[name].isel(time=time).values.ravel() for name in names])


def orthogonality(dataset: Any) -> float:
    """The largest element of R R^T - I."""
    R = dataset["rotation"].values
    return float(np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max())
