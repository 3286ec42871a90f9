"""The campaign behind scripts/fuzz_changes."""

import argparse
import sys
import tempfile
from collections import Counter
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from tests.oracles.switching.comparing import Verdict, judge, same_bits, way_of
from tests.oracles.switching.drawing import changing

PROGRAMS = 20  # a process compiles, before another takes its place


def attempt(seed: int, bits: bool) -> tuple[int, Verdict]:
    """One seed."""
    data = changing(seed)
    verdict = judge(data, way_of(seed))
    if bits and verdict.what != "refused":
        with tempfile.TemporaryDirectory() as folder:
            verdict.problems += same_bits(data, way_of(seed), Path(folder))
    return seed, verdict


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/fuzz_changes", description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="how many mechanisms")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="the first seed")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--bits", action="store_true", help="compare runs in sweeps, alone, resumed and replayed, too")
    given = parser.parse_args()
    verdicts: dict[int, Verdict] = {}
    kinds: Counter[str] = Counter()
    with get_context("spawn").Pool(given.processes, maxtasksperchild=PROGRAMS) as pool:
        seeds = range(given.first, given.first + given.count)
        for seed, verdict in pool.imap(partial(attempt, bits=given.bits), seeds):
            verdicts[seed] = verdict
            kinds.update(verdict.changes)
            if verdict.problems:
                print(f"seed {seed} ({way_of(seed)}, {verdict.what}):", "; ".join(verdict.problems), flush=True)
    print(*Counter(v.what for v in verdicts.values()).most_common(), sep="\n")
    print("changes:", ", ".join(f"{n} {kind}" for kind, n in kinds.most_common()))
    for name in sorted({name for v in verdicts.values() for name in v.deviations}):
        most = max(verdicts, key=lambda seed: verdicts[seed].deviations.get(name, 0.0))
        print(f"  {verdicts[most].deviations[name]:.1e}  {name} (seed {most}, {way_of(most)})")
    return 1 if any(v.problems for v in verdicts.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
