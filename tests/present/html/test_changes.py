"""The section of changes, and the marks of the mechanism."""

import numpy as np
import pytest

from tests.rigs.changing import changing
from tests.rigs.pages import Read, array, page_of

pytest.importorskip("plotly")


@pytest.fixture(scope="module")
def page():
    return Read(page_of(changing()))


def test_every_change_is_drawn_at_its_time(page):
    traces = page.chart("when each changed")["traces"]
    rows = {trace["y"][0]: array(trace["x"]) for trace in traces}
    assert {"shut: locked", "let_go: released", "floor: impact"} <= {*rows}
    assert rows["shut: locked"] == pytest.approx(np.full(4, 0.1))
    assert sum(map(len, rows.values())) == int((changing()["change_kind"] >= 0).sum())


def test_bands_count_the_runs(page):
    (closed,) = page.chart("hinge.lock")["traces"]
    assert (array(closed["y"]) == 4 * (array(closed["x"]) > 0.1 - 1e-12)).sum() >= 40
    assert array(closed["y"]).tolist() == (changing()["mode"].sel(switch="hinge.lock") == 1).sum("run").values.tolist()


def test_the_table_stands_in_the_same_section(page):
    assert "changed how runs times" in page.text
    assert "#changes" in [a["href"] for tag, a in page.tags if tag == "a"]
    assert "◆ locked, ○ open" in page.text


def test_the_mechanism_knows_what_is_locked(page):
    run = page.data["motion"]["runs"][0]
    looks = array(run["looks"]).reshape(-1, len(run["places"]))
    assert looks[0].tolist()[:2] == [0, 0]
    assert looks[-1].tolist()[:2] == [2, 1]
    assert run["hits"][0][0] > 0.05
