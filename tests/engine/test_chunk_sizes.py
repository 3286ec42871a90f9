"""Chunks for a cluster: how large, and that all runs are among them."""

import pytest

from lienumba.compiler.rows import W
from lienumba.engine.chunk_sizes import CHUNK_BYTES, CHUNKS_PER_CORE, PERIOD, SECONDS, Dealt


def chunks(runs: int, run_bytes: int, cores: int, cost: float) -> list[int]:
    """Runs of each chunk, where every run costs the same (s)."""
    dealt, found, first = Dealt(runs, run_bytes), [], 0
    while dealt.more:
        chunk = dealt.next(cores)
        assert chunk.start == first
        first, size = chunk.stop, chunk.stop - chunk.start
        found.append(size)
        dealt.learn(size, size * cost)
    assert first == runs
    return found


@pytest.mark.parametrize("runs", [1, 7, 8, 1000, 12345])
@pytest.mark.parametrize("cores", [0, 1, 64])
def test_all_runs_are_dealt_out_in_blocks_of_lanes(runs: int, cores: int) -> None:
    found = chunks(runs, 1000, cores, 1e-3)
    assert sum(found) == runs
    assert all(size % W == 0 for size in found[:-1])


def test_chunks_grow_until_they_take_their_time() -> None:
    found = chunks(10**6, 100, 8, 1e-3)
    assert found[:4] == [8, 16, 32, 64]
    assert max(found) == SECONDS / 1e-3
    assert found[-1] < max(found) / 10  # so that all cores finish together


def test_many_cores_get_longer_chunks() -> None:
    assert max(chunks(10**8, 1, 1000, 1e-3)) * 1e-3 == pytest.approx(1000 * PERIOD, rel=1e-3)


def test_chunks_are_not_larger_than_what_is_sent_at_a_time() -> None:
    assert CHUNK_BYTES - W * 1000 < 1000 * max(chunks(10**6, 1000, 2, 1e-9)) <= CHUNK_BYTES
    assert max(chunks(1000, 10 * CHUNK_BYTES, 2, 1e-9)) == W


def test_long_runs_go_alone_as_far_as_lanes_allow() -> None:
    assert set(chunks(100, 100, 2, 60.0)) == {8, 4}


def test_few_runs_are_shared_by_all_cores() -> None:
    assert max(chunks(960, 100, 4, 1e-6)) <= 960 / (4 * CHUNKS_PER_CORE)
