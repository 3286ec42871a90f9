"""Does what a page says, in a folder of its own."""

import contextlib
import io
import linecache
import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from glob import glob
from pathlib import Path
from typing import Any

import click
import pytest
import typer.main
from typer.testing import CliRunner

from lienumba.scenario.start.study_start import check_starts
from tests.documents.pages import LANGUAGES, ROOT, Block
from tests.facade import app, resolve

# Beginnings of commands of lienumba that a test cannot run: they are parsed.
NOT_RUN = ("lienumba run my.toml --dask ",)
# What other programs do; the scripts of the repository must exist.
ELSEWHERE = ("git", "cd", "pip", "dask", "sbatch", "qsub")
OURS = ("scripts/", ".venv/bin/python scripts/")
# First lines of Python blocks that need what is not here.
COMPILED_ONLY = ("from dask_jobqueue import SLURMCluster",)
# What the queue of a cluster tells its jobs.
ENVIRONMENT = {"SLURM_ARRAY_TASK_ID": "1", "SLURM_ARRAY_TASK_COUNT": "2", "COLUMNS": "140"}
COMMANDS: Any = typer.main.get_command(app)


class Player:
    """The current folder is that of the page."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.namespace: dict[str, Any] = {"__name__": "__main__"}
        self.printed = ""

    def play_all(self, blocks: Sequence[Block]) -> Iterator[Block]:
        """Run a page block by block; each is handed out before it runs. All its files are there from the beginning."""
        for block in blocks:
            if block.name:
                (self.folder / block.name).write_text(block.text.partition("\n")[2], encoding="utf-8")
        for block in blocks:
            yield block
            self.play(block)

    def play(self, block: Block) -> None:
        """Run one block; what it prints must be what is shown behind it."""
        assert block.language in LANGUAGES, f'a block of "{block.language}": give one of {", ".join(LANGUAGES)}'
        self.printed = ""
        getattr(self, block.language)(block)
        if block.output is not None:
            compare(block.output, self.printed)

    def text(self, block: Block) -> None:
        pass

    def csv(self, block: Block) -> None:
        assert block.name, "a table without `# name.csv` in its first line"

    def c(self, block: Block) -> None:
        assert block.name, "a program without `// name.c` in its first line"

    def toml(self, block: Block) -> None:
        whole = bool(block.name) or ("[model]" in block.text and "[integrator]" in block.text)
        path = self.folder / (block.name or f"block_{block.line}.toml")
        if not block.name:
            path.write_text(("" if whole else f'extends = "{block.into}"\n') + block.text, encoding="utf-8")
        scenario = resolve(path)
        assert not scenario.warnings, "\n".join(map(str, scenario.warnings))
        check_starts(scenario)

    def python(self, block: Block) -> None:
        file = str(self.folder / (block.name or f"block_{block.line}.py"))
        code = compile(block.text, file, "exec")
        if block.text.startswith(COMPILED_ONLY):
            return
        linecache.cache[file] = (len(block.text), None, block.text.splitlines(keepends=True), file)
        with contextlib.redirect_stdout(io.StringIO()) as heard:
            exec(code, self.namespace)
        self.printed = heard.getvalue()

    def sh(self, block: Block) -> None:
        subprocess.run(["bash", "-n"], input=block.text, text=True, check=True)
        for line in commands(block.text):
            self.printed += self.command(line, failing=block.output is not None)

    def console(self, block: Block) -> None:
        for said in re.split(r"^\$ ", block.text, flags=re.MULTILINE)[1:]:
            line, _, wanted = said.partition("\n")
            compare(wanted, self.command(line, failing=True))

    def command(self, line: str, failing: bool) -> str:
        """What a command prints; failing: whether it may end with the code that says that runs failed."""
        if line.startswith(OURS):
            script = next(word for word in line.split() if word.startswith("scripts/"))
            assert (ROOT / script).is_file(), f"{line}: there is no {script}"
            return ""
        words = shlex.split(os.path.expandvars(line), comments=True)
        if not words or words[0] in ELSEWHERE:
            return ""
        if words[0] == "cc":
            if shutil.which("cc") is None:
                pytest.skip("there is no C compiler")
            subprocess.run(words, cwd=self.folder, check=True)
            return ""
        assert words[0] == "lienumba", f"{line}: nobody runs {words[0]}"
        parse(words[1:])
        if line.startswith(NOT_RUN):
            return ""
        arguments = [found for word in words[1:] for found in ([word] if word.startswith("-") else matches(word))]
        result = CliRunner().invoke(app, arguments)
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        assert result.exit_code in ((0, 1) if failing else (0,)), f"{line}: {result.exit_code}\n{result.output}"
        return result.stdout


def commands(text: str) -> list[str]:
    """The lines of a script, continued ones joined."""
    return [line for line in text.replace("\\\n", " ").splitlines() if line.strip()]


def matches(word: str) -> Sequence[str]:
    """The files that a pattern stands for, as a shell finds them."""
    return sorted(glob(word)) or [word]


def parse(words: Sequence[str]) -> None:
    """The real command line takes these words, or a fault."""
    try:
        if words and not words[0].startswith("-"):
            command = COMMANDS.get_command(click.Context(COMMANDS), words[0])
            assert command is not None, f"lienumba has no command {words[0]}"
            command.make_context(words[0], list(words[1:]), resilient_parsing=False)
    except (click.exceptions.Exit, click.exceptions.NoArgsIsHelpError):
        pass


def compare(wanted: str, printed: str) -> None:
    """`...` is anything, blanks are one."""
    pieces = [re.escape(" ".join(piece.split())) for piece in wanted.split("...")]
    pattern = r"\s?.*?\s?".join(pieces)
    assert re.fullmatch(pattern, " ".join(printed.split()), re.DOTALL), f"shown:\n{wanted}\nprinted:\n{printed}"
