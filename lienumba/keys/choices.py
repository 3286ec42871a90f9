"""Keys whose values a registry knows: annotations of tables by their classes, and of names."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, Union

from pydantic import BaseModel, Discriminator, GetCoreSchemaHandler, GetJsonSchemaHandler, Tag, TypeAdapter
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

By = str | Callable[[Any], str | None]


@dataclass(frozen=True)
class OneOf:
    """A table that is one of the classes of a registry: `Annotated[Base, OneOf(REGISTRY)]`.

    by: the key that has the name of the class, or a function from a table to this name, or None for none of them.
    A class is built when the first table of it is validated: most scenarios name few of them.
    """

    registry: Mapping[str, type[BaseModel]]
    by: By = "type"

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self._validated)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        union: Any = Union[tuple(Annotated[section, Tag(name)] for name, section in self.registry.items())]  # noqa: UP007
        every: Any = Annotated[union, Discriminator(self.by)]
        return handler(TypeAdapter(every).core_schema)

    def _validated(self, value: object) -> BaseModel:
        """The table as its class has it. A table that names no class has the errors of a name that is not known."""
        if callable(self.by):
            name = self.by(value)
        else:
            name = value.get(self.by) if isinstance(value, dict) else getattr(value, self.by, None)
        known = name if isinstance(name, str) and name in self.registry else next(iter(self.registry))
        return _adapter(self.registry[known], known, self.by).validate_python(value)


@dataclass(frozen=True)
class _Tagged:
    """A union of one class: errors have the tag in their place, as those of a union of many."""

    tag: str
    by: By

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.tagged_union_schema({self.tag: handler(source)}, self.by)


@cache
def _adapter(section: type[BaseModel], tag: str, by: By) -> TypeAdapter[Any]:
    tagged: Any = Annotated[section, _Tagged(tag, by)]
    return TypeAdapter(tagged)


@dataclass(frozen=True)
class NameOf:
    """A name of a registry: `Annotated[str, NameOf(REGISTRY)]`; besides: names that are known, too; none: and
    "none", as the last."""

    registry: Mapping[str, Any]
    besides: tuple[str, ...] = ()
    none: bool = False

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return handler.generate_schema(Literal[(*self.besides, *self.registry, *(("none",) if self.none else ()))])
