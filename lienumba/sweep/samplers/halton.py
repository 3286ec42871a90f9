"""The Halton sequence with permuted digits: point i depends on its index alone, and each digit of it is permuted at
random for each stream, so that every number is uniform over the seeds."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from math import ceil, log2

import numpy as np

from lienumba.keys.literature import Reference
from lienumba.sweep.samplers.sampler import Sampler, Streams, names_of
from lienumba.sweep.samplers.streams import LARGEST, SMALLEST, uniforms

DIGITS = 53  # binary ones of a double


def draw(streams: Streams, labels: np.ndarray, seed: int, runs: int) -> dict[str, np.ndarray]:
    """Stream j in the base of the prime j."""
    every = zip(names_of(streams), _primes(), strict=False)
    return {name: _radical_inverse(f"{name} digits", base, labels, seed) for name, base in every}


def _radical_inverse(stream: str, base: int, labels: np.ndarray, seed: int) -> np.ndarray:
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


HALTON_1960 = Reference(
    "halton1960", "article", "Halton, J. H.", 1960,
    "On the efficiency of certain quasi-random sequences of points in evaluating multi-dimensional integrals",
    "Numerische Mathematik", "2(1):84--90", "10.1007/BF01386213",
)  # fmt: skip
HALTON = Sampler(
    "halton", draw, (HALTON_1960,), order_matters=True, evenly=True
)  # fmt: skip
