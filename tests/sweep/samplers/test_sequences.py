"""What every sampler promises: uniform numbers that depend on seed, run and path alone; and how evenly they lie."""

import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter
from scipy import stats
from scipy.stats import qmc

from lienumba.sweep.design import design_table, weights
from lienumba.sweep.distributions.registry import AnyDistribution
from lienumba.sweep.samplers import SAMPLERS, halton, sobol
from lienumba.sweep.samplers.importance import Proposal
from lienumba.sweep.samplers.streams import uniforms

DRAWING = {name: sampler for name, sampler in SAMPLERS.items() if not sampler.from_table}
SEQUENCES = tuple(name for name, sampler in DRAWING.items() if sampler.row is None)  # the others have rows of runs
GROWING = tuple(name for name, sampler in DRAWING.items() if not sampler.whole)
PATHS = ("bodies.a.mass", "bodies.b.mass", "gravity[1]")
NUMBER = {"distribution": "uniform", "low": 0, "high": 1}
VARY = TypeAdapter(dict[str, AnyDistribution]).validate_python(
    {
        "a": NUMBER,
        "r": {"distribution": "rotation_normal", "std": 0.3},
        "k": {"distribution": "constant", "value": 2},
        "q": {"distribution": "rotation_uniform"},
        "i": {"distribution": "inertia", "std": 0.1},
        "d": {"distribution": "direction"},
        "s": {"scipy": "gamma", "a": 2.5},
        "b": {"distribution": "truncated_normal", "std": 1, "low": 0.5},
    }
)
NOMINAL = {
    "a": 0.5, "r": (1.0, 0.0, 0.0, 0.0), "k": 1.0, "q": (1.0, 0.0, 0.0, 0.0), "i": (1.0, 1.0, 1.5, 0.0, 0.0, 0.1),
    "d": (0.0, 3.0, 4.0), "s": 1.0, "b": 1.0,
}  # fmt: skip
PROPOSALS = {"a": Proposal(shift=2.0), "r[1]": Proposal(shift=-1.0, scale=1.5)}
CORRELATE = [(["a", "r[1]", "b"], [[1, 0.3, 0], [0.3, 1, -0.5], [0, -0.5, 1]])]


def table(sampler, labels, count=1000, vary=VARY, correlate=CORRELATE, seed=7):
    own = {name: x for name, x in PROPOSALS.items() if SAMPLERS[sampler].weighted}
    return design_table(vary, NOMINAL, labels, seed, sampler=sampler, count=count, correlate=correlate, proposals=own)


def points(sampler, runs, seed=7, paths=PATHS):
    found = SAMPLERS[sampler].draw({path: [path] for path in paths}, np.arange(runs), seed, runs)
    return np.array([found[path] for path in paths])


def assert_same(one, two, rows=slice(None)):
    assert one.keys() == two.keys()
    for name in one:
        np.testing.assert_array_equal(one[name], two[name][rows], err_msg=name)


# ---------------------------------------------------------------- promises
@pytest.mark.parametrize("sampler", DRAWING)
def test_any_selection_of_runs_has_the_samples_of_the_whole_sweep(sampler):
    correlate = () if SAMPLERS[sampler].independent else CORRELATE
    whole = table(sampler, range(-1, 1000), correlate=correlate)
    for chosen in ([17, 42], [999], [-1, 3], range(100, 250), []):
        assert_same(table(sampler, chosen, correlate=correlate), whole, np.array(chosen, int) + 1)


@settings(max_examples=20)
@given(st.sampled_from([s for s in SEQUENCES if s in GROWING]), st.lists(st.integers(0, 2**20), max_size=5))
def test_a_run_is_the_same_wherever_it_is(sampler, labels):
    found = table(sampler, labels)
    for i, label in enumerate(labels):
        assert_same(table(sampler, [label], count=5), found, [i])


@pytest.mark.parametrize("sampler", GROWING)
def test_more_runs_change_no_sample(sampler):
    assert_same(table(sampler, range(90), count=90, correlate=()), table(sampler, range(1000), correlate=()), range(90))


def test_a_latin_hypercube_of_more_runs_is_another_one():
    few, many = table("latin_hypercube", range(90), count=90), table("latin_hypercube", range(1000))
    assert (few["a"] != many["a"][:90]).all()


@pytest.mark.parametrize("sampler", SEQUENCES)
def test_a_path_more_at_the_end_changes_no_other(sampler):
    less = {path: kind for path, kind in VARY.items() if path not in ("s", "b")}
    found = table(sampler, range(100), count=100, vary=less, correlate=())
    whole = table(sampler, range(100), count=100, correlate=())
    assert_same(found, {name: whole[name] for name in found})


@pytest.mark.parametrize("sampler", DRAWING)
def test_another_seed_changes_every_sample(sampler):
    one, two = points(sampler, 200), points(sampler, 200, seed=8)
    assert (one != two).all()


def test_random_samples_are_those_of_the_streams():
    for path, column in zip(PATHS, points("random", 50), strict=True):
        np.testing.assert_array_equal(column, uniforms(path, range(50), 7))


@pytest.mark.parametrize("sampler", GROWING)
def test_a_sampler_says_whether_it_matters_which_path_comes_first(sampler):
    """Of the inputs beside one another; what stands in rows takes them one after the other anyway."""
    there, back = (points(sampler, 50, paths=paths) for paths in (PATHS, PATHS[::-1]))
    assert (there != back[::-1]).any() == SAMPLERS[sampler].order_matters


