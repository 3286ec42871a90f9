"""The design table: every sample of a sweep, drawn before the first run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lienumba.errors import ScenarioError
from lienumba.sweep.samplers import uniforms

if TYPE_CHECKING:
    import numpy as np

    from lienumba.sweep.distributions import Distribution

NOMINAL_RUN = -1


def design_table(
    vary: Mapping[str, Distribution], nominal: Mapping[str, float], runs: Sequence[int], seed: int
) -> dict[str, np.ndarray]:
    """Samples (runs,) for each varied path; the run labelled -1 has the nominal values."""
    import numpy as np

    labels = np.asarray(runs, dtype=np.int64)
    sampled = labels != NOMINAL_RUN
    table, problems = {}, []
    for path, distribution in vary.items():
        column = np.full(labels.shape, float(nominal[path]))
        try:
            column[sampled] = distribution.ppf(uniforms(path, labels[sampled], seed), float(nominal[path]))
        except ScenarioError as error:
            problems.append(f'sweep.vary."{path}".{error}')
        table[path] = column
    if problems:
        raise ScenarioError("\n".join(problems))
    return table
