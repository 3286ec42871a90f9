"""One stream per seed, run and path: NumPy's own bits, and nothing else can change a sample."""

import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from lienumba.sweep.samplers import streams
from lienumba.sweep.samplers.streams import uniforms

MASS = "bodies.top.mass"
SPIN = "bodies.top.angular_velocity[1]"


def numpys_own(path: str, run: int, seed: int) -> float:
    words = np.frombuffer(hashlib.sha256(path.encode()).digest(), dtype="<u4").tolist()
    sequence = np.random.SeedSequence(seed, spawn_key=(run, *words))
    return float(np.random.Generator(np.random.PCG64(sequence)).random())


def test_golden_samples():
    np.testing.assert_array_equal(
        uniforms(MASS, [0, 1, 2, 999], 2015),
        [0.1726921096947286, 0.7397606178155152, 0.7828434658667646, 0.5915629809291617],
    )
    np.testing.assert_array_equal(
        uniforms(SPIN, [0, 1, 2, 999], 2015),
        [0.7553341156169529, 0.15168960366360484, 0.9546058436505639, 0.5466858773254425],
    )


@given(
    path=st.text(min_size=1, max_size=20),
    runs=st.lists(st.integers(0, 2**32 - 1), min_size=1, max_size=4),
    seed=st.one_of(st.integers(0, 2**33), st.integers(0, 2**200)),
)
def test_the_bits_are_those_of_numpys_seed_sequence_and_pcg64(path, runs, seed):
    expected = [numpys_own(path, run, seed) for run in runs]
    np.testing.assert_array_equal(uniforms(path, runs, seed), expected)


def test_a_sample_depends_on_no_other_run_and_on_no_order():
    many = uniforms(MASS, range(1003), 7)
    np.testing.assert_array_equal(uniforms(MASS, range(1000), 7), many[:1000])
    np.testing.assert_array_equal(uniforms(MASS, [42, 17], 7), many[[42, 17]])


def test_seeds_paths_and_runs_have_independent_streams():
    columns = [uniforms(MASS, range(4000), 7), uniforms(MASS, range(4000), 8), uniforms(SPIN, range(4000), 7)]
    columns.append(uniforms(MASS, range(1, 4001), 7))
    correlation = np.corrcoef(columns) - np.eye(4)
    assert np.abs(correlation).max() < 4 / np.sqrt(4000)


@pytest.mark.parametrize("seed", [0, 1, 2015])
def test_samples_are_uniform(seed):
    assert stats.kstest(uniforms(MASS, range(20000), seed), "uniform").pvalue > 1e-3


def test_zero_never_comes(monkeypatch):
    monkeypatch.setattr(streams, "_pcg64", lambda words: np.array([0, 2**64 - 1], dtype=np.uint64))
    low, high = uniforms(MASS, [0, 1], 0)
    assert 0.0 < low < 1e-16
    assert 1.0 - 2e-16 < high < 1.0


def test_no_runs_give_no_samples():
    assert uniforms(MASS, [], 0).shape == (0,)


@pytest.mark.parametrize("label", [-1, 2**32])
def test_a_label_outside_the_streams_is_refused(label):
    with pytest.raises(ValueError, match=str(label)):
        uniforms(MASS, [3, label], 0)
