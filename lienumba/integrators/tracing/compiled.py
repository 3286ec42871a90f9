"""The cache of programs: the same structure is traced, compiled and loaded once in a process, whatever numbers it has,
and once on a machine.

A program follows from the template of a model (`template.split`), in which every number is a slot but for the exact
0, 1 and -1 that shape it, from the method, the selection of rows, a few limits, and what the names of elements mean.
These are the key. A function of the user's own is known by its code and by what it records on symbols (`law_keys`).
An entry on disk holds the outline of a program and the names of its object code, as JSON. It is found by the key, by
what names of elements mean, by the CPU, and by all sources that may take part in tracing.
"""

import functools
import hashlib
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from typing import Any

from pydantic import TypeAdapter, ValidationError

from lienumba.compiler import cache, emit, native, segments
from lienumba.compiler.memo import Memo, UnknownError, content, text_of
from lienumba.compiler.symbols import uncollected
from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import GROUPS
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.tracing import law_keys, machine, program, step_kernels
from lienumba.integrators.tracing.implicit import stage_system
from lienumba.integrators.tracing.machine import Machine, ObjectCode
from lienumba.integrators.tracing.program import Method, Outline
from lienumba.integrators.tracing.row_selection import UNIQUE, RowSelection
from lienumba.integrators.tracing.template import split
from lienumba.keys.registry import Registry
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.drivers import DRIVERS
from lienumba.mechanics.elements.events import ACTIONS
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.quantities import NOISES, QUANTITIES
from lienumba.mechanics.mechanism.model import Code, Model
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.mechanics.system.projection import WEIGHTS

Compiled = tuple[Outline, Machine]

TRACING = (  # all that takes part; a test compares
    "errors.py", "words.py", "laws.py", "numerics", "groups", "keys", "compiler", "mechanics", "integrators",
)  # fmt: skip
REGISTRIES: tuple[Registry[Any], ...] = (
    METHODS, GROUPS, COORDINATES, DRIVERS, ACTIONS, CONTACTS, FORCES, JOINTS, QUANTITIES, NOISES, OUTPUT_VARIABLES,
    WEIGHTS,
)  # fmt: skip
PROGRAMS: Memo[Compiled] = Memo(64)  # kept in a process, those used last; a small one takes 100 KiB, a large one MiB


def compiled(
    model: Model, method: Method, selection: RowSelection = UNIQUE, fixed: bool = True,
    begin: Callable[[], None] = lambda: None,
) -> Compiled:  # fmt: skip
    """The program of this mechanism and method (see `program.build`), and that as machine code; begin: called where it
    has to be compiled, before."""

    def make() -> Compiled:
        found = None if key is None else find(key)
        if found is None:
            begin()
            with uncollected():
                made = program.build(model, method, selection, fixed)
                found = made.outline(), machine.compile_kernels(made)
                del made
            if key is not None:
                keep(key, *found)
        outline, code = found
        return outline, machine.load(outline, code)

    key = key_of(model, method, selection, fixed)
    return make() if key is None else PROGRAMS.get((Registry.changes, key), make)


def key_of(model: Model, method: Method, selection: RowSelection, fixed: bool) -> Hashable | None:
    """What decides about a program; None where that cannot be told."""
    template, _ = split(model)
    rows = selection.rows, selection.masks, selection.singular
    cuts = emit.LONG, emit.REPEATED, segments.SIZE, segments.SHORTEST, segments.LONGEST, segments.MEAN
    limits = step_kernels.INLINE, stage_system.LOOPS, cuts, emit.VALUES.lanes
    codes = [*(joint.code for joint in template.joints), *(force.code for force in template.forces)]
    own = [code for code in codes if code is not None]
    try:
        without = replace(
            template,
            joints=tuple(replace(joint, code=_named(joint.code)) for joint in template.joints),
            forces=tuple(replace(force, code=_named(force.code)) for force in template.forces),
        )
        said = content((without if own else template, method, rows, fixed, limits))
        return said, *(law_keys.codes(code.function) for code in own), law_keys.recorded(template) if own else None
    except (UnknownError, AttributeError):
        return None


def _named(code: Code | None) -> Code | None:
    """What is known of a law but for its function."""
    return None if code is None else replace(code, function=None)  # type: ignore[arg-type]


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
