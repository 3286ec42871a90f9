"""Python functions of a scenario: where their text comes from, and the function that it defines.

The text of every file travels with the scenario (section [files]), so that the dataset tells what was run. A function
that is handed over in Python is written out with all that it uses, and read again from there: both ways run the same.
"""

import ast
import inspect
import linecache
import os
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import lru_cache
from os.path import isfile
from pathlib import Path
from typing import Any

from lienumba.errors import Problem, ScenarioError
from lienumba.scenario.base.paths import MEASURES
from lienumba.scenario.base.problems import tables
from lienumba.scenario.base.source import CALLED, COMPILED, source_of
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.words import listed, option, printable, readable, suggestion

PYTHON = "python"
UNTRACED = ("jit", "foreign", "batched")  # of lienumba: they make functions that are not traced


def embedded(raw: Keys, folder: Path) -> Keys:
    """The scenario with the text of every Python file that its laws name, relative to this folder."""
    files = dict(table_in(raw, "files"))
    raw = _with_functions(raw, lambda place, function: _embed(place, function, files, folder))
    return {**raw, **({"files": files} if files else {})}


def files_of(raw: Keys) -> list[str]:
    """The Python files that a scenario brings or names."""
    named = dict.fromkeys(table_in(raw, "files"))
    _with_functions(raw, lambda place, function: named.setdefault(str(function).rpartition(":")[0]))
    return list(named)


def check_allowed(raw: Keys, where: str, doing: str, allow_code: bool) -> None:
    """A ScenarioError if the scenario of a dataset brings code that may not run."""
    files = files_of(raw)
    if files and not allow_code:
        raise ScenarioError.at(
            where,
            f"brings Python code, which {doing} runs: {listed(files)}",
            f"read it in the attribute `scenario`, and if you trust it, give {option('allow_code')}",
        )


def check_own(raw: Keys, file: Path) -> None:
    """A ScenarioError if a TOML file has code that is not plainly its owner's: within itself, or elsewhere than in
    Python files of the same user, beside it or below."""
    problems, trust = [], f"nothing of it was run; read it, and if you trust it, give {option('allow_code')}"
    if table_in(raw, "files"):
        within = listed(map(printable, table_in(raw, "files")))
        problems.append(Problem(printable(str(file)), f"brings Python code in itself, {within}", trust))
    for named in files_of(raw):
        foreign = None if named in table_in(raw, "files") else _foreign(file.parent, named)
        if foreign:
            problems.append(Problem(printable(str(file)), f"names Python code {foreign}: {printable(named)}", trust))
    if problems:
        raise ScenarioError(*problems)


def _foreign(folder: Path, name: str) -> str:
    """Why a file that a scenario in a folder names is not plainly the user's own; empty where it is, or is missing."""
    path = folder / name
    try:
        owner = path.stat().st_uid
        within = path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):
        return ""  # told where it is read
    if not within:
        return "outside its folder"
    if hasattr(os, "geteuid") and owner not in (os.geteuid(), 0):
        return "that is another user's"
    return ""


def beside(raw: Keys, stem: str) -> tuple[dict[str, Any], dict[str, str]]:
    """The scenario with its files as files beside its own, whose name begins with stem, and their texts by name."""
    files = table_in(raw, "files")
    names = {file: f"{stem}_{file}" for file in files}
    rest: dict[str, Any] = {key: x for key, x in _renamed(raw, names).items() if key != "files"}
    return rest, {names[file]: str(text) for file, text in files.items()}


def without_clash(raw: Keys, taken: object) -> Keys:
    """The scenario with other names for those of its files that are taken by other texts."""
    files = raw.get("files")
    if not isinstance(files, dict) or not isinstance(taken, dict):
        return raw
    names = {file: _free(file, text, taken) for file, text in files.items()}
    return {**_renamed(raw, names), "files": {names[file]: text for file, text in files.items()}}


def _renamed(raw: Keys, names: Mapping[str, str]) -> Keys:
    """The scenario with other names for files, in what names functions of them."""

    def named(place: str, function: object) -> Any:
        file, _, name = str(function).rpartition(":")
        return f"{names[file]}:{name}" if file in names else function

    return _with_functions(raw, named)


def _with_functions(raw: Keys, change: Callable[[str, Any], Any]) -> Keys:
    """The scenario with change(place, function) for the function of each law and each measure; a law that extends
    another one may leave out the type."""
    raw = _with_reducers(raw, change)
    model = raw.get("model")
    if not isinstance(model, dict):
        return raw
    changed: dict[str, Any] = dict(_with_reducers(model, change))
    for kind in ("forces", "joints"):
        for n, law in enumerate(tables(model.get(kind))):
            if "function" in law and law.get("type", PYTHON) == PYTHON:
                function = change(f"model.{kind}.{law.get('name')}", law["function"])
                changed[kind] = [*changed[kind][:n], {**law, "function": function}, *changed[kind][n + 1 :]]
    return {**raw, "model": changed}


