"""tests/costs.csv: what each test function costs in quiet seconds (tests/clock.py), measured by `--costs`.

A row has the cost of the first case, which makes what the others share, the mean cost of the others, how many cases
there are, the cost of the first case in the quick suite, where other tests make what many share, and the suite to which
the function belongs. Functions below `SMALLEST` in all are left out.
"""

import csv
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests import clock

HERE = Path(__file__).parent
COSTS = HERE / "costs.csv"
FUNCTION = re.compile(r"^(?:class (Test\w*)|( *)def (test_\w+))", re.MULTILINE)
SMALLEST = 0.015  # quiet s
RENEWED = 5.0  # s of core time after which the clock is measured again
DRIVERS = (  # compiled once in each process, by whichever test comes first: no cost of that test
    ("fixed_step", "drive"), ("variable_step", "drive"), ("events.states", "observe_events"),
    ("switching.at_rest", "forces"),
)  # fmt: skip


class Cost(NamedTuple):
    """first, others: quiet s of the first case and of each other; cases: how many; quick: of the first case in the
    quick suite, 0 if it never ran there; release: not of a commit."""

    first: float = 0.004
    others: float = 0.004
    cases: int = 1
    quick: float = 0.0
    release: bool = False


def function_of(case: str) -> str:
    return case.partition("[")[0]


def functions_of(path: Path) -> list[str]:
    """The tests of a file by its text, without importing it."""
    name, group, found = path.relative_to(HERE.parent).as_posix(), "", list[str]()
    for class_name, indent, function in FUNCTION.findall(path.read_text(encoding="utf-8")):
        group = f"{class_name}::" if class_name else group if indent else ""
        if function:
            found.append(f"{name}::{group}{function}")
    return found


def functions() -> list[str]:
    """All tests."""
    return [x for path in HERE.rglob("test_*.py") for x in functions_of(path)]


def read() -> dict[str, Cost]:
    """The cost of each function in the file."""
    with COSTS.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {
        x["function"]: Cost(
            float(x["first"]), float(x["others"]), int(x["cases"]), float(x["quick"]), x["suite"] != "commit"
        )
        for x in rows
    }


def write(costs: dict[str, Cost]) -> None:
    with COSTS.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("function", "first", "others", "cases", "quick", "suite"))
        for function, cost in sorted(costs.items()):
            if max(cost.first + cost.others * (cost.cases - 1), cost.quick) >= SMALLEST:
                suite = "release" if cost.release else "commit"
                numbers = f"{cost.first:.3f}", f"{cost.others:.4f}", cost.cases, f"{cost.quick:.3f}"
                rows.writerow((function, *numbers, suite))


def of_functions(cases: dict[str, float], known: dict[str, Cost], quick: bool) -> dict[str, Cost]:
    """The cost of each function from that of the cases that ran, in their order; known: the other numbers of its row;
    quick: whether they ran in the quick suite, where costs only rise, since each run has others make what is shared."""
    functions: dict[str, list[float]] = {}
    for case, seconds in cases.items():
        functions.setdefault(function_of(case), []).append(seconds)
    found = {}
    for function, (first, *others) in functions.items():
        cost = known.get(function, Cost(0.0, 0.0))
        each = sum(others) / len(others) if others else cost.others if cost.cases > 1 else 0.0
        if quick:
            found[function] = cost._replace(quick=max(cost.quick, first))
        else:
            found[function] = cost._replace(first=first, others=each)
    return found


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

    What does not run keeps its row, unless it is gone.
    """

    def __init__(self, quick: bool) -> None:
        self.quick = quick
        self.last = self.measured = 0.0
        self.ratio = 1.0
        self.counts = dict[str, int]()
        self.costs = dict[str, float]()
        self.left_out = set[str]()  # cases that failed or were skipped: they cost less than they should
        self.known = read()

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        for item in items:
            name = function_of(item.nodeid)
            self.counts[name] = self.counts.get(name, 0) + 1

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
        release = any(map(item.get_closest_marker, ("release", "campaign")))
        name = function_of(item.nodeid)
        report.function = name, self.counts[name], release
        return report

    def pytest_runtest_logreport(self, report: Any) -> None:
        if hasattr(report, "cost"):  # not in the report of a worker that crashed
            name, cases, release = report.function
            self.known[name] = self.known.get(name, Cost(0.0, 0.0))._replace(cases=cases, release=release)
            self.costs[report.nodeid] = self.costs.get(report.nodeid, 0.0) + report.cost
            if not report.passed:
                self.left_out.add(report.nodeid)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if not hasattr(session.config, "workerinput"):
            ran = {case: seconds for case, seconds in self.costs.items() if case not in self.left_out}
            there = {*functions()}
            known = {name: cost for name, cost in read().items() if name in there}
            write(known | of_functions(ran, self.known, self.quick))
