"""What sets failing runs apart, and how two designs compare: on made-up inputs whose influence is known."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.stats import mannwhitneyu
from typer.testing import CliRunner

import lienumba
from lienumba import ScenarioError, analysis
from lienumba.analysis.comparison import compare
from lienumba.analysis.requirements.separation import holm
from lienumba.figures import figure
from lienumba.figures.outputs import running
from lienumba.sweep.confidence import half_width
from tests.facade import app

BODY = {"name": "b", "mass": 1.0, "inertia": [1.0, 1.0, 1.0], "position": [0, 0, 0]}
WANTED = [
    {"name": "stays left", "value": "last_position.b.x", "below": 0.5, "probability": 0.7},
    {"name": "stays near", "value": "last_position.b.y", "between": [-1, 1], "probability": 0.5},
    {"name": "is there", "value": "last_position.b.z", "above": -1, "probability": 0.9},
]
NORMAL = {"distribution": "normal", "std": 1.0}
FLY: dict[str, Any] = {
    "title": "Flies",
    "model": {"bodies": [BODY | {"velocity": [0, 0, 0]}], "gravity": [0, 0, 0]},
    "requirements": WANTED,
    "integrator": {"step": 0.5, "end_time": 1.0},
    "sweep": {"runs": 400, "vary": {f"bodies.b.velocity[{k}]": NORMAL for k in range(2)} | {"bodies.b.mass": NORMAL}},
}
FLY["sweep"]["vary"]["bodies.b.mass"] = {"distribution": "uniform", "low": 1, "high": 2}
VX, VY, MASS = "bodies.b.velocity[0]", "bodies.b.velocity[1]", "bodies.b.mass"


@pytest.fixture(scope="module")
def flown() -> xr.Dataset:
    return lienumba.run(FLY)


def test_the_input_that_decides_is_first(flown: xr.Dataset) -> None:
    found = analysis.separation(flown, "stays left")
    assert found.input.values[0] == VX
    first = found.isel(input=0)
    assert (first.distance, first.larger) == (1.0, 1.0)
    assert first.p_value < 1e-20
    assert first.first_order > 0.5
    assert (found.p_value.values[1:] > 0.05).all()
    x = flown[VX].values
    assert (first.median_met, first.median_not_met) == (np.median(x[x < 0.5]), np.median(x[x >= 0.5]))
    assert found.attrs["met"] + found.attrs["not_met"] == 400


def test_failing_on_both_sides_is_seen(flown: xr.Dataset) -> None:
    """Where ranks see nothing, distributions differ."""
    found = analysis.separation(flown, "stays near").sel(input=VY)
    assert found.p_value < 1e-20
    assert 0.4 < found.larger < 0.6
    y = flown[VY].values
    test = mannwhitneyu(y[abs(y) > 1], y[abs(y) <= 1])
    assert found.larger == pytest.approx(test.statistic / ((abs(y) > 1).sum() * (abs(y) <= 1).sum()))


def test_p_values_are_for_all_inputs_together() -> None:
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.9, 0.8]) == [1.0, 1.0]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("is there", '"is there": all runs meet it, so that nothing sets them apart; there must be both'),
        ("is ther", 'the dataset has no requirement "is ther"; the nearest known name is "is there"'),
    ],
)
def test_what_cannot_be_told_apart_is_said(flown: xr.Dataset, name: str, message: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        analysis.separation(flown, name)
    assert str(refused.value) == message


def test_compared_designs_tell_their_requirements(flown: xr.Dataset) -> None:
    """By counting pairs; a requirement of one alone is left out."""
    other = lienumba.run(FLY | {"requirements": [WANTED[0] | {"below": 0.2}, WANTED[2]]})
    found = compare(flown, other)
    assert [x for x in found.output.values if x.startswith("requirement_met")] == [
        "requirement_met.stays left", "requirement_met.is there",
    ]  # fmt: skip
    row = found.sel(output="requirement_met.stays left")
    x = flown[VX].values
    lost = ((x >= 0.2) & (x < 0.5)).mean()
    assert row.difference == pytest.approx(-lost)
    assert row.difference_low < -lost < row.difference_high < 0
    assert found.attrs["verdicts"].split("\n")[1] == (
        "is there: met (0 of 400 runs fail it), then met (0 of 400 runs fail it)"
    )
    assert "requirements.stays left.below: 0.5, then 0.2" in found.attrs["changes"]


def test_figures(flown: xr.Dataset) -> None:
    drawn = figure(flown, requirement="stays left")
    assert drawn.axes[0].get_title(loc="left") == f"{VX}\np < 1e-6"
    heights = [patch.get_height() for patch in drawn.axes[0].patches]
    assert sum(heights) == pytest.approx(2.0)
    drawn = figure(flown, ["last_position.b.x", "requirement_met.stays near"], against=[VX, VY])
    assert len(drawn.axes) == 4
    assert drawn.axes[0].get_xlabel() == f"{VX} (m/s)"
    assert len(drawn.axes[0].lines[0].get_xdata()) == 400
    assert len(figure(flown, "last_position.b.x", convergence=True).axes[0].lines) == 1
    with pytest.raises(ScenarioError, match="against and convergence are asked for together, but each has a figure"):
        figure(flown, against=VX, convergence=True)
    with pytest.raises(ScenarioError, match=r'no input "bodies\.b\.velocity\[2\]"; the nearest known name is'):
        figure(flown, against="bodies.b.velocity[2]")


def test_a_running_mean_is_that_of_the_first_runs() -> None:
    values = 1e6 + np.random.default_rng(2).normal(size=1000)
    n, mean, low, high = running(values)
    for k in (0, 40, len(n) - 1):
        own = values[: n[k]]
        half = half_width(own.std(ddof=1), n[k], 0.95)
        assert (mean[k], low[k], high[k]) == pytest.approx((own.mean(), own.mean() - half, own.mean() + half), abs=1e-8)
    assert (n[0], n[-1]) == (2, 1000)
    n, mean, low, high = running(np.repeat([1.0, 0.0], [998, 2]))
    assert (mean[-1], low[-1] < 0.998 < high[-1], low[0] < 1 == high[0]) == (0.998, True, True)


def test_the_commands_show_it(flown: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    flown.to_netcdf("a.nc")
    lienumba.run(FLY | {"requirements": [], "title": "Plain"}, overrides={"sweep.runs": 2}, output="b.nc").close()
    Path("c.nc").write_text("no dataset")

    def said(*words: str) -> str:
        result = CliRunner().invoke(app, [*words])
        assert result.exit_code == 0, result.output
        return result.stdout

    told = said("analyse", "a.nc")
    assert 'fail "stays left" apart: 2 of 3 inputs show no difference' in told
    assert "stays left" in said("info", "a.nc")
    listed = said("list", "-o", "index.csv")
    assert "Flies" in listed
    assert re.search(r"[12] of 3 met", listed)
    assert "left out 1 file, the first: c.nc cannot be opened as netCDF" in listed
    lines = Path("index.csv").read_text().splitlines()
    assert lines[0] == "file,title,kind,runs,failed,date,version,stays left,stays near,is there"
    assert lines[2].startswith("b.nc,Plain,sweep,2,0,")
    for words in (["--requirement", "stays left"], ["last_position.b.x", "--against", VX], ["--convergence"]):
        said("plot", "a.nc", *words, "-o", "x.png")
    lienumba.report("a.nc", "a.html")
    page = Path("a.html").read_text()
    first, second = (page.index(f'id="{key}"') for key in ("verdict", "motion"))
    assert first < second
    assert page.index(" requirements met") < page.index("All 400 runs reached")
    assert page.count("What fails “") == 4  # two sections and their links
