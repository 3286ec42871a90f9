"""Paths to the numbers of a scenario: `bodies.top.angular_velocity[1]`, `integrator.step`.

A path is a sequence of keys and indices. In the list of bodies or of joints a key is the item's name. A path
of the model may start with `model.`; its canonical text leaves that out.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from pydantic import BaseModel

from lienumba.errors import BadValueError, Problem
from lienumba.numerics.expressions import Formula
from lienumba.numerics.grammar import ExpressionError
from lienumba.scenario.base.toml import Keys
from lienumba.words import nearest, printable, suggestion

Token = str | int
Tokens = tuple[Token, ...]
S = TypeVar("S", bound=BaseModel)
TOKEN = re.compile(r'(?:(?:^|\.)(?:"([^"]*)"|([A-Za-z_][\w-]*)))|\[(\d+)\]')
IN_WORDS = re.compile(r'\.(?:"([^"]*)"|([^."\[\]]*[^."\[\]\s]))|\[(\d+)\]')  # likewise a name that is words
LISTS = (  # of the model: tables known by their names
    "bodies", "joints", "drivers", "forces", "quantities", "noise", "events", "limits", "contacts", "measures",
    "requirements",
)  # fmt: skip
BY_NAMES = (["output", "summary"], ["output", "precision"])  # tables of names that may have dots
NEW = ("vary", "stop", "summary", "proposal")  # tables that a path may begin
INPUTS = "inputs"  # a table of them by their names
RECORDING = "recording"  # of this table, what gives one for each column of a file
START = "start"  # what is known of coordinates at the start, by their names, which may have dots
MEASURES, REQUIREMENTS = "measures", "requirements"
JUDGING = (MEASURES, REQUIREMENTS)  # of what says something of runs and changes none; their names are words
# What is part of the model and stands beside [model] in a file.
BESIDE = ("quantities", "noise", "events", MEASURES, REQUIREMENTS, INPUTS, START)
TEXT_KEYS = {
    "name", "type", "euler", "bodies", "body", "joint", "joints", "coordinate", "coordinates", "motion", "frame",
    "relative_to", "driver", "contact", "units", "function", "returns", "level", "rows", "derivative",
    "action", "once", "interpolation", "outside",
}  # fmt: skip  # whose values are texts as they should be
TEXT_PLACES = (("quantities", "limit"), ("quantities", "about"))  # elsewhere keys of these names hold numbers
OWN_NAMES = ("parameters", "states", "memory")  # of a law: tables of numbers by names of the user's own
WITH_FORMULAS = ("gravity", "drivers", "forces", "quantities", "events", INPUTS)
WITH_STATE = ("drivers", "forces", "quantities", "events", INPUTS)  # whose formulas may read tables and quantities
# Of distributions, those that no path of the model ends with.
DISTRIBUTION_KEYS = (
    "distribution|mean|std|low|high|relative|median|sigma|mode|values|weights|covariance|scipy|expression|column"
)
EXAMPLES = "such as bodies.top.mass or bodies.top.position[1]"
PLACES = re.compile(r"noise\.[^.]+\.table")  # of files, which decide nothing: their checksums do


class PathError(BadValueError):
    """A path that leads nowhere, and what to do."""

    def __init__(self, said: str, remedy: str = "") -> None:
        super().__init__("", remedy, verb=said)

    def of(self, path: str) -> Problem:
        """The problem of this path."""
        return self.at(place_of(path))


def place_of(path: str) -> str:
    """Where the problems of a path itself are."""
    return f"the path {printable(path)}"


def parse(text: str) -> list[Token]:
    """The keys and indices of a path."""
    tokens: list[Token] = []
    position = 0
    text = text.strip()
    while position < len(text):
        pattern = IN_WORDS if tokens and tokens[-1] in JUDGING else TOKEN
        match = pattern.match(text, position)
        if match is None or (position == 0 and match.group(3)):
            raise PathError("is not a path", f"write one {EXAMPLES}")
        quoted, plain, index = match.groups()
        tokens.append(int(index) if index is not None else quoted if quoted is not None else plain)
        position = match.end()
        if tokens == ["sweep", "vary"] and position < len(text):
            return tokens + _vary_tokens(text[position:])
        tokens = _of_start(tokens)
    if tokens[:2] in BY_NAMES:
        tokens = [*tokens[:2], *filter(None, [".".join(map(str, tokens[2:]))])]
    if not tokens:
        raise PathError("is not a path", f"write one {EXAMPLES}")
    return tokens


def _of_start(tokens: list[Token]) -> list[Token]:
    """With the name of a coordinate as one key: start.q.piston.angle."""
    first = tokens.index(START) + 3 if tokens[:1] == [START] or tokens[:2] == ["model", START] else len(tokens)
    joined = [token for token in tokens[first - 1 :] if isinstance(token, str)]
    if first >= len(tokens) or len(joined) < 2:
        return tokens
    return [*tokens[: first - 1], ".".join(joined), *(token for token in tokens[first:] if isinstance(token, int))]


def _vary_tokens(rest: str) -> list[Token]:
    """The varied path and a key of its distribution; a shell may have taken the path's quotes away."""
    match = re.fullmatch(rf'\.(?:"([^"]+)"(?:\.(\w+))?|(.+?)(?:\.({DISTRIBUTION_KEYS}))?)', rest)
    if match is None:
        raise PathError("is not a path", 'write one such as sweep.vary."bodies.top.mass".std')
    quoted, of_quoted, plain, of_plain = match.groups()
    key = of_quoted or of_plain
    return [quoted or plain] + ([key] if key else [])


