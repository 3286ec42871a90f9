"""How large the dataset of a sweep will be, before it begins."""

from collections.abc import Sequence

import numpy as np

from lienumba.engine.results import Results
from lienumba.scenario.base.arguments import labels_of
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import check_initial

LARGE = 10**10  # bytes: more than most people expect of one command
SMALL = 10**5  # runs times stored times, below which no mechanism comes near that


def expected_bytes(resolved: Scenario, runs: Sequence[int] | None) -> int:
    """Bytes of the variables of these runs (all if None) before compression; 0 where they are certainly few.

    In memory they take as much, and on the disk at most as much.
    """
    labels = labels_of(runs, resolved.labels)
    if resolved.plan is not None or len(labels) * len(resolved.times) < SMALL:
        return 0
    results = Results(resolved, check_initial(resolved))
    rows = {name: len(own) for name, own in results.labels(np.asarray(labels, np.int64)).items()}
    return sum(count * results.dtype(name).itemsize for name, count in rows.items())
