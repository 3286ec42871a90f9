"""Figures of what outputs depend on: bars and elementary effects are the numbers of the analysis."""

import numpy as np
import pytest

from lienumba.analysis import sensitivity
from lienumba.figures import figure
from tests.analysis.sensitivities.test_morris import samples, table
from tests.analysis.sweep_example import named, sweep
from tests.facade import ScenarioError

pytest.importorskip("matplotlib")


def lengths(ax):
    return [bar.get_width() for bar in ax.patches]


def names(ax):
    return [label.get_text() for label in ax.get_yticklabels()]


def test_inputs_of_any_runs():
    x = np.random.default_rng(3).standard_normal((600, 3))
    ds = sweep(named(x), y=x[:, 0] * x[:, 1] + x[:, 2], z=x[:, 2])
    found = sensitivity(ds, ["y", "z"])
    drawn = figure(ds, ["y", "z"], sensitivity=True)
    first, second = drawn.axes
    assert names(first)[0] == "c"
    assert lengths(first)[0] == float(found.first_order.sel(output="y", input="c"))
    assert [ax.get_xlabel() for ax in (first, second)] == ["part of the variance"] * 2
    assert (
        drawn.get_suptitle().replace("\n", " ").endswith("600 of 600 runs good, 0 failed; whiskers are 95 % intervals")
    )
    few = figure(ds.isel(run=slice(50)), "z", sensitivity=True)
    assert few.axes[0].get_xlabel() == "rank correlation"
    with pytest.raises(ScenarioError, match="convergence and sensitivity are asked for together"):
        figure(ds, convergence=True, sensitivity=True)


def test_total_indices_stand_beside_the_first():
    x = samples("saltelli", 5 * 64)
    drawn = figure(sweep(x, vary=table("saltelli"), y=x["a"] + x["b"] * x["c"]), "y", sensitivity=True)
    (bars,) = drawn.axes
    assert [text.get_text() for text in bars.get_legend().get_texts()] == ["alone", "with all others"]
    assert len(lengths(bars)) == 6


def test_elementary_effects_are_points():
    x = samples("morris", 4 * 60)
    ds = sweep(x, vary=table("morris"), y=3 * x["a"] - 2 * x["b"] * x["a"])
    found = sensitivity(ds, "y").isel(output=0)
    (ax,) = figure(ds, "y", sensitivity=True).axes
    points = {bars.get_label(): bars[0].get_xydata()[0] for bars in ax.containers}
    assert [*points] == ["a", "b", "c"]
    for name, place in points.items():
        np.testing.assert_array_equal(place, [found.mu_star.sel(input=name), found.sigma.sel(input=name)])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("mu* (m)", "sigma (m)")
