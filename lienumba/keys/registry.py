"""Registries: what a scenario can name, by its name. Whatever is derived from one is told when it changes."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import ClassVar, Generic, TypeVar, get_args

from pydantic import BaseModel

from lienumba.words import suggestion

T = TypeVar("T")


class Registry(Mapping[str, T], Generic[T]):
    """Records by name, in the order in which they were added.

    what: a record of it, in words ("joint"); name: of a record. Every function among `listeners` is called whenever
    the records have changed. `changes`: how often those of any registry have.
    """

    changes: ClassVar[int] = 0

    def __init__(self, what: str, name: Callable[[T], str]) -> None:
        self.what = what
        self.listeners: list[Callable[[], None]] = []
        self._name = name
        self._records: dict[str, T] = {}

    def __getitem__(self, name: str) -> T:
        try:
            return self._records[name]
        except KeyError:
            raise KeyError(f'there is no {self.what} "{name}"; {suggestion(str(name), self._records)}') from None

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self._records

    def __iter__(self) -> Iterator[str]:
        return iter(self._records)

    def __len__(self) -> int:
        return len(self._records)

    def add(self, record: T) -> T:
        """Add a record; as a decorator, a class."""
        name = self._name(record)
        if name in self._records:
            raise ValueError(f'there is a {self.what} "{name}" already; give this one another name')
        self._records[name] = record
        try:
            self._tell()
        except BaseException:
            del self._records[name]
            self._tell()
            raise
        return record

    @contextmanager
    def temporarily(self, *records: T) -> Iterator[None]:
        """With these records besides, as long as the context lasts."""
        added: list[str] = []
        try:
            for record in records:
                self.add(record)
                added.append(self._name(record))
            yield
        finally:
            for name in added:
                del self._records[name]
            self._tell()

    def _tell(self) -> None:
        Registry.changes += 1
        for listener in self.listeners:
            listener()


def literal(key: str) -> Callable[[type[BaseModel]], str]:
    """The name of a class of keys: the only text that its field `key` allows."""

    def name(section: type[BaseModel]) -> str:
        choices = get_args(section.model_fields[key].annotation)
        if len(choices) != 1:
            raise TypeError(f"{section.__name__}.{key} must be a Literal of one text, which is the name of the class")
        return str(choices[0])

    return name
