"""Figures of runs: what they show, with which labels and units; and what cannot be drawn."""

import sys
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import lienumba
from lienumba.figures import figure
from lienumba.store.outputs import write
from tests.facade import app
from tests.rigs.changing import CHANGING
from tests.rigs.studies import VARIED, top

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    path = tmp_path_factory.mktemp("plots") / "runs.nc"
    write(lienumba.run(top(sweep=VARIED | {"runs": 16, "nominal": True}, title="example")), path)
    return path


def texts(legend):
    return [text.get_text() for text in legend.get_texts()]


def shown(drawn):
    return [(ax.get_title(loc="left"), ax.get_xlabel(), ax.get_ylabel()) for ax in drawn.axes if ax.get_visible()]


def test_what_says_most_of_a_sweep(runs):
    drawn = figure(runs)
    assert drawn.get_suptitle() == "example: 16 runs and the nominal run"
    assert shown(drawn) == [
        ("position of top", "time (s)", "position (m)"),
        ("attitude of top", "time (s)", "angle of its axes\nfrom the nominal run (°)"),
        ("energy", "time (s)", "energy (J)"),
        ("angular velocity of top, body frame", "time (s)", "angular velocity (rad/s)"),
        ("velocity of top", "time (s)", "velocity (m/s)"),
        ("energy residual", "time (s)", "energy residual (J)"),
        ("violation of the constraints", "time (s)", "violation (m, m/s)"),
        ("last position of top, x", "last position (m)", "runs"),
        ("last position of top, y", "last position (m)", "runs"),
        ("last position of top, z", "last position (m)", "runs"),
        ("sampled bodies.top.mass", "mass (kg)", "runs"),
    ]
    assert texts(drawn.axes[0].get_legend()) == ["x", "y", "z"]
    assert texts(drawn.axes[2].get_legend()) == ["total", "kinetic", "potential"]
    assert texts(drawn.legends[0]) == [
        "median", "25 to 75 % of the runs", "5 to 95 % of the runs", "largest of the runs", "some of the runs",
        "nominal run",
    ]  # fmt: skip
    with xr.open_dataset(runs) as ds:
        for n, axis in enumerate("xyz"):
            one = ds.position.sel(body="top", axis=axis, run=slice(0, None))
            median, nominal = drawn.axes[0].lines[2 * n : 2 * n + 2]
            np.testing.assert_allclose(median.get_ydata(), one.quantile(0.5, dim="run"))
            np.testing.assert_array_equal(nominal.get_ydata(), ds.position.sel(body="top", axis=axis, run=-1))
            for band, (low, high) in zip(
                drawn.axes[0].collections[2 * n :], ((0.05, 0.95), (0.25, 0.75)), strict=False
            ):
                y = band.get_paths()[0].vertices[:, 1]
                assert y.min() == pytest.approx(float(one.quantile(low, dim="run").min()))
                assert y.max() == pytest.approx(float(one.quantile(high, dim="run").max()))
        assert sum(patch.get_height() for patch in drawn.axes[10].patches) == 16


def test_nothing_is_cut_off_and_no_legend_lies_over_data(runs):
    drawn = figure(runs, ["position", "rotation", "angular_velocity", "energy_residual", "bodies.top.mass"])
    drawn.draw_without_rendering()
    for ax in drawn.axes:
        if ax.get_visible():
            inside, around = drawn.bbox.padded(0.5).extents, ax.get_tightbbox().extents
            assert (inside[:2] <= around[:2]).all()
            assert (around[2:] <= inside[2:]).all()
            if ax.get_legend() is not None:
                assert ax.get_legend().get_window_extent().y0 >= ax.get_window_extent().y1
                title = ax._left_title.get_window_extent()
                assert not title.overlaps(ax.get_legend().get_window_extent())


