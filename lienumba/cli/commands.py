"""Commands as typer has them, but for what is told of a command line that makes no sense: one sentence with what is
wrong and what to do, as of every other mistake."""

import inspect
import os
import sys
from collections.abc import Sequence
from typing import Any, Literal, get_args, get_origin

from typer.core import TyperCommand, TyperGroup

from lienumba.words import ALIKE, listed, near, printable, show

BAD_LINE = 2  # exit code
SECTIONS = {"study": "a study is a section of a scenario: write [study] there, then lienumba run FILE.toml"}
OF_FILES = {".toml": "run", ".nc": "info", ".urdf": "import", ".xml": "import"}  # commands that take such files


class LineError(Exception):
    """`str(error)` is a sentence about the command line."""


class _Told:
    """What commands and the group of them have in common."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Options without a value stand in the help without one, `--help` too."""
        found: list[Any] = super().get_params(ctx)  # type: ignore[misc]
        for option in (option for option in found if getattr(option, "is_flag", False)):
            option.metavar = ""
        return found

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """As typer does, with sentences of our own."""
        given = [*args]
        try:
            found: list[str] = super().parse_args(ctx, args)  # type: ignore[misc]
        except Exception as error:
            alone = isinstance(self, TyperGroup) and not given  # then there is the help
            if alone or not hasattr(error, "format_message"):
                raise
            raise LineError(_sentence(error, self.get_params(ctx), ctx, given)) from None
        return found


class Command(_Told, TyperCommand):
    """A command."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """What nothing takes is told, too."""
        given, ctx.allow_extra_args = [*args], True
        found = super().parse_args(ctx, args)
        if ctx.args and not ctx.resilient_parsing:
            raise LineError(_too_many(str(ctx.args[0]), self.get_params(ctx), ctx, given))
        return found


class Group(_Told, TyperGroup):
    """All commands."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that is meant."""
        name = args[0]
        if self.get_command(ctx, name) is None and not ctx.resilient_parsing:
            raise LineError(_no_command(name, self.list_commands(ctx)))
        return super().resolve_command(ctx, args)

    def main(self, *args: Any, **more: Any) -> Any:
        """Do what the command line says; exit code 2 where it makes no sense."""
        try:
            return super().main(*args, **more)
        except LineError as error:
            print(f"error: {error}", file=sys.stderr)
            sys.exit(BAD_LINE)


def _no_command(name: str, known: Sequence[str]) -> str:
    ending = f".{name.rpartition('.')[2].lower()}" if "." in name else ""
    if ending in OF_FILES:
        return (
            f"there is no command {show(name)}; a file stands behind one: lienumba {OF_FILES[ending]} {printable(name)}"
        )
    if name in SECTIONS:
        return f"there is no command {show(name)}; {SECTIONS[name]}"
    close = near(name, known, ALIKE)[:1]
    remedy = f"the nearest is {close[0]}" if close else f"there are {listed(known)}"
    return f"there is no command {show(name)}; {remedy}"


def _too_many(extra: str, params: Sequence[Any], ctx: Any, given: Sequence[str]) -> str:
    """An argument that nothing takes: what stands before it says why."""
    name, at = ctx.info_name, given.index(extra) if extra in given else 0
    before, second = (given[at - 1] if at else ""), (given[at - 2] if at > 1 else "")
    flag = _option(before, params)
    if flag is not None and getattr(flag, "is_flag", False):
        return f"{name}: {before} takes no value, but {show(extra)} follows; give {before} alone, or leave it out"
    if second == "--set" and "=" not in before:
        return f"{name}: --set takes PATH=VALUE in one word; give --set {printable(f'{before}={extra}')}"
    takes = [_called(x) for x in params if x.param_type_name == "argument"]
    remedy = f"it takes {listed(takes)}" if takes else "it takes none"
    return f"{name}: the argument {show(extra)} is one too many; {remedy}, and options by their names"


def _called(param: Any) -> str:
    """What the help calls an argument, or the value of an option."""
    return str(param.metavar or param.name.upper()).strip("[].")


def _option(word: str, params: Sequence[Any]) -> Any | None:
    """The option that is written so, also with its value: --name=value."""
    return next((x for x in params if word.partition("=")[0] in (*x.opts, *x.secondary_opts)), None)


def _sentence(error: Any, params: Sequence[Any], ctx: Any, given: Sequence[str]) -> str:
    """What an error of typer's parser says, by what kind of error it is."""
    name, kind = ctx.info_name, type(error).__name__
    word = str(getattr(error, "option_name", "") or "")
    if kind == "NoSuchOption":
        return _no_option(word, params, ctx)
    if kind == "BadOptionUsage":
        own = _option(word, params)
        if getattr(own, "is_flag", False):
            return f"{name}: {word} takes no value; give {word} alone, or leave it out"
        return f"{name}: {word} has no value; give {word} {_called(own) if own is not None else 'VALUE'}"
    param = getattr(error, "param", None)
    if param is None:
        return f"{name}: {' '.join(error.format_message().split())}; lienumba {name} --help says what it takes"
    what = _called(param) if param.param_type_name == "argument" else max(param.opts, key=len)
    if kind == "MissingParameter":
        meaning = (param.help or "").partition(" (default")[0].rstrip(".")
        return f"{name}: {what} is missing; give {meaning[:1].lower()}{meaning[1:]}"
    closed = [x for x in given if os.path.exists(x) and not os.access(x, os.R_OK)]
    if closed and "not readable" in error.format_message():
        return f"{printable(closed[0])} cannot be read: Permission denied; check its permissions"
    value = _value(param.opts, given)
    rule, example = _rule(_annotation(param.name, ctx), value)
    return f"{name}: {what} = {show(value)}: {rule}; give it such as {what} {example}"


def _no_option(word: str, params: Sequence[Any], ctx: Any) -> str:
    if ctx.parent is None:
        return f"there is no option {printable(word)} of all commands; options stand behind the command they belong to"
    known = [option for x in params for option in (*x.opts, *x.secondary_opts) if option.startswith("-")]
    close = near(word, known, ALIKE)
    remedy = f"the nearest is {listed(close, 'or')}" if close else f"lienumba {ctx.info_name} --help has all"
    return f"{ctx.info_name}: there is no option {printable(word)}; {remedy}"


def _value(options: Sequence[str], given: Sequence[str]) -> str:
    """What an option has been given, the last time."""
    found = ""
    for n, word in enumerate(given):
        for option in options:
            if word == option and n + 1 < len(given):
                found = given[n + 1]
            elif word.startswith(f"{option}=") or (len(option) == 2 and word.startswith(option) and word != option):
                found = word[len(option) :].removeprefix("=")
    return found


def _annotation(name: str, ctx: Any) -> Any:
    """What a command says of one of its options: its type, and the rest."""
    return inspect.signature(ctx.command.callback).parameters[name].annotation


def _rule(annotation: Any, value: str) -> tuple[str, str]:
    """What a value must be, and an example."""
    own, *more = get_args(annotation)
    least = next((x.min for x in more if getattr(x, "min", None) is not None), None)
    for kind in (own, *get_args(own)):
        if get_origin(kind) is Literal:
            names = [show(x) for x in get_args(kind)]
            return f"must be {listed(names, 'or')}", str(get_args(kind)[0])
        if kind is int:
            return "must be a whole number" + (f", at least {least}" if least is not None else ""), "4"
        if kind is float:
            return "must be a number", "0.5"
    return "is not what it takes", f"as {value}"
