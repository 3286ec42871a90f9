"""The figure of a study: what it shows, with which labels and units."""

import numpy as np
import pytest

import lienumba
from lienumba.analysis import orders
from lienumba.figures import figure
from lienumba.store.study_layout import Coordinate
from tests.rigs.made_studies import METHOD, METHODS, STEPS, study

pytest.importorskip("matplotlib")
SLOPES = np.array(STEPS) ** np.array([[2.0], [4.0]])[None]


def texts(ax):
    return [text.get_text() for text in ax.texts]


def legend(drawn):
    return [text.get_text() for text in drawn.legends[0].get_texts()]


def test_a_study_shows_orders_and_work_against_precision():
    ds = study(SLOPES, floor=1e-10)
    drawn = figure(ds)
    assert drawn.get_suptitle() == "made up: 1 run at each point"
    assert [(ax.get_xlabel(), ax.get_ylabel()) for ax in drawn.axes] == [
        ("mean step", "largest position error (m)"),
        ("evaluations per run", "largest position error (m)"),
        ("time of one core per run", "largest position error (m)"),
    ]
    assert all(ax.get_xscale() == ax.get_yscale() == "log" for ax in drawn.axes)
    assert legend(drawn) == [*METHODS, "below 100 times the error of the reference"]
    assert texts(drawn.axes[0]) == ["slope 2", "slope 4"]
    for ax, x in zip(drawn.axes, (STEPS, ds["evaluations"][0, 0], ds["time_per_run"][0]), strict=True):
        for line, errors in zip(ax.lines[:2], SLOPES[0], strict=True):
            found = dict(zip(*line.get_data(), strict=True))
            assert found == pytest.approx(dict(zip(np.asarray(x), errors, strict=True)))
    for line, order in zip(drawn.axes[0].lines[2:], orders(ds)["order"].sel(error="position").values, strict=True):
        x, y = np.log(line.get_data())
        assert np.diff(y) / np.diff(x) == pytest.approx(order)
    assert len({line.get_color() for line in drawn.axes[0].lines}) == 3
    assert [len(ax.patches) for ax in drawn.axes] == [1, 1, 1]  # where the reference says little


def test_names_of_slopes_overlap_nothing():
    close = np.array(STEPS) ** np.array([[2.0], [3.0]])[None] * np.array([[1.0], [30.0]])
    drawn = figure(study(close / close[..., -1:]))
    drawn.draw_without_rendering()
    ax, other = drawn.axes[0], drawn.axes[1]
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) == 2
    assert not boxes[0].overlaps(boxes[1])
    taken = [ax.bbox, other.yaxis.get_tightbbox(), ax.xaxis.get_tightbbox()]
    assert not any(one.overlaps(two) for one in boxes for two in taken)


def test_any_variable_of_a_study():
    drawn = figure(study(np.concatenate([SLOPES] * 5)), ["velocity_error", "evaluations"])
    labels = [ax.get_ylabel() for ax in drawn.axes]
    assert labels == ["largest velocity error (m/s)"] * 3 + ["evaluations"] * 3
    assert drawn.get_suptitle() == "made up: medians of 5 runs"
    with pytest.raises(lienumba.ScenarioError, match=r'^"time_per_run" has no value for every run and point; '):
        figure(study(SLOPES), ["time_per_run"])


def test_points_without_steps_stand_alone():
    other = Coordinate("velocity", "velocity", ["mass", "none", "identity"], "1", "projection.velocity")
    drawn = figure(study(np.arange(1.0, 7.0).reshape(1, 2, 3), (METHOD, other), 0.1))
    assert [ax.get_xlabel() for ax in drawn.axes] == ["evaluations per run", "time of one core per run"]
    assert legend(drawn)[:2] == ["method = first, velocity = mass", "method = first, velocity = none"]
    assert len(drawn.axes[0].lines) == 6


def test_what_is_nowhere_positive_has_a_linear_axis():
    ds = study(SLOPES)
    drawn = figure(ds, ["steps", "rejected_steps"])
    assert [ax.get_yscale() for ax in drawn.axes] == ["log"] * 3 + ["linear"] * 3
    assert [len(line.get_xdata()) for line in drawn.axes[3].lines] == [len(STEPS)] * 2
    assert {ax.get_yscale() for ax in figure(study(0.0 * SLOPES)).axes} == {"linear"}
    with pytest.raises(lienumba.ScenarioError, match=r'^"status" is a code, not a number; name a variable such as '):
        figure(ds, "status")
