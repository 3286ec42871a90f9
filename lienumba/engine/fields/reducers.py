"""Numbers of whole runs by functions of the user's own, of the courses at the times of the output."""

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from lienumba.batch.integrate import Chunk
from lienumba.batch.statuses import GOOD
from lienumba.engine.fields.field import Field
from lienumba.errors import ScenarioError
from lienumba.integrators.tracing.program import Outline
from lienumba.scenario.base.code import function_of, said_of
from lienumba.scenario.resolve import Scenario
from lienumba.store.layout import RUN, Variable
from lienumba.words import show, suggestion

TIME = "t"
Courses = Callable[[str, Chunk, Outline], np.ndarray]  # (runs, times, ...)


@dataclass(frozen=True)
class Reducer:
    """place: of the measure; reference: the file and the function; asked: by argument the variable."""

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
