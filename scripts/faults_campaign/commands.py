"""Every command that takes a dataset, and how it may end."""

import contextlib
import random
import resource
import signal
import time
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from typer.testing import CliRunner

from lienumba.cli import app

SLOW, PATIENCE = 20.0, 120  # s of a core, and on the clock, that a command may take
SWOLLEN = 2 * 2**20  # KiB that it may add to the memory of the process
SOME = 2  # commands with each dataset, beside the first
PEOPLE = (0, 1, 2)  # exit codes that are meant
SENTENCES = ("error: ", "warning: ")


@dataclass(frozen=True)
class End:
    """code: what a command ended with; fault: what none may do; told: what it said."""

    code: int
    fault: str
    told: str


def commands(path: Path, sound: Path, scenarios: Path) -> list[list[str]]:
    """All that takes a dataset at this path; sound: one as it should be; scenarios: again.toml, of the same sweep, and
    started.toml and table.toml, which name the dataset."""
    own, other = str(path), str(sound)
    return [
        ["info", own], ["info", "--cite", own], ["analyse", own], ["analyse", own, "tip", "--verdict"],
        ["analyse", own, "-o", "a.csv"], ["plot", own, "-o", "b.png"], ["plot", own, "tip", "-o", "c.png"],
        ["plot", own, "--convergence", "-o", "d.png"], ["plot", own, "--sensitivity", "-o", "e.png"],
        ["plot", own, "--against", "bodies.bob.mass", "-o", "f.svg"],
        ["plot", own, "--requirement", "not too low", "-o", "g.png"],
        ["replay", own, "--run", "1", "-o", "h.nc"], ["replay", own, "--worst", "tip", "-o", "i.nc"],
        ["report", own, "-o", "j.html"], ["animate", own, "-o", "k.svg"],
        ["animate", own, "--mode", "1", "-o", "l.svg"], ["merge", own, other, "-o", "m.nc"],
        ["table", own, "-o", "n.csv"], ["table", own, "tip", "-o", "o.csv"],
        ["compare", own, other], ["compare", other, own, "tip"], ["list", str(path.parent)],
        ["modes", own, "--at", "0,end", "-o", "p.nc"], ["equilibrium", own, "-o", "q.nc"],
        ["run", str(scenarios / "started.toml"), "-o", "r.nc"], ["run", str(scenarios / "table.toml"), "-o", "s.nc"],
        ["rare", own], ["worst", own], ["sample", own], ["validate", own], ["import", own, "-o", "t.toml"],
        ["run", str(scenarios / "again.toml"), "-o", own, "--resume", "--set", "sweep.runs=5"],
    ]  # fmt: skip


def some(path: Path, sound: Path, scenarios: Path, pick: random.Random) -> Iterator[list[str]]:
    """The first, and some of the others; the last, which changes the dataset, behind them."""
    first, *others = commands(path, sound, scenarios)
    yield first
    yield from (others[n] for n in sorted(pick.sample(range(len(others)), SOME)))


def tried(arguments: list[str]) -> End:
    """What comes of a command, in this process."""
    before, held = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        with _in_time(), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = CliRunner().invoke(app, arguments)
    except Late as late:
        return End(-1, str(late), "")
    code, told = result.exit_code, result.output
    seconds = time.process_time() - before
    swollen = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - held
    fault = ""
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        fault = "".join(traceback.format_exception(result.exception)[-4:])
    elif code not in PEOPLE:
        fault = f"exit code {code}: {told[-300:]!r}"
    elif code and not any(line.startswith(SENTENCES) for line in result.stderr.splitlines()):
        fault = f"exit code {code} without a sentence: {told[-300:]!r}"
    elif {"\x1b", "\x07", "\x00", "\u202e"} & {*told}:
        fault = "what a terminal obeys"
    elif seconds > SLOW or swollen > SWOLLEN:
        fault = f"{seconds:.0f} s, {swollen / 2**10:.0f} MiB"
    return End(code, fault, told)


class Late(BaseException):
    """No command knows it, so none catches it."""


@contextlib.contextmanager
def _in_time() -> Iterator[None]:
    def late(*_: object) -> None:
        raise Late(f"took more than {PATIENCE} s")

    signal.signal(signal.SIGALRM, late)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)
