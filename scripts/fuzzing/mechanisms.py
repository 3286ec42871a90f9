"""The campaign behind scripts/fuzz_mechanisms."""

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from multiprocessing import get_context

import lienumba
from tests.oracles.mechanisms.comparing import BOUND, RESIDUAL, Comparison, compare
from tests.oracles.mechanisms.drawing import mechanism
from tests.oracles.mechanisms.engine import SingularError

PROGRAMS = 20  # a process compiles, before another takes its place
Outcome = tuple[int, str, Comparison | None]  # seed; "compared", or why not; how far apart


@dataclass
class Summary:
    """Of all seeds so far: how many are compared, why others are not, the largest deviation of each kind with its seed,
    the largest residual, and seeds that fail."""

    compared: int = 0
    others: Counter[str] = field(default_factory=Counter)
    largest: dict[str, tuple[float, int]] = field(default_factory=dict)
    residual: tuple[float, int] = (0.0, -1)
    failed: list[str] = field(default_factory=list)

    def add(self, outcome: Outcome) -> None:
        seed, what, found = outcome
        if found is None:
            self.others[what] += 1
            return
        self.compared += 1
        for name, x in found.deviations.items():
            self.largest[name] = max(self.largest.get(name, (0.0, seed)), (x, seed))
        self.residual = max(self.residual, (found.residual, seed))
        if found.status or not found.worst < BOUND or not found.residual < RESIDUAL:
            self.failed.append(f"seed {seed}: status {found.status}, {found.worst:.1e}, residual {found.residual:.1f}")

    def lines(self) -> Iterator[str]:
        yield f"{self.compared} mechanisms compared"
        yield from (f"{n} not: {why}" for why, n in self.others.most_common())
        for name, (x, seed) in sorted(self.largest.items(), key=lambda item: -item[1][0]):
            yield f"  {x:.1e}  {name} (seed {seed})"
        yield f"energy: {self.residual[0]:.1f} tolerances (seed {self.residual[1]})"
        yield from self.failed


def attempt(seed: int) -> Outcome:
    """One seed."""
    try:
        return seed, "compared", compare(mechanism(seed))
    except SingularError:
        return seed, "comes near a singular position", None
    except lienumba.ScenarioError as error:
        return seed, f"refused: {error.problems[0].rule} (seed {seed})", None


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/fuzz_mechanisms", description=__doc__)
    parser.add_argument("--count", type=int, default=300, help="mechanisms to be compared")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="the first seed")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    summary, first = Summary(), given.first
    with get_context("spawn").Pool(given.processes, maxtasksperchild=PROGRAMS) as pool:
        while summary.compared < given.count:
            seeds = range(first, first + given.count - summary.compared)
            first = seeds.stop
            for outcome in pool.imap(attempt, seeds):
                before = len(summary.failed)
                summary.add(outcome)
                if summary.failed[before:]:
                    print(summary.failed[-1], flush=True)
    print(*summary.lines(), sep="\n")
    return 1 if summary.failed else 0


if __name__ == "__main__":
    sys.exit(main())
