"""The pages of documentation, and the blocks of code on them.

How blocks are written, so that tests can run what a reader would type. A page is played from its top to its end in
one folder with a copy of `scenarios/` and nothing else; all Python blocks of a page share their names. Files that
stand on the page are there from the beginning.

    ```python     runs, but for those in `player.COMPILED_ONLY`. If its first line is `# name.py`, it is also that file.
    ```toml       `# name.toml` as the first line: a scenario of that name, which has to be valid and without warnings.
                  With [model] and [integrator] in it: the same, without a name. Any other is a fragment, which has
                  to be valid when it `extends` a scenario: that in `<!-- into: FILE -->` above it, or else
                  scenarios/heavy_top.toml.
    ```csv        `# name.csv` as the first line: a file of that name.
    ```c          `// name.c` as the first line: likewise.
    ```sh         every line is a command. Those of lienumba run, and must end with 0, or 1 where a `text` block
                  follows; those in `player.NOT_RUN` are only parsed. A line of `cc` runs, too; without a compiler
                  the page ends there. Everything else must begin with a word in `player.ELSEWHERE`.
    ```console    `$ command` lines, run likewise, each with what it prints behind it.
    ```text       not run. Right behind a python or sh block it is what that block prints. In all shown output `...`
                  stands for anything, and blanks count as one.

What a reader need not see stands in a comment: `<!--`, the block, `-->`; it is run like any other. A block of any other
language, or of none, is a fault. Commands in the text (`lienumba plot out.nc`) are parsed, too: capitals may stand for
names and numbers.
"""

import re
from dataclasses import dataclass
from pathlib import Path

from tests.rigs.places import ROOT

LANGUAGES = ("python", "toml", "csv", "c", "sh", "console", "text")
FENCE = re.compile(
    r"^(?P<indent> *)```(?P<language>[^\n`]*)\n(?P<text>.*?)^(?P=indent)``` *$", re.DOTALL | re.MULTILINE
)
NAME = re.compile(r"(?:#|//) ([\w.]+\.\w+)\n")
INTO = re.compile(r"<!-- into: (\S+) -->\s*\Z")
BASE = "scenarios/heavy_top.toml"


@dataclass(frozen=True)
class Block:
    """name: of the file that it is, or ""; into: the scenario that a fragment extends; output: what follows it."""

    line: int
    language: str
    text: str
    name: str
    into: str
    output: str | None = None


def pages() -> list[Path]:
    """All pages of the repository."""
    return sorted(path for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("scenarios/**/*.md")))


def blocks(text: str) -> list[Block]:
    """The blocks of a page in order."""
    fences = list(FENCE.finditer(text))
    found = []
    for n, fence in enumerate(fences):
        before = text[: fence.start()]
        name = NAME.match(fence["text"])
        into = INTO.search(before)
        found.append(
            Block(
                line=before.count("\n") + 1,
                language=fence["language"].strip(),
                text="".join(line.removeprefix(fence["indent"]) for line in fence["text"].splitlines(keepends=True)),
                name=name[1] if name else "",
                into=into[1] if into else BASE,
                output=_output(text, fence, fences[n + 1] if n + 1 < len(fences) else None),
            )
        )
    return found


def _output(text: str, fence: re.Match[str], following: re.Match[str] | None) -> str | None:
    """The block behind this one, if it is what this one prints."""
    if following is None or following["language"].strip() != "text":
        return None
    between = text[fence.end() : following.start()]
    return following["text"] if between.replace("-->", "").strip() == "" else None


def prose(text: str) -> str:
    """The page without blocks of code and comments."""
    return re.sub(r"<!--.*?-->", "", FENCE.sub("", text), flags=re.DOTALL)
