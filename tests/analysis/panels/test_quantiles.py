"""The numbers of figures: quantiles by NumPy's, angles from rotations that are known, what is chosen to be shown."""

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.analysis import labels
from lienumba.analysis.outcomes import counts
from lienumba.analysis.panels import quantiles, run_windows, select_panels
from lienumba.batch.statuses import NON_FINITE, STOPPED
from lienumba.groups import so3
from tests.analysis.sweep_example import sweep

RUNS = 40


def random(*shape, seed=1):
    return np.random.default_rng(seed).normal(size=shape)


def turned(angles, axis=(0.0, 0.0, 1.0)):
    """Rotation matrices (..., 3, 3) by these angles about a unit vector."""
    R = so3.exp(tuple(a * np.asarray(angles, float) for a in axis))
    return np.stack([np.broadcast_to(x, np.shape(angles)) for x in R], axis=-1).reshape(*np.shape(angles), 3, 3)


def rotating(angles, labels=None):
    """A sweep of two bodies that are turned by `angles` (runs, times) about z."""
    rotation = np.stack([turned(angles)] * 2, axis=2)
    return sweep({"a": np.arange(float(len(angles)))}, labels=labels, rotation=rotation)


def test_quantiles_are_those_of_numpy():
    values = random(RUNS, 30)
    np.testing.assert_allclose(quantiles.quantiles(values), np.quantile(values, quantiles.LEVELS, axis=0), rtol=1e-14)
    values[::3, 10:] = np.nan
    values[2:, 20] = np.nan  # one run
    values[:, 25] = np.nan  # none
    found = quantiles.quantiles(values)
    kept = np.arange(30) != 25
    np.testing.assert_allclose(found[:, kept], np.nanquantile(values[:, kept], quantiles.LEVELS, axis=0), rtol=1e-13)
    assert np.isnan(found[:, 25]).all()


def test_failed_and_nominal_runs_are_no_part_of_a_fan():
    tip = random(RUNS, 3)
    status = np.zeros(RUNS, int)
    status[[3, 7]], status[9] = NON_FINITE, STOPPED
    tip[[3, 7], 1:], tip[9, 2:] = np.nan, np.nan
    ds = sweep({"a": random(RUNS)}, status, np.arange(RUNS) - 1, tip=tip)
    [panel] = select_panels.named_panels(ds, ["tip"]).panels
    [line] = (found := quantiles.time_series(ds, panel)).lines
    good = np.delete(tip, [0, 3, 7], axis=0)
    assert (found.runs, found.few) == (RUNS - 3, False)
    np.testing.assert_allclose(line.quantiles, np.nanquantile(good, quantiles.LEVELS, axis=0))
    np.testing.assert_array_equal(line.largest, np.nanmax(good, axis=0))
    np.testing.assert_array_equal(line.nominal, tip[0])
    assert all(np.array_equal(course, tip[run + 1]) for run, course in line.each.items())
    assert (counts(ds).failed, counts(ds).stopped) == ("2 failed (2 non finite)", 1)
    assert quantiles.statuses(ds) == {"success": RUNS - 4, "non_finite": 2, "stopped_by_event": 1}


def test_large_sweeps_are_read_in_blocks_and_by_windows(tmp_path, monkeypatch):
    tip = random(1000, 3)
    ds = sweep({"a": random(1000)}, tip=tip)
    monkeypatch.setattr(run_windows, "MOST_VALUES", 3 * 256)
    monkeypatch.setattr("lienumba.store.windows.WINDOW_BYTES", 24 * 50)
    ds.to_netcdf(tmp_path / "out.nc", engine="netcdf4")
    with xr.open_dataset(tmp_path / "out.nc") as opened:
        [panel] = select_panels.named_panels(opened, ["tip"]).panels
        which = run_windows.shown_runs(opened, panel)
        found = quantiles.time_series(opened, panel)
        assert not opened["tip"].variable._in_memory
    assert which.sum() == found.runs <= 256
    blocks = np.flatnonzero(which.reshape(-1, 8).any(axis=1))
    assert (np.diff(np.flatnonzero(which)) > 1).sum() == 3  # four blocks
    assert blocks[0] == 0
    np.testing.assert_allclose(found.lines[0].quantiles, np.quantile(tip[which], quantiles.LEVELS, axis=0))


