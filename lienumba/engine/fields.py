"""Of what tables of runs consist: variables of the dataset, each with the function that takes it from a chunk."""

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from lienumba.batch.changes import NONE
from lienumba.batch.integrate import Chunk
from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.integrators.tracing.program import Outline
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system.switches import switches_of
from lienumba.scenario.base.code import function_of, said_of
from lienumba.scenario.formulas.measure_formula import MeasureFormula
from lienumba.scenario.formulas.measures import REDUCERS
from lienumba.scenario.formulas.units import units_of
from lienumba.scenario.resolve import Scenario
from lienumba.store.layout import RUN, VARIABLES, Variable
from lienumba.words import show, suggestion

QUIET = ("record", "stop")  # actions that change no mechanism
TIME = "t"  # the argument of a function that asks for the times
Courses = Callable[[str, Chunk, Outline], np.ndarray]  # (runs, times, ...)


@dataclass(frozen=True)
class Field:
    """A variable of the dataset: how it is described, and value(chunk, program) -> (runs, ...); None: it follows from
    the others of a record."""

    name: str
    spec: Variable
    shape: tuple[int, ...]
    value: Callable[[Chunk, Outline], np.ndarray] | None
    dtype: str = "f8"


def changes_told(model: Model, most: int) -> int:
    """Of how many changes of a run is told, of so many at most: of a mechanism that never changes of none."""
    acts = any(event.action not in QUIET for event in model.events)
    return most if acts or switches_of(model) else 0


def fates(model: Model, changes: int, started: int) -> Iterator[Field]:
    """How runs ended, which events happened, and the first changes of a mechanism that changes; started: how many
    numbers an equilibrium gives a start, 0 where runs do not start in one."""
    events, switches = (len(model.events),), (len(switches_of(model)),)
    yield _plain("status", (), lambda chunk: chunk.codes, "i1")
    yield _plain("end_time", (), lambda chunk: chunk.ends)
    yield _plain("steps", (), lambda chunk: chunk.steps, "i8")
    yield _plain("rejected_steps", (), lambda chunk: chunk.rejected, "i8")
    if started:
        yield _plain("start_equilibrium", (), lambda chunk: chunk.rests, "i1")
        yield _plain("start_state", (started,), lambda chunk: chunk.starts)
    yield _plain("event_time", events, lambda chunk: chunk.event_times)
    yield _plain("event_count", events, lambda chunk: chunk.event_counts, "i8")
    if changes:
        yield _plain("change_time", (changes,), lambda chunk: chunk.changes[:, :, 0])
        yield _plain("change_kind", (changes,), lambda chunk: _whole(chunk.changes[:, :, 1]), "i1")
        yield _plain("change_what", (changes,), lambda chunk: _whole(chunk.changes[:, :, 2]), "i4")
        yield _plain("change_impulse", (changes,), lambda chunk: chunk.changes[:, :, 3])
        yield _plain("change_energy", (changes,), lambda chunk: chunk.changes[:, :, 4])
        yield _plain("changes", (), lambda chunk: chunk.change_counts, "i8")
        yield _plain("energy_lost", (), lambda chunk: chunk.energy_lost)
        yield _plain("last_mode", switches, lambda chunk: chunk.modes, "i1")


def measured(resolved: Scenario, model: Model) -> Iterator[Field]:
    """Formulas of whole runs."""
    if not resolved.parameters.measures:
        return
    given, before = {x.name: x.units for x in resolved.data.model.measures}, 0
    names, reducers = quantities.units(model), {name: reducer.unit for name, reducer in REDUCERS.items()}
    for name, formula in resolved.parameters.measures.items():
        own = slice(before, before + len(formula.kept))
        units = given.get(name) or units_of(formula.text, names, reducers)
        spec = Variable(RUN, units, f"{name} of the run", measure=formula.text)
        yield Field(name, spec, (), _of(formula, own))
        before = own.stop


def _of(formula: MeasureFormula, own: slice) -> Callable[[Chunk, Outline], np.ndarray]:
    return lambda chunk, _: np.where(np.isin(chunk.codes, GOOD), formula.number(chunk.kept[:, own]), np.nan)