def _with_reducers(section: Keys, change: Callable[[str, Any], Any]) -> Keys:
    """The section with change(place, function) for the function of each measure."""
    every = section.get(MEASURES)
    if not isinstance(every, list):
        return section
    changed = [
        {**x, "function": change(f"{MEASURES}.{x.get('name')}", x["function"])}
        if isinstance(x, dict) and x.get("function") is not None
        else x
        for x in every
    ]
    return {**section, MEASURES: changed}


def _free(file: str, text: object, taken: Keys) -> str:
    """A name for a text among others: its own, or with a number."""
    key, number = file, 2
    while taken.get(key, text) != text:
        key, number = f"{Path(file).stem}_{number}.py", number + 1
    return key


def _embed(place: str, function: object, files: Keys, folder: Path) -> Any:
    """The reference to a function, whose text is among the files."""
    if callable(function):
        name = getattr(function, "__name__", "law")
        text = source_of(function, place)
    else:
        file, _, name = str(function).rpartition(":")
        if not file or not name or file in files:
            return function
        path = folder / file
        try:
            if not path.is_file():
                raise ScenarioError.at(f"{place}.function", f"there is no file {file}", "check the path", function)
            text = path.read_text(encoding="utf-8-sig")
        except (OSError, ValueError) as error:
            raise ScenarioError.at(f"{place}.function", f"{file} cannot be read: {error}", value=function) from None
        _refuse_siblings(f"{place}.function", function, path, text)
    key = _free(f"{name if callable(function) else Path(file).stem}.py", text, files)
    files[key] = text
    return f"{key}:{name}"


def _refuse_siblings(place: str, function: object, path: Path, text: str) -> None:
    """A file must be complete in itself: what it imports from beside it would not travel with the scenario."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return  # told when it is run
    for node in ast.walk(tree):
        if not isinstance(node, ast.Import | ast.ImportFrom):
            continue
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module or ""]
        for name in (name.partition(".")[0] for name in names):
            beside = path.parent / name
            known = name in ("", "lienumba") or name in sys.stdlib_module_names
            if not known and (isfile(f"{beside}.py") or isfile(beside / "__init__.py")):
                raise ScenarioError.at(
                    place,
                    f"line {node.lineno} imports {name} from beside {path.name}, but only {path.name} is kept "
                    "with the scenario",
                    "put what it uses into this file",
                    function,
                )


def function_of(place: str, reference: str, files: Mapping[str, str]) -> Callable[..., Any]:
    """The function behind "arm.py:pd"."""
    at, value = f"{place}.function", reference
    file, _, name = reference.rpartition(":")
    if not file or not name.isidentifier():
        raise ScenarioError.at(at, "must name a file and a function in it", 'write "arm.py:pd"', value)
    if file not in files:
        raise ScenarioError.at(at, f"there is no file {file}", suggestion(file, files), value)
    try:
        namespace = _namespace(file, files[file])
    except (Exception, SystemExit) as error:
        raise ScenarioError.at(at, f"{file} cannot be run: {said_of(error, file)}", "correct it", value) from None
    function = namespace.get(name)
    if hasattr(function, "py_func"):
        raise ScenarioError.at(at, COMPILED, CALLED, value)
    if not inspect.isfunction(function):
        known = [key for key, value in namespace.items() if inspect.isfunction(value)]
        raise ScenarioError.at(at, f"{file} has no function {name}", suggestion(name, known), value)
    return function


def identities(files: Keys) -> dict[str, str]:
    """Return the identities of functions in Python files that are not traced, by file and name. Runs such files."""
    from lienumba.compiler.foreign.calls import Function

    found: dict[str, str] = {}
    for file, text in ((file, str(text)) for file, text in files.items()):
        with suppress(Exception, SystemExit):  # told where the law is built
            space = _namespace(file, text) if "lienumba" in text and any(name in text for name in UNTRACED) else {}
            found |= {f"{file}:{name}": x.identity() for name, x in space.items() if isinstance(x, Function)}
    return found


@lru_cache(maxsize=64)
def _namespace(file: str, text: str) -> Keys:
    namespace: Keys = {"__name__": Path(file).stem, "__file__": file}
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    if sys.modules.get("dask", namespace) is None:  # hidden from xarray by the command line; this file may want it
        del sys.modules["dask"]
    exec(compile(text, file, "exec"), namespace)
    return namespace


def said_of(error: BaseException, file: str) -> str:
    """An error with the line of the user's file that it comes from."""
    said = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    line = line_of(error, file)
    return readable(f"{line}: {said}" if line else said)


def line_of(error: BaseException, file: str) -> str:
    """The line of the user's file that an error comes from; empty where it comes from elsewhere."""
    line = error.lineno if isinstance(error, SyntaxError) else None
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == file:
            line = trace.tb_lineno
        trace = trace.tb_next
    return f"line {line}, `{linecache.getline(file, line).strip()}`" if line else ""
