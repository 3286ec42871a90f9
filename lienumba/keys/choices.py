"""Keys whose values a registry knows: annotations that pydantic reads anew whenever a class is rebuilt."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union

from pydantic import BaseModel, Discriminator, Field, GetCoreSchemaHandler, Tag
from pydantic_core import CoreSchema


@dataclass(frozen=True)
class OneOf:
    """A table that is one of the classes of a registry: `Annotated[Base, OneOf(REGISTRY)]`.

    by: the key that has the name of the class, or a function from a table to this name, or None for none of them.
    """

    registry: Mapping[str, type[BaseModel]]
    by: str | Callable[[Any], str | None] = "type"

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        if isinstance(self.by, str):
            union: Any = Union[tuple(self.registry.values())]  # noqa: UP007
            return handler.generate_schema(Annotated[union, Field(discriminator=self.by)])
        union = Union[tuple(Annotated[section, Tag(name)] for name, section in self.registry.items())]  # noqa: UP007
        return handler.generate_schema(Annotated[union, Discriminator(self.by)])


@dataclass(frozen=True)
class NameOf:
    """A name of a registry: `Annotated[str, NameOf(REGISTRY)]`; besides: names that are known, too; none: and
    "none", as the last."""

    registry: Mapping[str, Any]
    besides: tuple[str, ...] = ()
    none: bool = False

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return handler.generate_schema(Literal[(*self.besides, *self.registry, *(("none",) if self.none else ()))])