def _plain(name: str, shape: tuple[int, ...], value: Callable[[Chunk], np.ndarray], dtype: str = "f8") -> Field:
    return Field(name, VARIABLES[name], shape, lambda chunk, _: value(chunk), dtype)


def _whole(x: np.ndarray) -> np.ndarray:
    """Whole numbers; NaN is none."""
    return np.where(np.isnan(x), NONE, x).astype(np.int32)


@dataclass(frozen=True)
class Reducer:
    """A number of whole runs by a function of the user's own, of the courses at the times of the output.

    place: of the measure; reference: the file and the function; asked: by argument the variable."""

    place: str
    reference: str
    function: Callable[..., object]
    asked: Mapping[str, str]
    timed: bool

    def numbers(self, chunk: Chunk, program: Outline, times: np.ndarray, courses: Courses) -> np.ndarray:
        """One number for each run, NaN where a run failed; a run that ended early has fewer times."""
        found = np.full(len(chunk.codes), np.nan)
        given = {name: courses(variable, chunk, program) for name, variable in self.asked.items()}
        for run in np.flatnonzero(np.isin(chunk.codes, GOOD)):
            until = int(np.searchsorted(times, chunk.ends[run], side="right"))
            own: dict[str, Any] = {name: x[run, :until].copy() for name, x in given.items()}
            found[run] = self._number(own | ({TIME: times[:until].copy()} if self.timed else {}))
        return found

    def _number(self, given: Mapping[str, Any]) -> float:
        file = self.reference.rpartition(":")[0]
        try:
            x = self.function(**given)
        except Exception as error:
            rule = f"{file} cannot be run: {said_of(error, file)}"
            raise ScenarioError.at(f"{self.place}.function", rule, "correct it", self.reference) from None
        if isinstance(x, np.ndarray) and x.ndim == 0:
            x = x[()]
        if not isinstance(x, Real):
            rule = f"returns {show(repr(x)[:60])}, which is no number"
            raise ScenarioError.at(f"{self.place}.function", rule, "return one, such as float(x.max())", self.reference)
        return float(x)


def reduced(resolved: Scenario, names: list[str], times: np.ndarray, courses: Courses) -> Iterator[Field]:
    """The measures that functions are; names: of the variables of which there are courses.

    Raises
    ------
    ScenarioError
        If there is no such function, or it asks for something else.
    """
    for measure in resolved.data.model.measures:
        if measure.function is not None:
            place = f"measures.{measure.name}"
            reducer = _reducer(place, measure.function, resolved.data.files, names)
            spec = Variable(RUN, measure.units or "1", f"{measure.name} of the run", measure=measure.function)
            yield Field(measure.name, spec, (), _value(reducer, times, courses))


def _value(reducer: Reducer, times: np.ndarray, courses: Courses) -> Callable[[Chunk, Outline], np.ndarray]:
    return lambda chunk, program: reducer.numbers(chunk, program, times, courses)


def _reducer(place: str, reference: str, files: Mapping[str, str], names: list[str]) -> Reducer:
    function = function_of(place, reference, files)
    known = {name.replace(".", "_"): name for name in names}
    asked: dict[str, str] = {}
    arguments = inspect.signature(function).parameters
    for name, argument in arguments.items():
        if argument.kind in (argument.VAR_POSITIONAL, argument.VAR_KEYWORD, argument.POSITIONAL_ONLY):
            rule = f"has the argument {argument}, but it is called by names"
            raise ScenarioError.at(f"{place}.function", rule, "write one for each course, such as (t, tip)", reference)
        if name in known:
            asked[name] = known[name]
        elif name != TIME and argument.default is argument.empty:
            rule = f'asks for "{name}", of which there is no course; {suggestion(name, [TIME, *known])}'
            raise ScenarioError.at(f"{place}.function", rule, "or add it to [[quantities]]", reference)
    return Reducer(place, reference, function, asked, TIME in arguments)
