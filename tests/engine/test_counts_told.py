"""What is told of the runs that are done, where some go again."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from lienumba.engine.results import Piece
from lienumba.engine.simulate import Progress, Runs, simulate
from lienumba.integrators.codes import RESELECT

AGAIN = (1, 4)  # of six runs, in pieces of two


def computed(runs: Runs, fixed: bool, report: Any, begin: Any) -> Iterator[Piece]:
    for first in range(0, len(runs.labels), 2):
        labels = runs.labels[first : first + 2]
        records = np.zeros(len(labels), [("label", "i8"), ("status", "i1")])
        records["label"] = labels
        records["status"] = np.where(np.isin(labels, AGAIN) & fixed, RESELECT, 0)
        yield Piece({"run": records}, 0.0)
        report(first + len(labels))


def test_runs_that_go_again_are_counted_once() -> None:
    told: list[Progress] = []
    found = list(simulate(Runs(np.arange(6), {}, None), told.append, computed))  # type: ignore[arg-type]
    labels = np.concatenate([piece.tables["run"]["label"] for piece in found])
    assert sorted(labels) == list(range(6))
    assert [event.total for event in told] == [6] * 4
    assert [event.done for event in told] == [1, 3, 4, 6]
