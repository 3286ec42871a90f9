"""tests/costs.csv: what each test function costs in quiet seconds (tests/clock.py), measured by `--costs`.

A row has the cost of the first case, which makes what the others share, the mean cost of the others, how many cases
there are, and the suite to which the function belongs. Functions below `SMALLEST` in all are left out.
"""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests import clock

COSTS = Path(__file__).with_name("costs.csv")
SMALLEST = 0.015  # quiet s
RENEWED = 5.0  # s of core time after which the clock is measured again
DRIVERS = (  # compiled once in each process, by whichever test comes first: no cost of that test
    ("fixed_step", "drive"), ("variable_step", "drive"), ("events.states", "observe_events"),
    ("switching.at_rest", "forces"),
)  # fmt: skip


class Cost(NamedTuple):
    """first, others: quiet s of the first case and of each other; cases: how many; release: not of a commit."""

    first: float = 0.004
    others: float = 0.001
    cases: int = 1
    release: bool = False


def read() -> dict[str, Cost]:
    """The cost of each function in the file."""
    with COSTS.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    numbers = [(float(x["first"]), float(x["others"]), int(x["cases"]), x["suite"] != "commit") for x in rows]
    return {row["function"]: Cost(*cost) for row, cost in zip(rows, numbers, strict=True)}


def write(costs: dict[str, Cost]) -> None:
    with COSTS.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("function", "first", "others", "cases", "suite"))
        for function, cost in sorted(costs.items()):
            suite = "release" if cost.release else "commit"
            rows.writerow((function, f"{cost.first:.3f}", f"{cost.others:.4f}", cost.cases, suite))


def of_functions(cases: dict[str, float], release: set[str]) -> dict[str, Cost]:
    """The cost of each function from that of its cases, in the order in which they ran."""
    functions: dict[str, list[float]] = {}
    for case, seconds in cases.items():
        functions.setdefault(case.partition("[")[0], []).append(seconds)
    return {
        function: Cost(first, sum(others) / len(others) if others else 0.0, 1 + len(others), function in release)
        for function, (first, *others) in functions.items()
        if first + sum(others) >= SMALLEST or function in release
    }


def compile_drivers() -> None:
    """Leave the drivers in the cache, as tests compile them and as users do."""
    from lienumba.compiler import flat, native

    for level, passes in ((0, 0), (native.LEVEL, flat.PASSES)):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(native, "LEVEL", level)
            patch.setattr(flat, "PASSES", passes)
            for module, name in DRIVERS:
                flat.kept(f"lienumba.integrators.drivers.{module}", name)


class Measuring:
    """The plugin that measures every test in its worker, and writes the file from the reports of all workers.

    A run of some tests renews their rows, and leaves the others.
    """

    def __init__(self) -> None:
        self.last = self.measured = 0.0
        self.ratio = 1.0
        self.cases = dict[str, float]()
        self.release = set[str]()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self) -> Iterator[Any]:
        if not self.measured:
            compile_drivers()
        if not self.measured or clock.core_seconds() - self.measured > RENEWED:
            self.ratio, self.measured = clock.ratio(), clock.core_seconds()
        self.last = clock.core_seconds()
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item) -> Iterator[Any]:
        report = yield
        now = clock.core_seconds()
        report.cost, self.last = (now - self.last) / self.ratio, now
        report.release = any(map(item.get_closest_marker, ("release", "campaign")))
        return report

    def pytest_runtest_logreport(self, report: Any) -> None:
        cost = getattr(report, "cost", 0.0)  # not in the report of a worker that crashed
        self.cases[report.nodeid] = self.cases.get(report.nodeid, 0.0) + cost
        if getattr(report, "release", False):
            self.release.add(report.nodeid.partition("[")[0])

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if hasattr(session.config, "workerinput"):
            return
        measured = {case.partition("[")[0] for case in self.cases}
        files = {function.partition("::")[0] for function in measured}
        kept = {name: cost for name, cost in read().items() if name.partition("::")[0] not in files}
        write(kept | of_functions(self.cases, self.release))