def text_of(tokens: list[Token]) -> str:
    """A path's text."""
    parts = [f"[{token}]" if isinstance(token, int) else f".{token}" for token in tokens]
    return "".join(parts).removeprefix(".")


def written(tokens: Sequence[Token]) -> str:
    """The text of a path of the model, as the file has it."""
    return text_of(list(tokens) if tokens[0] in BESIDE else ["model", *tokens])


def last_part(tokens: list[Token]) -> str:
    """The text of the last key of a path, with the indices behind it."""
    first = max(i for i, token in enumerate(tokens) if isinstance(token, str))
    return text_of(tokens[first:])


def canonical(text: str, model: Keys) -> str:
    """The text by which a path of the model is known: without spaces, without `model.`, bodies and joints by name."""
    return text_of(named(parse(text), model))


def named(tokens: list[Token], model: Keys) -> list[Token]:
    """The path without `model`, and with the name of a body or joint that is given by its index."""
    tokens = tokens[1:] if tokens[0] == "model" else tokens
    items = model.get(tokens[0]) if tokens and isinstance(tokens[0], str) else None
    if len(tokens) > 1 and isinstance(tokens[1], int) and isinstance(items, list) and tokens[1] < len(items):
        name = name_of(items[tokens[1]])
        if name is not None:
            return [tokens[0], name, *tokens[2:]]
    return tokens


def child(node: object, token: Token) -> Any:
    """One step down; PathError where there is nothing."""
    if isinstance(node, BaseModel):
        node = dict(node)
    if isinstance(node, dict):
        if token in node:
            return node[token]
        raise PathError(f'has no "{token}" here', suggestion(str(token), [str(key) for key in node]))
    if isinstance(node, list):
        return node[position_in(node, token)]
    raise PathError("goes too deep: there is a single value before its end")


def name_of(item: object) -> str | None:
    """The name of a table, written or checked."""
    name = item.get("name") if isinstance(item, dict) else getattr(item, "name", None)
    return name if isinstance(name, str) else None


def position_in(items: list[Any], token: Token) -> int:
    """The index of a list's item, given by index or by the item's name."""
    names = [name_of(item) for item in items if isinstance(item, dict | BaseModel)]
    if isinstance(token, int):
        if token < len(items):
            return token
        if not items:
            raise PathError(f"has the index {token}, but the list is empty", "write its first entry into the scenario")
        name = f' or the name "{names[-1]}"' if names and names[-1] else ""
        raise PathError(
            f"has the index {token}, but the indices go from 0 to {len(items) - 1}",
            f"give such as [{len(items) - 1}]{name}",
        )
    if len(names) < len(items) or not items:
        raise PathError(f'has no "{token}" here', "give an index such as [0]")
    if token in names:
        return names.index(token)
    raise PathError(f'has no "{token}" here', suggestion(token, [str(name) for name in names]))


def get(data: object, tokens: list[Token]) -> Any:
    """The value at a path."""
    for token in tokens:
        data = child(data, token)
    return data


