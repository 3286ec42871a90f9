"""Every block of code of every page works, and shows what it prints."""

import re
import shlex
import shutil
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from lienumba.cli.commands import LineError
from lienumba.figures import playing
from lienumba.figures.playing import Film
from tests.documents import player
from tests.documents.pages import ROOT, Block, blocks, pages, prose
from tests.rigs.places import SCENARIOS

PAGES = [pytest.param(path, id=str(path.relative_to(ROOT))) for path in pages()]
FIRST_PAGES = ("README.md", "docs/first_sweep.md", "docs/write_a_scenario.md", "docs/architecture.md")
FIRST = [page for page in PAGES if page.id in FIRST_PAGES]


def shortest(*asked: Any) -> Film:
    """The first two frames of a film: what is in them is tested elsewhere."""
    film = playing.film(*asked)
    return replace(film, times=film.times[:2])


def blank(self: Any, picture: Any, **how: Any) -> None:
    """A file for a figure, which takes longest to draw: pictures are tested elsewhere."""
    picture.write(b"") if hasattr(picture, "write") else Path(picture).touch()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(SCENARIOS, tmp_path / "scenarios")
    for name, value in player.ENVIRONMENT.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(import_module("lienumba.figures.animate"), "film", shortest)
    monkeypatch.setattr(import_module("matplotlib.figure").Figure, "savefig", blank)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("vectors")  # which pages show
@pytest.mark.parametrize("page", FIRST)
def test_blocks_of_the_first_pages_run(page: Path, folder: Path) -> None:
    play(page, folder)


@pytest.mark.release
@pytest.mark.usefixtures("vectors")
@pytest.mark.parametrize("page", [page for page in PAGES if page.id not in FIRST_PAGES])
def test_blocks_run(page: Path, folder: Path) -> None:
    play(page, folder)


def play(page: Path, folder: Path) -> None:
    line = 0
    try:
        for block in player.Player(folder).play_all(blocks(page.read_text(encoding="utf-8"))):
            line = block.line
    except (Exception, SystemExit) as error:
        pytest.fail(f"{page.relative_to(ROOT)}:{line}: {type(error).__name__}: {error}")


@pytest.mark.parametrize("page", PAGES)
def test_commands_in_the_text_are_commands(page: Path) -> None:
    for span in re.findall(r"`(lienumba [^`]+)`", prose(page.read_text(encoding="utf-8"))):
        words = [re.sub(r"\b[A-Z]{1,2}\b", "1", word) for word in shlex.split(span, comments=True)[1:]]
        try:
            if words and words[0].isupper():
                continue  # any command
            if len(words) > 1:
                player.parse(words)
            elif words and not words[0].startswith("-"):
                assert words[0] in player.COMMANDS.commands
        except (LineError, AssertionError) as error:
            pytest.fail(f"{page.relative_to(ROOT)}: `{span}`: {error}")


def test_blocks_are_found_with_their_names_bases_and_outputs() -> None:
    text = "<!-- into: a.toml -->\n```toml\nx = 1\n```\n<!--\n```python\n# b.py\nprint(1)\n```\n-->\n```text\n1\n```\n"
    first, second, third = blocks(text)
    assert first == Block(2, "toml", "x = 1\n", "", "a.toml")
    assert (second.name, second.output) == ("b.py", "1\n")
    assert (third.language, third.into) == ("text", "scenarios/heavy_top.toml")
    assert "x = 1" not in prose(text)
    assert "b.py" not in prose(text)


@pytest.mark.parametrize(
    ("language", "text", "told"),
    [
        ("", "a", "a block of"),
        ("rust", "a", "a block of"),
        ("csv", "a,b", "a table without"),
        ("toml", "[integrator]\nstep = 3", "step"),
        ("toml", "[projection]\nfoo = 3", "foo"),
        ("python", "x = 1/0", "division"),
        ("sh", "lienumba run --speed", "--speed"),
        ("sh", "lienumba fly", "no command fly"),
        ("sh", "lienumba validate none.toml", "none.toml"),
        ("sh", "if", "bash"),
        ("sh", "curl x", "nobody runs curl"),
        ("sh", "scripts/none", "there is no scripts/none"),
        ("console", "$ lienumba --version\nlienumba 99", "printed"),
    ],
)
def test_faults_are_found(folder: Path, language: str, text: str, told: str) -> None:
    with pytest.raises((Exception, SystemExit), match=re.escape(told)):
        player.Player(folder).play(Block(1, language, text, "", "scenarios/heavy_top.toml"))


def test_output_that_differs_is_a_fault(folder: Path) -> None:
    shown = Block(1, "python", "print('a  b', 7)", "", "", output="a b ...\n")
    player.Player(folder).play(shown)
    with pytest.raises(AssertionError, match="shown"):
        player.Player(folder).play(Block(1, "python", "print(2)", "", "", output="3"))
