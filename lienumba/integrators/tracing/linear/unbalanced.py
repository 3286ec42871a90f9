"""Forces that nothing can balance: those along a coordinate that are the same, and not 0, wherever a mechanism is.

What weighs on a body that nothing holds, or a motor on a hinge that nothing brakes. Such a force is told by what is
recorded of it: sums, products, sines and cosines of what places consist of, without multipliers, are analytic; what is
analytic and has the same value at places drawn at random has it everywhere, but for a case of probability 0. What
places divide, are compared with or look up may hold where nobody has looked.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.symbols import FUSED, Graph, Symbol, live
from lienumba.compiler.tape import replayed

Array = npt.NDArray[Any]
ANALYTIC = {"input", "+", "-", "*", "neg", "sin", "cos", *FUSED}
PLACES = 4  # at which forces are looked at
SAME = 1e-9  # of a force: by how much it differs by rounding alone
LARGE = 1e-6  # of the largest force: what is certainly not 0


def analytic(values: Sequence[Any], known: Callable[[str, int], float | None], free: set[tuple[str, int]]) -> Array:
    """Which values are analytic in places, whatever else is known. known: the number of an input, if it has one; free:
    the inputs that are neither places nor numbers of the mechanism."""
    graph = Graph(analytic=True)

    def given(array: str, row: int) -> Any:
        number = known(array, row)
        return graph.input(array, row) if number is None else number

    return np.array([_is_analytic(x, free) for x in replayed(values, given)], bool)


def _is_analytic(x: Any, free: set[tuple[str, int]]) -> bool:
    nodes = [node for node in live([x]) if not node.invariant] if isinstance(x, Symbol) else []
    return all(_keeps(node) and (node.op != "input" or node.args not in free) for node in nodes)


def _keeps(node: Symbol) -> bool:
    """Whether what an operation makes of what is analytic is so, too."""
    divisor = node.args[1] if node.op == "/" else None
    constant = isinstance(divisor, float) or (isinstance(divisor, Symbol) and divisor.invariant)
    return node.op in ANALYTIC or constant


def unbalanced(forces: Array) -> Array:
    """Of forces (places, runs, rows) that are analytic the largest of each run (runs,) that is the same at all
    places, and not 0; else 0."""
    largest = np.abs(forces).max(axis=(0, 2), initial=0.0)[:, None]
    same = np.abs(forces - forces[0]).max(axis=0) <= SAME * np.abs(forces).max(axis=0)
    own = np.where(same & (np.abs(forces[0]) > LARGE * largest), np.abs(forces[0]), 0.0)
    found: Array = own.max(axis=1, initial=0.0)
    return found
