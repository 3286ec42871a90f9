"""The suites of tests: `--quick`, `--commit`, and `--all`, that of a release, chosen by tests/costs.csv.

`--quick` runs, in every room, the first case of each cheap function and as many more as cost little together, and of
every room at least a tenth of the functions. `--commit` leaves out what is marked `release` or costs too much. Of each
function it runs the first case, another one by the hash of the commit, and as many more as cost little together; dear
functions take turns, by that hash, too. `--all` runs everything, and the campaigns: tests with the marker
`campaign(number)`, whose argument `seed` is as many numbers drawn from the hash of the commit. Without an option pytest
runs everything but the campaigns. `--quick` does not import files of which it runs nothing.
"""

import statistics
import subprocess
import time
from functools import cache
from pathlib import Path
from random import Random

import pytest

from tests import clock, costs
from tests.costs import Cost, function_of

QUICK = 0.1  # quiet s of a first case in --quick,
QUICK_TOGETHER = 0.05  # and of all cases of a function, if there are more of them
QUICK_SHARE = 0.1  # of the functions of a room are in --quick, cheapest first, whatever they cost up to
QUICK_DEAREST = 0.5  # quiet s
PROCESSES = "tests/process/"  # tests that start processes, browsers and other CPUs: none is quick
FAMILY = 1.0  # quiet s of all cases of a function in --commit, if there are more than two of them
DEAR = 1.0  # quiet s of a case; of the functions with dearer ones a commit runs
SOME = 6  # one in so many, of those that cost up to
DEAREST = 4.0  # quiet s a case; the others are of a release
SUITES = ("quick", "commit", "all")
NEW = Cost()  # of functions that tests/costs.csv does not name


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--quick", action="store_true", help="the cheap tests of every room, by tests/costs.csv")
    parser.addoption("--commit", action="store_true", help="the suite of a commit")
    parser.addoption("--all", action="store_true", help="the suite of a release: every case, new seeds of campaigns")
    parser.addoption("--seed", help="the text from which --all draws new seeds; default: the hash of the commit")
    parser.addoption("--costs", action="store_true", help="measure what tests cost, and write tests/costs.csv")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "release: of the suite of a release, not of that of a commit")
    config.addinivalue_line("markers", "campaign(number): of a release, on `number` new seeds")
    chosen = [suite for suite in SUITES if config.getoption(f"--{suite}")]
    if len(chosen) > 1:
        raise pytest.UsageError(f"--{chosen[0]} and --{chosen[1]}: choose one suite")
    if config.getoption("--costs"):
        config.pluginmanager.register(costs.Measuring(config.getoption("--quick")))
    config.pluginmanager.register(CoreSeconds(config))


@cache
def _head() -> str:
    try:
        command = ["git", "rev-parse", "--short=12", "HEAD"]
        return subprocess.run(command, capture_output=True, text=True, cwd=costs.HERE).stdout.strip()
    except OSError:
        return ""


def _commit(config: pytest.Config) -> str:
    return config.getoption("--seed") or _head() or "unknown"


# ---------------------------------------------------------------- campaigns
def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    for marker in metafunc.definition.iter_markers("campaign"):
        draw = Random(f"{_commit(metafunc.config)} {metafunc.definition.name}")
        metafunc.parametrize("seed", [draw.randrange(1000, 10**6) for _ in range(marker.args[0])])


