"""What a class of keys says of them beyond what they may hold, as annotations that pydantic passes over."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeVar, get_args

from annotated_types import Gt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

T = TypeVar("T")


@dataclass(frozen=True)
class Unit:
    """The unit of a key's numbers: "m s-1"."""

    symbol: str


def facts(section: type[BaseModel], kind: type[T]) -> dict[str, T]:
    """The annotations of this kind, by the keys that have one."""
    return {key: x for key, field in section.model_fields.items() for x in field.metadata if isinstance(x, kind)}


def is_positive(section: type[BaseModel], key: str) -> bool:
    """Whether the number of a key must be above 0."""
    field = section.model_fields[key]
    return any(isinstance(x, Gt) and x.gt == 0 for x in (*field.metadata, *_annotations(field.annotation)))


def _annotations(annotation: object) -> Iterator[Any]:
    for x in get_args(annotation):
        yield from x.metadata if isinstance(x, FieldInfo) else (x, *_annotations(x))
