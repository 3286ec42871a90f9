"""Pictures of the report of the heavy top's Monte Carlo, as a desk and a phone show it. Needs Chromium."""

import shutil
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

import lienumba

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
WIDTHS = {1280: (1280, 1560), 390: (390, 844)}  # of the pictures
MOMENT = 1.3  # s
ARGUMENTS = ["--no-sandbox", "--enable-unsafe-swiftshader"]


def main() -> None:
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if browser is None:
        sys.exit("there is no Chromium on the PATH; install it")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as started:
        file = Path(folder) / "heavy_top_monte_carlo.html"
        lienumba.report(lienumba.run(ROOT / "scenarios" / "heavy_top_monte_carlo.toml"), file)
        opened = started.chromium.launch(executable_path=browser, args=ARGUMENTS)
        PICTURES.mkdir(exist_ok=True)
        for width, (wide, high) in WIDTHS.items():
            page = opened.new_page(viewport={"width": wide, "height": high}, is_mobile=wide < 640)
            page.goto(file.as_uri())
            _at(page, MOMENT)
            page.screenshot(path=PICTURES / f"report_{width}.png")
            page.close()
        opened.close()


def _at(page: Page, time: float) -> None:
    """The page as it is at a time of the run."""
    page.wait_for_selector("html[data-ready]")
    page.click("#play")
    move = "(t) => { const x = document.getElementById('time'); x.value = t; x.dispatchEvent(new Event('input')); }"
    page.evaluate(move, time)
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_timeout(2000)


if __name__ == "__main__":
    main()
