"""Points that fill the unit cube more evenly than random ones: Latin hypercubes, Sobol' and Halton sequences.

Point i of a sequence depends on its index alone. It is randomised for each path from the path's own stream, so that
every number is uniform over the seeds, and no path changes another one's samples.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count
from math import ceil, log2
from typing import TYPE_CHECKING

from lienumba.sweep.samplers.streams import SMALLEST, uniforms

if TYPE_CHECKING:
    import numpy as np

LARGEST = 1.0 - 2.0**-53
DIGITS = 53  # binary ones of a double
SOBOL_BITS = 32  # of SciPy's integers: as many points as runs may have labels
MOST_DIMENSIONS = 21201  # of SciPy's Sobol' sequence: those of S. Joe and F. Y. Kuo (2008)


def latin_hypercube(path: str, labels: np.ndarray, seed: int, runs: int) -> np.ndarray:
    """Of `runs` equal parts of (0, 1) one for each run, in an order that the seed and the path decide."""
    import numpy as np

    order = np.argsort(uniforms(f"{path} order", np.arange(runs), seed), kind="stable")
    samples: np.ndarray = (order[labels] + uniforms(path, labels, seed)) / runs
    return np.minimum(samples, LARGEST)


def sobol(paths: Sequence[str], labels: np.ndarray, seed: int, first: int = 0) -> dict[str, np.ndarray]:
    """The Sobol' sequence, path j in dimension first + j, its binary digits flipped by a random number for each path (a
    digital shift), which keeps its evenness."""
    import numpy as np

    if not paths:
        return {}
    gray = labels.astype(np.uint64)
    gray ^= gray >> np.uint64(1)
    bits = int(labels.max(initial=0)).bit_length()
    found = {}
    for path, numbers in zip(paths, _direction_numbers(first + len(paths), bits)[first:], strict=True):
        points = np.zeros(labels.shape, np.uint64)
        for k in range(bits):
            points ^= (gray >> np.uint64(k) & np.uint64(1)) * numbers[k]
        shift = np.uint64(uniforms(f"{path} shift{' of B' if first else ''}", [0], seed)[0] * 2.0**DIGITS)
        samples = (points << np.uint64(DIGITS - SOBOL_BITS) ^ shift) * 2.0**-DIGITS
        found[path] = np.maximum(samples, SMALLEST)
    return found


def _direction_numbers(dimensions: int, bits: int) -> np.ndarray:
    """What SciPy's sequence is made of, (dimensions, bits): number k is its point 2^(k+1) - 1, of Gray code 2^k."""
    import numpy as np
    from scipy.stats import qmc

    engine = qmc.Sobol(dimensions, scramble=False, bits=SOBOL_BITS)
    numbers = np.empty((dimensions, bits), np.uint64)
    for k in range(bits):
        engine.fast_forward(2 ** (k + 1) - 1 - engine.num_generated)
        numbers[:, k] = engine.random(1)[0] * 2.0**SOBOL_BITS
    return numbers


def halton(paths: Sequence[str], labels: np.ndarray, seed: int) -> dict[str, np.ndarray]:
    """The Halton sequence, path j in the base of the prime j, each digit permuted at random for each path."""
    return {
        path: _radical_inverse(f"{path} digits", base, labels, seed)
        for path, base in zip(paths, _primes(), strict=False)
    }


def _radical_inverse(stream: str, base: int, labels: np.ndarray, seed: int) -> np.ndarray:
    import numpy as np

    digits = ceil(DIGITS / log2(base))  # zeros in front of an index are digits, too
    orders = np.argsort(uniforms(stream, np.arange(digits * base), seed).reshape(digits, base), kind="stable")
    left, samples, value = labels, np.zeros(labels.shape), 1.0
    for order in orders:
        left, digit = np.divmod(left, base) if left.any() else (left, left)
        value /= base
        samples = samples + order[digit] * value
    return np.clip(samples, SMALLEST, LARGEST)


def _primes() -> Iterator[int]:
    found: list[int] = []
    for n in count(2):
        if all(n % p for p in found):
            found.append(n)
            yield n
