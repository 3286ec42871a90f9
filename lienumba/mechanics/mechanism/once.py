"""What follows from a model alone is computed once for each model, which nobody changes."""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

from lienumba.mechanics.mechanism.model import Model

T = TypeVar("T")


def once_per_model(function: Callable[[Model], T]) -> Callable[[Model], T]:
    """The same function, which finds what it has returned for this very model before; nobody may change that either."""

    @wraps(function)
    def remembered(model: Model) -> T:
        known: dict[object, T] = model.__dict__.setdefault("_once", {})
        if function not in known:
            known[function] = function(model)
        return known[function]

    return remembered
