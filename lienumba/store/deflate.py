"""What HDF5's filters `shuffle` and `deflate` make of a chunk, and checksums: by ISA-L, or zlib where that is not."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

LEVEL = 1


def deflated(chunk: np.ndarray) -> bytes:
    """A chunk as the file holds it: the first bytes of all numbers, then the second ones, and so on, compressed."""
    size = chunk.dtype.itemsize
    planes = np.ascontiguousarray(chunk).reshape(-1).view(np.uint8).reshape(-1, size).T
    return _library().compress(np.ascontiguousarray(planes), LEVEL)


def checksum(content: bytes | memoryview | np.ndarray, before: int = 0) -> int:
    """CRC-32 of what follows something that has one, the same by either library."""
    return _library().crc32(content, before)


class _Library:
    """compress(content, level): a zlib stream."""

    def __init__(self, module: Any) -> None:
        self.compress: Callable[[Any, int], bytes] = module.compress
        self.crc32: Callable[[Any, int], int] = module.crc32


@cache
def _library() -> _Library:
    try:
        from isal import isal_zlib
    except ImportError:
        import zlib

        return _Library(zlib)
    return _Library(isal_zlib)
