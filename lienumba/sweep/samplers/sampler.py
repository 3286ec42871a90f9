"""A sampler as a record: how the uniform numbers behind all samples of a sweep are drawn, and what follows from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lienumba.keys.literature import Reference
from lienumba.keys.registry import Registry

Streams = Mapping[str, Sequence[str]]  # the names of the streams of each varied path
Draw = Callable[[Streams, np.ndarray, int, int], dict[str, np.ndarray]]


@dataclass(frozen=True)
class Sampler:
    """draw(streams, labels, seed, runs): a number in (0, 1) for each stream and run (labels from 0 on) of a sweep of so
    many; those of a run may depend on nothing else.

    references: what a citation names; order_matters: whether it does to samples which path comes first; evenly:
    whether runs fill the space of all inputs more evenly than by chance; whole: what makes them depend on the
    number of runs, which then cannot grow; most_dimensions: of uniform numbers for each run, of which it takes
    `dimensions` where inputs have n; row: of how many runs a row consists where f inputs vary, all rows being
    whole; independent: whether inputs may have no correlations; independent_of_row: how many runs at the beginning
    of a row share no number; sobol_indices, screening: whether its runs are laid out for them, or for elementary
    effects; from_table: whether samples are given; weighted: whether runs have weights.
    """

    name: str
    draw: Draw
    references: tuple[Reference, ...] = ()
    order_matters: bool = False
    evenly: bool = False
    whole: str = ""
    most_dimensions: int | None = None
    dimensions: Callable[[int], int] = lambda n: n
    row: Callable[[int], int] | None = None
    independent: bool = False
    independent_of_row: int = 0
    sobol_indices: bool = False
    screening: bool = False
    from_table: bool = False
    weighted: bool = False

    def counting(self, labels: np.ndarray, inputs: int) -> np.ndarray:
        """Which runs with these labels count as independent (runs,): all but the nominal one, unless there is no other;
        of rows those that share no number; inputs: how many are drawn."""
        drawn: np.ndarray = labels >= 0 if (labels >= 0).any() else labels < 0
        return drawn if self.row is None else drawn & (labels % self.row(inputs) < self.independent_of_row)


SAMPLERS: Registry[Sampler] = Registry("sampler", lambda sampler: sampler.name)


def names_of(streams: Streams) -> list[str]:
    """Of all streams."""
    return [name for of_path in streams.values() for name in of_path]
