"""A page in headless Chromium, and what it says of itself."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
NEEDED = "LIENUMBA_NEEDS_BROWSER"  # set where a browser must be there
# What Chromium says whatever plotly.js draws: how fast WebGL is in software, and how its labels are rendered.
DRIVER = ("GL Driver Message", "willReadFrequently")
WIDTHS = {1280: 800, 390: 844}  # and their heights
HEIGHTS = WIDTHS | {768: 1024}
PATIENCE = 60_000  # ms: what is drawn in software waits for its turn on a busy machine
DRAWN = """(run) => {
  const stage = document.getElementById("stage"), { traces, dataScale } = stage._fullLayout.scene._scene;
  const parts = stage._fullData.filter((x, n) => stage.data[n].meta.run === run && stage.data[n].meta.part);
  const placed = (x) => [["x", "y", "z"].map((key) => Array.from(x[key])), Array.from(traces[x.uid].mesh.placed)];
  return [parts.map(placed), dataScale];
}"""
CUT_OFF = (Path(__file__).parent / "cut_off.js").read_text()
MOVE = "(t) => { const x = document.getElementById('time'); x.value = t; x.dispatchEvent(new Event('input')); }"


def chromium() -> str:
    """The browser; skips where there is none, and fails where one is needed."""
    pytest.importorskip("plotly")
    pytest.importorskip("playwright")
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        reason = f"no Chromium: none of {', '.join(NAMES)} is on the PATH"
        if os.environ.get(NEEDED):
            pytest.fail(f"{reason}, and {NEEDED} is set")
        pytest.skip(reason)
    return found


class Seen:
    """A page of this width in a browser. complaints: of its console, and of what it asked any network for."""

    def __init__(self, browser: Any, file: Path, width: int, theme: str = "light") -> None:
        narrow = width < 640
        size = {"width": width, "height": HEIGHTS[width]}
        self.context = browser.new_context(viewport=size, color_scheme=theme, has_touch=narrow, is_mobile=narrow)
        self.page, self.width = self.context.new_page(), width
        self.page.set_default_timeout(PATIENCE)
        self.complaints: list[str] = []
        self.page.on("console", self._listen)
        self.page.on("pageerror", lambda error: self.complaints.append(f"error: {error}"))
        self.page.on("request", self._ask)
        self.url = file.as_uri()
        self.page.goto(self.url)
        self.page.wait_for_selector("html[data-ready]")
        self.plays = self.page.inner_text("#play") == "Pause"  # by itself
        self.pause()

    def _listen(self, message: Any) -> None:
        if message.type in ("error", "warning") and not any(known in message.text for known in DRIVER):
            self.complaints.append(f"{message.type}: {message.text}")

    def _ask(self, request: Any) -> None:
        if request.url != self.url and not request.url.startswith(("data:", "blob:")):
            self.complaints.append(f"request: {request.url}")

    def close(self) -> None:
        self.context.close()

    def ask(self, script: str, *arguments: Any) -> Any:
        return self.page.evaluate(script, *arguments)

    def look_at_all(self) -> None:
        """Scroll down, so that all charts are drawn."""
        for top in range(0, self.ask("document.scrollingElement.scrollHeight"), HEIGHTS[self.width] // 2):
            self.ask(f"scrollTo(0, {top})")
            self.page.wait_for_timeout(60)
        self.page.wait_for_selector("[data-chart] .xtick text", state="attached")
        self.ask("scrollTo(0, 0)")

    def click(self, what: str) -> None:
        """Click an element, as its page sees it; a mouse would wait for two frames, which software may never draw."""
        self.page.locator(what).evaluate("(element) => element.click()")

    def pause(self) -> None:
        if self.page.inner_text("#play") == "Pause":
            self.click("#play")

    def go_to(self, time: float) -> None:
        """Move the slider to a time."""
        self.ask(MOVE, time)

    @property
    def time(self) -> float:
        return float(self.page.inner_text("#clock").removesuffix(" s"))

    def vertices(self, run: int = 0) -> np.ndarray:
        """The vertices (n, 3) that are drawn of all bodies of a run: where the matrices of their meshes take them."""
        drawn, scale = self.ask(DRAWN, run)
        found = []
        for corners, columns in drawn:
            matrix = np.reshape(columns, (4, 4)).T
            found.append((np.array(corners).T * scale @ matrix[:3, :3].T + matrix[:3, 3]) / scale)
        return np.concatenate(found)


@contextmanager
def browser() -> Iterator[Any]:
    path = chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        opened = started.chromium.launch(executable_path=path, args=["--no-sandbox", "--enable-unsafe-swiftshader"])
        yield opened
        opened.close()
