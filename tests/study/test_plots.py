"""Figures: what they show, with which labels and units; and what cannot be drawn."""

import sys

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import lienumba
from lienumba.analysis import orders, plots
from lienumba.cli import app
from lienumba.store.files import write
from lienumba.store.study_layout import Coordinate

from .made import METHOD, METHODS, STEPS, study
from .rigs import VARIED, top

pytest.importorskip("matplotlib")
SLOPES = np.array(STEPS) ** np.array([[2.0], [4.0]])[None]


def texts(ax):
    return [text.get_text() for text in ax.texts]


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_a_study_shows_orders_and_work_against_precision():
    ds = study(SLOPES, floor=1e-10)
    figure = plots.figure(ds)
    assert figure.get_suptitle() == "made up: 1 run at each point"
    assert [(ax.get_xlabel(), ax.get_ylabel()) for ax in figure.axes] == [
        ("mean step", "largest position error (m)"),
        ("evaluations per run", "largest position error (m)"),
        ("time of one core per run", "largest position error (m)"),
    ]
    assert all(ax.get_xscale() == ax.get_yscale() == "log" for ax in figure.axes)
    assert legend(figure) == list(METHODS)
    assert texts(figure.axes[0]) == ["slope 2", "slope 4"]
    for ax, x in zip(figure.axes, (STEPS, ds["evaluations"][0, 0], ds["time_per_run"][0]), strict=True):
        for line, errors in zip(ax.lines[:2], SLOPES[0], strict=True):
            found = dict(zip(*line.get_data(), strict=True))
            assert found == pytest.approx(dict(zip(np.asarray(x), errors, strict=True)))
    for line, order in zip(figure.axes[0].lines[2:], orders(ds)["order"].sel(error="position").values, strict=True):
        x, y = np.log(line.get_data())
        assert np.diff(y) / np.diff(x) == pytest.approx(order)
    assert len({line.get_color() for line in figure.axes[0].lines}) == 3
    assert [len(ax.patches) for ax in figure.axes] == [1, 1, 1]  # where the reference says little


def test_any_variable_of_a_study():
    figure = plots.figure(study(np.concatenate([SLOPES] * 5)), ["velocity_error", "evaluations"])
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert labels == ["largest velocity error (m/s)"] * 3 + ["evaluations"] * 3
    assert figure.get_suptitle() == "made up: medians of 5 runs"
    with pytest.raises(lienumba.ScenarioError, match=r'^"time_per_run" has no value for every run and point; '):
        plots.figure(study(SLOPES), ["time_per_run"])


def test_points_without_steps_stand_alone():
    other = Coordinate("velocity", "velocity", ["mass", "none", "identity"], "1", "projection.velocity")
    figure = plots.figure(study(np.arange(1.0, 7.0).reshape(1, 2, 3), (METHOD, other), 0.1))
    assert [ax.get_xlabel() for ax in figure.axes] == ["evaluations per run", "time of one core per run"]
    assert legend(figure)[:2] == ["method = first, velocity = mass", "method = first, velocity = none"]
    assert len(figure.axes[0].lines) == 6


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    path = tmp_path_factory.mktemp("plots") / "runs.nc"
    write(lienumba.run(top(sweep=VARIED | {"runs": 16}, title="example")), path)
    return path


def test_runs_spread_over_the_time(runs):
    with xr.open_dataset(runs) as ds:
        figure = plots.figure(ds)
        drawn = [(ax.get_title(), ax.get_xlabel(), ax.get_ylabel()) for ax in figure.axes if ax.get_visible()]
        assert drawn[:3] == [
            ("position of top", "time (s)", "position (m)"),
            ("velocity of top", "time (s)", "velocity (m/s)"),
            ("angular_velocity of top", "time (s)", "angular velocity (rad/s)"),
        ]
        assert [title for title, *_ in drawn[3:]] == [
            "energy", "energy_residual", "position_violation", "velocity_violation",
        ]  # fmt: skip
        assert figure.get_suptitle() == "example: median and 5 to 95 % of 16 runs"
        first = figure.axes[0]
        assert [text.get_text() for text in first.get_legend().get_texts()] == ["x", "y", "z"]
        for line, axis in zip(first.lines, "xyz", strict=True):
            one = ds.position.sel(body="top", axis=axis)
            np.testing.assert_allclose(line.get_ydata(), one.quantile(0.5, dim="run"))
        band = first.collections[0].get_paths()[0].vertices[:, 1]
        assert band.max() == pytest.approx(float(ds.position.sel(axis="x").quantile(0.95, dim="run").max()))
        assert plots.figure(ds.isel(run=[0])).get_suptitle() == "example: 1 run"


