"""`--quick` and `--daily`: the cheap tests of every room, by what tests/costs.csv says of them; `--costs` writes that
file anew, `--quick --costs` only what turned out dearer: what tests share is made by the first of them that runs.

Of every function the first case, if it is cheap, and as many more as take little together; of every room at least one
test. What costs.csv does not name, such as a new test, is cheap.
"""

import csv
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

COSTS = Path(__file__).with_name("costs.csv")
PARTS = {"quick": (0.15, 0.05), "daily": (1.0, 0.3)}  # s of one core: the first case of a function, all its cases
TOLD = 0.03  # s; functions that take less in all are not in the file
UNKNOWN = 0.01, 0.002  # s, of the first case of such a function, and of each other


def pytest_addoption(parser: pytest.Parser) -> None:
    for part, (first, _) in PARTS.items():
        text = f"only tests of every room that take less than {first} s, by tests/costs.csv"
        parser.addoption(f"--{part}", action="store_true", help=text)
    parser.addoption("--costs", action="store_true", help="write tests/costs.csv from this run")


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--costs"):
        config.pluginmanager.register(Costs(read() if config.getoption("--quick") else {}))


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for part in (x for x in PARTS if config.getoption(f"--{x}")):
        kept = cheap([item.nodeid for item in items], read(), *PARTS[part])
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in kept])
        items[:] = [item for item in items if item.nodeid in kept]


def cheap(tests: list[str], costs: dict[str, tuple[float, float]], dearest: float, together: float) -> set[str]:
    """Which of these tests are run; costs: by function, of its first case and of each other; dearest: of a first case
    that is run; together: what all cases of a function may take if more are."""
    rooms: dict[str, dict[str, list[str]]] = {}
    for test in tests:
        function = test.partition("[")[0]
        room = test.partition("::")[0].rpartition("/")[0]
        rooms.setdefault(room, {}).setdefault(function, []).append(test)
    kept: set[str] = set()
    for functions in rooms.values():
        first = {function: costs.get(function, UNKNOWN)[0] for function in functions}
        least = min(first, key=lambda function: first[function])
        for function, cases in functions.items():
            each = costs.get(function, UNKNOWN)[1]
            more = int((together - first[function]) / each) if each else len(cases)
            if first[function] <= dearest or function == least:
                kept |= {*cases[: 1 + max(more, 0)]}
    return kept


def read() -> dict[str, tuple[float, float]]:
    with COSTS.open(encoding="utf-8", newline="") as file:
        return {row["function"]: (float(row["first"]), float(row["others"])) for row in csv.DictReader(file)}


def write(costs: dict[str, float], least: dict[str, tuple[float, float]]) -> None:
    """costs: of every test, in the order in which they ran; least: of functions, which do not get cheaper than this."""
    functions: dict[str, list[float]] = {}
    for test, seconds in costs.items():
        functions.setdefault(test.partition("[")[0], []).append(seconds)
    found = dict(least)
    for function, (first, *others) in functions.items():
        known, each = least.get(function, (0.0, 0.0))
        mean = sum(others) / len(others) if others else 0.0
        if function in least or first + sum(others) >= TOLD:
            found[function] = max(first, known), max(mean, each)
    with COSTS.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("function", "first", "others"))
        rows.writerows((function, f"{first:.2f}", f"{each:.3f}") for function, (first, each) in sorted(found.items()))


def spent() -> float:
    """Seconds of all cores that this process and those that it has waited for have used."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


class Costs:
    """What each test takes, from all workers."""

    def __init__(self, least: dict[str, tuple[float, float]]) -> None:
        self.least, self.last, self.costs = least, 0.0, dict[str, float]()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self) -> Iterator[Any]:
        self.last = spent()
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Iterator[Any]:
        report = yield
        now = spent()
        report.cost, self.last = now - self.last, now
        return report

    def pytest_runtest_logreport(self, report: Any) -> None:
        cost = getattr(report, "cost", 0.0)  # not in the report of a worker that crashed
        self.costs[report.nodeid] = self.costs.get(report.nodeid, 0.0) + cost

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if not hasattr(session.config, "workerinput"):
            write(self.costs, self.least)
