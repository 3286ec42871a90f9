"""The Sobol' sequence with a digital shift: its binary digits are flipped by a random number for each stream, so that
every number is uniform over the seeds; point i depends on its index alone. And rows of two of its points for indices.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lienumba.keys.literature import Reference
from lienumba.sweep.samplers.sampler import Sampler, Streams, names_of
from lienumba.sweep.samplers.streams import SMALLEST, uniforms

DIGITS = 53  # binary ones of a double
BITS = 32  # of SciPy's integers: as many points as runs may have labels
MOST_DIMENSIONS = 21201  # of SciPy's sequence: those of S. Joe and F. Y. Kuo (2008)


def draw(streams: Streams, labels: np.ndarray, seed: int, runs: int) -> dict[str, np.ndarray]:
    return points(names_of(streams), labels, seed)


def points(names: Sequence[str], labels: np.ndarray, seed: int, first: int = 0) -> dict[str, np.ndarray]:
    """The sequence, stream j in dimension first + j."""
    if not names:
        return {}
    gray = labels.astype(np.uint64)
    gray ^= gray >> np.uint64(1)
    bits = int(labels.max(initial=0)).bit_length()
    found = {}
    for name, numbers in zip(names, _direction_numbers(first + len(names), bits)[first:], strict=True):
        point = np.zeros(labels.shape, np.uint64)
        for k in range(bits):
            point ^= (gray >> np.uint64(k) & np.uint64(1)) * numbers[k]
        shift = np.uint64(uniforms(f"{name} shift{' of B' if first else ''}", [0], seed)[0] * 2.0**DIGITS)
        samples = (point << np.uint64(DIGITS - BITS) ^ shift) * 2.0**-DIGITS
        found[name] = np.maximum(samples, SMALLEST)
    return found


def _direction_numbers(dimensions: int, bits: int) -> np.ndarray:
    """What SciPy's sequence is made of, (dimensions, bits): number k is its point 2^(k+1) - 1, of Gray code 2^k."""
    from scipy.stats import qmc

    engine = qmc.Sobol(dimensions, scramble=False, bits=BITS)
    numbers = np.empty((dimensions, bits), np.uint64)
    for k in range(bits):
        engine.fast_forward(2 ** (k + 1) - 1 - engine.num_generated)
        numbers[:, k] = engine.random(1)[0] * 2.0**BITS
    return numbers


def draw_rows(streams: Streams, labels: np.ndarray, seed: int, runs: int) -> dict[str, np.ndarray]:
    """Two points A and B, and A with the numbers of one input after another from B; the next row likewise."""
    inputs, names = [of_path for of_path in streams.values() if of_path], names_of(streams)
    if not names:
        return {}
    row, part = np.divmod(labels, runs_of_row(len(inputs)))
    A, B = points(names, row, seed), points(names, row, seed, first=len(names))
    return {name: np.where(of_B(part, k), B[name], A[name]) for k, of_input in enumerate(inputs) for name in of_input}


def of_B(part: np.ndarray, k: int) -> np.ndarray:
    """Whether the runs of these places in a row (n,) take input k from B instead of A."""
    found: np.ndarray = (part == 1) | (part == 2 + k)
    return found


def runs_of_row(inputs: int) -> int:
    """A, B, and one for each input."""
    return inputs + 2


SOBOL_1967 = Reference(
    "sobol1967", "article", "Sobol', I. M.", 1967,
    "On the distribution of points in a cube and the approximate evaluation of integrals",
    "USSR Computational Mathematics and Mathematical Physics", "7(4):86--112", "10.1016/0041-5553(67)90144-9",
)  # fmt: skip
JOE = Reference(
    "joe2008", "article", "Joe, Stephen and Kuo, Frances Y.", 2008,
    "Constructing Sobol sequences with better two-dimensional projections",
    "SIAM Journal on Scientific Computing", "30(5):2635--2654", "10.1137/070709359",
)  # fmt: skip
SALTELLI_2010 = Reference(
    "saltelli2010", "article",
    "Saltelli, Andrea and Annoni, Paola and Azzini, Ivano and Campolongo, Francesca and Ratto, Marco and "
    "Tarantola, Stefano",
    2010,
    "Variance based sensitivity analysis of model output. Design and estimator for the total sensitivity index",
    "Computer Physics Communications", "181(2):259--270", "10.1016/j.cpc.2009.09.018",
)  # fmt: skip
SOBOL = Sampler(
    "sobol", draw, (SOBOL_1967, JOE), order_matters=True, evenly=True, most_dimensions=MOST_DIMENSIONS,
)  # fmt: skip
SALTELLI = Sampler(
    "saltelli", draw_rows, (SOBOL_1967, JOE, SALTELLI_2010), order_matters=True, most_dimensions=MOST_DIMENSIONS,
    dimensions=lambda n: 2 * n, row=runs_of_row, independent=True, independent_of_row=2, sobol_indices=True,
)  # fmt: skip
