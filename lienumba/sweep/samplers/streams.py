"""Uniform numbers: one stream for each seed, run and path, so that nothing else can change a sample.

The stream is NumPy's PCG64(SeedSequence(seed, spawn_key=(run, *words of sha256(path)))). Building these
objects costs more than simulating a small mechanism, so both are computed here for all runs at once; a test
compares every bit with NumPy's own.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Words = NDArray[np.uint32]
    Wide = tuple[NDArray[np.uint64], NDArray[np.uint64]]  # 128 bits: high, low

MASK = 0xFFFFFFFF
POOL_SIZE = 4
HASH_POOL = (0x43B0D7E5, 0x931E8875)  # SeedSequence: first constant, and what it is multiplied by at each use
HASH_STATE = (0x8B51F9DD, 0x58F38DED)
MIX = (0xCA01F9DD, 0x4973F715)
PCG_MULTIPLIER = 0x2360ED051FC65DA44385DF649FCCF645
BLOCK = 1 << 14  # runs at a time, so that what they need stays in the processor's cache
SMALLEST = 2.0**-54  # stands for 0, which no unbounded distribution can take
LARGEST = 1.0 - 2.0**-53  # below 1


def uniforms(path: str, runs: Sequence[int] | np.ndarray, seed: int) -> np.ndarray:
    """The first number in (0, 1) of each run's stream for `path`, shape (runs,); labels are 0 to 2**32 - 1."""
    labels = np.asarray(runs, dtype=np.int64)
    if labels.size and not 0 <= labels.min() <= labels.max() <= MASK:
        raise ValueError(f"run labels must lie between 0 and {MASK}, but reach {labels.min()} and {labels.max()}")
    blocks = [labels[start : start + BLOCK] for start in range(0, len(labels), BLOCK)]
    return np.concatenate([_uniforms(path, block, seed) for block in blocks] or [np.empty(0)])


def _uniforms(path: str, labels: NDArray[np.int64], seed: int) -> np.ndarray:
    digest = hashlib.sha256(path.encode()).digest()
    seed_words = [seed >> shift & MASK for shift in range(0, max(seed.bit_length(), 1), 32)]
    entropy = [*seed_words, *[0] * (POOL_SIZE - len(seed_words)), labels]
    entropy += [int.from_bytes(digest[k : k + 4], "little") for k in range(0, len(digest), 4)]
    words = [np.broadcast_to(np.asarray(word, dtype=np.uint32), labels.shape) for word in entropy]
    samples: np.ndarray = (_pcg64(_seed_words(words)) >> np.uint64(11)) * 2.0**-53
    return np.where(samples > 0.0, samples, SMALLEST)


def _hash(value: Words, constants: Iterator[int]) -> Words:
    hashed: Words = (value ^ np.uint32(next(constants))) * np.uint32(next(constants))
    return hashed ^ (hashed >> np.uint32(16))


def _constants(first: int, multiplier: int) -> Iterator[int]:
    """The hash takes two at a time: c0, c1, then c1, c2, then c2, c3 ..."""
    while True:
        yield first
        first = first * multiplier & MASK
        yield first


def _seed_words(entropy: list[Words]) -> list[Words]:
    """SeedSequence: eight words of state from the words of entropy, all uint32 (runs,)."""
    constants = _constants(*HASH_POOL)

    def mix(x: Words, y: Words) -> Words:
        mixed: Words = np.uint32(MIX[0]) * x - np.uint32(MIX[1]) * _hash(y, constants)
        return mixed ^ (mixed >> np.uint32(16))

    pool = [_hash(word, constants) for word in entropy[:POOL_SIZE]]
    for source in range(POOL_SIZE):
        for target in range(POOL_SIZE):
            if source != target:
                pool[target] = mix(pool[target], pool[source])
    for word in entropy[POOL_SIZE:]:
        pool = [mix(value, word) for value in pool]
    constants = _constants(*HASH_STATE)
    return [_hash(pool[k % POOL_SIZE], constants) for k in range(8)]


def _pcg64(words: list[Words]) -> NDArray[np.uint64]:
    """PCG64 (XSL-RR): the first 64 bits, uint64 (runs,), of generators seeded with these words."""
    half = [words[k].astype(np.uint64) | words[k + 1].astype(np.uint64) << np.uint64(32) for k in range(0, 8, 2)]
    start, sequence = (half[0], half[1]), (half[2], half[3])
    one = np.uint64(1)
    increment = (sequence[0] << one | sequence[1] >> np.uint64(63), sequence[1] << one | one)
    state = _add(increment, start)
    for _ in range(2):  # one step ends the seeding, one makes the number
        state = _add(_multiply(state), increment)
    mixed, turn = state[0] ^ state[1], state[0] >> np.uint64(58)
    turned: NDArray[np.uint64] = np.bitwise_or(mixed >> turn, mixed << (np.uint64(64) - turn & np.uint64(63)))
    return turned


def _add(a: Wide, b: Wide) -> Wide:
    low = a[1] + b[1]
    return a[0] + b[0] + (low < a[1]), low


def _multiply(a: Wide) -> Wide:
    """a times the multiplier of PCG64, modulo 2**128."""
    shift, mask = np.uint64(32), np.uint64(MASK)
    high, low = np.uint64(PCG_MULTIPLIER >> 64), np.uint64(PCG_MULTIPLIER & (1 << 64) - 1)
    a1, a0, b1, b0 = a[1] >> shift, a[1] & mask, low >> shift, low & mask
    middle = a1 * b0 + (a0 * b0 >> shift)
    other = a0 * b1 + (middle & mask)
    carried = a1 * b1 + (middle >> shift) + (other >> shift)
    return carried + a[0] * low + a[1] * high, a[1] * low
