"""The design table: every sample of a sweep, drawn before the first run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.errors import Problem, ScenarioError
from lienumba.sweep.copula import Rows, correlated
from lienumba.sweep.distributions.base import NUMBER
from lienumba.sweep.distributions.external import Column
from lienumba.sweep.samplers import DEFAULT, SAMPLERS
from lienumba.sweep.samplers.importance import IMPORTANCE, Proposal, proposed
from lienumba.sweep.samplers.streams import BLOCK

if TYPE_CHECKING:
    from lienumba.sweep.distributions.base import Distribution
    from lienumba.sweep.table import SampleTable

NOMINAL_RUN = -1


def design_table(
    vary: Mapping[str, Distribution],
    nominal: Mapping[str, Any],
    runs: Sequence[int],
    seed: int,
    *,
    sampler: str = DEFAULT,
    count: int = 0,
    correlate: Sequence[tuple[Sequence[str], Rows]] = (),
    table: SampleTable | None = None,
    proposals: Mapping[str, Proposal] | None = None,
    uniforms: Mapping[str, np.ndarray] | None = None,
) -> dict[str, np.ndarray]:
    """Samples (runs,) of each number that varies, by its path; the run labelled -1 has the nominal values.

    nominal: of each varied path a number, or as many as it has columns; count: the runs of the whole sweep; correlate:
    names of streams with the correlations of their normal scores; proposals: by names of streams, of a sampler with
    weights; uniforms: by the names of all streams, instead of what the sampler would draw.
    """
    labels = np.asarray(runs, dtype=np.int64)
    sampled = labels != NOMINAL_RUN
    drawn = labels[sampled]
    streams = {path: kind.streams(path) for path, kind in vary.items()}
    u = SAMPLERS[sampler].draw(streams, drawn, seed, count) if uniforms is None else dict(uniforms)
    for name, x in u.items():
        if x.shape != drawn.shape or not np.all((x > 0.0) & (x < 1.0)):
            raise TypeError(f'the sampler "{sampler}" must draw {len(drawn)} numbers between 0 and 1 for {name}')
    if uniforms is None and SAMPLERS[sampler].weighted:
        u |= proposed(u, proposals or {}, drawn, seed)[0]
    for names, matrix in correlate:
        u |= correlated(u, names, matrix)
    rows = None if table is None else table.indices(drawn)
    found: dict[str, np.ndarray] = {}
    problems: list[Problem] = []
    for path, kind in vary.items():
        own = [nominal[path]] if kind.shape == NUMBER else nominal[path]
        try:
            if isinstance(kind, Column):
                assert table is not None, "checked with the scenario"
                samples: Sequence[Any] = [np.asarray(table.columns[name])[rows] for name in kind.names]
            else:
                samples = _drawn(kind, [u[name] for name in kind.streams(path)], nominal[path])
        except ScenarioError as error:
            problems += [problem.below(f'sweep.vary."{path}"') for problem in error.problems]
            continue
        for name, start, values in zip(kind.columns(path), own, samples, strict=True):
            found[name] = np.full(labels.shape, float(start))
            found[name][sampled] = values
    if problems:
        raise ScenarioError(*problems)
    return found


def weights(
    vary: Mapping[str, Distribution], proposals: Mapping[str, Proposal], labels: np.ndarray, seed: int
) -> np.ndarray:
    """Of runs that a sampler with weights draws (runs,); 1 of the nominal run."""
    drawn = labels[labels != NOMINAL_RUN]
    streams = {path: [name for name in kind.streams(path) if name in proposals] for path, kind in vary.items()}
    u = IMPORTANCE.draw(streams, drawn, seed, 0)
    found = np.ones(labels.shape)
    found[labels != NOMINAL_RUN] = proposed(u, proposals, drawn, seed)[1]
    return found


def _drawn(kind: Distribution, u: Sequence[np.ndarray], nominal: Any) -> Sequence[Any]:
    """The columns of a distribution, block by block."""
    if len(u) == 0 or len(u[0]) == 0:
        return kind.draw(u, nominal)
    with np.errstate(all="ignore"):  # a run with what is no number is marked
        blocks = [kind.draw([x[start : start + BLOCK] for x in u], nominal) for start in range(0, len(u[0]), BLOCK)]
    return [np.concatenate(column) for column in zip(*blocks, strict=True)]
