"""The suites of tests, and what they cost."""

from collections import Counter

import numpy as np
import pytest

from tests import costs
from tests.costs import Cost
from tests.rigs.places import ROOT
from tests.suites import (
    COMMIT_CASE,
    COMMIT_FUNCTION,
    COMMIT_TURNS,
    QUICK_CASE,
    QUICK_CORE_CASE,
    QUICK_FUNCTION,
    RELEASE_CASE,
    commit_cases,
    quick_cases,
    quick_functions,
)

COMMIT = 1000.0  # quiet core seconds that the tests of a commit may cost in all,
QUICK = 50.0  # and those of --quick
KNOWN = {
    "a/t.py::f": Cost(QUICK_FUNCTION / 2, QUICK_FUNCTION / 5, 5),
    "a/t.py::g": Cost(9.0, 9.0, 5),
    "b/t.py::h": Cost(COMMIT_CASE, COMMIT_FUNCTION / 2, 5),
    "b/t.py::i": Cost(COMMIT_FUNCTION / 2, COMMIT_FUNCTION / 5, 5),
    "b/t.py::j": Cost(QUICK_CASE, 0.0, 1, release=True),
    "tests/process/t.py::k": Cost(QUICK_CASE, 0.0, 1),
}
CASES = [f"{name}[{case}]" for name in KNOWN for case in range(5)]


def test_the_quick_part_has_cheap_functions_and_the_cheapest_of_every_room() -> None:
    assert quick_functions([*KNOWN, "a/t.py::new"], KNOWN) == {"a/t.py::f", "a/t.py::new", "b/t.py::i"}
    assert quick_cases(["a/t.py::new", *CASES[:10]], KNOWN) == {
        "a/t.py::new", "a/t.py::f[0]", "a/t.py::f[1]", "a/t.py::f[2]", "a/t.py::g[0]"
    }  # fmt: skip


def test_of_a_tenth_of_a_room_the_first_case_is_quick() -> None:
    room = {f"a/t.py::f{n}": Cost(QUICK_CASE + 0.01 * n + 0.01) for n in range(20)}
    assert quick_functions([*room], room) == {"a/t.py::f0", "a/t.py::f1"}


def test_what_results_rest_on_may_cost_more() -> None:
    core = [f"tests/mechanics/t.py::f{n}" for n in range(20)]
    assert quick_functions(core, dict.fromkeys(core, Cost(QUICK_CORE_CASE))) == {*core}
    assert len(quick_functions(core, dict.fromkeys(core, Cost(QUICK_CORE_CASE + 0.01)))) == 2


def test_a_commit_has_other_cases_of_a_dear_family_than_the_next_one() -> None:
    found = {commit: commit_cases(CASES[:20], KNOWN, commit) for commit in map(str, range(50))}
    for function, number in (("a/t.py::f", 5), ("a/t.py::g", 0), ("b/t.py::h", 2), ("b/t.py::i", 3)):
        own = [sorted(x for x in kept if x.startswith(function)) for kept in found.values()]
        assert {len(x) for x in own} == {number}
        assert all(f"{function}[0]" in x for x in own if number)
        assert len({case for kept in own for case in kept}) == (5 if number else 0)


def test_dear_functions_take_turns() -> None:
    cases, known = ["f", "g"], {"f": Cost(RELEASE_CASE, 0.0, 1), "g": Cost(RELEASE_CASE + 0.1, 0.0, 1)}
    found = [commit_cases(cases, known, str(commit)) for commit in range(60 * COMMIT_TURNS)]
    assert set().union(*found) == {"f"}
    assert 40 < found.count({"f"}) < 80


def cost_of(kept: set[str], known: dict[str, Cost], quick: bool = False) -> float:
    """Quiet seconds of these cases."""
    numbers = Counter(map(costs.function_of, kept))
    firsts = {name: (known[name].quick if quick else 0.0) or known[name].first for name in numbers}
    return sum(firsts[name] + (n - 1) * known[name].others for name, n in numbers.items())


def test_the_suites_keep_their_budgets() -> None:
    """That of a commit: as a mean, since its dear functions take turns."""
    known = costs.read()
    cases = [f"{name}[{n}]" for name, cost in known.items() if not cost.release for n in range(cost.cases)]
    commits = [cost_of(commit_cases(cases, known, str(n)), known) for n in range(12)]
    assert np.mean(commits) <= COMMIT, "mark families `release`, or make them cheaper"
    quick = quick_functions([*known], known)
    assert cost_of(quick_cases([x for x in cases if costs.function_of(x) in quick], known), known, True) <= QUICK


def test_what_cases_cost() -> None:
    known = {"f": Cost(1.0, 0.5, 37, quick=2.0), "g": Cost(1.0, 0.0, 1)}
    assert cost_of({"f[0]", "f[3]", "f[4]", "g"}, known) == 3.0
    assert cost_of({"f[0]", "f[3]", "f[4]", "g"}, known, quick=True) == 4.0


def test_costs_are_of_cases_in_the_order_in_which_they_ran(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    cases = {"a::f[y]": 2.0, "a::f[x]": 0.5, "a::f[z]": 1.5, "a::g": 0.5 * costs.SMALLEST, "a::h[x]": 1.0}
    known = {"a::f": Cost(0.0, 0.0, 9), "a::g": Cost(3.0, 0.0), "a::h": Cost(0.5, 0.7, 3, release=True)}
    found = costs.of_functions(cases, known, quick=False)
    assert found["a::f"] == Cost(2.0, 1.0, 9)
    assert found["a::h"] == Cost(1.0, 0.7, 3, release=True)
    monkeypatch.setattr(costs, "COSTS", tmp_path / "costs.csv")
    costs.write(known | found)
    assert costs.read() == {name: cost for name, cost in found.items() if name != "a::g"}


def test_a_quick_run_only_raises_what_a_first_case_costs_there() -> None:
    known = {"f": Cost(1.0, 2.0, 3, quick=1.0), "g": Cost(1.0, 2.0, 3)}
    found = costs.of_functions({"f[0]": 0.5, "f[1]": 9.0, "g[0]": 1.5}, known, quick=True)
    assert found == {"f": Cost(1.0, 2.0, 3, quick=1.0), "g": Cost(1.0, 2.0, 3, quick=1.5)}


def test_tests_are_found_in_the_text_of_a_file() -> None:
    found = costs.functions_of(ROOT / "tests" / "process" / "test_suites.py")
    assert "tests/process/test_suites.py::test_tests_are_found_in_the_text_of_a_file" in found
    assert "tests/oracles/paper/test_motion.py::TestMonteCarlo::test_every_run_starts_where_its_numbers_put_it" in (
        costs.functions_of(ROOT / "tests" / "oracles" / "paper" / "test_motion.py")
    )


def test_costs_are_of_files_that_are_there() -> None:
    gone = {name for name in costs.read() if not (ROOT / name.partition("::")[0]).exists()}
    assert len(gone) < 20, "renew tests/costs.csv, see CONTRIBUTING.md"