@pytest.mark.parametrize(("count", "last"), [(3, "joint_2"), (12, "joint_11")])
def test_legends_of_many_coordinates_stay_beside_the_figure(runs, count, last):
    with xr.open_dataset(runs) as ds:
        one = ds.isel(run=[3])
        q = (("run", "time", "coordinate"), np.ones((1, ds.sizes["time"], count)), {"long_name": "coordinates"})
        names = {"coordinate": [f"joint_{n}" for n in range(count)]}
        units = {"coordinate_unit": ("coordinate", ["rad"] * count)}
        drawn = figure(one.assign(q=q, qd=q).assign_coords(names | units), ["q", "qd"])
    drawn.draw_without_rendering()
    for ax in drawn.axes[:2]:
        legend, title = ax.get_legend().get_window_extent(), ax._left_title.get_window_extent()
        assert texts(ax.get_legend())[-1] == last
        assert legend.x0 >= ax.get_tightbbox().x0 - 1.0
        assert ax.get_window_extent().y1 <= legend.y0
        assert legend.y1 <= drawn._suptitle.get_window_extent().y0
        assert not title.overlaps(legend)


@pytest.mark.parametrize("names", [["energy"], ["energy", "position"], []])
def test_long_titles_and_legends_have_lines_enough(runs, names):
    with xr.open_dataset(runs) as ds:
        drawn = figure(ds.assign_attrs(title="a long title " * 12), names)
    drawn.draw_without_rendering()
    for artist in (drawn._suptitle, drawn.legends[0]):
        assert drawn.bbox.x0 <= artist.get_window_extent().x0
        assert artist.get_window_extent().x1 <= drawn.bbox.x1
    assert drawn.legends[0].get_window_extent().y1 <= min(
        ax.get_tightbbox().y0 for ax in drawn.axes if ax.get_visible()
    )


def test_few_runs_are_drawn_one_by_one(runs):
    with xr.open_dataset(runs) as ds:
        drawn = figure(ds.isel(run=slice(0, 4)), ["energy", "position"])
        assert drawn.get_suptitle() == "example: 3 runs and the nominal run"
        assert texts(drawn.axes[0].get_legend()) == ["run 0", "run 1", "run 2"]
        assert len(drawn.axes[0].lines) == 4
        assert not drawn.axes[1].collections
        alone = figure(ds.isel(run=[3]))
        assert alone.get_suptitle() == "example: 1 run"
        assert [title for title, *_ in shown(alone)][-2:] == ["energy residual", "violation of the constraints"]
        assert not alone.legends


def test_anything_by_its_name(runs):
    names = ["rotation", "rotation.top.x.z", "steps", "bodies.top.mass", "joint_force", "status", "position.top.z"]
    drawn = figure(runs, names)
    assert [title for title, *_ in shown(drawn)] == [
        "attitude of top", "rotation of top, xz", "steps", "sampled bodies.top.mass", "joint force of pivot", "status",
        "position of top, z",
    ]  # fmt: skip
    with xr.open_dataset(runs) as ds:
        samples = ds["bodies.top.mass"].values
        histogram = drawn.axes[3]
        assert sum(patch.get_height() for patch in histogram.patches) == 16
        assert histogram.lines[0].get_xdata()[0] == samples[0]  # the nominal run
        failed = ds.assign(status=ds.status + 1)
        bars = figure(failed, ["status"]).axes[0]
        assert [label.get_text() for label in bars.get_yticklabels()] == ["non finite"]
        assert bars.patches[0].get_width() == 16
        some = ds.assign(status=ds.status + (ds.run == 4) * 2)
        assert figure(some, ["energy"]).get_suptitle().replace("\n", " ") == (
            "example: 16 runs and the nominal run; 1 failed (1 projection not converged) and not shown"
        )
        for wrong in ("positon", "axis"):
            with pytest.raises(lienumba.ScenarioError, match=f'^the dataset has no variable "{wrong}"; '):
                figure(ds, [wrong])
        with pytest.raises(
            lienumba.ScenarioError, match=r'^no run of the dataset succeeded; draw how they .* "status", or an'
        ):
            figure(failed, ["energy"])
        with pytest.raises(lienumba.ScenarioError, match=r"^the dataset: has no run; select at least one$"):
            figure(ds.isel(run=[]))
        drawn = figure(failed)
        assert [title for title, *_ in shown(drawn)] == ["status", "sampled bodies.top.mass"]
        assert drawn.get_suptitle() == "example: 16 runs and the nominal run, which failed; 16 failed (16 non finite)"
        assert texts(drawn.axes[1].get_legend()) == ["failed runs"]


def test_a_notebook_shows_it(runs):
    assert figure(runs, "energy")._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize(("name", "start"), [("a.png", b"\x89PNG"), ("a.svg", b"<?xml"), ("a.pdf", b"%PDF")])
