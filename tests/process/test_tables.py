"""No table of a report is cut, however wide the page: of changes, of many inputs with long names, of studies."""

from contextlib import closing
from typing import Any

import pytest

import lienumba
from tests.process.browser import CUT_OFF, browser
from tests.rigs.changing import CHANGING
from tests.rigs.pages import page_of
from tests.rigs.studies import SAMPLED, ball

SIZES = {390: 844, 768: 1024, 1280: 800}
SHAPES = "[...document.querySelectorAll('.scroll')].map((x) => x.dataset.shape || '')"
CUT = """() => {
  const right = (x) => x.getBoundingClientRect().right;
  const cells = (x) => [...x.querySelectorAll("td, th")];
  const out = (x) => cells(x).some((y) => right(y) > right(x) + 1 || y.scrollWidth > y.clientWidth + 1);
  const cut = [...document.querySelectorAll(".scroll")].filter((x) => x.scrollWidth > x.clientWidth || out(x));
  return cut.map((x) => x.innerText.slice(0, 80));
}"""
OPEN = "document.querySelectorAll('details').forEach((x) => { x.open = true; })"
DRIVE: dict[str, Any] = {"distribution": "normal", "std": 1e-3}
LONG = [f"bodies.{body}.inertia[{n}]" for body in ("door", "ball") for n in range(3)]
POINTS = {"integrator.method": ["midpoint", "rk4"], "integrator.step": [0.02, 0.01, 0.005]}


def changing() -> Any:
    vary = CHANGING["sweep"]["vary"] | dict.fromkeys(LONG, DRIVE)
    asked = {"output": {**CHANGING["output"], "summary": {"velocity": ["max"]}}}
    return lienumba.run({**CHANGING, **asked, "sweep": {"runs": 12, "vary": vary}})


def study() -> Any:
    return lienumba.run(ball(POINTS, sweep=SAMPLED))


@pytest.fixture(scope="module")
def opened():
    with browser() as found:
        yield found


@pytest.mark.filterwarnings("ignore:study.reference")
@pytest.mark.parametrize("made", [changing, study])
def test_no_table_is_cut_at_any_width(made, opened, tmp_path):
    file = tmp_path / "page.html"
    file.write_text(page_of(made()), encoding="utf-8")
    with closing(opened.new_context(viewport={"width": 1280, "height": 800})) as context:
        page = context.new_page()
        page.goto(file.as_uri())
        page.wait_for_selector("html[data-ready]")
        page.evaluate(OPEN)
        seen = []
        for width, height in SIZES.items():
            page.set_viewport_size({"width": width, "height": height})
            page.wait_for_timeout(300)
            assert page.evaluate(CUT) == [], width
            assert page.evaluate("document.scrollingElement.scrollWidth") <= width
            assert [x for x in page.evaluate(CUT_OFF) if not x.startswith("chart")] == [], width
            seen.append(page.evaluate(SHAPES))
    assert "cards" in seen[0]  # on the narrowest, and never on the widest
    assert "cards" not in seen[-1]
    assert "" not in seen[-1]