# ---------------------------------------------------------------- evenness
@pytest.mark.parametrize("sampler", SEQUENCES)
def test_every_number_is_uniform_over_the_seeds(sampler):
    """Also where a single run is looked at: no sample is biased."""
    found = np.array([points(sampler, 8, seed) for seed in range(100)])
    for path in range(len(PATHS)):
        for run in (0, 1, 7):
            assert stats.kstest(found[:, path, run], "uniform").pvalue > 1e-4
    assert 0 < found.min() < found.max() < 1


@settings(max_examples=30)
@given(st.integers(1, 500), st.integers(0, 2**40))
def test_a_latin_hypercube_has_one_run_in_each_part(runs, seed):
    for column in points("latin_hypercube", runs, seed):
        np.testing.assert_array_equal(np.sort(np.floor(column * runs)), np.arange(runs))


@pytest.mark.parametrize("log_runs", [3, 6, 9])
def test_sobol_points_have_one_run_in_each_part(log_runs):
    for column in points("sobol", 2**log_runs):
        np.testing.assert_array_equal(np.sort(np.floor(column * 2**log_runs)), np.arange(2**log_runs))


def test_halton_points_have_one_run_in_each_part():
    for base, column in zip((2, 3, 5), points("halton", 30**3), strict=True):
        whole = base**3
        np.testing.assert_array_equal(np.sort(np.floor(column[:whole] * whole)), np.arange(whole))


def test_sequences_fill_the_cube_more_evenly_than_random_points():
    discrepancy = {s: np.mean([qmc.discrepancy(points(s, 512, seed).T) for seed in range(3)]) for s in SEQUENCES}
    assert discrepancy["sobol"] < 0.02 * discrepancy["random"]
    assert discrepancy["halton"] < 0.05 * discrepancy["random"]
    assert discrepancy["latin_hypercube"] < 0.6 * discrepancy["random"]


# ---------------------------------------------------------------- the sequences themselves
def test_sobol_points_are_scipys_with_their_digits_flipped(monkeypatch):
    monkeypatch.setattr(sobol, "uniforms", lambda path, runs, seed: np.zeros(len(runs)))
    found = sobol.points(PATHS, np.arange(300), 0)
    expected = qmc.Sobol(3, scramble=False, bits=32).random(512)[:300]
    np.testing.assert_array_equal(np.array([found[path] for path in PATHS]).T, np.maximum(expected, 2.0**-54))


def test_halton_points_are_scipys_with_their_digits_permuted(monkeypatch):
    monkeypatch.setattr(halton, "uniforms", lambda path, runs, seed: np.arange(len(runs)) / len(runs))  # sorted
    found = halton.draw({path: [path] for path in PATHS}, np.arange(300), 0, 300)
    expected = qmc.Halton(3, scramble=False).random(300)
    np.testing.assert_allclose(np.array([found[path] for path in PATHS]).T, np.maximum(expected, 2.0**-54), rtol=1e-14)


def test_saltellis_runs_exchange_one_input_after_another():
    """Of three inputs, one of them a rotation: row n has A, B, and A with each input from B."""
    vary = {path: VARY[path] for path in ("a", "k", "r", "b")}
    found = table("saltelli", range(5 * 64), vary=vary, correlate=())
    A, B, *mixed = ({name: x[j::5] for name, x in found.items()} for j in range(5))
    for path, exchanged in zip(("a", "r", "b"), mixed, strict=True):
        own = VARY[path].columns(path)
        for name in found:
            np.testing.assert_array_equal(exchanged[name], (B if name in own else A)[name])
    assert all((A[name] != B[name]).all() for name in A if name != "k")
    assert abs(np.corrcoef(A["a"], B["a"])[0, 1]) < 0.1
    assert_same(table("sobol", range(64), vary=vary, correlate=()), A)


def test_sobols_indices_come_out_of_saltellis_runs():
    """Of a linear function the indices are the shares of the variance."""
    vary = dict.fromkeys(("a", "s", "b"), VARY["a"])
    x = table("saltelli", range(5 * 1024), vary=vary, correlate=())
    y = (4 * x["a"] + 2 * x["s"] + x["b"]).reshape(-1, 5).T
    result = stats.sobol_indices(func={"f_A": y[:1], "f_B": y[1:2], "f_AB": y[2:, None]}, n=1024, dists=None)
    np.testing.assert_allclose(result.first_order, np.array([16, 4, 1]) / 21, atol=0.01)


def test_a_million_runs_need_no_more_than_their_labels():
    last = 2**32 - 2
    found = halton.draw({path: [path] for path in PATHS}, np.array([0, last]), 1, last + 1)
    assert all(np.isfinite(column).all() for column in found.values())


PINS = {
    "random": "cb01cc1fa0c3c3f9",
    "latin_hypercube": "9f988232eca06af1",
    "sobol": "54606031aaa7f200",
    "halton": "c41221069b5a5103",
    "saltelli": "2178a654c7d1d680",
    "morris": "65fdca6504898b25",
    "importance": "69fb2c11b9951273",
}


@pytest.mark.parametrize("sampler", DRAWING)
def test_the_bits_are_the_same_everywhere(sampler):
    own = {path: kind for path, kind in VARY.items() if path != "s"}  # those of SciPy are SciPy's
    found = table(sampler, range(1000), vary=own, correlate=() if SAMPLERS[sampler].independent else CORRELATE)
    given = {"weight": weights(own, PROPOSALS, np.arange(1000), 7)} if SAMPLERS[sampler].weighted else {}
    assert hashlib.sha256(b"".join(x.tobytes() for x in (found | given).values())).hexdigest()[:16] == PINS[sampler]
