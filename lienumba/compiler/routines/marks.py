"""How a routine says what it is: whether it is compiled into what calls it, and the arrays it gets from outside."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

import numpy as np

F = TypeVar("F", bound=Callable[..., Any])

ENTRY = "entry"  # the name of a routine that is called from outside: void (whole numbers, floats)
ATTRIBUTES: dict[Any, str] = {}  # of marked routines, in LLVM


@dataclass(frozen=True)
class Numbers:
    """The kind of an array in an annotation: of how many dimensions, and whether of whole numbers."""

    dimensions: int
    whole: bool = False


Integers1 = Annotated[np.ndarray, Numbers(1, whole=True)]
Integers2 = Annotated[np.ndarray, Numbers(2, whole=True)]
Floats1 = Annotated[np.ndarray, Numbers(1)]
Floats2 = Annotated[np.ndarray, Numbers(2)]
Floats3 = Annotated[np.ndarray, Numbers(3)]
Floats4 = Annotated[np.ndarray, Numbers(4)]


def inlined(function: F) -> F:
    """Mark a routine that is compiled into what calls it: for what is done in each step arguments cost more than
    code."""
    ATTRIBUTES[function] = "alwaysinline"
    return function


def apart(function: F) -> F:
    """Mark a routine that is compiled once, and called: code that is long or rarely needed."""
    ATTRIBUTES[function] = "noinline"
    return function
