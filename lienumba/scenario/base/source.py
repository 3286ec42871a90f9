"""The text of a Python function with all that it uses, so that it can be read again elsewhere."""

import ast
import dis
import inspect
import math
import sys
import sysconfig
import textwrap
from pathlib import Path
from types import CodeType, FunctionType, ModuleType

import numpy as np

from lienumba.errors import ScenarioError

COMPILED, CALLED = "is a function for Numba or of arrays, but a law is traced", "write a law that calls it"
ARRAY = "numpy.array("
HEADER = "from __future__ import annotations\n"
LIBRARIES = tuple(sysconfig.get_paths()[key] for key in ("stdlib", "platstdlib", "purelib", "platlib"))


def source_of(function: object, place: str) -> str:
    """The text; a ScenarioError that begins with the place if it cannot be written."""
    if hasattr(function, "py_func"):
        raise ScenarioError.at(f"{place}.function", COMPILED, CALLED)
    if not isinstance(function, FunctionType) or function.__name__ == "<lambda>":
        kind = "lambda" if inspect.isfunction(function) else type(function).__name__
        raise ScenarioError.at(f"{place}.function", f"must be a plain function, written with def, but is a {kind}")
    writer = _Writer(place)
    writer.take(function)
    return HEADER + "".join(writer.pieces.values())


class _Writer:
    """pieces: the text behind each name, what is used first."""

    def __init__(self, place: str) -> None:
        self.place = place
        self.pieces: dict[str, str] = {}

    def take(self, f: FunctionType) -> None:
        self.pieces[f.__name__] = ""
        try:
            text = textwrap.dedent(inspect.getsource(f))
            node = ast.parse(text).body[0]
        except (OSError, TypeError, SyntaxError, IndexError):
            node = ast.Pass()
        if not isinstance(node, ast.FunctionDef):
            raise ScenarioError.at(
                f"{self.place}.function", f"the text of {f.__name__} is not known", "write it with def, in a file"
            )
        if f.__code__.co_freevars:
            raise ScenarioError.at(
                f"{self.place}.function",
                f"{f.__name__} uses {f.__code__.co_freevars[0]} of the function around it",
                "make it a parameter",
            )
        around = [*node.decorator_list, *node.args.defaults, *(x for x in node.args.kw_defaults if x is not None)]
        names = {n.id: None for x in around for n in ast.walk(x) if isinstance(n, ast.Name)}
        for name in (*names, *_names(f.__code__)):
            if name in f.__globals__ and name not in self.pieces:
                self.use(name, f.__globals__[name], f)
        del self.pieces[f.__name__]
        self.pieces[f.__name__] = text

    def use(self, name: str, value: object, f: FunctionType) -> None:
        literal, value = _literal(value), getattr(value, "py_func", value)  # of a function for Numba that in Python
        if literal is not None:
            if ARRAY in literal:
                self.pieces["numpy"] = "import numpy\n"
            self.pieces[name] = f"{name} = {literal}\n"
        elif hasattr(value, "written"):  # a function of a library
            self.pieces[name] = value.written(name)
        elif isinstance(value, ModuleType) and _of_library(value):
            self.pieces[name] = f"import {value.__name__} as {name}\n"
        elif isinstance(value, FunctionType) and not _of_library(inspect.getmodule(value)):
            self.take(value)
            if value.__name__ != name:
                self.pieces[name] = f"{name} = {value.__name__}\n"
        elif callable(value) and _of_library(inspect.getmodule(value)) and "." not in _name_of(value):
            self.pieces[name] = f"from {value.__module__} import {_name_of(value)} as {name}\n"
        else:
            raise ScenarioError.at(
                f"{self.place}.function",
                f"{f.__name__} uses {name}, which cannot be written into a file",
                "make it a parameter, or a function or number of its own",
            )


def _name_of(value: object) -> str:
    """By which a module knows a function or a class; with a dot where it does not."""
    return str(getattr(value, "__qualname__", "."))


def _names(code: CodeType) -> list[str]:
    """The global names that a function may use, those of functions inside it included; attributes are none."""
    own = [x.argval for x in dis.get_instructions(code) if x.opname in ("LOAD_GLOBAL", "LOAD_NAME")]
    inner = [name for c in code.co_consts if isinstance(c, CodeType) for name in _names(c)]
    return list(dict.fromkeys((*own, *inner)))


def _of_library(module: ModuleType | None) -> bool:
    """Whether a module is installed wherever the text may be read."""
    if module is None or module.__name__ == "__main__":
        return False
    if module.__name__.partition(".")[0] in {"lienumba", *sys.builtin_module_names}:
        return True
    file = getattr(module, "__file__", None)
    return file is None or any(Path(file).is_relative_to(folder) for folder in LIBRARIES)


def _literal(value: object) -> str | None:
    """How a constant is written; None for what is none."""
    if hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return f'float("{value}")'
    if value is None or isinstance(value, bool | int | float | str):
        return repr(value)
    if isinstance(value, np.ndarray) and value.dtype.kind in "bif":
        return f"{ARRAY}{_literal(value.tolist())}, '{value.dtype.str}')"
    if isinstance(value, tuple | list):
        inner = [_literal(x) for x in value]
        if any(x is None for x in inner):
            return None
        text = ", ".join(x for x in inner if x is not None)
        return f"[{text}]" if isinstance(value, list) else f"({text},)" if len(inner) == 1 else f"({text})"
    return None