@pytest.mark.parametrize("nominal", [True, False])
def test_attitudes_are_angles_of_axes_from_their_reference(nominal):
    angles = np.outer(np.linspace(-0.4, 0.4, 21), [0.0, 0.5, 1.0]) + 0.3 * np.arange(3)
    ds = rotating(angles, np.roll(np.arange(21) - 1, 10) if nominal else None)
    panels = select_panels.named_panels(ds, ["rotation"]).panels
    assert [panel.title for panel in panels] == ["attitude of arm", "attitude of top"]
    courses = quantiles.time_series(ds, panels[1])
    from_middle = np.degrees(abs(angles - angles[10]))
    runs = np.arange(21) != 10 if nominal else np.ones(21, bool)
    for line in courses.lines[:2]:
        np.testing.assert_allclose(line.quantiles, np.quantile(from_middle[runs], quantiles.LEVELS, axis=0), atol=1e-6)
    np.testing.assert_allclose(courses.lines[2].quantiles, 0.0, atol=1e-6)  # the axis about which they turn
    reference = "the nominal run" if nominal else "their mean directions"
    assert quantiles.label(ds, panels[1]) == f"angle of its axes\nfrom {reference} (°)"
    alone = ds.isel(run=[20])
    [x, *_] = quantiles.time_series(alone, select_panels.named_panels(alone, ["rotation.top"]).panels[0]).lines
    np.testing.assert_allclose(x.quantiles[2], np.degrees(abs(angles[20] - angles[20, 0])), atol=1e-6)


def test_an_element_of_a_rotation_can_be_asked_for():
    ds = rotating(random(20, 3))
    [panel] = select_panels.named_panels(ds, ["rotation.top.x.y"]).panels
    assert (panel.title, panel.angles, len(panel.lines)) == ("rotation of top, xy", False, 1)
    [line] = quantiles.time_series(ds, panel).lines
    np.testing.assert_allclose(line.quantiles[2], np.median(ds["rotation"].values[:, :, 1, 0, 1], axis=0))


def test_spreads_have_the_values_of_all_runs_that_have_one():
    first = random(RUNS)
    first[:5] = np.nan
    ds = sweep({"a": random(RUNS)}, labels=np.arange(RUNS) - 1, first=first, tip=random(RUNS, 3))
    [spread] = quantiles.histograms(ds, select_panels.named_panels(ds, ["first"]).panels[0])
    np.testing.assert_array_equal(spread.values, first[5:])
    assert (spread.missing, spread.nominal) == (4, None)
    [panel] = [panel for panel in select_panels.default_panels(ds).panels if panel.title == "tip at the end"]
    [spread] = quantiles.histograms(ds, panel)
    np.testing.assert_array_equal(spread.values, ds["tip"].values[1:, -1])
    assert spread.nominal == ds["tip"].values[0, -1]


@pytest.mark.parametrize(
    ("values", "edges"),
    [
        ([3.0] * 9, [2.97, 3.03]),
        ([0.0] * 9, [-0.01, 0.01]),
        ([1.0, 2.0, 4.0, 4.0], [0.5, 1.5, 2.5, 3.5, 4.5]),
        ([1.0 + 1e-15, 1.0], [0.99, 1.01]),
        ([0.5, 1.5], np.linspace(0.5, 1.5, 6)),
        (np.geomspace(1e-9, 1e-3, 100), np.geomspace(1e-9, 1e-3, 11)),
        ([*np.linspace(0.0, 1.0, 1000), 1e12], np.linspace(0.0, 1e12, 22)),
    ],
)
def test_bins(values, edges):
    found = quantiles.bins([quantiles.Histogram("", np.array(values), 0, None)])
    np.testing.assert_allclose(found, edges)
    assert np.histogram(values, found)[0].sum() == len(values)


def test_what_says_most_comes_first_and_the_rest_is_named():
    a, b = random(50, seed=2), random(50, seed=3)
    tip, still = np.outer(a, [0.0, 1.0, 2.0]), np.ones((50, 3))
    position = random(50, 3, 2, 3, seed=4)
    ds = sweep({"b": b, "a": a, "c": b**2, "d": b**3}, tip=tip, still=still, position=position, velocity=position)
    choice = select_panels.default_panels(ds)
    titles = [panel.title for panel in choice.panels]
    assert titles == [
        "tip", "position of top", "velocity of top", "position of arm", "velocity of arm",
        "tip at the end", "sampled a", "sampled b", "sampled d", "sampled c",
    ]  # fmt: skip  # nothing changes in `still`; tip depends on a
    assert choice.left_out == ""
    many = sweep({name: random(50, seed=n) for n, name in enumerate("abcdefgh")}, **{f"q{n}": tip for n in range(8)})
    choice = select_panels.default_panels(many)
    assert len(choice.panels) == select_panels.MOST
    assert choice.left_out == "not shown: q6, q7, 5 inputs"


