"""The suites of tests, and what they cost."""

import pytest

from tests import costs
from tests.costs import Cost
from tests.rigs.places import ROOT
from tests.suites import DEAR, DEAREST, FAMILY, QUICK, QUICK_TOGETHER, SOME, commit_cases, quick_cases, quick_functions

COMMIT = 1000.0  # quiet core seconds that the suite of a commit may cost in all,
FUNCTION = 10.0  # and the cases of one function
KNOWN = {
    "a/t.py::f": Cost(QUICK_TOGETHER / 2, QUICK_TOGETHER / 5, 5),
    "a/t.py::g": Cost(9.0, 9.0, 5),
    "b/t.py::h": Cost(DEAR, FAMILY / 2, 5),
    "b/t.py::i": Cost(FAMILY / 2, FAMILY / 5, 5),
    "b/t.py::j": Cost(QUICK, 0.0, 1, release=True),
}
CASES = [f"{name}[{case}]" for name in KNOWN for case in range(5)]


def test_the_quick_part_has_cheap_functions_and_the_cheapest_of_every_room() -> None:
    assert quick_functions([*KNOWN, "a/t.py::new"], KNOWN) == {"a/t.py::f", "a/t.py::new", "b/t.py::i"}
    assert quick_cases(["a/t.py::new", *CASES[:10]], KNOWN) == {
        "a/t.py::new", "a/t.py::f[0]", "a/t.py::f[1]", "a/t.py::f[2]", "a/t.py::g[0]"
    }  # fmt: skip


def test_of_a_tenth_of_a_room_the_first_case_is_quick() -> None:
    room = {f"a/t.py::f{n}": Cost(QUICK + 0.01 * n + 0.01) for n in range(20)}
    assert quick_functions([*room], room) == {"a/t.py::f0", "a/t.py::f1"}


def test_a_commit_has_other_cases_of_a_dear_family_than_the_next_one() -> None:
    found = {commit: commit_cases(CASES[:20], KNOWN, commit) for commit in map(str, range(50))}
    for function, number in (("a/t.py::f", 5), ("a/t.py::g", 0), ("b/t.py::h", 2), ("b/t.py::i", 3)):
        own = [sorted(x for x in kept if x.startswith(function)) for kept in found.values()]
        assert {len(x) for x in own} == {number}
        assert all(f"{function}[0]" in x for x in own if number)
        assert len({case for kept in own for case in kept}) == (5 if number else 0)


def test_dear_functions_take_turns() -> None:
    cases, known = ["f", "g"], {"f": Cost(DEAREST, 0.0, 1), "g": Cost(DEAREST + 0.1, 0.0, 1)}
    found = [commit_cases(cases, known, str(commit)) for commit in range(60 * SOME)]
    assert set().union(*found) == {"f"}
    assert 40 < found.count({"f"}) < 80


def cost_of_a_commit(known: dict[str, Cost]) -> dict[str, float]:
    """Quiet seconds of each function in the suite of a commit."""
    cases = [f"{name}[{n}]" for name, cost in known.items() if not cost.release for n in range(cost.cases)]
    counts = dict.fromkeys(known, 0)
    for case in commit_cases(cases, known, ""):
        counts[case.partition("[")[0]] += 1
    return {name: known[name].first + (n - 1) * known[name].others for name, n in counts.items() if n}


def test_the_suite_of_a_commit_keeps_its_budget() -> None:
    functions = cost_of_a_commit(costs.read())
    assert sum(functions.values()) <= COMMIT, "mark a family `release`, or make it cheaper"
    assert max(functions.values()) <= FUNCTION


def test_what_a_commit_costs() -> None:
    known = {"f": Cost(DEAR, DEAR, 37), "g": Cost(DEAR, 0.0, 1), "h": Cost(COMMIT, release=True)}
    assert cost_of_a_commit(known) == {"f": 2 * DEAR, "g": DEAR}


def test_costs_are_of_cases_in_the_order_in_which_they_ran(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    cases = {"a::f[y]": 2.0, "a::f[x]": 0.5, "a::f[z]": 1.5, "a::g": 0.5 * costs.SMALLEST, "a::h[x]": 1.0}
    known = {"a::f": Cost(0.0, 0.0, 9), "a::h": Cost(0.5, 0.7, 3, release=True)}
    found = costs.of_functions(cases, known)
    assert found == {"a::f": Cost(2.0, 1.0, 9), "a::h": Cost(1.0, 0.7, 3, release=True)}
    monkeypatch.setattr(costs, "COSTS", tmp_path / "costs.csv")
    costs.write(found)
    assert costs.read() == found


def test_a_quick_run_only_raises_costs() -> None:
    known = {"f": Cost(1.0, 2.0, 3), "g": Cost(1.0, 2.0, 3)}
    found = costs.dearer(known, {"f": Cost(0.5, 9.0), "g": Cost(1.5, 9.0), "h": Cost(0.1)})
    assert found == {"f": Cost(1.0, 2.0, 3), "g": Cost(1.5, 2.0, 3), "h": Cost(0.1)}


def test_costs_are_of_files_that_are_there() -> None:
    gone = {name for name in costs.read() if not (ROOT / name.partition("::")[0]).exists()}
    assert len(gone) < 20, "renew tests/costs.csv: scripts/test --costs"
