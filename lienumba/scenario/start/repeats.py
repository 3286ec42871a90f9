"""Functions whose code is not known, called again before runs begin: equal numbers have to give equal bits."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lienumba.compiler.foreign import calls
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import reached
from lienumba.compiler.tape import replayed
from lienumba.errors import BadValueError
from lienumba.groups import so3
from lienumba.groups.state import ELEMENT
from lienumba.mechanics.mechanism.tables import Numbers, RunNumbers

EVERY = np.arange(W)
PURE = "let its outputs depend on its arguments alone"
LANES = np.linspace(-1.0, 1.0, W) + 0.0625  # of what differs between runs


def check_repeats(values: Sequence[object], numbers: Sequence[Any], initial: Sequence[Any]) -> None:
    """Refuse a function that returns other bits when it is called again: for the same runs, and for each run alone.

    Parameters
    ----------
    values : sequence
        What the law returned on symbols.
    numbers : sequence
        Those of the model, by rows of its parameters; the first runs count.
    initial : sequence
        The initial states of all laws, each law's memory behind its own.

    Raises
    ------
    BadValueError
        Names the function.
    """
    outside = [node for node in reached(values) if node.op == "call" and calls.KNOWN[node.args[0]].outside]
    for node in outside:
        made = calls.KNOWN[node.args[0]]
        outputs = [calls.part(node, n) for n in range(made.outputs)]
        orders = [EVERY, EVERY[::-1], *(np.full(W, run) for run in EVERY)] if made.evaluate else [EVERY, EVERY]
        with np.errstate(all="ignore"):
            found = [_rows(replayed(outputs, _Given(numbers, initial, runs))) for runs in orders]
        for runs, rows in zip(orders, found, strict=True):
            if rows.tobytes() != found[0][:, runs].tobytes():
                how = "in another block of runs" if made.evaluate else "again"
                rule = f"{made.name} returns other numbers when it is called {how} with equal arguments"
                raise BadValueError(rule, PURE)


def _rows(values: Sequence[Any]) -> np.ndarray:
    return np.array([np.broadcast_to(x, W) for x in values])


class _Given:
    """The inputs of a law in W runs (indices below W), which differ in their motion."""

    def __init__(self, numbers: Sequence[Any], initial: Sequence[Any], runs: np.ndarray) -> None:
        self.numbers, self.initial, self.runs, self.lanes = numbers, initial, runs, LANES[runs]

    def __call__(self, array: str, row: int) -> Any:
        if array == "parameters":
            return _of_runs(self.numbers[row], self.runs)
        if array == "extra":
            return _of_runs(self.initial[row], self.runs)
        if array == "clock":
            return 0.0
        body, element = divmod(row, ELEMENT)
        turns = so3.exp(tuple(a * (0.1 + 0.05 * body) * self.lanes for a in (1.0, -2.0, 1.5)))
        return turns[element - 3] if 3 <= element < 12 else 0.1 * (1.0 + element + body) * self.lanes


def _of_runs(x: Any, runs: np.ndarray) -> Any:
    """A number of some of the first W runs, or numbers in memory."""
    if isinstance(x, RunNumbers):
        return x.part(np.zeros(W, np.int64))
    return x if isinstance(x, Numbers | float | int) else np.resize(np.asarray(x, float), W)[runs]


def needs_samples(values: Sequence[object]) -> tuple[str, str]:
    """The name of a function whose law has to be sampled, and why; empty if there is none."""
    made = [calls.KNOWN[x.args[0]] for x in reached(values) if x.op == "call"]
    return next(((x.name, x.sampled) for x in made if x.sampled), ("", ""))
