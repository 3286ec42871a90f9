"""The campaign behind scripts/fuzz_drops."""

import argparse
import signal
import sys
from collections import Counter
from multiprocessing import get_context

from tests.oracles.dropping.drawing import drop
from tests.oracles.dropping.judging import Verdict, judge

LONGEST = 20.0  # s of a core, compiling apart
PATIENCE = 90.0  # s of a core for all of one seed, which ends there
PROGRAMS = 20  # a process compiles, before another takes its place


def attempt(seed: int) -> tuple[int, str, Verdict | None]:
    """One seed; None where it takes too long."""
    thrown = drop(seed)
    signal.signal(signal.SIGPROF, _stop)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        return seed, thrown.title, judge(thrown, again=True)
    except TimeoutError:
        return seed, thrown.title, None
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def _stop(number: int, frame: object) -> None:
    raise TimeoutError


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/fuzz_drops", description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="how many are thrown")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="the first seed")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    verdicts, failed = {}, 0
    with get_context("spawn").Pool(given.processes, maxtasksperchild=PROGRAMS) as pool:
        for seed, title, verdict in pool.imap(attempt, range(given.first, given.first + given.count)):
            if verdict is None:
                print(f"seed {seed} ({title}): not ended within {PATIENCE:.0f} s of a core", flush=True)
                failed += 1
                continue
            verdicts[seed] = verdict
            problems = verdict.problems()
            if not verdict.seconds < LONGEST:
                problems.append(f"{verdict.seconds:.0f} s")
            if problems or verdict.status != "success":
                print(f"seed {seed} ({title}): {verdict.status}", *problems, sep=", ", flush=True)
            failed += bool(problems)
    print(*Counter(v.status for v in verdicts.values()).most_common(), sep="\n")
    for name in ("steps", "changes", "residual", "rise", "sunk", "seconds") if verdicts else ():
        most = max(verdicts, key=lambda seed: getattr(verdicts[seed], name))
        print(f"{name}: at most {getattr(verdicts[most], name):.2g} (seed {most})")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
