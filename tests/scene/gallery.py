"""Datasets of the gallery, each simulated once."""

import warnings
from functools import cache
from typing import Any

import lienumba
from tests.rigs.places import SCENARIOS


@cache
def gallery(name: str) -> Any:
    """The dataset of this scenario."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what a scenario of the gallery is told of is no matter here
        return lienumba.run(SCENARIOS / f"{name}.toml", runs=[0])
