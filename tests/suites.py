"""The suites of tests: `--quick`, `--commit`, and `--all`, that of a release, chosen by tests/costs.csv.

`--quick` runs the first case of each function that costs little. If a room has few of these, it adds the room's
cheapest functions, up to a tenth. It leaves out tests/process, and does not import files of which it runs
nothing. `--commit` runs of each function the first case, another one, and as many more as cost `COMMIT_FUNCTION`
together. Functions with dearer cases than `COMMIT_CASE` take turns; with dearer ones than `RELEASE_CASE`, or marked
`release`, they run in a release only. The hash of HEAD chooses. `--all` runs everything, and the campaigns: tests with
the marker `campaign(number)`, whose argument `seed` is as many numbers drawn from that hash. Without an option pytest
runs everything but the campaigns.
"""

import statistics
import subprocess
import time
from functools import cache
from operator import itemgetter
from pathlib import Path
from random import Random

import pytest

from tests import clock, costs
from tests.costs import Cost, function_of

# Costs in quiet s (tests/clock.py).
QUICK_CASE = 0.05  # most that a first case in --quick costs,
QUICK_CORE_CASE = 0.2  # and one of what the results rest on
QUICK_FUNCTION = 0.05  # most that all quick cases of a function cost, if more than the first run
QUICK_SHARE = 0.1  # least part of a room's functions in --quick
QUICK_DEAREST = 0.5  # most that a first case added for that share costs
COMMIT_FUNCTION = 0.6  # most that the cases of a function in --commit cost, if more than two run
COMMIT_CASE = 0.6  # functions with a dearer case run in one commit of COMMIT_TURNS
COMMIT_TURNS = 6
RELEASE_CASE = 4.0  # functions with a dearer case run in a release only
CORE = ("tests/groups/", "tests/numerics/", "tests/compiler/", "tests/mechanics/", "tests/integrators/")
PROCESSES = "tests/process/"  # tests that start processes, browsers and other CPUs: none is quick
SUITES = ("quick", "commit", "all")
NEW = Cost()  # of functions that tests/costs.csv does not name


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--quick", action="store_true", help="the cheap tests of every room, by tests/costs.csv")
    parser.addoption("--commit", action="store_true", help="the suite of a commit")
    parser.addoption("--all", action="store_true", help="the suite of a release: every case, new seeds of campaigns")
    parser.addoption(
        "--seed", help="the text that chooses the cases of --commit and the seeds of --all; default: the hash of HEAD"
    )
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
    for name, room in rooms.items():
        limit = QUICK_CORE_CASE if f"{name}/".startswith(CORE) else QUICK_CASE
        first_case = {function: _quick_first(known.get(function, NEW)) for function in room}
        for n, (function, first) in enumerate(sorted(first_case.items(), key=itemgetter(1))):
            if first <= limit or (n < QUICK_SHARE * len(room) and first <= QUICK_DEAREST):
                kept.add(function)
    return frozenset(kept)


def quick_cases(cases: list[str], known: dict[str, Cost]) -> set[str]:
    """Of each function the first case, and as many more as cost at most `QUICK_FUNCTION` with it."""
    kept: set[str] = set()
    for function, (first, *others) in _families(cases).items():
        cost = known.get(function, NEW)
        kept |= {first, *others[: _number_within(QUICK_FUNCTION - _quick_first(cost), cost, len(others))]}
    return kept


def commit_cases(cases: list[str], known: dict[str, Cost], commit: str) -> set[str]:
    """Of each function the first case, another one, and as many more as cost at most `COMMIT_FUNCTION` with them; the
    commit chooses which, and one in `COMMIT_TURNS` of the functions with dear cases."""
    kept: set[str] = set()
    for function, (first, *others) in _families(cases).items():
        cost = known.get(function, NEW)
        dearest, draw = max(cost.first, cost.others), Random(f"{commit} {function}")
        if dearest <= COMMIT_CASE or (dearest <= RELEASE_CASE and draw.randrange(COMMIT_TURNS) == 0):
            number = min(max(_number_within(COMMIT_FUNCTION - cost.first, cost, len(others)), 1), len(others))
            kept |= {first, *draw.sample(others, number)}
    return kept


def _quick_first(cost: Cost) -> float:
    """The cost of a first case in `--quick`, as far as it is known."""
    return cost.quick or cost.first


def _number_within(budget: float, cost: Cost, others: int) -> int:
    """How many of the other cases cost at most `budget` quiet s."""
    return min(max(int(budget / cost.others), 0), others) if cost.others else others


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
