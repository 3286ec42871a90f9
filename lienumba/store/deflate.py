"""What HDF5's filters `shuffle` and `deflate` make of a chunk, and checksums: by ISA-L, or zlib where that is not.

The low bytes of numbers mostly are noise, which no compression makes smaller. They go into a stream as they are, for
which the format has blocks of its own: written and read at once, and the file is smaller.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np

LEVEL = 1
RAW = -15  # a stream without header and checksum, and its window
HEADER = b"\x78\x01"
BLOCK = 65535  # bytes of a block that is stored as it is
NOISE = 0.98  # of its size, to which noise can be compressed


def shuffled(chunk: np.ndarray) -> np.ndarray:
    """The first bytes of all numbers, then the second ones, and so on (bytes, numbers)."""
    size = chunk.dtype.itemsize
    return np.ascontiguousarray(np.ascontiguousarray(chunk).reshape(-1).view(np.uint8).reshape(-1, size).T)


def noise_of(planes: np.ndarray) -> int:
    """How many of the first planes are noise."""
    compress = _library().compress
    return next(
        (n for n, plane in enumerate(planes) if len(compress(plane, LEVEL, RAW)) < NOISE * plane.size), len(planes)
    )


def deflated(planes: np.ndarray, noise: int) -> bytes:
    """A zlib stream of these bytes; noise: how many of the first planes are not compressed."""
    library, first = _library(), noise * planes.shape[1]
    content = planes.reshape(-1)
    packed = library.compress(content[first:], LEVEL, RAW)
    return b"".join((HEADER, *_stored(content[:first].data), packed, struct.pack(">I", library.adler32(content))))


def checksum(content: bytes | memoryview, before: int = 0) -> int:
    """CRC-32 of what follows something that has one, the same by either library."""
    return _library().crc32(content, before)


def _stored(content: memoryview) -> Iterator[bytes | memoryview]:
    """Blocks, none of which is the last."""
    for first in range(0, len(content), BLOCK):
        block = content[first : first + BLOCK]
        yield struct.pack("<BHH", 0, len(block), len(block) ^ 0xFFFF)
        yield block


class _Library:
    """compress(content, level, window): a stream; checksums of something."""

    def __init__(self, module: Any) -> None:
        self.compress: Callable[[Any, int, int], bytes] = module.compress
        self.crc32: Callable[[Any, int], int] = module.crc32
        self.adler32: Callable[[Any], int] = module.adler32


@cache
def _library() -> _Library:
    try:
        from isal import isal_zlib
    except ImportError:
        import zlib

        return _Library(zlib)
    return _Library(isal_zlib)
