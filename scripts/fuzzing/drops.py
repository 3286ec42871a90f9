"""The campaign behind scripts/fuzz_drops."""

import argparse
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from tests.oracles.dropping.drawing import drop
from tests.oracles.dropping.judging import Verdict, judge

LONGEST = 20.0  # s of a core, compiling apart
PROGRAMS = 20  # a process compiles, before another takes its place


def attempt(seed: int) -> tuple[int, str, Verdict]:
    """One seed."""
    thrown = drop(seed)
    return seed, thrown.title, judge(thrown, again=True)


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/fuzz_drops", description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="how many are thrown")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="the first seed")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    verdicts, failed = {}, 0
    with ProcessPoolExecutor(given.processes, get_context("spawn"), max_tasks_per_child=PROGRAMS) as pool:
        for seed, title, verdict in pool.map(attempt, range(given.first, given.first + given.count)):
            verdicts[seed] = verdict
            problems = verdict.problems()
            if not verdict.seconds < LONGEST:
                problems.append(f"{verdict.seconds:.0f} s")
            if problems or verdict.status != "success":
                print(f"seed {seed} ({title}): {verdict.status}", *problems, sep=", ", flush=True)
            failed += bool(problems)
    print(*Counter(v.status for v in verdicts.values()).most_common(), sep="\n")
    for name in ("steps", "changes", "residual", "rise", "sunk", "seconds"):
        most = max(verdicts, key=lambda seed: getattr(verdicts[seed], name))
        print(f"{name}: at most {getattr(verdicts[most], name):.2g} (seed {most})")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
