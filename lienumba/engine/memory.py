"""Keeps what runs give in memory: for datasets that are not written, and for the points of a study."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lienumba.engine.results import Piece
from lienumba.store.layout import FULL
from lienumba.store.shards import LABEL

Arrays = dict[str, np.ndarray]


class Memory:
    """arrays: what was taken, by variable, in the order of the labels; seconds: that cores were busy with it."""

    def __init__(self, labels: Sequence[int]) -> None:
        self.labels = np.asarray(labels, np.int64)
        self.arrays: Arrays = {}
        self.seconds = 0.0
        self._full: list[np.ndarray] = []

    def take(self, piece: Piece) -> None:
        self.seconds += piece.seconds
        records = piece.tables["run"]
        rows = positions(self.labels, records[LABEL])
        for name in _fields(records):
            if name not in self.arrays:
                self.arrays[name] = np.empty((len(self.labels), *records.dtype[name].shape), records.dtype[name].base)
            self.arrays[name][rows] = records[name]
        if FULL in piece.tables:
            self._full.append(piece.tables[FULL])

    def columns(self, kept: np.ndarray) -> Arrays:
        """Every column of every table, of the runs (a mask) that are kept."""
        arrays = self.arrays if kept.all() else {name: x[kept] for name, x in self.arrays.items()}
        if not self._full:
            return arrays
        records = np.concatenate(self._full)
        records = records[np.isin(records[LABEL], self.labels[kept])]
        records = records[np.argsort(positions(self.labels, records[LABEL]))]
        return arrays | {name: np.ascontiguousarray(records[name]) for name in _fields(records)}

    def column(self, name: str, labels: np.ndarray) -> np.ndarray:
        """The values of a variable of these runs."""
        return self.arrays[name][positions(self.labels, labels)]


def _fields(records: np.ndarray) -> list[str]:
    names: Any = records.dtype.names
    return [name for name in names if name != LABEL]


def positions(labels: np.ndarray, some: np.ndarray) -> np.ndarray:
    """Where each of some labels stands among all."""
    order = np.argsort(labels, kind="stable")
    found: np.ndarray = order[np.searchsorted(labels, some, sorter=order)]
    return found
