"""The jitted steps are compiled once, and kept in Numba's cache: half a minute that is no cost of any one test."""

import pytest

import lienumba
from tests.rigs.parts import ORIGIN, pivot, resting


@pytest.fixture(scope="session")
def compiled() -> None:
    model = {"bodies": [resting(position=[0.1, 0, 0])], "joints": [pivot("hinge", "b", ORIGIN, [-0.1, 0, 0])]}
    integrator = {"step": 1e-3, "end_time": 1e-3, "engine": "numba"}
    lienumba.run({"model": model, "integrator": integrator}, progress=False)
