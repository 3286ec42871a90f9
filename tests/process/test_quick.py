"""Which tests are quick."""

from tests.quick import PARTS, cheap, read
from tests.rigs.places import ROOT

DEAREST, TOGETHER = PARTS["quick"]
COSTS = {
    "a/t.py::f": (TOGETHER / 2, TOGETHER / 5),
    "a/t.py::g": (9.0, 9.0),
    "b/t.py::h": (9.0, 8.0),
    "b/t.py::i": (8.0, 1.0),
}


def test_the_first_cases_of_cheap_functions_and_the_cheapest_test_of_every_room() -> None:
    tests = [f"{name}[{case}]" for name in COSTS for case in range(5)] + [
        "a/t.py::new",
        "c/t.py::new[0]",
        "c/t.py::new[1]",
    ]
    assert cheap(tests, COSTS, DEAREST, TOGETHER) == {
        "a/t.py::f[0]", "a/t.py::f[1]", "a/t.py::f[2]", "a/t.py::new", "b/t.py::i[0]",
        "c/t.py::new[0]", "c/t.py::new[1]"
    }  # fmt: skip


def test_what_is_run_every_day_is_quick_or_dearer() -> None:
    tests = [f"{name}[{case}]" for name in COSTS for case in range(5)]
    quick, daily = (cheap(tests, COSTS, *PARTS[part]) for part in ("quick", "daily"))
    assert quick < daily
    assert "a/t.py::g[0]" not in daily


def test_costs_are_of_files_that_are_there() -> None:
    gone = {name for name in read() if not (ROOT / name.partition("::")[0]).exists()}
    assert len(gone) < 20, "renew tests/costs.csv: scripts/test --costs"
