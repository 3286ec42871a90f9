"""Run labels and settings as the command line writes them."""

import pytest

from lienumba.scenario.base.arguments import check_count, check_labels, labels_of, parse_assignments, parse_labels
from tests.facade import ScenarioError


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("3", [3]),
        ("3,17", [3, 17]),
        ("17, 3,3", [3, 17]),
        ("0:4", [0, 1, 2, 3]),
        ("0:2,5", [0, 1, 5]),
        ("-1,0", [-1, 0]),
        ("-1:2", [-1, 0, 1]),
    ],
)
def test_labels(text: str, labels: list[int]) -> None:
    assert parse_labels(text, 20) == labels


@pytest.mark.parametrize("text", ["", "a", "1-3", "-2", "3:", ":3", "3:3", "1.5", "1,,2"])
def test_labels_that_are_none(text: str) -> None:
    with pytest.raises(ScenarioError, match="runs="):
        parse_labels(text, 20)


def test_labels_must_be_runs_of_the_sweep() -> None:
    check_labels([-1, 0, 9], 10)
    for labels in ([10], [-2], []):
        with pytest.raises(ScenarioError):
            check_labels(labels, 10)


def test_the_last_run_of_a_range_is_one_of_the_sweep() -> None:
    assert parse_labels("18:20", 20) == [18, 19]
    with pytest.raises(ScenarioError, match="run 20 does not exist"):
        parse_labels("18:21", 20)
    assert labels_of([9, -1], range(10)) == [9, -1]
    with pytest.raises(ScenarioError, match="run 10 does not exist"):
        labels_of([10], range(10))


def test_a_huge_range_is_refused_before_it_is_built() -> None:
    with pytest.raises(ScenarioError, match=r"run 999999999999 does not exist"):
        parse_labels("0:1000000000000", 20)


def test_assignments() -> None:
    assert parse_assignments(["a.b=1", "c = [1, 2]", "d=x=y", "a.b=2"]) == {
        "a.b": "2",
        "c": "[1, 2]",
        "d": "x=y",
    }


def test_labels_of_python() -> None:
    assert labels_of(None, range(-1, 10)) == range(-1, 10)
    assert labels_of((x for x in (3, 1)), range(10)) == [3, 1]
    for given in (5, "3"):
        with pytest.raises(ScenarioError, match=r"runs = .*: must be labels in a list; give such as \[3, 17\]"):
            labels_of(given, range(10))


def test_more_runs_than_a_machine_has_memory_for() -> None:
    check_count(10**6, 10)
    with pytest.raises(ScenarioError, match=r"1,000,000,000,000 runs: their labels and samples alone take 93,\d* GiB"):
        check_count(10**12, 0)
