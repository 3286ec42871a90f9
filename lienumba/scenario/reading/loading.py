"""Where a scenario comes from: a TOML file, a dict or a System; and what `--set` changes in it."""

import copy
import re
import tomllib
from collections.abc import Container, Mapping
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

from lienumba.errors import BadValueError, Problem, ScenarioError
from lienumba.mechanics.elements.forces import FORCES
from lienumba.scenario.base import paths
from lienumba.scenario.base.code import embedded
from lienumba.scenario.base.paths import BESIDE, INPUTS, LISTS, START
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.reading.extends import extended, replaced_by
from lienumba.scenario.reading.mesh_files import with_meshes
from lienumba.scenario.reading.recordings import with_recordings
from lienumba.scenario.reading.reference_file import marked
from lienumba.scenario.reading.sample_table import sampled
from lienumba.scenario.reading.start_file import located
from lienumba.scenario.schema.tables import inlined
from lienumba.words import nearest, show, suggestion

MODEL_KEYS = ("gravity", "ground_shapes", *LISTS, INPUTS, START)


def load(source: object) -> Keys:
    """The scenario's keys and values, not yet checked, with what its files hold; `source`: a path, a dict, a System.

    Quantities and events stand beside the model in a file; here they are a part of it, as everything that has a name.
    """
    raw = _load(source)
    for kind in BESIDE:
        listed = raw.pop(kind, None)
        model = raw.setdefault("model", {}) if listed is not None else raw.get("model")
        if listed is not None and isinstance(model, dict):
            raw["model"] = {**model, kind: _together(model.get(kind), listed)}
    return raw


def _together(within: object, beside: object) -> object:
    """What stands in the model, and what beside it."""
    if isinstance(within, list) and isinstance(beside, list):
        return [*within, *beside]
    return {**within, **beside} if isinstance(within, dict) and isinstance(beside, dict) else beside


def with_files(raw: Keys, folder: Path) -> Keys:
    """The scenario with what the files hold that it names: tables, recordings, meshes, the texts of functions, the mark
    of a reference, samples; of the start, where its file is."""
    raw = with_recordings(with_meshes(inlined(raw, folder), folder), folder)
    return located(sampled(marked(embedded(raw, folder), folder), folder), folder)


def _load(source: object) -> Keys:
    if isinstance(source, str | Path):
        return extended(_read(Path(source)), Path(source).parent, _read, (Path(source).resolve(),))
    if hasattr(source, "to_dict"):
        source = source.to_dict()
    if isinstance(source, Mapping):
        plain = _plain(source)
        assert isinstance(plain, dict)
        return extended(with_files(plain, Path()), Path(), _read)
    raise ScenarioError.at(
        f"the scenario is a {type(source).__name__}", "must be the path of a TOML file, a dict or a System"
    )


