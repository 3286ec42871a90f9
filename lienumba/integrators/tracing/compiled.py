"""The memo of programs: the same structure is traced, compiled and loaded once in a process, whatever numbers it has.

A program follows from the template of a model (`template.split`), in which every number is a slot but for the exact
0, 1 and -1 that shape it, from the method, the selection of rows, a few limits, and what the names of elements mean.
These are the key, with which other processes find it too (`stored`). A function of the user's own is known by its
code and by what it records on symbols (`law_keys`).
"""

from collections.abc import Callable, Hashable
from dataclasses import replace

from lienumba.compiler import emit, segments
from lienumba.compiler.memo import Memo, UnknownError, content
from lienumba.compiler.symbols import uncollected
from lienumba.integrators.tracing import law_keys, machine, program, step_kernels, stored
from lienumba.integrators.tracing.machine import Machine
from lienumba.integrators.tracing.program import Method, Outline
from lienumba.integrators.tracing.row_selection import UNIQUE, RowSelection
from lienumba.integrators.tracing.template import split
from lienumba.keys.registry import Registry
from lienumba.mechanics.mechanism.model import Code, Model

Compiled = tuple[Outline, Machine]

PROGRAMS: Memo[Compiled] = Memo(64)  # kept in a process, those used last; a small one takes 100 KiB, a large one MiB


def compiled(
    model: Model, method: Method, selection: RowSelection = UNIQUE, fixed: bool = True,
    begin: Callable[[], None] = lambda: None,
) -> Compiled:  # fmt: skip
    """The program of this mechanism and method (see `program.build`), and that as machine code; begin: called where it
    has to be compiled, before."""

    def make() -> Compiled:
        found = None if key is None else stored.find(key)
        if found is None:
            begin()
            with uncollected():
                made = program.build(model, method, selection, fixed)
                found = made.outline(), machine.compile_kernels(made)
                del made
            if key is not None:
                stored.keep(key, *found)
        outline, code = found
        return outline, machine.load(outline, code)

    key = key_of(model, method, selection, fixed)
    return make() if key is None else PROGRAMS.get((Registry.changes, key), make)


def key_of(model: Model, method: Method, selection: RowSelection, fixed: bool) -> Hashable | None:
    """What decides about a program; None where that cannot be told."""
    template, _ = split(model)
    rows = selection.rows, selection.masks, selection.singular
    cuts = emit.LONG, emit.REPEATED, segments.SIZE, segments.SHORTEST, segments.LONGEST, segments.MEAN
    limits = step_kernels.INLINE, cuts, emit.VALUES.lanes
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