def test_any_variable_of_runs_by_its_name(runs):
    with xr.open_dataset(runs) as ds:
        figure = plots.figure(ds, ["rotation", "steps", "bodies.top.mass", "joint_force"])
        assert [ax.get_title() for ax in figure.axes[:4]] == [
            "rotation of top", "steps", "bodies.top.mass", "joint_force of pivot",
        ]  # fmt: skip
        names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
        assert names == ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"]
        styles = {(line.get_color(), line.get_linestyle()) for line in figure.axes[0].lines}
        assert len(styles) == 9
        assert figure.axes[2].get_xlabel() == "bodies.top.mass (kg)"
        assert sum(patch.get_height() for patch in figure.axes[2].patches) == 16
        for wrong in ("positon", "axis"):
            with pytest.raises(lienumba.ScenarioError, match=f'^the dataset has no variable "{wrong}"; '):
                plots.figure(ds, [wrong])
        with pytest.raises(lienumba.ScenarioError, match=r"^no run of the dataset succeeded"):
            plots.figure(ds.assign(status=ds.status + 1))


@pytest.mark.parametrize(("name", "start"), [("a.png", b"\x89PNG"), ("a.svg", b"<?xml"), ("a.pdf", b"%PDF")])
def test_formats(tmp_path, runs, name, start):
    target = tmp_path / name
    result = CliRunner().invoke(app, ["plot", str(runs), "energy", "-o", str(target)])
    assert result.exit_code == 0, result.output
    assert result.stdout == f"written to {target}\n"
    assert target.read_bytes().startswith(start)


def test_the_figure_bears_the_name_of_the_dataset(tmp_path, runs, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(app, ["plot", str(runs), "energy"]).exit_code == 0
    assert [item.name for item in tmp_path.iterdir()] == ["runs.png"]


def test_what_cannot_be_drawn(tmp_path, runs, monkeypatch):
    def said(*arguments):
        result = CliRunner().invoke(app, ["plot", *map(str, arguments)])
        assert result.exit_code == 2
        assert list(tmp_path.iterdir()) == []
        return result.stderr

    monkeypatch.chdir(tmp_path)
    assert said(runs, "-o", "a.txt") == (
        "error: output = a.txt: is no figure; give a name that ends in .png, .svg or .pdf\n"
    )
    assert said(runs, "-o", "no/a.png") == (
        "error: output = no/a.png: its folder no does not exist; create it or choose another\n"
    )
    assert said(runs, "energi") == 'error: the dataset has no variable "energi"; the nearest known name is "energy"\n'
    assert said("none.nc") == "error: none.nc does not exist; check the path\n"
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert said(runs) == 'error: a figure needs matplotlib, which is missing; pip install "lienumba[plot]"\n'


def test_summaries_are_drawn_as_histograms_and_courses_of_full_runs_as_lines():
    output = {"every": 0.01, "mode": "summary", "summary": {"position": ["max"]}, "full_runs": "0:3"}
    data = top(output=output, sweep={**VARIED, "runs": 5})
    ds = lienumba.run(data, workers=1, runs=[-1, *range(5)])
    figure = plots.figure(ds)
    maxima = ["max_position_violation", "max_velocity_violation", "max_energy_drift"]
    assert [ax.get_title() for ax in figure.axes if ax.get_visible()] == ["position_max of top", *maxima]
    assert sum(patch.get_height() for patch in figure.axes[0].patches) == 3 * 5
    assert figure.get_suptitle().endswith("median and 5 to 95 % of 5 runs")
    figure = plots.figure(ds, ["energy", "position"])
    assert [ax.get_title() for ax in figure.axes] == ["energy (3 runs)", "position (3 runs) of top"]
    assert len(figure.axes[1].lines) == 3
