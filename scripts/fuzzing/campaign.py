"""Many cases in processes of their own, which may die, hang or swell: that is a failure, too."""

import multiprocessing
import pprint
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path

BYTES = 2 * 2**30  # of memory, beside what the process has at its start
HANGING = 120.0  # seconds on the clock of one case until its process is ended, on a machine that may be busy
CASES = 1500  # until a process is replaced


@dataclass
class Tally:
    """What came of the cases so far."""

    counts: Counter[str] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)
    slowest: tuple[float, str] = (0.0, "")
    memory: float = 0.0


@dataclass
class _Worker:
    process: multiprocessing.process.BaseProcess
    pipe: Connection
    number: int = -1
    since: float = 0.0
    done: int = 0


def _serve(pipe: Connection, seed: int) -> None:
    """Try the cases whose numbers come through the pipe."""
    import resource

    from fuzzing.cases import case, gallery
    from fuzzing.trial import peak_memory, tried

    gallery()
    held = (
        int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() if sys.platform == "linux" else 0
    )
    if held:
        resource.setrlimit(resource.RLIMIT_AS, (held + BYTES, held + BYTES))
    while (number := pipe.recv()) >= 0:
        outcome = tried(case(seed, number))
        pipe.send((outcome.what, outcome.seconds, outcome.failure, peak_memory()))


def campaign(
    seed: int, seconds: float, cases: int, processes: int, folder: Path, tell: Callable[[str], None], first: int = 0
) -> Tally:
    """Try cases for so long, or so many; each failing one goes to a file of this folder."""
    context = multiprocessing.get_context("spawn")
    tally, started, told = Tally(), time.monotonic(), time.monotonic()
    workers: list[_Worker] = []
    following = first

    def begin() -> _Worker:
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, seed), daemon=True)
        process.start()
        theirs.close()
        return _Worker(process, ours)

    def hand_out(worker: _Worker) -> bool:
        nonlocal following
        if time.monotonic() - started > seconds or following >= first + cases:
            return False
        worker.number, worker.since = following, time.monotonic()
        worker.pipe.send(following)
        following += 1
        return True

    def failed(number: int, what: str, said: str) -> None:
        tally.counts[what] += 1
        name = f"{seed}-{number}"
        tally.failures.append(name)
        _keep(folder, seed, number, said)
        tell(f"{what}: {name}: {said.strip().splitlines()[-1][:200]}")

    workers = [begin() for _ in range(processes)]
    busy = [worker for worker in workers if hand_out(worker)]
    while busy:
        ready = wait([worker.pipe for worker in busy], timeout=5.0)
        for worker in list(busy):
            if worker.pipe in ready:
                try:
                    what, took, failure, memory = worker.pipe.recv()
                except (EOFError, ConnectionResetError):
                    worker.process.join()
                    failed(worker.number, "killed", f"the process ended with {worker.process.exitcode}")
                    busy.remove(worker)
                    busy += [new] if hand_out(new := begin()) else []
                    continue
                tally.slowest = max(tally.slowest, (took, f"{seed}-{worker.number}"))
                tally.memory = max(tally.memory, memory)
                if failure:
                    failed(worker.number, what, failure)
                else:
                    tally.counts[what] += 1
                worker.done += 1
                if worker.done >= CASES:
                    worker.pipe.send(-1)
                    busy.remove(worker)
                    worker = begin()
                    busy.append(worker)
                if not hand_out(worker):
                    worker.pipe.send(-1)
                    busy.remove(worker)
            elif time.monotonic() - worker.since > HANGING:
                worker.process.kill()
                failed(worker.number, "hanging", f"no answer for {HANGING:g} s")
                busy.remove(worker)
                busy += [new] if hand_out(new := begin()) else []
        if time.monotonic() - told > 60.0:
            told = time.monotonic()
            tell(summary(tally, told - started))
    return tally


def summary(tally: Tally, seconds: float) -> str:
    """The counts in one line."""
    total = sum(tally.counts.values())
    counts = ", ".join(f"{number} {what}" for what, number in sorted(tally.counts.items()))
    return (
        f"{total} cases in {seconds / 60:.1f} min ({60 * total / max(seconds, 1e-9):.0f} a minute): {counts}; "
        f"slowest {tally.slowest[0]:.1f} s ({tally.slowest[1]}), memory {tally.memory / 2**20:.0f} MiB"
    )


def _keep(folder: Path, seed: int, number: int, said: str) -> None:
    """What failed, and how, as a text."""
    from fuzzing.cases import case

    folder.mkdir(parents=True, exist_ok=True)
    found = case(seed, number)
    scenario = found.scenario if isinstance(found.scenario, str) else pprint.pformat(found.scenario, sort_dicts=False)
    sys.setrecursionlimit(10_000)  # of pprint
    text = f"{said}\n\n{found.act}\n{found.overrides or found.settings!r}\n{found.files!r}\n\n{scenario}\n"
    (folder / f"{seed}-{number}.txt").write_bytes(text.encode("utf-8", "backslashreplace"))
