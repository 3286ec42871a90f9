"""A sweep in a process of its own that is killed, resumed, and compared with one that was not."""

import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

import numpy as np
import xarray as xr

Arguments = list[str]


@dataclass
class Report:
    """kills: how many; moments: runs that were safe at each; sweeps: that were finished and compared; different: names
    of variables that were not the same in one of them."""

    kills: int = 0
    moments: list[int] = field(default_factory=list)
    sweeps: int = 0
    different: list[str] = field(default_factory=list)


def command(scenario: Path, output: Path, options: Arguments) -> Arguments:
    return [sys.executable, "-m", "lienumba", "run", str(scenario), "-o", str(output), "--quiet", *options]


def safe_runs(output: Path) -> int:
    """How many runs are in the shards of a sweep, by the names of these."""
    folder = output.with_name(f"{output.name}.runs")
    spans = [path.stem.split("-") for path in folder.glob("run-*.npy")]
    return sum(int(last) - int(first) + 1 for _, first, last, _ in spans)


def same(one: Path, other: Path) -> list[str]:
    """The variables whose bits differ."""
    with xr.open_dataset(one, engine="netcdf4") as a, xr.open_dataset(other, engine="netcdf4") as b:
        missing = set(a.variables) ^ set(b.variables)
        common = set(a.variables) - missing
        return sorted([*map(str, missing), *(str(n) for n in common if not _equal(a[n].values, b[n].values))])


def _equal(a: np.ndarray, b: np.ndarray) -> bool:
    bits = a.tolist() == b.tolist() if a.dtype.hasobject else a.tobytes() == b.tobytes()
    return a.dtype == b.dtype and a.shape == b.shape and bits


def campaign(
    scenario: Path, folder: Path, options: Arguments, kills: int, seed: int,
    tell: Callable[[str], None] = lambda line: None,
) -> Report:  # fmt: skip
    """Kill, resume and compare until there have been so many kills; the moments follow from the seed."""
    moments, report = random.Random(seed), Report()
    whole = folder / "whole.nc"
    started = time.monotonic()
    subprocess.run([*command(scenario, whole, options), "--overwrite"], check=True)
    length = time.monotonic() - started
    tell(f"a sweep that nobody disturbs takes {length:.1f} s")
    target = folder / "killed.nc"
    while report.kills < kills or report.sweeps == 0:
        _clear(target)
        while not _finished(command(scenario, target, [*options, "--resume"]), moments.uniform(0.0, length)):
            report.kills += 1
            report.moments.append(safe_runs(target))
            tell(f"kill {report.kills}: {report.moments[-1]} runs were safe")
            if report.kills >= kills:  # now to its end
                subprocess.run(command(scenario, target, [*options, "--resume"]), check=True)
                break
        report.sweeps += 1
        report.different += same(whole, target)
        report.different += _left(folder, whole, target)
        tell(f"sweep {report.sweeps} is finished; different: {report.different or 'nothing'}")
    return report


def at_every_change(
    scenario: Path, folder: Path, options: Arguments, tell: Callable[[str], None] = lambda line: None
) -> Report:
    """Kill a sweep right before, and so behind, every change that it makes in its folder, and resume it each time."""
    report, whole, target = Report(), folder / "whole.nc", folder / "killed.nc"
    subprocess.run([*command(scenario, whole, options), "--overwrite"], check=True)
    for call in count():
        _clear(target)
        line = command(scenario, target, [*options, "--resume"])
        suicide = [sys.executable, "-m", "faults_campaign.suicide", str(call), str(folder), *line[3:]]
        if subprocess.run(suicide).returncode != -signal.SIGKILL:
            return report
        report.kills += 1
        report.moments.append(safe_runs(target))
        subprocess.run(line, check=True)
        report.sweeps += 1
        report.different += same(whole, target) + _left(folder, whole, target)
        tell(f"killed before change {call + 1}; different: {report.different or 'nothing'}")
    raise AssertionError


def _left(folder: Path, *files: Path) -> list[str]:
    """What nobody needs any more."""
    return [f"left over: {path.name}" for path in folder.iterdir() if path not in files]


def _clear(target: Path) -> None:
    target.unlink(missing_ok=True)
    shutil.rmtree(target.with_name(f"{target.name}.runs"), ignore_errors=True)
    for path in target.parent.glob(f"{target.name}.*"):
        path.unlink()


def _finished(line: Arguments, patience: float) -> bool:
    """Whether a process ends by itself in time; else it is killed."""
    process = subprocess.Popen(line)
    try:
        if process.wait(patience) != 0:
            raise RuntimeError(f"{' '.join(line)} ended with {process.returncode}")
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return False
    return True
