"""Sobol' indices against closed forms, and against plain formulas where rows are missing."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm, sobol_indices

from lienumba.analysis import sensitivity
from lienumba.analysis.sensitivities.sobol import Rows, indices
from tests.analysis.sweep_example import named, saltelli, sweep
from tests.facade import ScenarioError

KINDS = ("first_order", "total_order")


def uniform(u):
    return np.pi * (2 * u - 1)


def ishigami(x):
    return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def ishigami_indices():
    """T. Ishigami, T. Homma (1990), with a = 7, b = 0.1."""
    a, b, pi = 7.0, 0.1, np.pi
    alone = np.array([0.5 * (1 + b * pi**4 / 5) ** 2, a**2 / 8, 0.0])
    together = b**2 * pi**8 * (1 / 18 - 1 / 50)  # of the first and the third
    variance = alone.sum() + together
    return alone / variance, (alone + [together, 0, together]) / variance


def plain(y):
    """A. Saltelli et al. (2010), table 2 (b) and (f), of outputs (rows, d + 2)."""
    A, B, AB = y[:, 0], y[:, 1], y[:, 2:]
    mean, variance = y[:, :2].mean(), y[:, :2].var()
    first = ((B - mean)[:, None] * (AB - A[:, None])).mean(axis=0) / variance
    return first, 0.5 * ((AB - A[:, None]) ** 2).mean(axis=0) / variance


def found(ds, *names):
    result = sensitivity(ds, "y")
    return result, *(result[name].values[0] for name in names or KINDS)


def test_the_ishigami_function():
    x = saltelli(4096, [uniform] * 3)
    result, first, total = found(sweep(named(x), vary="saltelli", y=ishigami(x)))
    for values, kind, known in zip((first, total), KINDS, ishigami_indices(), strict=True):
        assert values == pytest.approx(known, abs=0.02)
        low, high = (result[f"{kind}_{end}"].values[0] for end in ("low", "high"))
        assert (low < known + 1e-3).all()
        assert (known - 1e-3 < high).all()
        assert (high - low < 0.15).all()
    assert result["rows"].item() == result.attrs["rows"] == 4096
    assert result["runs"].item() == 2 * 4096
    y = ishigami(x).reshape(4096, 5).T
    theirs = sobol_indices(func={"f_A": y[:1], "f_B": y[1:2], "f_AB": y[2:, None]}, n=4096)
    assert first == pytest.approx(theirs.first_order, abs=1e-12)
    assert total == pytest.approx(theirs.total_order, abs=1e-12)


def test_a_linear_model_of_normal_inputs():
    slopes = np.array([3.0, -2.0, 1.0, 0.0])
    x = saltelli(2048, [norm.ppf] * 4, seed=3)
    _, first, total = found(sweep(named(x), vary="saltelli", y=100.0 + x @ slopes))
    assert first == pytest.approx(slopes**2 / 14, abs=0.02)
    assert total == pytest.approx(slopes**2 / 14, abs=0.02)
    assert total[3] == 0.0


def test_one_input_explains_everything():
    x = saltelli(256, [norm.ppf], seed=1)
    _, first, total = found(sweep(named(x), vary="saltelli", y=x[:, 0] ** 3))
    assert first == pytest.approx([1.0], abs=0.25)
    assert total == pytest.approx([1.0], abs=0.25)


def test_incomplete_rows_are_left_out_whole():
    x = saltelli(64, [uniform] * 3)
    y, labels, status = ishigami(x), np.arange(len(x)), np.zeros(len(x), int)
    status[[3, 10 * 5 + 1, 10 * 5 + 4]] = 1
    missing = [20 * 5 + 2, 21 * 5]
    kept = np.setdiff1d(labels, missing)
    kept = np.concatenate([kept[::-1], [-1]])  # in any order, and with the nominal run
    ds = sweep(named(x[kept]), status[kept], kept, vary="saltelli", y=np.where(status, 1e9, y)[kept])
    result, first, total = found(ds)
    whole = np.delete(y.reshape(64, 5), [0, 10, 20, 21], axis=0)
    assert result["rows"].item() == 60
    assert result.attrs["rows"] == 64
    assert (result.attrs["runs"], result.attrs["failed"]) == (len(x) - 2, 3)
    assert first == pytest.approx(plain(whole)[0], abs=1e-12)
    assert total == pytest.approx(plain(whole)[1], abs=1e-12)
    assert result["runs"].item() == 2 * 64 - 2  # of A and B: one has failed, one is missing


def test_intervals_are_the_same_every_time_and_hold_what_they_say():
    slopes, held = np.array([2.0, 1.0]), []
    for seed in range(60):
        x = norm.ppf(np.random.default_rng(seed).random((64, 4)))
        A, B = x[:, :2], x[:, 2:]
        rows = np.stack([A, B, np.stack([B[:, 0], A[:, 1]], 1), np.stack([A[:, 0], B[:, 1]], 1)], axis=1).reshape(-1, 2)
        ds = sweep(named(rows), vary="saltelli", y=rows @ slopes)
        result, low, high = found(ds, "total_order_low", "total_order_high")
        held += [(low <= [0.8, 0.2]) & (high >= [0.8, 0.2])]
        if seed == 0:
            xr.testing.assert_identical(result, sensitivity(ds, "y"))
    assert np.mean(held) == pytest.approx(0.95, abs=0.08)


def test_a_vector_is_one_input_and_what_is_not_drawn_is_none():
    x = saltelli(128, [norm.ppf] * 4, seed=5)
    x = x.reshape(128, 6, 4)[:, [0, 1, 2, 5]]  # the first three belong together
    x[:, 2, :3] = x[:, 1, :3]
    x = x.reshape(-1, 4)
    samples = {f"rotation[{k}]": x[:, k] for k in range(3)} | {"mass": x[:, 3], "half": 0.5 * x[:, 3]}
    normal = {"distribution": "normal", "std": 1.0}
    vary = {
        "rotation": {"distribution": "rotation_normal", "std": 1.0},
        "fixed": {"distribution": "constant", "value": 2.0},
        "mass": normal,
        "half": {"expression": "0.5*mass"},
    }
    samples["fixed"] = np.full(len(x), 2.0)
    ds = sweep(samples, vary={"sampler": "saltelli", "vary": vary}, y=x.sum(axis=1))
    result = sensitivity(ds, "y")
    total = result["total_order"].sel(output="y").dropna("input")
    assert sorted(total["input"].values) == ["mass", "rotation"]
    assert total.sel(input=["rotation", "mass"]).values == pytest.approx([0.75, 0.25], abs=0.1)
    ranks = result["rank_correlation"].sel(output="y").dropna("input")
    assert list(ranks["input"].values) == ["rotation[0]", "rotation[1]", "rotation[2]", "mass", "half"]
    notes = result.attrs["notes"].split("\n")
    assert notes[0] == "inputs that do not vary are left out: fixed"
    assert notes[-1].startswith("rank correlations, changes and first indices of inputs that depend on one another")


def notes_of(**vary):
    x = saltelli(16, [norm.ppf] * 2)
    return sensitivity(sweep(named(x), vary=vary, y=x.sum(axis=1)), "y").attrs["notes"].split("\n")


def test_what_is_said_where_there_are_no_indices():
    assert notes_of(sampler="sobol") == [
        'total Sobol\' indices need sweep.sampler = "saltelli" and (2 + 2)*2^m runs, such as sweep.runs = 4096'
    ]
    correlated = [{"inputs": ["a", "b"], "correlation": 0.5}]
    assert notes_of(sampler="latin_hypercube", correlate=correlated) == [
        "rank correlations, changes and first indices of inputs that depend on one another hold the effects of all of "
        "these",
        "total Sobol' indices are left out, since [[sweep.correlate]] makes inputs depend on one another",
    ]
    x = np.random.default_rng(0).random((64, 2))
    result = sensitivity(sweep(named(x), vary="saltelli", y=x.sum(axis=1)), "y")
    assert result["first_order"].isnull().all()
    assert result.attrs["notes"] == (
        "total Sobol' indices are left out, since the runs are not laid out as those of a saltelli sweep; analyse the "
        "dataset as lienumba run wrote it"
    )


def test_a_sampler_of_another_version_is_named() -> None:
    x = np.random.default_rng(0).random((64, 2))
    with pytest.raises(ScenarioError, match=r'sweep\.sampler = "weyl": this version of lienumba does not'):
        sensitivity(sweep(named(x), vary={"sampler": "weyl"}, y=x.sum(axis=1)), "y")


def test_intervals_of_total_indices_are_of_their_logarithm() -> None:
    """Above 0, and 1 at most; what has no effect has none for sure."""
    rng = np.random.default_rng(3)
    a, b = rng.uniform(0.0, 1.0, (2, 40, 3))
    points = np.stack([a, b, *(np.where(np.arange(3) == k, b, a) for k in range(3))], axis=1)
    values = np.exp(4.0 * points[..., 0]) + points[..., 1]
    found = indices(values.ravel(), Rows(["a", "b", "c"], np.arange(200).reshape(40, 5)))
    assert found is not None
    total, low, high = found.total
    assert 0.0 < low[0] < total[0] <= high[0] <= max(1.0, total[0])
    assert low[1] * high[1] == pytest.approx(total[1] ** 2)
    assert low[1] < total[1] < high[1] < 1.0
    assert (found.total[:, 2] == 0.0).all()
