"""The names and labels of the points of a study in its dataset."""

from collections.abc import Callable, Collection, Iterator
from itertools import product
from typing import Any

from lienumba.errors import Problem, ScenarioError
from lienumba.scenario.base import paths
from lienumba.scenario.base.toml import Keys, value_text
from lienumba.scenario.base.units import SETTINGS
from lienumba.scenario.reading.loading import tokens_of
from lienumba.store.study_layout import CASE, ERRORS, TAKEN, Coordinate

Grid = dict[str, list[Any]]


def coordinates(grids: list[Grid], model: Keys, units: Callable[[str], str]) -> list[Coordinate]:
    """One for each path, known by its last part, if that is enough; model, units: of a resolved scenario."""
    paths_of = [{_canonical(path, model): values for path, values in grid.items()} for grid in grids]
    every = list(dict.fromkeys(path for grid in paths_of for path in grid))
    short = {path: paths.last_part(paths.parse(path)) for path in every}
    names = {
        path: path if last in TAKEN or list(short.values()).count(last) > 1 else last for path, last in short.items()
    }
    found = []
    for path in every:
        given = [value for grid in paths_of for value in grid.get(path, ())]
        numbers = all(isinstance(x, int | float) and not isinstance(x, bool) for x in given)
        label: Any = float if numbers else _label
        missing = float("nan") if numbers else ""
        if len(grids) == 1:
            dim, values = names[path], list(map(label, given))
        else:
            points = [point for grid in paths_of for point in combinations(grid)]
            dim, values = CASE, [label(point[path]) if path in point else missing for point in points]
        unit = (SETTINGS.get(path) or units(path)) if numbers else "1"
        found.append(Coordinate(names[path], dim, values, unit, path))
    return found


def check_measures(measures: Collection[str], others: Collection[str]) -> None:
    """A ScenarioError if the dataset has something else of the name of a measure, or of its error; others: names of
    coordinates and inputs."""
    taken = {*TAKEN, *ERRORS, *others}
    for name in measures:
        if {name, f"{name}_error", f"reference_{name}_error"} & (taken | ({*measures} - {name})):
            rule = "is the name of something else in the dataset of a study, alone or with _error behind it"
            raise ScenarioError(Problem(f"measures.{name}.name", rule, "give another name", name))


def combinations(grid: Grid) -> Iterator[Keys]:
    """Every point of a grid, by path."""
    return (dict(zip(grid, values, strict=True)) for values in product(*grid.values()))


def _label(value: object) -> str:
    return value if isinstance(value, str) else value_text(value)


def _canonical(path: str, model: Keys) -> str:
    return paths.text_of(paths.named(tokens_of(path), model))
