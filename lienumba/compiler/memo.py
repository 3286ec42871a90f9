"""Things that are made once, for any number of threads, and what tells whether two are the same."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import fields
from functools import cache
from threading import Lock
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class UnknownError(TypeError):
    """Nothing tells whether such a thing is the same as another."""


class Memo(Generic[T]):
    """The things asked for last, so many of them, by their keys.

    Of threads that ask for the same at the same time one makes it, and the others wait; nobody waits for anything else.
    """

    def __init__(self, entries: int) -> None:
        self.entries = entries
        self._kept: OrderedDict[Hashable, Future[T]] = OrderedDict()
        self._lock = Lock()

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """The thing of this key, made if it is not there. What cannot be made is not kept."""
        while True:
            with self._lock:
                known = self._kept.get(key)
                if known is None:
                    mine = self._kept[key] = Future()
                self._kept.move_to_end(key)
                while len(self._kept) > self.entries:
                    self._kept.popitem(last=False)
            if known is None:
                return self._made(key, mine, make)
            with suppress(_NotMadeError):
                return known.result()

    def _made(self, key: Hashable, mine: "Future[T]", make: Callable[[], T]) -> T:
        try:
            mine.set_result(make())
        except BaseException:
            with self._lock:
                if self._kept.get(key) is mine:
                    del self._kept[key]
            mine.set_exception(_NotMadeError())  # who waited tries, and fails by himself
            raise
        return mine.result()

    def clear(self) -> None:
        """Forget everything."""
        with self._lock:
            self._kept.clear()

    def __len__(self) -> int:
        return len(self._kept)


class _NotMadeError(Exception):
    pass


def content(thing: Any) -> Hashable:
    """What data says, as a key: of data that differs in anything it says, in a type or in the sign of a zero, the keys
    differ. Data classes are known by the fields that they compare. Raises UnknownError for what is not data."""
    kind = thing.__class__
    if kind is str or thing is None:
        return thing
    if kind is float:
        return kind, thing.hex()
    if kind is int or kind is bool:
        return kind, thing
    if kind is tuple or kind is list:
        return kind, *map(content, thing)
    if kind is dict:
        return kind, *((content(key), content(value)) for key, value in thing.items())
    if kind is frozenset:
        return kind, frozenset(map(content, thing))
    return kind, *(content(getattr(thing, name)) for name in _compared(kind))


@cache
def _compared(kind: type) -> tuple[str, ...]:
    try:
        return tuple(field.name for field in fields(kind) if field.compare)
    except TypeError:
        raise UnknownError(f"a {kind.__name__} is not data") from None


def text_of(key: Any) -> str:
    """A key as text, the same in every process; keys that differ have different texts. Raises UnknownError for a key
    with what only this process knows, such as classes that are not part of the package."""
    kind = key.__class__
    if kind is tuple:
        return f"({','.join(map(text_of, key))})"
    if kind in (str, bytes, bool, int) or key is None:
        return repr(key)
    if kind is float:
        return str(key.hex())
    if kind is frozenset:
        return f"{{{','.join(sorted(map(text_of, key)))}}}"
    if isinstance(key, type) and (key.__module__ == "builtins" or key.__module__.startswith("lienumba.")):
        return f"<{key.__module__}.{key.__qualname__}>"
    raise UnknownError(f"{key!r} is known to this process alone")
