"""Every link to a file, to a heading, and every picture of every page is there."""

import pkgutil
import re
from pathlib import Path
from urllib.parse import unquote

import pytest

from tests.documents.pages import FENCE, ROOT, pages, prose

PAGES = [pytest.param(path, id=str(path.relative_to(ROOT))) for path in pages()]
LINK = re.compile(r"\]\(<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)")
SOURCE = re.compile(r"(?:src|srcset|href)=\"([^\"]+)\"")
SPAN = re.compile(r"`[^`\n]*`")


def links(text: str) -> list[str]:
    """All targets that are no addresses of the network."""
    text = SPAN.sub("", FENCE.sub("", text))
    return [link for link in LINK.findall(text) + SOURCE.findall(text) if not re.match(r"[a-z]+:", link)]


def anchors(text: str) -> set[str]:
    """The headings of a page as GitHub names them."""
    found: list[str] = []
    for heading in re.findall(r"^#{1,6} +(.*?)\s*$", FENCE.sub("", text), re.MULTILINE):
        shown = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        slug = re.sub(r"[^\w\- ]", "", shown.lower()).replace(" ", "-")
        again = sum(re.fullmatch(rf"{re.escape(slug)}(-\d+)?", other) is not None for other in found)
        found.append(f"{slug}-{again}" if again else slug)
    return set(found)


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: Path) -> None:
    for link in links(page.read_text(encoding="utf-8")):
        file, _, anchor = unquote(link).partition("#")
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), f"{link}: there is no {file}"
        assert target.is_relative_to(ROOT), f"{link}: leads out of the repository"
        if anchor:
            assert anchor in anchors(target.read_text(encoding="utf-8")), f"{link}: no heading #{anchor}"


@pytest.mark.parametrize("page", PAGES)
def test_names_and_files_in_the_text_exist(page: Path) -> None:
    """`lienumba.groups.so3.exp` can be imported, `scenarios/heavy_top.toml` is there."""
    for span in re.findall(r"`([^`\n]+)`", prose(page.read_text(encoding="utf-8"))):
        if re.fullmatch(r"lienumba(\.\w+)+", span):
            pkgutil.resolve_name(span)
        elif re.fullmatch(r"(lienumba|scenarios|scripts|tests|docs)(/[\w.]+)+/?", span):
            assert (ROOT / span).exists(), f"there is no {span}"


def test_links_and_headings_are_read() -> None:
    text = '[a](b.md#c) ![p](p.png) `[no](no.md)` [n](https://x.y) <img src="q.svg">\n```text\n[x](y)\n```\n'
    assert links(text) == ["b.md#c", "p.png", "q.svg"]
    assert anchors("# One `two`, three\n## A\n## A\n") == {"one-two-three", "a", "a-1"}
