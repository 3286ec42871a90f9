"""Datasets of the gallery, the first tenth of a second of each, simulated once."""

import warnings
from functools import cache
from typing import Any

import lienumba
from tests.rigs.places import SCENARIOS

SHORT = {"integrator.end_time": 0.1, "output.every": 0.01}


@cache
def gallery(name: str) -> Any:
    """The dataset of this scenario."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what a scenario of the gallery is told of is no matter here
        return lienumba.run(SCENARIOS / f"{name}.toml", runs=[0], overrides=SHORT)
