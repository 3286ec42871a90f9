"""What tells laws of the user's own apart: the code of their functions, and what they compute.

Numbers that a function reads elsewhere, such as a variable of its file, are known by what it records on symbols with
the values that they have now.
"""

import sys
from collections.abc import Hashable, Iterable
from types import CellType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

from lienumba.compiler.memo import content
from lienumba.compiler.symbols import Symbol
from lienumba.groups.state import ELEMENT
from lienumba.integrators.layout import TIME
from lienumba.integrators.tracing.template import symbolic
from lienumba.mechanics.elements import user_laws
from lienumba.mechanics.mechanism.kinematics import Instant, still
from lienumba.mechanics.mechanism.model import Model

FOREIGN = {"lienumba", "numpy", *sys.stdlib_module_names}  # packages whose functions are known by their versions


def codes(function: Any) -> Hashable:
    """The code of a function, and of all functions and classes that it may call, as a key."""
    found: list[Hashable] = []
    seen: set[int] = set()
    _look(function, (), found, seen)
    return tuple(found)


def _look(thing: Any, names: Iterable[str], found: list[Hashable], seen: set[int]) -> None:
    """Add the code behind `thing` to what was found; names: what may be read of it, if it is a module."""
    if isinstance(thing, ModuleType):
        if _own(thing.__name__):
            for name in names:
                if not isinstance(read := getattr(thing, name, None), ModuleType):
                    _look(read, (), found, seen)
        return
    if isinstance(thing, MethodType):
        _look(thing.__self__, (), found, seen)
        thing = thing.__func__
    if not isinstance(thing, FunctionType | type):
        thing = type(thing)
    if id(thing) in seen or not _own(thing.__module__ or ""):
        return
    seen.add(id(thing))
    if isinstance(thing, type):
        for inside in (*thing.__bases__, *vars(thing).values()):
            inside = inside.fget if isinstance(inside, property) else inside
            _look(getattr(inside, "__func__", inside), (), found, seen)
        return
    found.append(_code(thing.__code__))
    read = list(_names(thing.__code__))
    cells = [cell.cell_contents for cell in thing.__closure__ or () if cell != CellType()]
    globals_ = [thing.__globals__[name] for name in read if name in thing.__globals__]
    for value in (*cells, *globals_, *(thing.__defaults__ or ()), *(thing.__kwdefaults__ or {}).values()):
        _look(value, read, found, seen)


def _own(module: str) -> bool:
    """Whether a module is of the user's own."""
    return module.partition(".")[0] not in FOREIGN and module != "builtins"


def _names(code: CodeType) -> Iterable[str]:
    """All names that a code reads, with those of functions inside it."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _code(code: CodeType) -> Hashable:
    """What a code does; its file and its lines do not count."""
    counts = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags
    names = code.co_name, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
    return code.co_code, getattr(code, "co_exceptiontable", b""), counts, names, tuple(map(_constant, code.co_consts))


def _constant(x: Any) -> Hashable:
    if isinstance(x, CodeType):
        return _code(x)
    if isinstance(x, tuple | frozenset):
        return type(x), type(x)(map(_constant, x))
    return type(x), repr(x)


def recorded(template: Model) -> Hashable:
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
