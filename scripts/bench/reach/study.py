"""The cheapest setting of each contestant that reaches an error, and what it costs, timed among everything else."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bench.cases import Case
from bench.checks import Check
from bench.clock import Spent, Stopwatch
from bench.reach import chain, satellite, top
from bench.reach.contestants import Contestant, FailedError, Heyoka, engines, reference, rivals
from bench.reach.problems import Array, Problem

CACHE = "LIENUMBA_CACHE_DIR"
TARGETS = (1e-6, 1e-9, 1e-12, 1e-13)  # m, worst body of the worst run, at the end
SAME = 1e-11  # m: nearer than any two mechanisms that differ
DEAR = {"rk4": 1e-9}  # what has too many steps below this error
PROBLEMS: dict[str, tuple[Callable[[int], Problem], int]] = {  # and how many runs
    "top": (top.problem, 128), "chain": (chain.problem, 64), "satellite": (satellite.problem, 256),
}  # fmt: skip


@dataclass
class Search:
    """Errors of a contestant by setting, found where they are asked for."""

    contestant: Contestant
    exact: Array
    errors: dict[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.tried = self.contestant.searched()

    def error(self, n: int) -> float:
        """Of the n-th setting of its ladder; infinite if runs fail."""
        if n not in self.errors:
            try:
                ends, _ = self.tried.run(self.contestant.ladder[n])
                self.errors[n] = float(np.sqrt(((ends[-len(self.exact) :] - self.exact) ** 2).sum(axis=1)).max())
            except FailedError:
                self.errors[n] = float("inf")
        return self.errors[n]

    def reaches(self, target: float) -> int | None:
        """The number of the coarsest setting that does, by bisection."""
        low, high = -1, len(self.contestant.ladder) - 1
        low = max((n for n, error in self.errors.items() if error > target), default=low)
        good = [n for n, error in self.errors.items() if error <= target and n > low]
        high = min(good, default=high)
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if self.error(middle) <= target else (middle, high)
        return high if self.error(high) <= target else None


@dataclass(frozen=True)
class Reach:
    """Of all problems: what is to be timed, whether all simulate the same, and the settings by the cases' keys."""

    cases: list[Case] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    settings: dict[str, dict[str, Any]] = field(default_factory=dict)


def prepared(names: Sequence[str], tell: Callable[[str], object], targets: Sequence[float] = TARGETS) -> Reach:
    """Nothing without heyoka, which is the reference as well; tell: hears who is being searched. Nothing is compiled
    before: the folder of the cache is empty."""
    kept = os.environ.get(CACHE)
    with TemporaryDirectory() as folder:
        os.environ[CACHE] = folder
        try:
            return _searched(names, tell, targets)
        finally:
            os.environ.pop(CACHE)
            if kept is not None:
                os.environ[CACHE] = kept


def _searched(names: Sequence[str], tell: Callable[[str], object], targets: Sequence[float]) -> Reach:
    done = Reach()
    for name in names:
        make, runs = PROBLEMS[name]
        problem = make(runs)
        against = rivals(problem)
        if not against:
            return done
        exact = reference(problem)
        for contestant in [*against, *engines(problem)]:
            tell(f"{problem.label}: {contestant.label}")
            search = Search(contestant, exact)
            for target in targets:
                if target < _least(contestant):
                    continue
                n = search.reaches(target)
                if n is None:
                    continue
                key = f"reach_{name}_{target:.0e}_{contestant.key}"
                done.settings[key] = _told(problem.label, contestant, search, n)
                run = partial(_spend, contestant, contestant.ladder[n])
                done.cases.append(Case(key, contestant.label, 1, problem.runs, run))
            best = min(search.errors.values())
            done.checks.append(
                Check(f"{problem.label}, {contestant.label}: finest error in m", best, max(SAME, _least(contestant)))
            )
    return done


def _least(contestant: Contestant) -> float:
    """The smallest error that is asked of it, m."""
    return DEAR.get(contestant.key.partition("_")[0], 0.0)


def _told(problem: str, contestant: Contestant, search: Search, n: int) -> dict[str, Any]:
    setting = contestant.ladder[n]
    contestant.run(setting)
    return {
        "problem": problem, "setting": setting, "error": search.errors[n],
        "steps": contestant.steps(setting), "compile_s": max(contestant.compiled.values()),
        "order": contestant.order(setting) if isinstance(contestant, Heyoka) else None,
    }  # fmt: skip


def _spend(contestant: Contestant, setting: float) -> Spent:
    watch = Stopwatch()
    core = contestant.run(setting)[1]
    return Spent(watch.spent().wall, core)
