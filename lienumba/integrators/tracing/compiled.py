"""The memo of programs: the same structure is traced, compiled and loaded once in a process, whatever numbers it has.

A program follows from the template of a model (`tracer.split`), in which every number is a slot but for the exact
0, 1 and -1 that shape it, from the method, the selection of rows, a few limits, and what the names of elements mean.
These are the key. A function of the user's own is known by its code and by what it records on symbols: what it reads
elsewhere, such as a variable of its file, is in there with the value that it has now.
"""

from collections.abc import Hashable, Iterable
from dataclasses import replace
from typing import Any

from lienumba.compiler import emit, segments
from lienumba.compiler.memo import Memo, UnknownError, content
from lienumba.compiler.symbols import Symbol
from lienumba.groups.state import ELEMENT
from lienumba.integrators.layout import TIME
from lienumba.integrators.tracing import program, step_kernels
from lienumba.integrators.tracing.machine import Machine, compile_program
from lienumba.integrators.tracing.program import Method, Program
from lienumba.integrators.tracing.row_selection import UNIQUE, RowSelection
from lienumba.integrators.tracing.tracer import split, symbolic
from lienumba.keys.registry import Registry
from lienumba.mechanics.elements import user_laws
from lienumba.mechanics.mechanism.kinematics import Instant, still
from lienumba.mechanics.mechanism.model import Code, Model

Compiled = tuple[Program, Machine]  # the program without its kernels, which are large and have done their work

PROGRAMS: Memo[Compiled] = Memo(64)  # kept in a process, those used last; a small one takes 100 KiB, a large one MiB


def compiled(model: Model, method: Method, selection: RowSelection = UNIQUE, fixed: bool = True) -> Compiled:
    """The program of this mechanism and method (see `program.build`), and that as machine code."""

    def make() -> Compiled:
        made = program.build(model, method, selection, fixed)
        machine = compile_program(made)
        return replace(made, kernels={}), machine

    key = key_of(model, method, selection, fixed)
    return make() if key is None else PROGRAMS.get(key, make)


def key_of(model: Model, method: Method, selection: RowSelection, fixed: bool) -> Hashable | None:
    """What decides about a program; None where that cannot be told."""
    template, _ = split(model)
    rows = selection.rows, selection.masks, selection.singular
    cuts = emit.LONG, emit.REPEATED, segments.SIZE, segments.SHORTEST, segments.LONGEST, segments.MEAN
    limits = step_kernels.INLINE, cuts, Registry.changes
    codes = [*(joint.code for joint in template.joints), *(force.code for force in template.forces)]
    own = [code for code in codes if code is not None]
    try:
        without = replace(
            template,
            joints=tuple(replace(joint, code=_named(joint.code)) for joint in template.joints),
            forces=tuple(replace(force, code=_named(force.code)) for force in template.forces),
        )
        said = content((without if own else template, method, rows, fixed, limits))
        return said, *(code.function.__code__ for code in own), _recorded(template) if own else None
    except (UnknownError, AttributeError):
        return None


def _named(code: Code | None) -> Code | None:
    """What is known of a law but for its function."""
    return None if code is None else replace(code, function=None)  # type: ignore[arg-type]


def _recorded(template: Model) -> Hashable:
    """What the functions of the user's own compute, as they record it on symbols."""
    graph, model = symbolic(template)
    bodies = tuple(graph.inputs("state", ELEMENT, ELEMENT * i) for i in range(len(model.bodies)))
    now = Instant(bodies, graph.input("clock", TIME))
    view = still(now, tuple(range(len(bodies))))
    returned: list[Hashable] = []
    for index, joint in enumerate(model.joints):
        if joint.code is not None:
            returned.append(_numbers(user_laws.residual(model, index, view)))
    for force in model.forces:
        if force.code is None:
            continue
        if force.code.returns == user_laws.POTENTIAL:
            returned.append(_numbers([user_laws.energy(model, force, now, view)]))
            continue
        loads, states = user_laws.outcome(model, force, now)
        for load in loads:
            acts = load.kind, load.target, load.frame, load.coordinate
            returned.append((acts, _numbers(load.value), _numbers(load.at)))
        returned.append(_numbers(states))
    return graph.recorded(), tuple(returned)


def _numbers(values: Iterable[Any]) -> Hashable:
    """What a law returns: symbols by their places in the graph."""
    return tuple(("symbol", x.id) if isinstance(x, Symbol) else content(x) for x in values)
