"""Where the samples of a noise come from: a linear recursion that normal numbers drive, or a file."""

from dataclasses import dataclass
from typing import Any

Square = tuple[tuple[Any, ...], ...]


@dataclass(frozen=True)
class Recursion:
    """x[0] = start w[0], x[k + 1] = move x[k] + kick w[k + 1], of which out . x is told; w: normal numbers. Square
    matrices, start and kick lower triangles; entries are floats, or arrays (runs,)."""

    move: Square
    kick: Square
    start: Square
    out: tuple[Any, ...]


@dataclass(frozen=True)
class Recorded:
    """Samples of each run that stand in a file with this checksum: a variable (run, time) of so many samples."""

    file: str
    variable: str
    samples: int
    checksum: str | None
