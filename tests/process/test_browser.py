"""The page in a browser: quiet, offline, readable at any width; the mechanism moves as NumPy says."""

from contextlib import closing

import numpy as np
import pytest

import lienumba
from lienumba.scene import scene
from tests.process.browser import CUT_OFF, WIDTHS, Seen, browser
from tests.rigs.pages import page_of, swept

SIZE = 1.2  # m, of the mechanism


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    found = tmp_path_factory.mktemp("page") / "pendel.html"
    found.write_text(page_of(swept()), encoding="utf-8")
    return found


@pytest.fixture(scope="module")
def started():
    with browser() as found:
        yield found


@pytest.fixture(scope="module", params=WIDTHS)
def page(request, started, file):
    with closing(Seen(started, file, request.param)) as seen:
        yield seen


@pytest.fixture(scope="module")
def shown():
    return scene(swept(), count=8)


def vertices_of(run, n):
    """Of all bodies at the n-th time of a run: position + R vertex."""
    solids = run.mechanism.solids
    return np.concatenate(
        [run.positions[n, b] + solid.vertices @ run.rotations[n, b].T for b, solid in enumerate(solids)]
    )


def test_the_animation_plays_and_stops(page):
    assert page.plays
    before, first = page.vertices(), page.time
    page.click("#play")
    page.page.wait_for_timeout(300)
    assert page.page.inner_text("#play") == "Pause"
    page.click("#play")
    after, time = page.vertices(), page.time
    assert time != first
    assert abs(after - before).max() > 1e-3
    page.page.wait_for_timeout(100)
    assert page.time == time


def test_the_slider_moves_the_bodies_to_where_they_are(page, shown):
    run = shown.runs[0]
    for n in (0, 13, 40):
        page.go_to(run.times[n])
        assert page.time == pytest.approx(run.times[n])
        assert page.vertices() == pytest.approx(vertices_of(run, n), abs=1e-3 * SIZE)
        beside = next(x for x in shown.runs if x.why.startswith("farthest"))
        assert page.vertices(1) == pytest.approx(vertices_of(beside, n), abs=1e-3 * SIZE)


def test_between_stored_times_bodies_are_where_a_replay_has_them(page, shown):
    dense = lienumba.replay(swept(), -1)
    for time in (0.016, 0.124, 0.298, 0.394):
        page.go_to(time)
        there = dense.isel(run=0).sel(time=time, method="nearest")
        assert float(there.time) == pytest.approx(time)
        expected = np.concatenate(
            [
                r + solid.vertices @ R.T
                for r, R, solid in zip(
                    there["position"].values, there["rotation"].values, shown.runs[0].mechanism.solids, strict=True
                )
            ]
        )
        assert page.vertices() == pytest.approx(expected, abs=1e-3 * SIZE)


def test_another_run_can_be_chosen(page, shown):
    page.go_to(0.2)
    page.page.select_option("#run", "3")
    assert page.vertices() == pytest.approx(vertices_of(shown.runs[3], 20), abs=1e-3 * SIZE)
    page.page.select_option("#beside", "0")
    assert page.ask("[...new Set(document.getElementById('stage').data.map((x) => x.meta.run))]") == [None, 0]
    page.page.select_option("#run", "0")


def test_nothing_is_cut_off_and_no_page_scrolls_sideways(page):
    page.look_at_all()
    assert page.ask("document.scrollingElement.scrollWidth") <= page.width
    assert page.ask(CUT_OFF) == []


def test_the_console_is_quiet_and_nothing_was_asked_for(page):
    assert page.complaints == []
