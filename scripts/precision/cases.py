"""The mechanisms that are measured, and studies of them."""

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import lienumba
from lienumba.integrators import methods
from lienumba.scenario.checks.integrator import pairs

ROOT = Path(__file__).resolve().parents[2]
METHODS = sorted(methods.METHODS, key=lambda name: methods.METHODS[name].order)
PAIRS = pairs()
PROJECTED = {"projection.position": "local", "projection.velocity": "mass"}
FREE = {"projection.position": "none", "projection.velocity": "none"}


def gallery(name: str, **more: Any) -> dict[str, Any]:
    """A scenario of the gallery with something put over it."""
    return {"extends": str(ROOT / "scenarios" / f"{name}.toml"), **more}


def study(
    scenario: Any, reference: Mapping[str, Any], grid: Sequence[Mapping[str, Any]], overrides: Mapping[str, Any]
) -> Any:
    """The dataset of a study, each point run once on one core."""
    wanted = {"reference": dict(reference), "grid": [dict(one) for one in grid], "repeats": 1}
    return simulated(scenario, {"study": wanted, **overrides})


def simulated(scenario: Any, overrides: Mapping[str, Any]) -> Any:
    """On one core; without warnings: the satellite's slider has an inertia that no rigid body has, as printed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return lienumba.run(scenario, overrides=overrides, workers=1)