def test_the_same_dataset_gives_the_same_bytes(tmp_path, runs, name, start):
    target = tmp_path / name
    written = []
    for _ in range(2):
        result = CliRunner().invoke(app, ["plot", str(runs), "energy", "-o", str(target)])
        assert result.exit_code == 0, result.output
        assert result.stdout == f"written to {target}\n"
        written.append(target.read_bytes())
    assert written[0].startswith(start)
    assert written[0] == written[1]


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
    monkeypatch.delitem(sys.modules, "lienumba.figures.shown", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert said(runs) == (
        'error: a figure needs matplotlib, which is missing; in the clone of lienumba, pip install ".[plot]"\n'
    )


def test_summaries_are_drawn_as_histograms_and_courses_of_full_runs_as_lines():
    output = {"every": 0.01, "mode": "summary", "summary": {"position": ["mean"]}, "full_runs": "0:3"}
    data = top(output=output, sweep={**VARIED, "runs": 15})
    drawn = figure(lienumba.run(data, workers=1, runs=[-1, *range(15)]))
    titles = [title for title, *_ in shown(drawn)]
    assert titles[:2] == ["position of top", "attitude of top"]
    assert titles[-4:-1] == [f"position_mean of top, {axis}" for axis in "xyz"]
    assert drawn.get_suptitle().endswith("15 runs and the nominal run; courses of 3")
    assert len(drawn.axes[0].lines) == 3 * 3
    output.pop("full_runs")
    drawn = figure(lienumba.run(top(output=output, sweep={**VARIED, "runs": 15}), workers=1))
    assert [title for title, *_ in shown(drawn)] == [
        "position_mean of top, x", "position_mean of top, y", "position_mean of top, z", "max position violation",
        "max velocity violation", "max energy drift", "sampled bodies.top.mass",
    ]  # fmt: skip


def test_bands_end_where_few_runs_are_left(runs):
    """Of 16 runs 3 finish, and the others end at 0.02 s."""
    with xr.open_dataset(runs) as ds:
        late = (ds["time"] > 0.02) & (ds["run"] > 2)
        ended = ds[["position", "energy_residual"]].where(~late).astype(float)
        drawn = figure(ds.assign(ended), ["position.top.z"])
    first = float(ended["time"][ended["time"] > 0.02][0])
    [ax] = drawn.axes
    assert max(band.get_paths()[0].vertices[:, 0].max() for band in ax.collections) < first
    left = [line for line in ax.lines if np.isnan(line.get_ydata()[0])]
    assert len(left) == 3
    assert drawn.legends[0].get_title().get_text().replace("\n", " ") == (
        f"from {first:g} s on some runs have ended, and quantiles are of those that go on: 3 of 16 at the end, each "
        "drawn where 12 or fewer are left"
    )


def test_a_constant_is_a_thin_bar_at_its_value(runs):
    [ax] = figure(runs, ["end_time"]).axes
    [bar] = ax.patches
    assert bar.get_height() == 16
    assert bar.get_width() < 0.05 * np.ptp(ax.get_xlim())
    assert [text.get_text() for text in ax.get_xticklabels()] == [f"{bar.get_x() + 0.5 * bar.get_width():g}"]


def test_ticks_of_numbers_that_differ_late_do_not_overlap(runs):
    with xr.open_dataset(runs) as ds:
        last = ds["last_position"] * 0.0 - 4.905 + 1e-5 * ds["run"]
        drawn = figure(ds.assign(last_position=last), ["last_position.top", "steps"] * 2)
    drawn.draw_without_rendering()
    boxes = [text.get_window_extent() for text in drawn.axes[0].get_xticklabels() if text.get_text()]
    assert len(boxes) > 1
    assert not any(one.padded(2).overlaps(other) for one, other in pairwise(boxes))


def test_bands_of_modes_are_steps():
    drawn = figure(lienumba.run(CHANGING | {"sweep": {"runs": 60, "vary": CHANGING["sweep"]["vary"]}}), ["mode"])
    edges = [np.diff(path.vertices, axis=0) for band in drawn.axes[0].collections for path in band.get_paths()]
    assert edges
    assert any((edge != 0).any() for edge in edges)
    assert all((edge[:, 0] * edge[:, 1] == 0).all() for edge in edges)
