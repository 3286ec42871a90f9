"""The page of modes in a browser: a mode moves as NumPy says, at any width nothing is cut off."""

from contextlib import closing

import pytest

import lienumba
from lienumba.present.html.motion import CYCLE
from lienumba.scene import mode_scene
from lienumba.scene.modes import FRAMES
from tests.process.browser import CUT_OFF, HEIGHTS, Seen, browser
from tests.process.test_browser import vertices_of
from tests.rigs.pages import page_of
from tests.rigs.places import SCENARIOS


@pytest.fixture(scope="module")
def found():
    return lienumba.modes(SCENARIOS / "machine_on_mounts.toml", overrides={"sweep.runs": 12})


def test_modes_move_and_fit_any_screen(found, tmp_path):
    file = tmp_path / "modes.html"
    file.write_text(page_of(found, "modes.nc"), encoding="utf-8")
    shown = mode_scene(found, modes=range(1, 9)).runs
    with browser() as started:
        for width in HEIGHTS:
            with closing(Seen(started, file, width)) as seen:
                assert seen.plays
                for mode in (0, 2):
                    seen.page.select_option("#run", str(mode))
                    for n in (0, FRAMES // 4, FRAMES // 2):
                        seen.go_to(CYCLE * n / FRAMES)
                        assert seen.page.inner_text("#clock") == f"{360 * n // FRAMES}°"
                        assert seen.vertices() == pytest.approx(vertices_of(shown[mode], n), abs=1e-3)
                seen.look_at_all()
                assert seen.ask("document.scrollingElement.scrollWidth") <= width
                assert seen.ask(CUT_OFF) == []
                assert seen.complaints == []
