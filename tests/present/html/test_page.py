"""The page: whole, harmless, the same every time, and right for every kind of dataset."""

import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import lienumba
from lienumba import ScenarioError
from lienumba.batch.statuses import NON_FINITE
from lienumba.store.outputs import write
from tests.facade import app
from tests.rigs.made_studies import study
from tests.rigs.pages import TITLE, Read, array, page_of, pendulum, swept

pytest.importorskip("plotly")
SECTIONS = ["The mechanism", "Summary", "Over the time", "Energy and drift", "What depends on what", "What came out",
            "What was drawn", "What was run"]  # fmt: skip


def failing(ds, codes):
    """The dataset with these statuses: what failed is NaN from the tenth time on, and ended there."""
    ds = ds.copy(deep=True)
    for run, code in codes.items():
        ds["status"].loc[{"run": run}] = code
        ds["end_time"].loc[{"run": run}] = 0.1
        for name, x in ds.data_vars.items():
            if "time" in x.dims and x.dtype.kind == "f":
                ds[name].loc[{"run": run, "time": ds.time[11:]}] = np.nan
    return ds


def test_the_page_has_all_sections_and_says_how_it_went():
    page = Read(page_of(swept()))
    assert [a["href"] for tag, a in page.tags if tag == "a"] == [
        "#motion", "#summary", "#courses", "#checks", "#sensitivity", "#outputs", "#inputs", "#origin"
    ]  # fmt: skip
    for title in SECTIONS:
        assert title in page.text
    assert "All 40 runs and the nominal run reached t = 0.4 s" in page.text
    assert "2 bodies · 2 joints · rk4, step 0.002 s · 2 varied numbers" in page.text
    assert "lienumba replay pendel.nc --run -1" in page.text
    assert swept().attrs["scenario_sha256"] in page.text


def test_nothing_is_loaded_from_anywhere():
    page = Read(page_of(swept()))
    assert all("src" not in a for _, a in page.tags)
    assert {a["href"] for _, a in page.tags if "href" in a and not a["href"].startswith("#")} == {"data:,"}
    assert page.policy.startswith("default-src 'none'; ")
    assert "http" not in page.policy


def test_titles_and_names_are_no_markup():
    text = page_of(swept(), 'a"><script>alert(1)</script>.nc')
    page = Read(text)
    assert page.text.count(TITLE) == 3  # the title of the page, its heading, and what info says
    assert "<b>fett" not in text
    assert [tag for tag, _ in page.tags].count("script") == 3
    assert page.ids["scenario-toml"] == swept().attrs["scenario"]


def test_the_same_dataset_gives_the_same_bytes():
    assert page_of(swept()) == page_of(swept().copy(deep=True))


def test_fans_are_quantiles_over_the_runs():
    page = Read(page_of(swept()))
    traces = page.chart("tip")["traces"]
    values = swept()["tip"].sel(run=slice(0, None)).values
    median = next(x for x in traces if x["name"] == "z")
    low, high = array(median["customdata"]).T
    for found, level in ((low, 0.05), (array(median["y"]), 0.5), (high, 0.95)):
        assert found == pytest.approx(np.quantile(values[..., 2], level, axis=0))
    nominal = next(x for x in traces if x["name"] == "z nominal run")
    assert array(nominal["y"]) == pytest.approx(swept()["tip"].sel(run=-1, axis="z").values)
    assert array(median["x"]) == pytest.approx(swept()["time"].values)


def test_histograms_count_the_runs_of_the_sweep():
    page = Read(page_of(swept()))
    masses = swept()["bodies.oben.mass"].values[1:]
    (bars,) = page.chart("bodies.oben.mass")["traces"]
    counts, ends = array(bars["y"]), array(bars["customdata"])
    assert counts.sum() == len(masses)
    assert counts[0] == ((masses >= ends[0, 0]) & (masses < ends[0, 1])).sum()


def test_sensitivity_is_that_of_the_analysis():
    ds = swept()
    found = lienumba.analysis.sensitivity(ds)
    page = Read(page_of(ds))
    (ranks,) = page.chart("Spearman's rank correlations")["traces"]
    expected = found["rank_correlation"].sel(input=ranks["x"], output=ranks["y"]).transpose("output", "input")
    assert array(ranks["z"]) == pytest.approx(expected.values)
    strongest = str(abs(found.rank_correlation.sel(output="tip.x")).idxmax().item())
    (points,) = page.chart(f"tip.x (m) over {strongest}")["traces"]
    assert array(points["x"]) == pytest.approx(ds[strongest].values[1:])
    assert array(points["y"]) == pytest.approx(ds["tip"].values[1:, -1, 0])


def test_failures_are_told_with_a_remedy():
    page = Read(page_of(failing(swept(), {3: NON_FINITE, 7: NON_FINITE})))
    assert "38 of 40 runs are good: 2 failed (2 non finite); the nominal run is good" in page.text
    assert "an implicit method (radau5) where a force is stiff 3 (at 0.1 s), 7 (at 0.1 s)" in page.text
    assert "lienumba replay pendel.nc --run 3" in page.text


def test_all_runs_failed():
    ds = failing(swept(), dict.fromkeys(swept()["run"].values.tolist(), NON_FINITE))
    page = Read(page_of(ds))
    assert "0 of 40 runs are good: 40 failed (40 non finite); the nominal run failed (non finite)" in page.text
    assert page.data["motion"]["runs"][0]["label"] == "nominal run"


