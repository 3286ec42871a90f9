"""Morris' design: rows of runs of which each changes one more input.

The first run of a row is drawn at random, and then one input after another, in a random order, moves from its number u
to u + s modulo 1 with a random s from 1/4 to 3/4. So every number is uniform, every step is from 1/4 to 3/4 of the
range of probability, and no period hides an effect as it may for steps of one size.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lienumba.keys.literature import Reference
from lienumba.sweep.samplers.sampler import Sampler, Streams
from lienumba.sweep.samplers.streams import LARGEST, SMALLEST, uniforms

NEAREST = 0.25  # of the ends of a step, modulo 1


def runs_of_row(inputs: int) -> int:
    """The first, and one for each input."""
    return inputs + 1


def places(inputs: Sequence[str], rows: np.ndarray, seed: int) -> np.ndarray:
    """The run of its row, from 1 on, in which each input moves (inputs, rows)."""
    u = np.array([uniforms(f"{name} order", rows, seed) for name in inputs])
    found: np.ndarray = u.argsort(axis=0, kind="stable").argsort(axis=0, kind="stable") + 1
    return found


def moved(u: np.ndarray, path: str, rows: np.ndarray, seed: int) -> np.ndarray:
    """Where an input moves from its uniform number u (rows,)."""
    step = NEAREST + (1.0 - 2.0 * NEAREST) * uniforms(f"{path} step", rows, seed)
    return np.clip((u + step) % 1.0, SMALLEST, LARGEST)


def draw(streams: Streams, labels: np.ndarray, seed: int, runs: int) -> dict[str, np.ndarray]:
    """The inputs in an order of their own in each row."""
    inputs = {path: names for path, names in streams.items() if names}
    if not inputs:
        return {}
    row, part = np.divmod(labels, runs_of_row(len(inputs)))
    behind = part >= places(list(inputs), row, seed)
    found = {}
    for (path, names), own in zip(inputs.items(), behind, strict=True):
        for name in names:
            u = uniforms(name, row, seed)
            found[name] = np.where(own, moved(u, path, row, seed), u)
    return found


MORRIS_1991 = Reference(
    "morris1991", "article", "Morris, Max D.", 1991,
    "Factorial sampling plans for preliminary computational experiments",
    "Technometrics", "33(2):161--174", "10.1080/00401706.1991.10484804",
)  # fmt: skip
CAMPOLONGO = Reference(
    "campolongo2007", "article", "Campolongo, Francesca and Cariboni, Jessica and Saltelli, Andrea", 2007,
    "An effective screening design for sensitivity analysis of large models",
    "Environmental Modelling & Software", "22(10):1509--1518", "10.1016/j.envsoft.2006.10.004",
)  # fmt: skip
MORRIS = Sampler(
    "morris", draw, (MORRIS_1991, CAMPOLONGO), row=runs_of_row, independent=True, independent_of_row=1, screening=True,
)  # fmt: skip
