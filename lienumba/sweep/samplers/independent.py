"""Independent random numbers, one stream for each input and run; a table of samples takes them for what it lacks."""

from __future__ import annotations

import numpy as np

from lienumba.keys.literature import Reference
from lienumba.sweep.samplers.sampler import Sampler, Streams, names_of
from lienumba.sweep.samplers.streams import uniforms


def draw(streams: Streams, labels: np.ndarray, seed: int, runs: int) -> dict[str, np.ndarray]:
    return {name: uniforms(name, labels, seed) for name in names_of(streams)}


ONEILL = Reference(
    "oneill2014", "techreport", "O'Neill, Melissa E.", 2014,
    "PCG: A family of simple fast space-efficient statistically good algorithms for random number generation",
    "Harvey Mudd College", "HMC-CS-2014-0905",
)  # fmt: skip
RANDOM = Sampler("random", draw, (ONEILL,))
TABLE = Sampler("table", draw, from_table=True)
