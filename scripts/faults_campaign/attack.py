"""Every command meets changed datasets, files of others, changed shards and parts: each ends with success or a
sentence, and goes on only with what is right."""

import contextlib
import multiprocessing
import random
import resource
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from pathlib import Path

from faults_campaign import subjects
from faults_campaign.commands import PATIENCE, some, tried
from faults_campaign.datasets import changed
from faults_campaign.folders import WHOLE, changed_parts, changed_shards
from faults_campaign.foreign import FOREIGN
from faults_campaign.kills import same
from lienumba.store import opening

MOST = 8 * 2**30  # bytes of addresses that a process may take: what asks for more is told so, not killed
LOST = 3.0  # s that HDF5 gets for a file, of which there are many
NOW = "now.txt"  # what a process of the campaign is doing, should it die


@dataclass
class Outcome:
    """files: how many; codes: how many commands ended so; faults: what none may do."""

    files: int = 0
    codes: Counter[int] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)

    def add(self, other: "Outcome") -> None:
        self.files += other.files
        self.codes += other.codes
        self.faults += other.faults


def attack(folder: Path, seed: int, count: int, first: int = 0, sources: dict[str, Path] | None = None) -> Outcome:
    """The changed datasets from one number to another, or to the first that HDF5 does not come back from, and some
    commands with each; sources: sound ones, if they are there already."""
    sources, found = sources or subjects.prepared(folder), Outcome()
    for n in range(first, count):
        pick = random.Random(seed * 1_000_003 + n)
        name = pick.choice([*sources])
        path = folder / f"tried{n}" / f"changed{n}.nc"  # HDF5 may still hold another open, which it could not read
        path.parent.mkdir()
        foreign = pick.choice([*FOREIGN]) if pick.random() < 0.1 else ""
        with contextlib.chdir(path.parent):
            if foreign:
                FOREIGN[foreign](sources[name], path)
            what = foreign or changed(sources[name], path, pick)
            _tell(path.parent, name, path)
            found.add(_commands(path, sources[name], f"seed {seed}, file {n} ({name}: {what})", pick))
        shutil.rmtree(path.parent)
        if opening.busy():
            break
    return found


def attack_folders(folder: Path, seed: int, count: int, first: int = 0) -> Outcome:
    """So many changed folders of shards, and parts that do not belong together."""
    whole, begun = subjects.interrupted(folder)
    parts, found = subjects.parts(folder), Outcome()
    sound = begun.with_name(f"{begun.name}.runs")
    (folder / "long.toml").write_text(_toml({**subjects.TOP, **subjects.LONG}))
    for n in range(first, count):
        pick = random.Random(seed * 1_000_003 + n)
        own = folder / f"tried{n}"
        own.mkdir()
        output = own / "out.nc"
        with contextlib.chdir(own):
            what = changed_shards(sound, own / "out.nc.runs", pick)
            flag = pick.choice([["--resume"], ["--resume"], ["--overwrite"], []])
            end = tried(["run", str(folder / "long.toml"), "-o", str(output), "-j", "1", *flag])
            fault = end.fault
            if not fault and output.exists() and (different := same(whole, output)):
                fault = f"other bits: {different}"
            book(found, end.code, fault, f"seed {seed}, folder {n} ({what}), {flag}")
            for told, given in changed_parts(parts, own, pick) if n % 10 == 0 else ():
                end = tried(["merge", *map(str, given), "-o", "m.nc", "--overwrite"])
                fault = end.fault
                complete = told in WHOLE and not fault and end.code == 0
                if complete and (different := same(whole, own / "m.nc")):
                    fault = f"other bits: {different}"
                book(found, end.code, fault, f"seed {seed}, parts {n} ({told})")
        shutil.rmtree(own)
    return found


def _commands(path: Path, sound: Path, what: str, pick: random.Random) -> Outcome:
    found = Outcome()
    for arguments in some(path, sound, path.parent, pick):
        Path(NOW).write_text(f"{what}, {' '.join(arguments)}")
        end = tried(arguments)
        book(found, end.code, end.fault, f"{what}, {' '.join(arguments)}")
    found.files = 1
    return found


def book(found: Outcome, code: int, fault: str, what: str) -> None:
    found.codes[code] += 1
    if fault:
        found.faults.append(f"{what}:\n{fault}")


def _tell(folder: Path, name: str, path: Path) -> None:
    """Scenarios that have to do with a dataset."""
    again = subjects.scenario(name)
    (folder / "again.toml").write_text(_toml(again))
    (folder / "started.toml").write_text(_toml({**subjects.TOP, "start": {"file": str(path)}}))
    table = {"sampler": "table", "table": {"file": str(path)}}
    (folder / "table.toml").write_text(_toml({**subjects.TOP, "sweep": table}))


def _toml(data: dict[str, object]) -> str:
    from lienumba.scenario.base import toml

    return toml.dumps(data)


def _limited(work: Callable[[Path, int, int, int], Outcome], folder: Path, *numbers: int) -> Outcome:
    resource.setrlimit(resource.RLIMIT_AS, (MOST, MOST))
    opening.PATIENCE = LOST
    return work(folder, *numbers)


def campaign(folder: Path, seed: int, portions: int, size: int, tell: Callable[[str], None]) -> Outcome:
    """Portions in processes of their own: one that dies is a fault, too; a tenth as many changed folders of shards."""
    whole = Outcome()
    waiting = [(work, seed + n, count, 0) for n, (work, count) in enumerate(_portions(portions, size))]
    while waiting:
        work, *numbers = waiting.pop(0)
        own = folder / "-".join(map(str, numbers))
        own.mkdir()
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
            job = pool.submit(_limited, work, own, *numbers)
            try:
                found = job.result(timeout=PATIENCE + 20 * size)
            except (BrokenProcessPool, TimeoutError) as error:
                for process in multiprocessing.active_children():
                    process.kill()
                doing = [path.read_text() for path in own.glob(f"*/{NOW}")]
                what = "hangs" if isinstance(error, TimeoutError) else "died"
                found = Outcome(faults=[f"seed, count, first {numbers}: the process {what}: {doing}"])
        shutil.rmtree(own, ignore_errors=True)
        whole.add(found)
        first = numbers[2] + found.files
        if found.files and first < numbers[1]:  # HDF5 has not come back
            waiting.insert(0, (work, *numbers[:2], first))
        tell(f"{whole.files} files, exit codes {dict(whole.codes)}, {len(whole.faults)} faults")
        for fault in found.faults:
            tell(fault)
    return whole


def _portions(portions: int, size: int) -> Iterator[tuple[Callable[[Path, int, int, int], Outcome], int]]:
    for _ in range(portions):
        yield attack, size
    if portions:
        yield attack_folders, portions * size // 10
