"""python -m fuzzing: see scripts/fuzz."""

import argparse
import random
import sys
import time
from pathlib import Path

from fuzzing.campaign import campaign, summary


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/fuzz", description="Attacks the scenario language.")
    parser.add_argument("--minutes", type=float, default=1e9, help="for how long")
    parser.add_argument("--cases", type=int, default=10**12, help="at most so many")
    parser.add_argument("--seed", type=int, default=None, help="of the cases (default: another one each time)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--failures", type=Path, default=Path("fuzz_failures"), help="the folder of what fails")
    parser.add_argument("--case", metavar="SEED-NUMBER", help="one case again, and what comes of it")
    given = parser.parse_args()
    if given.case:
        return _again(given.case)
    seed = random.SystemRandom().randrange(10**6) if given.seed is None else given.seed
    print(f"seed {seed}", flush=True)
    start = time.monotonic()
    tally = campaign(
        seed, 60 * given.minutes, given.cases, given.processes, given.failures, lambda x: print(x, flush=True)
    )
    print(summary(tally, time.monotonic() - start))
    print(f"{len(tally.failures)} failures" + (f", kept in {given.failures}" if tally.failures else ""))
    return 1 if tally.failures else 0


def _again(name: str) -> int:
    from fuzzing.cases import case
    from fuzzing.trial import tried

    outcome = tried(case(*map(int, name.split("-"))))
    print(f"{outcome.what} in {outcome.seconds:.2f} s\n{outcome.failure}")
    return 1 if outcome.failure else 0


if __name__ == "__main__":
    sys.exit(main())