def put(data: object, tokens: list[Token], value: object) -> None:
    """Replace the value at a path; a table's key may be new, and so may a whole section."""
    for depth, token in enumerate(tokens[:-1]):
        is_new = depth == 0 or token in NEW or START in tokens[max(depth - 1, 0) : depth + 1]
        if isinstance(data, dict) and isinstance(token, str) and token not in data and is_new:
            data[token] = {}
        data = child(data, token)
    last = tokens[-1]
    if isinstance(data, dict) and isinstance(last, int):
        raise PathError(f"has the index {last} of a table, which has names", "give the name of a key")
    if isinstance(data, dict):
        data[last] = value
    elif isinstance(data, list):
        data[position_in(data, last)] = value
    else:
        raise PathError("goes too deep: there is a single value before its end")


def with_values(section: S, values: Mapping[Tokens, object]) -> S:
    """A copy of a section with other values at these paths, which exist; a value takes the place of all below."""
    found = {str(key): _with(getattr(section, str(key)), below) for key, below in _grouped(values).items()}
    return section.model_copy(update=found)


def _with(node: object, values: Mapping[Tokens, object]) -> object:
    if () in values:
        return values[()]
    if isinstance(node, BaseModel):
        return with_values(node, values)
    below = _grouped(values)
    if isinstance(node, list):
        found: dict[int, dict[Tokens, object]] = {}
        for token, inner in below.items():  # an item may be given by its name and by its index
            found.setdefault(position_in(node, token), {}).update(inner)
        return [_with(item, found[i]) if i in found else item for i, item in enumerate(node)]
    assert isinstance(node, dict), "the path of a number"
    return {**node, **{key: _with(node.get(key), inner) for key, inner in below.items()}}


def _grouped(values: Mapping[Tokens, object]) -> dict[Token, dict[Tokens, object]]:
    """The values by the first keys of their paths."""
    found: dict[Token, dict[Tokens, object]] = {}
    for (first, *rest), value in values.items():
        found.setdefault(first, {})[tuple(rest)] = value
    return found


def numeric_paths(model: Keys) -> list[str]:
    """The canonical paths of all numbers of a model that may vary, defaults included."""
    found: list[str] = []

    def walk(node: object, tokens: list[Token]) -> None:
        if isinstance(node, BaseModel):
            node = dict(node)
        if isinstance(node, dict):
            for key, item in node.items():
                if not is_recording([*tokens, key]):
                    walk(item, [*tokens, key])
        elif isinstance(node, list):
            for index, item in enumerate(node):
                name = name_of(item)
                walk(item, [*tokens, index if name is None else name])
        elif (isinstance(node, float | int) and not isinstance(node, bool)) or _is_constant(node, tokens):
            found.append(text_of(tokens))

    walk(model, [])
    return found


def holds_text(tokens: Sequence[Token]) -> bool:
    """Whether a text at a place is a name or a choice, and no formula."""
    if OWN_NAMES[0] in tokens[2:3]:
        return False
    return bool(TEXT_KEYS.intersection(map(str, tokens[2:]))) or (tokens[0], *tokens[2:]) in TEXT_PLACES


def is_recording(tokens: Sequence[Token]) -> bool:
    """Whether a path leads to the numbers of a recorded input, of which none varies by itself."""
    return len(tokens) > 2 and tokens[0] == INPUTS and tokens[2] in ("times", "values")


def _is_constant(node: object, tokens: list[Token]) -> bool:
    """Whether a formula stands there that does not vary in time."""
    if not isinstance(node, str) or tokens[0] not in WITH_FORMULAS or holds_text(tokens):
        return False
    try:
        return Formula(node).constant is not None
    except ExpressionError:
        return False


def nearest_path(text: str, model: Keys) -> str:
    """The remedy for a path that does not exist: the most similar one that does."""
    known, tokens = numeric_paths(model), parse(text)
    if tokens[0] == START and len(tokens) == 3:
        joint, joints = str(tokens[2]).partition(".")[0], model.get("joints")
        if isinstance(joints, list) and joint in map(name_of, joints):
            return f"give {tokens[2]} a number there, in {START}.{tokens[1]}, which is what it has without the sweep"
    close = nearest(text, known)
    return f'the nearest numeric path is "{close}"' if close else f'numeric paths are such as "{known[0]}"'
