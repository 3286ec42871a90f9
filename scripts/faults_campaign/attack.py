"""Every command meets changed datasets: each ends with success or a sentence."""

import contextlib
import multiprocessing
import os
import random
import signal
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from faults_campaign.datasets import changed

PATIENCE = 60  # s that a command may take
PEOPLE = (0, 1, 2)  # exit codes that are meant
TOP = {
    "title": "pendulum", "model": {
        "bodies": [{"name": "bob", "mass": 1.0, "inertia": [0.1, 0.1, 0.1], "position": [1, 0, 0]}],
        "joints": [{"name": "pivot", "type": "revolute", "bodies": ["ground", "bob"], "at": [0, 0, 0],
                    "axis": [0, 1, 0]}],
    },
    "quantities": [{"name": "tip", "type": "point", "body": "bob", "point": [1, 0, 0]}],
    "events": [{"name": "low", "when": "tip.z < -0.02"}],
    "integrator": {"method": "rk4", "step": 0.02, "end_time": 0.2},
}  # fmt: skip
SWEEP = {"runs": 4, "vary": {"bodies.bob.mass": {"distribution": "normal", "mean": 1.0, "std": 0.1}}}
KINDS: dict[str, dict[str, Any]] = {
    "full": {"sweep": SWEEP, "output": {"every": 0.02, "joint_coordinates": True}},
    "summary": {"sweep": SWEEP, "output": {
        "every": 0.02, "mode": "summary", "full_runs": "1:3", "summary": {"tip": ["max", "rms"]}}},
    "study": {"sweep": {"runs": 2, "vary": SWEEP["vary"]}, "study": {
        "reference": {"step": 0.002}, "grid": [{"integrator.step": [0.02, 0.01]}]}},
}  # fmt: skip


@dataclass
class Outcome:
    """files: how many; codes: how many commands ended so; faults: what none may do."""

    files: int = 0
    codes: Counter[int] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


def prepared(folder: Path) -> dict[str, Path]:
    """Datasets as they should be."""
    import lienumba

    for name, more in KINDS.items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            lienumba.run({**TOP, **more}, output=folder / f"{name}.nc", workers=1).close()
    return {name: folder / f"{name}.nc" for name in KINDS}


def commands(path: Path, sound: Path, folder: Path, pick: random.Random) -> Iterator[list[str]]:
    """What is tried with a changed dataset; sound: as it was."""
    yield ["info", str(path)]
    every = [
        ["info", "--cite", str(path)], ["analyse", str(path)], ["plot", str(path), "-o", str(folder / "x.png")],
        ["plot", str(path), "tip", "-o", str(folder / "x.png")], ["replay", str(path), "--run", "1", "-o", "x.nc"],
        ["replay", str(path), "--worst", "tip", "-o", str(folder / "y.nc")], ["report", str(path)],
        ["animate", str(path), "-o", str(folder / "x.svg")], ["merge", str(path), "-o", str(folder / "z.nc")],
        ["run", str(folder / "again.toml"), "-o", str(path), "--resume", "--set", "sweep.runs=5"],
        ["run", str(folder / "started.toml"), "-o", str(folder / "s.nc")],
    ]  # fmt: skip
    yield from pick.sample(every, 3)


def attack(folder: Path, seed: int, count: int) -> Outcome:
    """So many changed datasets, and some commands with each."""
    from typer.testing import CliRunner

    from lienumba.cli import app
    from lienumba.scenario.base import toml

    found, runner, sources = Outcome(), CliRunner(), prepared(folder)
    os.chdir(folder)
    for n in range(count):
        path = folder / f"changed{n}.nc"  # HDF5 may still hold another open, which it could not read
        (folder / "started.toml").write_text(toml.dumps({**TOP, "start": {"file": str(path)}}))
        pick = random.Random(seed * 1_000_003 + n)
        name = pick.choice([*sources])
        (folder / "again.toml").write_text(toml.dumps({**TOP, **KINDS[name]}))
        what = changed(sources[name], path, pick)
        found.files += 1
        for arguments in commands(path, sources[name], folder, pick):
            for old in [*folder.glob("[xyzs].*"), *folder.glob("changed*.html")]:
                old.unlink()
            with _in_time(), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                result = runner.invoke(app, arguments)
            found.codes[result.exit_code] += 1
            meant = result.exception is None or isinstance(result.exception, SystemExit)
            if not meant or result.exit_code not in PEOPLE or "\x1b" in result.output:
                trace = "".join(traceback.format_exception(result.exception)[-3:]) if result.exception else "escape"
                found.faults.append(f"seed {seed}, file {n} ({name}: {what}), {' '.join(arguments)}:\n{trace}")
        path.unlink(missing_ok=True)
    return found


@contextlib.contextmanager
def _in_time() -> Iterator[None]:
    def late(*_: object) -> None:
        raise TimeoutError(f"took more than {PATIENCE} s")

    signal.signal(signal.SIGALRM, late)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)


def campaign(folder: Path, seed: int, portions: int, size: int, tell: Callable[[str], None]) -> Outcome:
    """Portions in processes of their own: one that dies is a fault, too."""
    whole = Outcome()
    for n in range(portions):
        own = folder / f"portion{n}"
        own.mkdir()
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            job = pool.apply_async(attack, (own, seed + n, size))
            try:
                found = job.get(timeout=PATIENCE + 10 * size)
            except multiprocessing.TimeoutError:
                found = Outcome(faults=[f"seed {seed + n}: the process died, or hangs"])
        whole.files += found.files
        whole.codes += found.codes
        whole.faults += found.faults
        tell(f"{whole.files} files, exit codes {dict(whole.codes)}, {len(whole.faults)} faults")
        for fault in found.faults:
            tell(fault)
    return whole