@pytest.mark.parametrize(
    ("units", "text"),
    [
        ("m s-1", "m/s"),
        ("kg m2 s-1", "kg·m²/s"),
        ("1", ""),
        ("", ""),
        ("s-1", "1/s"),
        ("N m s rad-1", "N·m·s/rad"),
        ("rad/s", "rad/s"),
        ("m/s^2", "m/s²"),
        ("%", "%"),
        ("m0.5", "m^0.5"),
    ],
)
def test_units_as_people_write_them(units, text):
    assert labels.unit_label(units) == text
    assert labels.axis_label("angular_velocity", units) == "angular velocity" + (f" ({text})" if text else "")
    assert labels.axis_label("my_tip", units).startswith("my_tip")


def test_unknown_names():
    ds = sweep({"a": random(5)}, tip=random(5, 3, 3))
    assert [panel.title for panel in select_panels.named_panels(ds, ["tip.z", "tip.z"]).panels] == ["tip, z"]
    with pytest.raises(lienumba.ScenarioError, match=r'^the dataset has no variable "tip.w"; '):
        select_panels.named_panels(ds, ["tip.w"])


def test_violations_are_shown_by_their_peaks():
    """Of many times the largest of a few in a row: none is lost, and the ink is that of a line."""
    times = 1001
    violation = abs(random(3, times)) * 1e-16
    violation[1, 700] = 1e-9
    violation[2, 500:] = np.nan
    ds = sweep({"a": np.arange(3.0)}, times=np.linspace(0.0, 1.0, times), position_violation=violation)
    [panel] = select_panels.named_panels(ds, ["position_violation"]).panels
    found = quantiles.time_series(ds, panel)
    [line] = found.lines
    assert len(found.times) == len(line.largest) == 112
    assert quantiles.label(ds, panel) == "position violation (m)\nlargest of each 9 times"
    assert line.each[1].max() == line.largest.max() == 1e-9
    assert found.times[line.each[1].argmax()] == pytest.approx(0.7, abs=0.009)
    np.testing.assert_array_equal(line.each[0], [violation[0, k : k + 9].max() for k in range(0, times, 9)])
    assert np.isnan(line.each[2][-1])


def test_fans_say_how_many_runs_are_left_and_draw_the_last_ones():
    tip = random(RUNS, 6)
    ends = np.repeat([2, 3, 4, 6], [10, 17, 8, 5])  # stored times of each run
    tip[np.arange(6) >= ends[:, None]] = np.nan
    ds = sweep({"a": random(RUNS)}, np.where(ends < 6, STOPPED, 0), times=np.arange(6.0), tip=tip)
    found = quantiles.time_series(ds, select_panels.named_panels(ds, ["tip"]).panels[0])
    np.testing.assert_array_equal(found.survivors, [40, 40, 30, 13, 5, 5])
    np.testing.assert_array_equal(found.enough, [True] * 4 + [False] * 2)
    [line] = found.lines
    assert list(line.left) == [35, 36, 37, 38, 39]
    for run, values in line.left.items():
        np.testing.assert_array_equal(values, [*[np.nan] * 4, *tip[run, 4:]])
    few = ds.isel(run=slice(30, None))
    assert not quantiles.time_series(few, select_panels.named_panels(few, ["tip"]).panels[0]).lines[0].left


def test_inputs_are_of_all_sampled_runs():
    a = random(RUNS)
    status = np.where(np.arange(RUNS) % 4 == 1, NON_FINITE, 0)
    ds = sweep({"a": a}, status, np.arange(RUNS) - 1, first=random(RUNS))
    choice = select_panels.default_panels(ds)
    assert [panel.title for panel in choice.panels] == ["first", "status", "sampled a"]
    [spread] = quantiles.histograms(ds, choice.panels[2])
    np.testing.assert_array_equal(spread.values, a[1:])
    np.testing.assert_array_equal(spread.failed, a[1::4])
    assert (spread.missing, spread.nominal) == (0, a[0])
    assert quantiles.histograms(ds, choice.panels[0])[0].failed is None
    for lost in (ds.assign(status=ds["status"] * 0 + NON_FINITE), ds.isel(run=slice(1, 2))):
        choice = select_panels.default_panels(lost)
        assert [panel.title for panel in choice.panels] == ["status", "sampled a"]
        np.testing.assert_array_equal(
            quantiles.histograms(lost, choice.panels[1])[0].values, lost["a"].values[-RUNS + 1 :]
        )


def test_constants_say_nothing():
    same, some = np.zeros(RUNS), abs(random(RUNS))
    ds = sweep({"a": random(RUNS)}, first=random(RUNS), max_energy_drift=same, max_position_violation=some)
    assert [panel.title for panel in select_panels.default_panels(ds).panels] == [
        "first",
        "max position violation",
        "sampled a",
    ]
    alone = sweep({"a": same}, first=np.ones(RUNS), max_energy_drift=same).drop_vars("a")
    assert [panel.title for panel in select_panels.default_panels(alone).panels] == ["status"]
