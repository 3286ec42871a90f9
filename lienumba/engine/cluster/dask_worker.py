"""What a process of a cluster does: it makes ready what a scenario needs, once, and then computes runs of it.

Nothing heavy is imported before it is called: the scheduler, too, reads this module.
"""

import signal
import threading
import tomllib
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from lienumba.errors import ScenarioError

if TYPE_CHECKING:
    from lienumba.engine.results import Piece, Results

SCENARIOS = 8  # that are kept ready
SHELF = "lienumba"  # under which the scheduler has the texts of scenarios

_one_at_a_time = threading.Lock()  # a worker may have several threads


def dask_setup(_: object) -> None:
    """Called by a worker of a local cluster: an interrupt is for the process that began it, which ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def compute(
    shelf: list[str], wanted: Mapping[str, str], fixed: bool, labels: np.ndarray, samples: "Mapping[str, np.ndarray]"
) -> "Piece":
    """What these runs give; shelf: where the scheduler has the text of the scenario; wanted: versions."""
    check_versions(wanted)
    from time import thread_time

    from lienumba.engine.programs import compile_early
    from lienumba.engine.results import joined
    from lienumba.engine.simulate import chunks
    from lienumba.scenario.start.prepare import prepare

    with _one_at_a_time:
        results = _ready(_text(tuple(shelf)))
    resolved, started = results.resolved, thread_time()
    prepared = prepare(resolved, labels.tolist(), samples, results.nominal, asked=0)
    busy = thread_time() - started
    compile_early(resolved, prepared, fixed)  # which is no time of these runs
    started = thread_time()
    tasks = chunks(results, [prepared], fixed, 1, lambda done: None)
    pieces = [task.work(*np.zeros((2, 1), np.int64)) for task in tasks]
    return joined(pieces, busy + thread_time() - started)


def versions() -> dict[str, str]:
    """Of all that decides the bits of a run."""
    from importlib.metadata import version

    from lienumba import __version__

    return {"lienumba": __version__, **{name: version(name) for name in ("numba", "llvmlite")}}


def check_versions(wanted: Mapping[str, str]) -> None:
    """This process must have them."""
    for name, here in versions().items():
        if here != wanted[name]:
            from distributed import get_worker

            raise ScenarioError(
                f"dask: the worker {get_worker().address} has {name} {here}, but {wanted[name]} is wanted; install the "
                "same versions on all machines"
            )


@lru_cache(maxsize=SCENARIOS)
def _text(shelf: tuple[str, ...]) -> str:
    from distributed import get_client

    text: str = get_client().get_metadata(list(shelf))
    return text


@lru_cache(maxsize=SCENARIOS)
def _ready(text: str) -> "Results":
    from lienumba.engine.results import Results
    from lienumba.scenario.resolve import resolve
    from lienumba.scenario.start.prepare import check_initial

    resolved = resolve(tomllib.loads(text))
    return Results(resolved, check_initial(resolved))
