"""Chunks as HDF5's filters shuffle and deflate make them, by either library, and their checksums."""

import sys
import zlib

import numpy as np
import pytest

from lienumba.store import deflate

RNG = np.random.default_rng(1)
CHUNKS = {
    "noise": RNG.standard_normal((9, 201, 3, 3)),
    "noise in single precision": RNG.standard_normal((50, 11)).astype("f4"),
    "smooth": np.linspace(0.0, 1.0, 5000),
    "equal": np.full((7, 3), np.nan),
    "counts": RNG.integers(0, 3, 1000, np.int32),
    "bytes": RNG.integers(0, 9, 100, np.int8),
    "one": np.ones(1),
    "none": np.ones((0, 4)),
    "as long as a block": RNG.standard_normal(deflate.BLOCK),
    "longer than a block": RNG.standard_normal(deflate.BLOCK + 1),
    "not contiguous": RNG.standard_normal((40, 30)).T[3:],
}


@pytest.fixture(params=["isal", "zlib"], autouse=True)
def library(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Either one; None in `sys.modules` is a package that is not installed."""
    if request.param == "isal":
        pytest.importorskip("isal")
    else:
        monkeypatch.setitem(sys.modules, "isal", None)
    monkeypatch.setattr(deflate, "_library", deflate._library.__wrapped__)


@pytest.mark.parametrize("name", CHUNKS)
def test_the_stream_is_one_of_zlib_whatever_is_taken_for_noise(name: str) -> None:
    chunk = CHUNKS[name]
    planes = deflate.shuffled(chunk)
    size = chunk.dtype.itemsize
    one_by_one = b"".join(np.ravel(chunk).view(np.uint8)[n::size].tobytes() for n in range(size))
    for noise in range(size + 1):
        assert zlib.decompress(deflate.deflated(planes, noise)) == one_by_one


def test_noise_is_what_cannot_be_compressed() -> None:
    signs = np.sign(RNG.standard_normal(4000))
    random = RNG.integers(0, 2**63, 4000).view("f8")
    assert deflate.noise_of(deflate.shuffled(signs)) == 0
    assert deflate.noise_of(deflate.shuffled(random)) >= 7
    measured = RNG.uniform(1.0, 2.0, 4000)  # whose sign and exponent are all alike
    assert deflate.noise_of(deflate.shuffled(measured)) == 6
    repeated = np.tile(RNG.standard_normal(100), 40)  # random numbers, but the same again and again
    assert deflate.noise_of(deflate.shuffled(repeated)) == 0


def test_noise_makes_no_file_larger() -> None:
    planes = deflate.shuffled(RNG.uniform(1.0, 2.0, 16000))
    assert len(deflate.deflated(planes, deflate.noise_of(planes))) <= 1.01 * len(deflate.deflated(planes, 0))


def test_checksums_are_those_of_zlib_and_go_on() -> None:
    content = RNG.bytes(100_003)
    assert deflate.checksum(content) == zlib.crc32(content)
    assert deflate.checksum(memoryview(content)[7:], deflate.checksum(content[:7])) == zlib.crc32(content)
