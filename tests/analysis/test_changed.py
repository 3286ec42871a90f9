"""What is told of changes, of a dataset whose every number is known."""

import numpy as np
import pytest
import xarray as xr

from lienumba import ScenarioError
from lienumba.analysis import changes, run_table, summarise
from lienumba.batch.changes import KINDS, NAMES, NONE
from lienumba.integrators import codes
from lienumba.store.layout import dataset
from lienumba.store.outputs import write

NAN = np.nan
TOLD = np.array(  # two runs: time, kind, what, impulse, energy of two changes each
    [
        [[0.1, codes.LOCKED, 1, 2.0, 0.5], [0.4, codes.IMPACT, 0, 3.0, 0.25]],
        [[0.3, codes.LOCKED, 1, 4.0, 1.5], [NAN, NONE, NONE, NAN, NAN]],
    ]
)


def known(changed: np.ndarray = TOLD, counts: tuple[int, ...] = (3, 1)) -> xr.Dataset:
    runs, n = changed.shape[:2]
    return dataset(
        variables={
            "status": np.zeros(runs, np.int8),
            "end_time": np.ones(runs),
            "event_time": np.full((runs, 2), 0.1),
            "change_time": changed[:, :, 0],
            "change_kind": changed[:, :, 1],
            "change_what": changed[:, :, 2],
            "change_impulse": changed[:, :, 3],
            "change_energy": changed[:, :, 4],
            "changes": np.array(counts),
            "energy_lost": np.array([1.0, 1.5]),
            "mode": np.array([[[0, 1], [2, 1]], [[0, 0], [NAN, NAN]]]),
            "last_mode": np.array([[2, 1], [0, 0]]),
        },
        times=[0.0, 1.0], runs=range(10, 10 + runs), bodies=["top"], joints=[], constraints=[], events=["far", "near"],
        changes=n, switches=["stop", "latch"], inputs={}, input_units={}, attributes={},
    )  # fmt: skip


def test_every_change_by_run_and_time():
    found = changes(known())
    assert found.run.values.tolist() == [10, 10, 11]
    assert found.kind.values.tolist() == ["locked", "impact", "locked"]
    assert found.what.values.tolist() == ["near", "stop", "near"]  # of an event, of a switch
    assert found.time.values.tolist() == [0.1, 0.4, 0.3]
    assert found.energy.values.tolist() == [0.5, 0.25, 1.5]


def test_a_table_of_runs_names_changes_and_leaves_empty_ones_out():
    none = np.full((2, 1, 5), [NAN, NONE, NONE, NAN, NAN])
    table = run_table(known(np.concatenate([TOLD, none], axis=1)))
    assert table["change_kind.1"].tolist() == ["impact", ""]
    assert table["change_what.0"].tolist() == ["near", "near"]
    assert table["change_what.1"].tolist() == ["stop", ""]
    assert table["change_energy.1"].tolist()[0] == 0.25
    assert not [name for name in table if name.endswith(".2")]
    assert set(table.attrs["units"]) <= set(table)


def test_the_summary_tells_what_changed_and_when():
    summary = summarise(known())
    locked, impact = summary.changes
    assert (locked.what, locked.kind.name, locked.count, locked.runs) == ("near", "locked", 2, 2)
    assert (locked.median, locked.impulse, locked.largest_impulse, locked.energy) == pytest.approx((0.2, 3.0, 4.0, 1.0))
    assert (impact.what, impact.kind.name, impact.count, impact.runs) == ("stop", "impact", 1, 1)
    shown = repr(summary)
    assert "changes of each run: 1 to 3, of which the first 2 are told; energy lost: 1 to 1.5 J, median 1.25 J" in shown
    assert summarise(known(counts=(2, 1))).changes_told.startswith("changes of each run: 1 to 2; energy lost")


def test_runs_without_changes():
    none = np.array([[[NAN, NONE, NONE, NAN, NAN]]] * 2)
    assert len(changes(known(none, (0, 0))).entry) == 0
    assert "no changes" in repr(summarise(known(none, (0, 0))))
    with pytest.raises(ScenarioError, match="tells of no changes: its mechanism has no locks, limits, contacts"):
        changes(known()[["status"]])


def test_a_table_that_has_lost_a_column():
    for reading in (changes, summarise):
        with pytest.raises(ScenarioError, match="is not as lienumba wrote it, it has lost change_impulse;"):
            reading(known().drop_vars("change_impulse"))


def test_flags_say_what_numbers_mean(tmp_path):
    write(known(), tmp_path / "out.nc")
    with xr.open_dataset(tmp_path / "out.nc", decode_times=False) as opened:
        xr.testing.assert_identical(opened.load(), known())
        kind, mode = opened.change_kind, opened["mode"]
        assert dict(zip(kind.attrs["flag_values"], kind.attrs["flag_meanings"].split(), strict=True)) == {
            NONE: "none", **{x.code: x.name for x in KINDS}
        }  # fmt: skip
        assert kind.dtype == np.int8
        assert mode.attrs["flag_meanings"] == "off closed sliding"
        assert np.isnan(mode.sel(run=11, time=1.0)).all()
        assert opened.last_mode.sel(run=10, switch="stop") == 2


def test_figures_mark_changes_of_one_run_and_draw_modes_as_steps():
    from matplotlib import pyplot

    from lienumba.figures.plots import figure

    ax = figure(known().isel(run=[0]), "mode").axes[0]
    uprights = {line.get_xdata()[0] for line in ax.lines if len({*line.get_xdata()}) == 1}
    assert uprights == {0.1, 0.4}
    assert {line.get_drawstyle() for line in ax.lines if len({*line.get_xdata()}) > 1} == {"steps-post"}
    assert [x.get_text() for x in ax.get_yticklabels()] == ["off", "closed", "sliding"]
    ax = figure(known(), "mode").axes[0]
    assert not [line for line in ax.lines if len({*line.get_xdata()}) == 1]
    pyplot.close("all")


def test_kinds_are_those_of_the_drivers():
    assert len(NAMES) == codes.KINDS
    assert [kind.code for kind in KINDS] == [*range(codes.KINDS)]