# ---------------------------------------------------------------- which tests
def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out a file without a function of `--quick`."""
    if not config.getoption("--quick") or not collection_path.match("test_*.py"):
        return None
    return True if _quick_functions().isdisjoint(costs.functions_of(collection_path)) else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--all"):
        return
    left_out = ("release", "campaign") if any(map(config.getoption, ("--quick", "--commit"))) else ("campaign",)
    names = [item.nodeid for item in items if not any(map(item.get_closest_marker, left_out))]
    kept = {*names}
    if config.getoption("--quick"):
        kept = quick_cases([x for x in names if function_of(x) in _quick_functions()], costs.read())
    elif config.getoption("--commit"):
        kept = commit_cases(names, costs.read(), _commit(config))
    config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in kept])
    items[:] = [item for item in items if item.nodeid in kept]


def _families(cases: list[str]) -> dict[str, list[str]]:
    """The cases of each function."""
    found: dict[str, list[str]] = {}
    for case in cases:
        found.setdefault(function_of(case), []).append(case)
    return found


def quick_functions(functions: list[str], known: dict[str, Cost]) -> frozenset[str]:
    """Those of these functions of which `--quick` runs the first case, and maybe more."""
    rooms: dict[str, list[str]] = {}
    for function in functions:
        if not known.get(function, NEW).release and not function.startswith(PROCESSES):
            rooms.setdefault(function.partition("::")[0].rpartition("/")[0], []).append(function)
    kept: set[str] = set()
    for room in rooms.values():
        room.sort(key=lambda function: known.get(function, NEW).first)
        for n, function in enumerate(room):
            first = known.get(function, NEW).first
            if first <= QUICK or (n < QUICK_SHARE * len(room) and first <= QUICK_DEAREST):
                kept.add(function)
    return frozenset(kept)


def quick_cases(cases: list[str], known: dict[str, Cost]) -> set[str]:
    """Of each function the first case, and as many more as cost at most `QUICK_TOGETHER` with it."""
    kept: set[str] = set()
    for function, (first, *others) in _families(cases).items():
        kept |= {first, *others[: _number_within(QUICK_TOGETHER, known.get(function, NEW), len(others))]}
    return kept


def commit_cases(cases: list[str], known: dict[str, Cost], commit: str) -> set[str]:
    """Of each function the first case, another one, and as many more as cost at most `FAMILY` with them; the commit
    chooses which, and one in `SOME` of the functions with dear cases."""
    kept: set[str] = set()
    for function, (first, *others) in _families(cases).items():
        cost = known.get(function, NEW)
        dearest, draw = max(cost.first, cost.others), Random(f"{commit} {function}")
        if dearest <= DEAR or (dearest <= DEAREST and draw.randrange(SOME) == 0):
            number = min(max(_number_within(FAMILY, cost, len(others)), 1), len(others))
            kept |= {first, *draw.sample(others, number)}
    return kept


def _number_within(budget: float, cost: Cost, others: int) -> int:
    """How many of the other cases cost at most `budget` quiet s with the first one."""
    return min(max(int((budget - cost.first) / cost.others), 0), others) if cost.others else others


@cache
def _quick_functions() -> frozenset[str]:
    return quick_functions(costs.functions(), costs.read())


# ---------------------------------------------------------------- what the run cost
class CoreSeconds:
    """States the core time of all workers at the end, in seconds of this machine and of a quiet core."""

    def __init__(self, config: pytest.Config) -> None:
        self.config, self.spent, self.ratios = config, 0.0, [clock.ratio()]

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self) -> None:
        self.ratios.append(clock.ratio())
        workers_report = self.config.getoption("numprocesses", None)
        self.spent += time.process_time() if workers_report else clock.core_seconds()
        if hasattr(self.config, "workeroutput"):
            self.config.workeroutput["core_seconds"] = clock.core_seconds(), self.ratios

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: object) -> None:
        spent, ratios = getattr(node, "workeroutput", {}).get("core_seconds", (0.0, []))
        self.spent += spent
        self.ratios += ratios

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        ratio = statistics.mean(self.ratios)
        quiet = f"{self.spent / ratio:.0f} on a quiet core (the clock's ratio is {ratio:.2f})"
        terminalreporter.write_line(f"{self.spent:.0f} core seconds, {quiet}")
        if self.config.getoption("--commit") or self.config.getoption("--all"):
            terminalreporter.write_line(f"the same cases and seeds again: --seed {_commit(self.config)}")
