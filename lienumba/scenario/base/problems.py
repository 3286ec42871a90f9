"""What the checks of a scenario find, and how they name places."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel, ValidationError

from lienumba.errors import NOTHING, Problem, ScenarioError, missing
from lienumba.keys.facts import is_text
from lienumba.keys.types import Section
from lienumba.scenario.base import paths
from lienumba.scenario.base.toml import Keys
from lienumba.words import suggestion

GROUND = "ground"
S = TypeVar("S", bound=BaseModel)
T = TypeVar("T")
E = TypeVar("E", bound=Section)


@dataclass
class Report:
    """What the checks found: problems stop the scenario, warnings do not. `times`: from the start to the end of the
    run, where they are known, at which formulas of the time are looked at."""

    problems: list[Problem] = field(default_factory=list)
    warnings: list[Problem] = field(default_factory=list)
    times: np.ndarray | None = None

    def add(self, place: str, rule: str, remedy: str = "", value: object = NOTHING, *, verb: str = "") -> None:
        """A problem."""
        self.problems.append(Problem(place, rule, remedy, value, verb=verb))

    def miss(self, place: str, remedy: str, why: str = "") -> None:
        """The problem of a key that must be there."""
        self.problems.append(missing(place, remedy, why))

    def element(self, place: str, section: type[E] | None, raw: object) -> E | None:
        """A table as its class has it, and the problem of each of its faults; None where it is wrong in itself."""
        checked = read(section, raw)
        self.problems += [] if checked is None else [fault.below(place) for fault in checked.faults()]
        return checked

    def warn(self, place: str, rule: str, remedy: str = "", value: object = NOTHING) -> None:
        """A warning."""
        self.warnings.append(Problem(place, rule, remedy, value))


def each(act: Callable[..., T], *items: Iterable[Any]) -> list[T]:
    """`map`, with the problems of all items in one ScenarioError."""
    found: list[T] = []
    problems: list[Problem] = []
    for arguments in zip(*items, strict=True):
        try:
            found.append(act(*arguments))
        except ScenarioError as error:
            problems += error.problems
    if problems:
        raise ScenarioError(*problems)
    return found


def tables(items: object) -> list[Keys]:
    """The tables of a list; an empty one for what is none."""
    return [item if isinstance(item, dict) else {} for item in items] if isinstance(items, list) else []


def placed(kind: str, items: list[Keys]) -> Iterator[tuple[str, Keys]]:
    """Each table with the path by which it is known."""
    for index, item in enumerate(items):
        name = unique_name(items, index)
        yield paths.written((kind, name or index)), item


def names_of(items: Iterable[Keys]) -> list[str]:
    """The names of tables that have one."""
    return [str(item["name"]) for item in items]


def unique_name(items: Sequence[object], index: int) -> str | None:
    """The name of an item of a list of tables, if it has one that no other item bears."""
    names = [item.get("name") if isinstance(item, dict) else None for item in items]
    name = names[index]
    return name if isinstance(name, str) and name and name.isprintable() and names.count(name) == 1 else None


def read(section: type[S] | None, raw: object) -> S | None:
    """A section as its class has it; None where it is wrong in itself. raw: as it is written, or such a section."""
    if section is None:
        return None
    if isinstance(raw, section):
        return raw
    try:
        return section.model_validate(raw)
    except ValidationError:
        return None


def well_named(section: type[BaseModel], raw: object) -> bool:
    """Whether the texts of a table (names, choices) are as its class has them, whatever its numbers are."""
    try:
        section.model_validate(raw)
    except ValidationError as error:
        places = [item["loc"] for item in error.errors(include_url=False)]
        keys = {str(loc[0]) if loc else "" for loc in places}
        return not any(not key or (key in section.model_fields and is_text(section, key)) for key in keys)
    return True


def check_name(at: str, name: object, known: Iterable[str], what: str, report: Report) -> None:
    """Check that a name is one of these; what: "a body", ..."""
    if isinstance(name, str) and name not in known:
        remedy = 'write "global"' if name == GROUND and "global" in known else suggestion(name, known)
        report.add(at, f"is not {what} of the model", remedy, name)
