"""Programs on disk: what was traced once is loaded by later processes without tracing.

An entry holds the outline of a program and the names of its object code in the cache, as JSON. It is found by the key
of the program (`compiled.key_of`), by what names of elements mean, by the CPU, and by all sources that may take part in
tracing: what these say now is all that tracing could read.
"""

import functools
import hashlib
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from fractions import Fraction
from typing import Any

from pydantic import TypeAdapter, ValidationError

from lienumba.compiler import cache, native
from lienumba.compiler.memo import UnknownError, text_of
from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import GROUPS
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.tracing.machine import ObjectCode
from lienumba.integrators.tracing.program import Outline
from lienumba.keys.registry import Registry
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.drivers import DRIVERS
from lienumba.mechanics.elements.events import ACTIONS
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.quantities import NOISES, QUANTITIES
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.mechanics.system.projection import WEIGHTS

TRACING = (  # all that takes part; a test compares
    "errors.py", "words.py", "laws.py", "numerics", "groups", "keys", "compiler", "mechanics", "integrators",
)  # fmt: skip
REGISTRIES: tuple[Registry[Any], ...] = (
    METHODS, GROUPS, COORDINATES, DRIVERS, ACTIONS, CONTACTS, FORCES, JOINTS, QUANTITIES, NOISES, OUTPUT_VARIABLES,
    WEIGHTS,
)  # fmt: skip


@dataclass(frozen=True)
class Entry:
    """`kernels`: the name of the object code of each in the cache."""

    outline: Outline
    kernels: dict[str, str]
    work_rows: int


def find(key: Hashable) -> tuple[Outline, ObjectCode] | None:
    """The program of this key, if it is there whole."""
    name = name_of(key)
    stored = None if name is None else cache.recall(name)
    if stored is None:
        return None
    try:
        entry = _adapter().validate_json(stored)
    except ValidationError:
        return None
    objects = {kernel: cache.recall(name) for kernel, name in entry.kernels.items()}
    whole = {kernel: code for kernel, code in objects.items() if code is not None}
    if len(whole) < len(objects):
        return None
    return entry.outline, ObjectCode(whole, entry.kernels, entry.work_rows)


def keep(key: Hashable, outline: Outline, code: ObjectCode) -> None:
    """Write a program, whose object code is there already."""
    if name := name_of(key):
        cache.keep(name, _adapter().dump_json(Entry(outline, code.entries, code.work_rows)))


def name_of(key: Hashable) -> str | None:
    """The name of the entry of a key; None where another process could not tell what it means."""
    try:
        elements = _elements(Registry.changes)
        if elements is None:
            return None
        said = (sources(), elements, *native.cpu(), str(native.LEVEL), text_of(key))
        return cache.name_of("\n".join(said), "program")
    except UnknownError:
        return None


@functools.cache
def _adapter() -> TypeAdapter[Entry]:
    return TypeAdapter(Entry)


@functools.cache
def sources() -> str:
    """A digest of the sources that take part in tracing."""
    places = (cache.PACKAGE / name for name in TRACING)
    files = sorted(path for place in places for path in ([place] if place.is_file() else place.rglob("*.py")))
    digest = hashlib.sha256()
    for path in files:
        digest.update(str(path.relative_to(cache.PACKAGE)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


@functools.lru_cache(1)
def _elements(changes: int) -> str | None:
    """What names of elements mean; None if one of them is not of the package, since its source is not known."""
    try:
        return ";".join(f"{name}={_said(record)}" for registry in REGISTRIES for name, record in registry.items())
    except UnknownError:
        return None


def _said(x: Any) -> str:
    """What a record of a registry says; classes and functions by their names."""
    if isinstance(x, type) or (callable(x) and hasattr(x, "__qualname__")):
        if not x.__module__.startswith("lienumba."):
            raise UnknownError(f"{x!r} is not of this package")
        return f"{x.__module__}.{x.__qualname__}"
    if is_dataclass(x):
        return f"{_said(type(x))}({','.join(_said(getattr(x, field.name)) for field in fields(x))})"
    if isinstance(x, tuple | list):
        return f"({','.join(map(_said, x))})"
    if isinstance(x, Mapping):
        return f"{{{','.join(f'{_said(key)}:{_said(value)}' for key, value in x.items())}}}"
    if isinstance(x, str | int | float | Fraction) or x is None:
        return repr(x)
    raise UnknownError(f"a {type(x).__name__} is not known to other processes")