def test_one_run():
    page = Read(page_of(lienumba.run(pendulum(), runs=[5])))
    assert "The run reached t = 0.4 s" in page.text
    assert "What was drawn" not in page.text
    assert len(page.data["motion"]["runs"]) == 1


def test_summaries_are_replayed_for_the_mechanism():
    scenario = pendulum(8, output={"every": 0.01, "mode": "summary", "summary": {"tip": ["max"]}})
    page = Read(page_of(lienumba.run(scenario)))
    assert "Over the time" not in page.text
    assert "tip_max" in page.text
    assert len(page.data["motion"]["runs"]) == 8


def test_a_mechanism_that_cannot_be_shown_says_why():
    ds = swept().drop_vars(["position", "rotation"])
    ds.attrs["scenario"] = ds.attrs["scenario"].replace("[model]", 'files = {"own.py" = "x = 1"}\n[model]', 1)
    page = Read(page_of(ds))
    assert "pendel.nc: brings Python code, which a replay runs: own.py; read it" in page.text
    assert "motion" not in page.data


def test_a_study():
    errors = np.array([0.08, 0.04, 0.02, 0.01]) ** np.array([[2.0], [4.0]])
    page = Read(page_of(study(errors[None], floor=1e-12), "made.nc"))
    assert "8 points, each with 1 run, none failed." in page.text
    errors_shown = [text.split(" over ")[0] for _, text in page.captions[:2]]
    assert errors_shown == ["largest position error (m)", "largest velocity error (m/s)"]
    first = page.chart("largest position error (m) over the mean step")["traces"][0]
    assert sorted(array(first["y"])) == pytest.approx(sorted(errors[0]))
    assert "2.00" in page.text
    assert "4.00" in page.text


@pytest.mark.parametrize("scale", [1e300, 1e-300, np.inf, np.nan, 0.0])
def test_numbers_of_any_size(scale):
    ds = swept().copy(deep=True)
    with np.errstate(all="ignore"):
        ds["tip"] = ds["tip"].copy(data=scale * ds["tip"].values)
        page = Read(page_of(ds))
    assert "Summary" in page.text


def test_the_page_of_a_large_sweep_stays_small():
    ds = swept()
    many = ds.isel(run=np.arange(2000) % ds.sizes["run"]).assign_coords(run=np.arange(2000))
    text = page_of(many)
    assert len(text.encode()) < 8e6
    assert "of 2,000 runs 1,500 are drawn, evenly over their labels; all count" in Read(text).text


@pytest.mark.release
def test_runs_that_another_engine_recomputes():
    wrong = swept().copy(deep=True)
    wrong["velocity"].loc[{"run": 39}] *= 1.0 + 1e-6
    with pytest.warns(lienumba.errors.ResultWarning, match="gives other numbers for run"):
        text = Read(page_of(wrong, check=2)).text
    assert "from start to end: 1 agree, 1 differ, 0 without a verdict" in text
    assert 'warning: the engine "numba" gives other numbers for run 39' in text
    assert "lienumba report pendel.nc --check 2" in text


def test_what_another_engine_cannot_recompute_says_why():
    ds = lienumba.run(pendulum(integrator__coordinates="joint"), runs=[5])
    page = Read(page_of(ds, check=2))
    assert "Recomputed by another engine" in page.text
    assert 'integrator.coordinates = "joint": the engine "numba" does not support other coordinates' in page.text
    assert "warning" not in page.text
    with pytest.raises(ScenarioError, match="check = true: must be a number of runs"):
        lienumba.report(ds, "no.html", check=True)


def test_the_command(tmp_path):
    file = tmp_path / "pendel.nc"
    write(swept(), file)
    (tmp_path / "old.html").write_text("old")
    done = CliRunner().invoke(app, ["report", str(file), "-o", str(tmp_path / "old.html")])
    assert done.exit_code == 0
    assert done.output.startswith(f"written to {tmp_path / 'old.html'}, ")
    assert "Zwei Pendel" in (tmp_path / "old.html").read_text(encoding="utf-8")
    assert sorted(x.name for x in tmp_path.iterdir()) == ["old.html", "pendel.nc"]


@pytest.mark.parametrize(
    ("output", "sentence"),
    [
        ("page.pdf", "output = page.pdf: is no page; give a name that ends in .html or .htm"),
        ("no/page.html", "output = no/page.html: its folder no does not exist; create it or choose another"),
        ("folder.html", "output = folder.html: is a folder; give the name of a file in it, like folder.html/out.html"),
    ],
)
def test_refusals(tmp_path, monkeypatch, output, sentence):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(ScenarioError) as refused:
        lienumba.report(swept(), output)
    assert str(refused.value) == sentence


def test_without_plotly(monkeypatch):
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(ScenarioError) as refused:
        page_of(swept())
    assert str(refused.value) == (
        'a report needs plotly, which is missing; in the clone of lienumba, pip install ".[report]"'
    )


def test_warnings_stand_at_the_top():
    page = Read(page_of(swept().assign_attrs(warnings="max_relative_energy_drift = 0.9 in run 0; give a smaller step")))
    before, _, after = page.text.partition("warning: max_relative_energy_drift = 0.9 in run 0")
    assert "reached t = 0.4 s" in before
    assert "Summary" in after
