"""Latin hypercubes: as many equal parts of each range as there are runs, and a run in each."""

from __future__ import annotations

import numpy as np

from lienumba.keys.literature import Reference
from lienumba.sweep.samplers.sampler import Sampler, Streams, names_of
from lienumba.sweep.samplers.streams import LARGEST, uniforms


def draw(streams: Streams, labels: np.ndarray, seed: int, runs: int) -> dict[str, np.ndarray]:
    return {name: _points(name, labels, seed, runs) for name in names_of(streams)}


def _points(name: str, labels: np.ndarray, seed: int, runs: int) -> np.ndarray:
    """Of `runs` equal parts of (0, 1) one for each run, in an order that the seed and the stream decide."""
    order = np.argsort(uniforms(f"{name} order", np.arange(runs), seed), kind="stable")
    samples: np.ndarray = (order[labels] + uniforms(name, labels, seed)) / runs
    return np.minimum(samples, LARGEST)


MCKAY = Reference(
    "mckay1979", "article", "McKay, M. D. and Beckman, R. J. and Conover, W. J.", 1979,
    "A comparison of three methods for selecting values of input variables in the analysis of output from a "
    "computer code",
    "Technometrics", "21(2):239--245", "10.1080/00401706.1979.10489755",
)  # fmt: skip
LATIN_HYPERCUBE = Sampler(
    "latin_hypercube", draw, (MCKAY,),
    whole="divides each range into as many parts as there are runs",
)  # fmt: skip
