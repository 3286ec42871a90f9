"""What a class of keys says of them beyond what they may hold, as annotations that pydantic passes over."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import Any, Literal, TypeVar, get_args, get_origin

from annotated_types import Ge, Gt, Le, MaxLen
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


def is_not_negative(section: type[BaseModel], key: str) -> bool:
    """Whether the number of a key must be at least 0."""
    field = section.model_fields[key]
    return any(isinstance(x, Ge) and x.ge == 0 for x in (*field.metadata, *_annotations(field.annotation)))


def at_most(section: type[BaseModel], key: str) -> float:
    """The largest value that a key's number may have; infinite if there is none."""
    field = section.model_fields[key]
    every = (*field.metadata, *_annotations(field.annotation))
    return min((float(str(x.le)) for x in every if isinstance(x, Le)), default=inf)


def is_text(section: type[BaseModel], key: str) -> bool:
    """Whether the values of a key are texts, such as names and choices, or true or false, and never numbers."""
    leaves = set(_leaves(section.model_fields[key].annotation))
    return bool({str, bool} & leaves) and not {float, int} & leaves


def has_choices(section: type[BaseModel], key: str) -> bool:
    """Whether the value of a key may be one of some texts."""
    return any(isinstance(x, str) for x in _literals(section.model_fields[key].annotation))


def is_choice(section: type[BaseModel], key: str) -> bool:
    """Whether the value of a key is one of some whole numbers, or a count, and never any number."""
    leaves = list(_leaves(section.model_fields[key].annotation))
    return int in leaves and float not in leaves


def is_open_ended(section: type[BaseModel], key: str) -> bool:
    """Whether the value of a key is a list of any length."""
    field = section.model_fields[key]
    listed = [x for x in (field.annotation, *get_args(field.annotation)) if _is_list(x)]  # of a union, too
    said = [*field.metadata, *(y for x in listed for y in getattr(x, "__metadata__", ()))]
    said += [y for x in said if isinstance(x, FieldInfo) for y in x.metadata]
    return bool(listed) and not any(isinstance(x, MaxLen) for x in said)


def _is_list(annotation: object) -> bool:
    return get_origin(get_args(annotation)[0] if hasattr(annotation, "__metadata__") else annotation) is list


def _leaves(annotation: object) -> Iterator[type]:
    if get_origin(annotation) is Literal:
        yield from map(type, get_args(annotation))
    elif isinstance(annotation, type) and not get_args(annotation):
        yield annotation
    for x in get_args(annotation) if get_origin(annotation) is not Literal else ():
        yield from _leaves(x)


def _literals(annotation: object) -> Iterator[Any]:
    for x in get_args(annotation):
        yield from (x,) if get_origin(annotation) is Literal else _literals(x)


def _annotations(annotation: object) -> Iterator[Any]:
    for x in get_args(annotation):
        yield from x.metadata if isinstance(x, FieldInfo) else (x, *_annotations(x))
