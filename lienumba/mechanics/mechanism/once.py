"""What follows from a model alone is computed once for each model, which nobody changes."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar
from weakref import ref

from lienumba.mechanics.mechanism.model import Model

T = TypeVar("T")
_known: dict[int, tuple["ref[Model]", dict[object, Any]]] = {}  # by the identity of a model, while there is one


def once_per_model(function: Callable[[Model], T]) -> Callable[[Model], T]:
    """The same function, which finds what it has returned for this very model before; nobody may change that either."""

    @wraps(function)
    def remembered(model: Model) -> T:
        key = id(model)
        if key not in _known:
            _known[key] = ref(model, lambda _: _known.pop(key, None)), {}
        found = _known[key][1]
        if function not in found:
            found[function] = function(model)
        value: T = found[function]
        return value

    return remembered
