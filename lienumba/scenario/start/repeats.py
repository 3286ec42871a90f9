"""Functions whose code is not known, called twice before runs begin: equal numbers have to give equal bits."""

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

PURE = "let its outputs depend on its arguments alone"
LANES = np.linspace(-1.0, 1.0, W) + 0.0625  # of what differs between runs


def check_repeats(values: Sequence[object], numbers: Sequence[Any], initial: Sequence[Any]) -> None:
    """A BadValueError for a function that returns other bits when it is called again, with its runs in another order.

    Parameters
    ----------
    values : sequence
        What the law returned on symbols.
    numbers : sequence
        Those of the model, by rows of its parameters; the first run counts.
    initial : sequence
        The initial states of all laws, each law's memory behind its own.
    """
    outside = [node for node in reached(values) if node.op == "call" and calls.KNOWN[node.args[0]].outside]
    for node in outside:
        made = calls.KNOWN[node.args[0]]
        outputs = [calls.part(node, n) for n in range(made.outputs)]
        with np.errstate(all="ignore"):
            once, again = (replayed(outputs, _Given(numbers, initial, order)) for order in (1, -1))
        for x, y in zip(once, again, strict=True):
            if np.broadcast_to(x, W).tobytes() != np.broadcast_to(y, W)[::-1].tobytes():
                order = ", its runs in another order" if made.evaluate else ""
                rule = f"{made.name} returns other numbers when it is called again with equal arguments{order}"
                raise BadValueError(rule, PURE)


class _Given:
    """The inputs of a law in W runs, which differ in their motion; order: 1 or -1."""

    def __init__(self, numbers: Sequence[Any], initial: Sequence[Any], order: int) -> None:
        self.numbers, self.initial, self.lanes = numbers, initial, LANES[::order].copy()

    def __call__(self, array: str, row: int) -> Any:
        if array == "parameters":
            return _first(self.numbers[row])
        if array == "extra":
            return _first(self.initial[row])
        if array == "clock":
            return 0.0
        body, element = divmod(row, ELEMENT)
        turns = so3.exp(tuple(a * (0.1 + 0.05 * body) * self.lanes for a in (1.0, -2.0, 1.5)))
        return turns[element - 3] if 3 <= element < 12 else 0.1 * (1.0 + element + body) * self.lanes


def _first(x: Any) -> Any:
    """A number of the first run, or numbers in memory."""
    if isinstance(x, RunNumbers):
        return x.part(np.zeros(W, np.int64))
    return x if isinstance(x, Numbers | float | int) else float(np.asarray(x).flat[0])


def needs_samples(values: Sequence[object]) -> tuple[str, str]:
    """The name of a function whose law has to be sampled, and why; empty if there is none."""
    made = [calls.KNOWN[x.args[0]] for x in reached(values) if x.op == "call"]
    return next(((x.name, x.sampled) for x in made if x.sampled), ("", ""))
