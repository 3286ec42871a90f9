"""Where a scenario comes from: a TOML file, a dict or a System; and what `--set` changes in it."""

import os
import re
from collections.abc import Callable, Container, Mapping
from dataclasses import replace
from functools import partial
from itertools import chain, count
from pathlib import Path
from typing import Any

from lienumba.errors import BadValueError, Problem, ScenarioError
from lienumba.keys.types import NAME
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.forces import FORCES
from lienumba.scenario.base import paths
from lienumba.scenario.base.code import check_own, embedded
from lienumba.scenario.base.paths import BESIDE, INPUTS, LISTS, START
from lienumba.scenario.base.plain import plain, plain_value
from lienumba.scenario.base.problems import tables
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.reading.extends import extended, replaced_by, resolved
from lienumba.scenario.reading.toml_text import parse_value, read_toml
from lienumba.sweep.distributions.registry import follows_nominal
from lienumba.words import printable, settings, show, suggestion

LONGEST = 300  # characters of a setting in a message
MODEL_KEYS = ("gravity", "ground_shapes", *LISTS, INPUTS, START)


def load(source: object, allow_code: bool = False) -> Keys:
    """The scenario's keys and values, not yet checked, with what its files hold; `source`: a path, a dict, a System;
    allow_code: whether TOML files may have Python code that is not plainly their owner's.

    Quantities and events stand beside the model in a file; here they are a part of it, as everything that has a name.
    """
    raw = _load(source, partial(_read, allow_code))
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
    of a reference, samples; of the start, where its file is.

    A reader is imported where the scenario has something for it."""
    model = table_in(raw, "model")
    if "tables" in raw or INPUTS in raw or INPUTS in model:
        from lienumba.scenario.reading.recordings import with_recordings, with_tables

        raw = with_recordings(with_tables(raw, folder), folder)
    if "ground_shapes" in model or any("shapes" in body for body in tables(model.get("bodies"))):
        from lienumba.scenario.reading.mesh_files import with_meshes

        raw = with_meshes(raw, folder)
    if "noise" in raw:
        from lienumba.scenario.reading.run_tables import with_run_tables

        raw = with_run_tables(raw, folder)
    raw = embedded(raw, folder)
    if "study" in raw or START in raw:
        from lienumba.scenario.reading.datasets import with_reference, with_start

        raw = with_start(with_reference(raw, folder), folder)
    if "table" in table_in(raw, "sweep"):
        from lienumba.scenario.reading.sample_table import with_samples

        raw = with_samples(raw, folder)
    return raw


def _load(source: object, read: Callable[[Path], Keys]) -> Keys:
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        raw = read(path)
        return extended(raw, path.parent, read, (resolved(path),)) if "extends" in raw else raw
    if hasattr(source, "to_dict"):
        source = source.to_dict()
    if isinstance(source, Mapping):
        return extended(with_files(plain(source), Path()), Path(), read)
    raise ScenarioError.at(
        f"the scenario is a {type(source).__name__}", "must be the path of a TOML file, a dict or a System"
    )


def _read(allow_code: bool, path: Path) -> Keys:
    raw = read_toml(path)
    if not allow_code:
        check_own(raw, path)
    return with_files(raw, path.parent)


def apply_overrides(data: Keys, overrides: Mapping[str, object]) -> list[Problem]:
    """Set values by path, in place; texts are read as TOML. Returns a problem for each that cannot be.

    A key of a section takes the place of others as in `extends`: a tolerance that of the step.
    """
    problems: list[Problem] = []
    for path, value in overrides.items():
        said = settings(printable(str(path)), _text(value))
        try:
            if not isinstance(path, str):
                raise ScenarioError.at(f"the path {show(path)}", "must be a text", f"write one {paths.EXAMPLES}")
            setting = plain_value(parse_value(value) if isinstance(value, str) else value, path)
            tokens = tokens_of(path)
            _refuse_gridded(data, tokens)
            put_setting(data, tokens, setting, overrides, followed=True)
        except paths.PathError as error:
            problems.append(error.of(path).inside(said))
        except BadValueError as error:
            problems.append(replace(error.problem, place=f"the value {_text(value)}").inside(said))
        except ScenarioError as error:
            problems += error.inside(said).problems
    return problems


def tokens_of(path: str) -> list[paths.Token]:
    """A path within the whole scenario: of the model with `model`."""
    tokens = paths.parse(path)
    return ["model", *tokens] if tokens[0] in MODEL_KEYS else tokens


def put_setting(
    data: Keys,
    tokens: list[paths.Token],
    value: object,
    beside: Container[str] = frozenset(),
    *,
    followed: bool = False,
) -> None:
    """Set one value, in place, and remove the keys whose place it takes, unless they are set beside it (paths); a
    PathError where it would change nothing, or where there is nothing. followed: also what samples follow."""
    _refuse_varied(data, tokens, followed)
    _refuse_unknown_parameter(data, tokens)
    paths.put(data, tokens, value)
    section = paths.get(data, tokens[:-1])
    named = isinstance(section, dict) and tokens[:-1] != ["model", INPUTS]
    for other in replaced_by(tokens[-1]) if named else ():
        if paths.text_of([*tokens[:-1], other]) not in beside:
            section.pop(other, None)


def name_unnamed(data: Keys) -> None:
    """Give what needs no name one, in place: driver_1, spring_damper_2 (counted within the list); a limit that of its
    joint, if that is free."""
    model: Any = data.get("model")
    for kind in ("drivers", "forces", "contacts", "limits"):
        items: Any = model.get(kind) if isinstance(model, dict) else None
        items = items if isinstance(items, list) else []
        taken = [item["name"] for item in items if isinstance(item, dict) and "name" in item]
        for index, item in enumerate(items):
            if isinstance(item, dict) and "name" not in item:
                kind_of_item = item.get("type")
                known = isinstance(kind_of_item, str) and (kind_of_item in FORCES or kind_of_item in CONTACTS)
                stem = kind_of_item if known else kind.removesuffix("s")
                first = item.get("joint") if kind == "limits" else None
                numbered = (f"{stem}_{n}" for n in count(index + 1))
                own = (first,) if isinstance(first, str) and re.fullmatch(NAME, first) else ()
                name = next(name for name in chain(own, numbered) if name not in taken)
                items[index] = {"name": name, **item}
                taken.append(name)


def _text(value: object) -> str:
    text = printable(value) if isinstance(value, str) else show(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]} ..."


def _refuse_unknown_parameter(data: Keys, tokens: list[paths.Token]) -> None:
    """A parameter or an input that the scenario does not have would change nothing."""
    known = data.get("parameters") or {}
    if tokens[0] == "parameters" and len(tokens) == 2 and isinstance(known, dict) and tokens[1] not in known:
        raise paths.PathError("is no parameter of the scenario", suggestion(str(tokens[1]), known))
    inputs = table_in(table_in(data, "model"), INPUTS)
    if tokens[:2] == ["model", INPUTS] and len(tokens) > 2 and tokens[2] not in inputs:
        raise paths.PathError("is no input of the scenario", suggestion(str(tokens[2]), inputs))


def _refuse_varied(data: Keys, tokens: list[paths.Token], followed: bool) -> None:
    """A number that the sweep varies has no single value to set; followed: unless its samples follow that."""
    if tokens[0] not in ("model", "parameters"):
        return
    sweep = data.get("sweep")
    varied = sweep.get("vary") if isinstance(sweep, dict) else None
    setting = _named(tokens, data)
    for path, entry in varied.items() if isinstance(varied, dict) else ():
        other = _named(path, data)
        shared = min(len(other), len(setting))
        if other and other[:shared] == setting[:shared] and not (followed and follows_nominal(entry)):
            keys = [x for x in entry if x not in ("distribution", "relative")] if isinstance(entry, dict) else []
            own = next((x for x in ("mean", "median", "mode", *keys) if x in keys), "")
            why = "whose samples do not follow it" if followed else "so it cannot be set"
            raise paths.PathError(
                f'is varied by sweep.vary."{path}", {why}',
                f"set {'.'.join(filter(None, ['sweep.vary', path, own]))}, or take it out of sweep.vary",
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
