"""First and total Sobol' indices of a sweep with `sampler = "saltelli"`, each with a 95 % interval by the bootstrap.

Of d sampled inputs, run n (d + 2) + j is row n of the sample A (j = 0), of B (j = 1), or of A with input j - 2 taken
from B. scipy.stats.sobol_indices has the estimators (A. Saltelli et al., Computer Physics Communications 181 (2010),
table 2 b, f). An interval is Student's with bootstrap standard errors; rows are resampled, of which few are far out,
so that a tenth of their number is its freedom. That of a total index is of its logarithm: it is a mean of squares,
which lies low where none of the few large ones was drawn.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lienumba.scenario.base.toml import Tables
from lienumba.sweep.distributions.registry import class_of
from lienumba.sweep.samplers.sobol import of_B, runs_of_row

RESAMPLES = 200
SEED = 2010  # of the resampling: the same dataset gives the same intervals
AT_ONCE = 1 << 22  # numbers of resampled outputs that are in memory
FEWEST = 4  # complete rows
CONFIDENCE = 0.95
FREEDOM, LEAST = 0.1, 3.0  # of Student's distribution: for each row, and at least
ENDS = ("", "_low", "_high")


@dataclass(frozen=True)
class Rows:
    """Which run (index) stands where. table (rows, d + 2): -1 where it is missing; inputs: the d of [sweep.vary]."""

    inputs: list[str]
    table: np.ndarray

    @property
    def independent(self) -> np.ndarray:
        """The runs of A and B, which share no number."""
        found: np.ndarray = self.table[:, :2][self.table[:, :2] >= 0]
        return found


@dataclass(frozen=True)
class Indices:
    """first, total (3, d): the index and the ends of its interval, of each input; rows: how many complete ones."""

    inputs: list[str]
    first: np.ndarray
    total: np.ndarray
    rows: int

    def by_input(self) -> dict[str, dict[str, float]]:
        """The numbers of each input by the names of `sensitivity`."""
        both = {"first_order": self.first, "total_order": self.total}
        return {
            name: {f"{kind}{end}": float(x[m, k]) for kind, x in both.items() for m, end in enumerate(ENDS)}
            for k, name in enumerate(self.inputs)
        }


def sampled_inputs(sweep: Tables) -> list[str]:
    """What is drawn, in the order of [sweep.vary]: no constants, expressions of other inputs or columns of a table."""
    return [path for path, entry in sweep.get("vary", {}).items() if class_of(entry).dimensions > 0]


def columns_of(path: str, columns: Sequence[str]) -> list[str]:
    """The coordinates of an input: itself, or the elements of a vector, such as a rotation."""
    return [name for name in columns if name == path or name.startswith((f"{path}[", f"{path}."))]


def rows_of(labels: np.ndarray, sweep: Tables, samples: Mapping[str, np.ndarray]) -> Rows | None:
    """The rows of a dataset with these labels (runs,) and samples (runs,); None if they are not laid out so."""
    inputs = sampled_inputs(sweep)
    rows = Rows(inputs, table_of(labels, runs_of_row(len(inputs)))[1])
    kept = [path for path, entry in sweep.get("vary", {}).items() if path not in inputs and "expression" not in entry]
    return rows if inputs and _hold(rows, kept, samples) else None


def table_of(labels: np.ndarray, length: int) -> tuple[np.ndarray, np.ndarray]:
    """The rows of so many runs that a dataset has (rows,), and which run (index) stands where (rows, length): -1 where
    it is missing."""
    runs = np.flatnonzero(labels >= 0)
    rows, row = np.unique(labels[runs] // length, return_inverse=True)
    table = np.full((len(rows), length), -1)
    table[row, labels[runs] % length] = runs
    return rows, table


def _hold(rows: Rows, kept: Sequence[str], samples: Mapping[str, np.ndarray]) -> bool:
    """Whether each run has its numbers from A or B as it should, and a row those that are kept in common."""
    table = rows.table[(rows.table >= 0).all(axis=1)]
    for path in (*rows.inputs, *kept):
        source = np.zeros(table.shape[1], int)  # the run of its row from which each has the input
        if path in rows.inputs:
            source = of_B(np.arange(table.shape[1]), rows.inputs.index(path)).astype(int)
        for name in columns_of(path, list(samples)):
            x = samples[name][table]
            if (x != x[:, source]).any():
                return False
    return True


def indices(values: np.ndarray, rows: Rows) -> Indices | None:
    """First and total indices of an output (runs,), of the complete rows alone; None if there are too few."""
    from scipy.special import stdtrit

    y = np.where(rows.table >= 0, values[rows.table], np.nan)
    y = y[np.isfinite(y).all(axis=1)].T
    n = y.shape[1]
    if n < FEWEST:
        return None
    generator = np.random.default_rng(SEED)
    parts = np.linspace(0, RESAMPLES, min(max(RESAMPLES * y.size // AT_ONCE, 1), RESAMPLES // 2) + 1).astype(int)
    itself = _estimate(y[:, None, np.arange(n)].repeat(2, axis=1))[:, 0]
    choices = (generator.integers(n, size=(end - start, n)) for start, end in pairwise(parts))
    drawn = [_estimate(y[:, chosen]) for chosen in choices]
    half = stdtrit(max(FREEDOM * n, LEAST), 0.5 + 0.5 * CONFIDENCE) * np.concatenate(drawn, axis=1).std(axis=1, ddof=1)
    ends = np.stack([itself, itself - half, itself + half])
    ends[:, 1] = _above_zero(itself[1], half[1])
    return Indices(rows.inputs, ends[:, 0], ends[:, 1], n)


def _above_zero(total: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Total indices (d,) with the ends of the intervals of their logarithms: at most 1, or what they are themselves."""
    factor = np.exp(np.divide(half, total, out=np.zeros_like(half), where=total > 0.0))
    return np.stack([total, total / factor, np.maximum(np.minimum(total * factor, 1.0), total)])


def _estimate(y: np.ndarray) -> np.ndarray:
    """First and total indices (2, samples, d) of outputs (d + 2, samples, n); of at least two samples.

    SciPy wants n to be a power of 2. Rows at the mean of A and B add nothing to any sum, and the estimators are ratios
    of such: filled up with them, n rows give what n rows alone would.
    """
    from scipy.stats import sobol_indices

    samples, n = y.shape[1:]
    whole = 1 << (n - 1).bit_length()
    filled = np.empty((len(y), samples, whole))
    filled[..., :n] = y
    filled[..., n:] = y[:2].mean(axis=(0, 2))[:, None]
    found = sobol_indices(func={"f_A": filled[0], "f_B": filled[1], "f_AB": filled[2:]}, n=whole)
    return np.stack([x.reshape(samples, -1) for x in (found.first_order, found.total_order)])
