"""The uniform numbers of a sweep, by its sampler."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal, get_args

from lienumba.sweep.samplers import sequences
from lienumba.sweep.samplers.streams import uniforms

if TYPE_CHECKING:
    import numpy as np

Sampler = Literal["random", "latin_hypercube", "sobol", "halton", "table", "saltelli"]
SAMPLERS: tuple[str, ...] = get_args(Sampler)


def uniform_numbers(
    streams: Mapping[str, Sequence[str]], labels: np.ndarray, seed: int, sampler: str, runs: int
) -> dict[str, np.ndarray]:
    """A number in (0, 1) for each run (labels from 0 on) and stream; streams: of each varied path; runs: of the whole
    sweep."""
    names = [name for of_path in streams.values() for name in of_path]
    if sampler == "latin_hypercube":
        return {name: sequences.latin_hypercube(name, labels, seed, runs) for name in names}
    if sampler == "sobol":
        return sequences.sobol(names, labels, seed)
    if sampler == "halton":
        return sequences.halton(names, labels, seed)
    if sampler == "saltelli":
        return _saltelli([of_path for of_path in streams.values() if of_path], labels, seed)
    return {name: uniforms(name, labels, seed) for name in names}  # also of what a table lacks


def _saltelli(factors: Sequence[Sequence[str]], labels: np.ndarray, seed: int) -> dict[str, np.ndarray]:
    """Two points A and B, and A with the numbers of one factor after another from B: factors + 2 runs, and so on.

    A. Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Commun. 181 (2010).
    """
    import numpy as np

    names = [name for factor in factors for name in factor]
    if not names:
        return {}
    row, part = np.divmod(labels, len(factors) + 2)
    A, B = sequences.sobol(names, row, seed), sequences.sobol(names, row, seed, first=len(names))
    return {
        name: np.where((part == 1) | (part == 2 + k), B[name], A[name])
        for k, factor in enumerate(factors)
        for name in factor
    }
