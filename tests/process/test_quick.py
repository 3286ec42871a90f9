"""Which tests are quick."""

from tests.quick import TOGETHER, cheap, read
from tests.rigs.places import ROOT

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
    assert cheap(tests, COSTS) == {
        "a/t.py::f[0]", "a/t.py::f[1]", "a/t.py::f[2]", "a/t.py::new", "b/t.py::i[0]",
        "c/t.py::new[0]", "c/t.py::new[1]"
    }  # fmt: skip


def test_costs_are_of_files_that_are_there() -> None:
    gone = {name for name in read() if not (ROOT / name.partition("::")[0]).exists()}
    assert len(gone) < 20, "renew tests/costs.csv: scripts/test --costs"
