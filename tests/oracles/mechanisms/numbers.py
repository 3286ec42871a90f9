"""Numbers of a scenario that are formulas of the time."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

from tests.oracles.mechanisms.places import Array

NAMES = {"sin": np.sin, "cos": np.cos, "exp": np.exp, "pi": np.pi}


@cache
def number(x: Any) -> Callable[[Any], Any]:
    """A function of time, complex, too."""
    if not isinstance(x, str):
        return lambda t: x + 0.0 * t
    code = compile(x, "formula", "eval")
    return lambda t: eval(code, {"__builtins__": {}, **NAMES, "t": t})


def vector(x: Sequence[Any]) -> Callable[[Any], Array]:
    """(n, 3) at times (n,), or (1, 3) at one."""
    parts = [number(c) for c in x]
    return lambda t: np.stack([np.atleast_1d(part(t) + 0.0 * t) for part in parts], -1)
