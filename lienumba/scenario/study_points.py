"""The points of a study, every combination of the values of a grid, each a scenario of its own; their labels in the
dataset; references."""

import copy
import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

from lienumba.errors import Problem, ScenarioError
from lienumba.scenario.base import paths
from lienumba.scenario.base.toml import Keys, table_in, value_text
from lienumba.scenario.base.units import SETTINGS
from lienumba.scenario.checks.study import numerical
from lienumba.scenario.reading.loading import put_setting, tokens_of
from lienumba.scenario.study_errors import STATE
from lienumba.store.study_layout import CASE, ERRORS, TAKEN, Coordinate
from lienumba.words import listed, plural, show

if TYPE_CHECKING:
    from lienumba.scenario.resolve import Scenario

    Attempt = Callable[["Settings"], Scenario]

Grid = dict[str, list[Any]]
Settings = Keys  # values by path
Choice = tuple[int, ...]  # which value of each path of a grid
LOOSER = 10.0  # times the tolerance of a reference that its judge has


@dataclass(frozen=True)
class Point:
    """place: how messages name it; problem: what it solves, beside how; `scenario`: of this point alone."""

    place: str
    problem: str
    scenario: "Scenario"


@dataclass(frozen=True)
class Plan:
    """points: in the order of the grids; shape: of the one grid, or of the cases of several; `references`: by problem,
    a scenario and another one by which it is judged; none where formulas or a file say what is true."""

    points: list[Point]
    shape: tuple[int, ...]
    coordinates: list[Coordinate]
    references: "dict[str, tuple[Scenario, Scenario]]"

    def headline(self) -> str:
        """How many points there are, of what."""
        return f"{plural(len(self.points), 'point', 'points')}: {', '.join(c.path for c in self.coordinates)}"


def plan_of(raw: Keys, base: "Scenario", resolve: "Callable[[Keys], Scenario]") -> Plan:
    """The points of a scenario with a study; raw: as it is written; base: the same, resolved."""
    study = base.data.study
    assert study is not None
    plain = {key: section for key, section in raw.items() if key != "study"}
    every = {"every": base.data.output.every} if base.data.output.times is None else {}
    whole = {**plain, "output": {**table_in(plain, "output"), **every}}

    def attempt(settings: Settings) -> "Scenario":
        try:
            return resolve(changed(whole, settings))
        except ScenarioError:
            resolve(changed(plain, settings))  # says nothing of an interval that nobody wrote
            raise

    found: list[Point] = []
    problems: list[Problem] = []
    solved: dict[str, Settings] = {}
    for number, grid in enumerate(study.grid):
        attempts = _Attempts(f"study.grid[{number}]", grid, attempt)
        problems += attempts.problems()
        for choice, scenario in attempts.resolved.items():
            problem = {
                path: value for path, value in attempts.settings(choice).items() if not numerical(tokens_of(path))
            }
            key = json.dumps(problem)
            solved[key] = problem
            found.append(Point(attempts.name(choice), key, scenario))
    if problems:
        raise ScenarioError(*problems)
    references = _references(study.reference, solved, attempt)
    shape = tuple(map(len, study.grid[0].values())) if len(study.grid) == 1 else (len(found),)
    model = dict(base.data.model)
    axes = coordinates(study.grid, model, base.units)
    check_measures(base.parameters.measures, [*(x.name for x in axes), *base.data.sweep.vary])
    return Plan(found, shape, axes, references)


class _Attempts:
    """Resolves every point of a grid; a point that is no scenario is told by the value that is to blame."""

    def __init__(self, place: str, grid: dict[str, list[Any]], attempt: "Attempt") -> None:
        self.place, self.grid, self.attempt = place, grid, attempt
        self.resolved: dict[Choice, Scenario] = {}
        self.failed: dict[Choice, tuple[Problem, ...]] = {}
        for choice in self.choices():
            try:
                self.resolved[choice] = attempt(self.settings(choice))
            except ScenarioError as error:
                self.failed[choice] = error.problems

    def choices(self) -> Iterator[Choice]:
        return product(*(range(len(values)) for values in self.grid.values()))

    def settings(self, choice: Choice) -> Settings:
        return {path: self.grid[path][i] for path, i in zip(self.grid, choice, strict=True)}

    def name(self, choice: Choice) -> str:
        """How messages name a point."""
        parts = [f'"{path}" = {show(value)}' for path, value in self.settings(choice).items()]
        return f"{self.place} at {listed(parts)}"

    def problems(self) -> list[Problem]:
        told: list[Problem] = []
        for problem in dict.fromkeys(x for problems in self.failed.values() for x in problems):
            left = {choice for choice, problems in self.failed.items() if problem in problems}
            for position, path in enumerate(self.grid):
                blamed = [i for i in range(len(self.grid[path])) if self._is_to_blame(position, i, problem, left)]
                left = {choice for choice in left if choice[position] not in blamed}
                told += self._blame(path, blamed, problem)
            if left:
                more = f" (and {plural(len(left) - 1, 'more point', 'more points')})" if len(left) > 1 else ""
                told.append(problem.inside(f"{self.name(min(left))}{more}"))
        return told

    def _is_to_blame(self, position: int, value: int, problem: Problem, left: set[Choice]) -> bool:
        """Whether all points with this value fail in this way, and so does the scenario with this value alone."""
        path = list(self.grid)[position]
        if not {choice for choice in self.choices() if choice[position] == value} <= left:
            return False
        try:
            self.attempt({path: self.grid[path][value]})
        except ScenarioError as error:
            return problem in error.problems
        return False

    def _blame(self, path: str, values: Sequence[int], problem: Problem) -> list[Problem]:
        at, given = f'{self.place}."{path}"', self.grid[path]
        if len(values) == len(given) > 1 or (values and problem.place == paths.place_of(path)):
            return [problem.inside(at)]
        return [problem.inside(f"{at}[{i}] = {show(given[i])}") for i in values]


def changed(plain: Keys, settings: Mapping[str, object]) -> Keys:
    """A scenario with other settings."""
    raw = copy.deepcopy(plain)
    for path, value in settings.items():
        try:
            put_setting(raw, tokens_of(path), copy.deepcopy(value))
        except paths.PathError as error:
            raise ScenarioError(error.of(path)) from None
    return raw


def _references(
    reference: Keys, solved: dict[str, Settings], attempt: "Attempt"
) -> "dict[str, tuple[Scenario, Scenario]]":
    """For each problem the reference with these settings, and its judge: with half the step, or a looser tolerance."""
    if reference.keys() & {"file", *STATE}:
        return {}
    settings = {key if "." in key else f"integrator.{key}": value for key, value in reference.items()}
    found = {}
    try:
        for key, problem in solved.items():
            first = attempt({**problem, **settings})
            integrator = first.to_dict()["integrator"]
            if "step" in integrator:
                judge = {"integrator.step": 0.5 * integrator["step"]}
            else:
                judge = {"integrator.tolerance": _looser(integrator["tolerance"])}
            found[key] = first, attempt({**problem, **settings, **judge})
    except ScenarioError as error:
        raise error.inside("study.reference") from None
    return found


def _looser(tolerance: object) -> object:
    """A tolerance, or a table of them."""
    if isinstance(tolerance, dict):
        return {key: _looser(value) for key, value in tolerance.items()}
    assert isinstance(tolerance, float), "checked"
    return LOOSER * tolerance


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