def _plain(value: object) -> Any:
    """A copy in the types that TOML has: NumPy's arrays become lists, its numbers plain, tuples lists."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items() if item is not None}
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return copy.copy(value)


def _read(path: Path) -> Keys:
    if path.is_dir():
        raise ScenarioError.at("", f"{path} is a folder", "give the path of a TOML file in it")
    if not path.exists():
        raise ScenarioError.at("", f"{path} does not exist", _similar_file(path))
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ScenarioError.at("", f"{path} is not a text file in UTF-8", "give the path of a TOML file") from None
    except OSError as error:
        raise ScenarioError.at(f"{path} cannot be read", str(error.strerror), "check its permissions") from None
    try:
        return with_files(tomllib.loads(text), path.parent)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(_syntax(path, text, str(error))) from None


def _similar_file(path: Path) -> str:
    folder = path.parent
    if not folder.is_dir():
        return f"nor does the folder {folder}; check the path"
    close = nearest(path.name, [item.name for item in folder.glob("*.toml")])
    return f"the nearest file there is {folder / close}" if close else "check the path"


def _syntax(path: Path, text: str, message: str) -> Problem:
    """A TOML syntax error: line, column, the line itself, and the usual cause."""
    match = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", message, re.DOTALL)
    lines = text.splitlines() or [""]
    if match is None or match.group(2) is None:
        number, column = len(lines), len(lines[-1]) + 1
    else:
        number, column = int(match.group(2)), int(match.group(3))
    reason = match.group(1) if match else message
    line = lines[number - 1].strip() if number <= len(lines) else ""
    where = f"{path}, line {number}, column {column}"
    return Problem(where, f"not valid TOML: {reason}, in `{line[:80]}`", _usual_cause(line, reason))


def _usual_cause(line: str, reason: str) -> str:
    value = line.partition("=")[2].strip()
    if "overwrite" in reason or "twice" in reason:
        return "this key or table is there twice; keep one of them"
    if re.fullmatch(r"[-+]?\d+,\d+", value):
        return f"a decimal number has a point: {value.replace(',', '.')}"
    if value.endswith((";", ",")):
        return "a line ends without a comma or semicolon"
    if re.search(r"(^|[\s\[,=])[-+]?\.\d", value) or re.search(r"\d\.(\D|$)", value):
        return "a decimal point needs a digit on both sides: 0.5, 15.0"
    if re.match(r"(True|False|None|none|null)\b", value):
        return "write true or false in lower case; leave a key out to omit it"
    if re.match(r"[\d.]+\s*(kg|m|s|rad|deg|Nm|N)\b", value):
        return "write the number alone, without its unit"
    if re.match(r"[A-Za-z]", value):
        return "a text needs quotes"
    if re.match(r"[\w.]*\[\d+\]|[\w.]+\[", line) and "=" in line:
        return "a path with an index needs quotes"
    if "=" not in line and not line.startswith("["):
        return "a line is `key = value` or `[section]`"
    return "check brackets, quotes and commas"


def parse_value(text: str) -> Any:
    """The value of `--set path=text`: TOML, or a bare word as a string."""
    try:
        parsed = tomllib.loads(f"value = {text}")
        if list(parsed) == ["value"]:
            return parsed["value"]
    except tomllib.TOMLDecodeError:
        if re.fullmatch(r"[A-Za-z_][\w-]*", text.strip()):
            return text.strip()
    raise BadValueError(
        "", "give a number, a list in [] or a text in quotes (a bare word needs none)", verb="is not TOML"
    )


def apply_overrides(data: Keys, overrides: Mapping[str, object]) -> list[Problem]:
    """Set values by path, in place; texts are read as TOML. Returns a problem for each that cannot be.

    A key of a section takes the place of others as in `extends`: a tolerance that of the step.
    """
    problems: list[Problem] = []
    for path, value in overrides.items():
        try:
            setting = parse_value(value) if isinstance(value, str) else _plain(value)
            tokens = tokens_of(path)
            _refuse_gridded(data, tokens)
            put_setting(data, tokens, setting, overrides)
        except paths.PathError as error:
            problems.append(error.of(path).inside(f"--set {path}={_text(value)}"))
        except BadValueError as error:
            said = replace(error.problem, place=f"the value {_text(value)}")
            problems.append(said.inside(f"--set {path}={_text(value)}"))
    return problems


def tokens_of(path: str) -> list[paths.Token]:
    """A path within the whole scenario: of the model with `model`."""
    tokens = paths.parse(path)
    return ["model", *tokens] if tokens[0] in MODEL_KEYS else tokens


def put_setting(data: Keys, tokens: list[paths.Token], value: object, beside: Container[str] = frozenset()) -> None:
    """Set one value, in place, and remove the keys whose place it takes, unless they are set beside it (paths); a
    PathError where it would change nothing, or where there is nothing."""
    _refuse_varied(data, tokens)
    _refuse_unknown_parameter(data, tokens)
    paths.put(data, tokens, value)
    section = paths.get(data, tokens[:-1])
    named = isinstance(section, dict) and tokens[:-1] != ["model", INPUTS]
    for other in replaced_by(tokens[-1]) if named else ():
        if paths.text_of([*tokens[:-1], other]) not in beside:
            section.pop(other, None)


def name_unnamed(data: Keys) -> None:
    """Give drivers and forces without a name one, in place: driver_1, spring_damper_2 (counted within the list)."""
    model: Any = data.get("model")
    for kind in ("drivers", "forces"):
        items: Any = model.get(kind) if isinstance(model, dict) else None
        items = items if isinstance(items, list) else []
        taken = [item["name"] for item in items if isinstance(item, dict) and "name" in item]
        for index, item in enumerate(items):
            if isinstance(item, dict) and "name" not in item:
                kind_of_item = item.get("type")
                known = isinstance(kind_of_item, str) and kind_of_item in FORCES
                stem = kind_of_item if known else kind.removesuffix("s")
                name = next(name for n in count(index + 1) if (name := f"{stem}_{n}") not in taken)
                items[index] = {"name": name, **item}
                taken.append(name)


def _text(value: object) -> str:
    return value.replace("\n", "\\n") if isinstance(value, str) else show(value)


def _refuse_unknown_parameter(data: Keys, tokens: list[paths.Token]) -> None:
    """A parameter or an input that the scenario does not have would change nothing."""
    known = data.get("parameters") or {}
    if tokens[0] == "parameters" and len(tokens) == 2 and isinstance(known, dict) and tokens[1] not in known:
        raise paths.PathError("is no parameter of the scenario", suggestion(str(tokens[1]), known))
    inputs = table_in(table_in(data, "model"), INPUTS)
    if tokens[:2] == ["model", INPUTS] and len(tokens) > 2 and tokens[2] not in inputs:
        raise paths.PathError("is no input of the scenario", suggestion(str(tokens[2]), inputs))


def _refuse_varied(data: Keys, tokens: list[paths.Token]) -> None:
    """A number that the sweep varies has no single value to set."""
    if tokens[0] not in ("model", "parameters"):
        return
    sweep = data.get("sweep")
    varied = sweep.get("vary") if isinstance(sweep, dict) else None
    setting = _named(tokens, data)
    for path in varied if isinstance(varied, dict) else ():
        other = _named(path, data)
        shared = min(len(other), len(setting))
        if other and other[:shared] == setting[:shared]:
            raise paths.PathError(
                f'is varied by sweep.vary."{path}", so it cannot be set',
                f"set the distribution (sweep.vary.{path}.mean=...) or take it out of sweep.vary",
            )


def _refuse_gridded(data: Keys, tokens: list[paths.Token]) -> None:
    """What every grid of a study sets has no other value."""
    study = data.get("study")
    grids = study.get("grid") if isinstance(study, dict) else None
    setting = _named(tokens, data)
    found = [
        [path for path in grid if (other := _named(path, data)) and setting[: len(other)] == other]
        for grid in (grids if isinstance(grids, list) else ())
        if isinstance(grid, dict)
    ]
    if found and all(found):
        place = f'study.grid[0]."{found[0][0]}"'
        raise paths.PathError(f"is set by {place}, so it cannot be set here", f"set that ({place}=[...])")


def _named(path: str | list[paths.Token], data: Keys) -> list[paths.Token]:
    """The keys by which a path is known; none for what is no path."""
    model = table_in(data, "model")
    try:
        return paths.named(paths.parse(path) if isinstance(path, str) else path, model)
    except paths.PathError:
        return []
