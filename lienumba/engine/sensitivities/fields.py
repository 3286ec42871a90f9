"""What of derivatives is in the dataset: `d_<name>`, with a dimension `input`."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lienumba.batch.integrate import Chunk
from lienumba.batch.records import Layout, Record
from lienumba.batch.statuses import GOOD
from lienumba.batch.tangents.changes import FLAGS as MEANINGS
from lienumba.engine.fields import Field
from lienumba.engine.sensitivities.differentiate import Tangents, differentiate
from lienumba.errors import ScenarioError
from lienumba.integrators.tracing.program import Outline
from lienumba.mechanics.mechanism.model import LARGEST, NONE, SMALLEST
from lienumba.scenario.base import paths
from lienumba.scenario.formulas.measure_formula import MeasureFormula
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Nominal, Prepared
from lienumba.store.layout import RUN, Variable
from lienumba.store.names import BY, COURSE, END, FLAGS, LAST, MEASURE, RATE, Names
from lienumba.words import listed

EVENT_TIME = "event_time"
NEVER = ("energy_residual", "work", "position_violation", "velocity_violation", "mode")  # courses without derivatives
STEP = 1e-4  # of the differences of the arithmetic at the end of a measure
PLACE = "sensitivities.of"


@dataclass(frozen=True)
class Derivatives:
    """Those that a scenario asks for; names: of all that its dataset has; specs, shapes: of the variables of these."""

    resolved: Scenario
    nominal: Nominal
    layout: Layout
    times: np.ndarray
    names: Names
    specs: dict[str, tuple[Variable, tuple[int, ...]]]

    @cached_property
    def by(self) -> list[str]:
        """The inputs."""
        asked = self.resolved.data.sensitivities
        assert asked is not None
        columns = [c for path, kind in self.resolved.data.sweep.vary.items() for c in kind.columns(path)]
        return list(asked.by) if asked.by else columns

    @property
    def units(self) -> list[str]:
        """Those of the inputs."""
        return [self.resolved.units(path) for path in self.by]

    @cached_property
    def _variables(self) -> frozenset[str]:
        """What has to be observed."""
        asked = self.resolved.data.sensitivities
        assert asked is not None
        found = {x.variable for x in self.names.every.values() if {x.variable, x.name} & {*asked.of}}
        return frozenset(found | ({"kinetic_energy", "potential_energy"} if "energy" in found else set()))

    def of(self, prepared: Prepared, runs: slice, codes: np.ndarray, fixed: bool) -> Tangents:
        """The derivatives of some of the prepared runs."""
        labels, model = prepared.labels[runs], dict(self.resolved.data.model)
        samples = {path: np.array(x[runs]) for path, x in prepared.samples.items()}
        values = self.resolved.parameters.values()
        for path in self.by:
            if path not in samples:
                first, *rest = paths.parse(path)
                number = values[paths.text_of(rest)] if first == "parameters" else paths.get(model, [first, *rest])
                samples[path] = np.full(len(labels), float(number))
        wanted = np.isin(codes, GOOD)
        return differentiate(self.resolved, labels, samples, self.by, self.nominal, self._variables, wanted, fixed)

    def fields(self) -> Iterator[Field]:
        """The variables, each once."""
        asked = self.resolved.data.sensitivities
        assert asked is not None
        events = (len(self.nominal.model.events),)
        for name in asked.of:
            spec, shape, value = self._of(name)
            yield self._field(name, spec, shape, value)
        flags = Variable(RUN, "1", f"what of the derivatives is doubtful: {_flag_words()}", dtype="int32")
        yield Field(FLAGS, flags, (), lambda chunk, _: _tangents(chunk).flags, "i8")
        if any(events):
            text = "how fast the condition grew when it first became true, in its unit per s"
            rates = Variable((*RUN, "event"), "s-1", text)
            yield Field(RATE, rates, events, lambda chunk, _: _tangents(chunk).event_rates)

    def _field(self, name: str, spec: Variable, shape: tuple[int, ...], value: "Value") -> Field:
        units = set(self.units)
        by = units.pop() if len(units) == 1 else "input_units"
        own = spec.units if by == "1" else f"({spec.units}) / ({by})"
        text = f"derivative of: {spec.long_name}"
        made = Variable((*spec.dims, BY), own, text, spec.frame)
        return Field(f"d_{name}", made, (*shape, len(self.by)), value)

    def _of(self, asked: str) -> tuple[Variable, tuple[int, ...], "Value"]:
        """A variable, or one number of it."""
        names = [x for x in self.names.every.values() if asked in (x.variable, x.name)]
        part = None if asked in self.specs else names[0].place if names else None
        if not names or names[0].variable not in self.specs:
            raise ScenarioError.at(
                PLACE, f'has "{asked}", which the dataset does not have of every run', self._remedy(), asked
            )
        variable, kind = names[0].variable, names[0].kind
        spec, shape = self.specs[variable]
        values = self._values(variable, kind)
        if part is None:
            return spec, shape, values
        over = 1 if "time" in spec.dims else 0

        def one(chunk: Chunk, program: Outline) -> np.ndarray:
            return values(chunk, program)[(slice(None),) * (1 + over) + tuple(part)]

        return replace(spec, dims=spec.dims[: 1 + over], units=names[0].units), shape[:over], one

    def _remedy(self) -> str:
        own = [x.variable for x in self.names.every.values() if x.kind in (COURSE, MEASURE, END)]
        own = [name for name in own if name in self.specs]
        own += [EVENT_TIME] * bool(self.nominal.model.events)
        return f"give some of {listed(dict.fromkeys(x for x in own if x not in NEVER))}, or one number of these"

    def _values(self, variable: str, kind: str) -> "Value":
        if variable in self.layout.names and variable not in NEVER and not self.specs[variable][0].count:
            return lambda chunk, program: self._course(variable, chunk, program)
        if variable == EVENT_TIME:
            return lambda chunk, program: _tangents(chunk).event_times
        if variable.startswith(LAST) and kind == END and variable[len(LAST) :] in self.layout.names:
            return lambda chunk, program: self._last(variable[len(LAST) :], chunk, program)
        if variable in self.resolved.parameters.measures:
            return self._measure(variable)
        raise ScenarioError.at(PLACE, f'has "{variable}", which has no derivative', self._remedy(), variable)

    def _course(self, name: str, chunk: Chunk, program: Outline) -> np.ndarray:
        found = _tangents(chunk)
        program = replace(program, observed=found.observed)
        return Record(self.layout, found.records[:, :-1], program)[name][:, -len(self.times) :]

    def _last(self, name: str, chunk: Chunk, program: Outline) -> np.ndarray:
        found = _tangents(chunk)
        return Record(self.layout, found.records[:, -1:], replace(program, observed=found.observed))[name][:, 0]

    def _measure(self, name: str) -> "Value":
        """Of a measure: the arithmetic at its end, of what is kept."""
        measures, before = self.resolved.parameters.measures, 0
        for other, formula in measures.items():
            if other == name:
                break
            before += len(formula.kept)
        known = (x.event or (x.kind in (LARGEST, SMALLEST) and x.condition == NONE) for x in formula.kept)
        if formula.times or not all(known):
            rule = f'has "{name}", which is not made of values at events and of extremes of the whole run alone'
            raise ScenarioError.at(PLACE, rule, "leave it out, or ask for what it is made of", name)
        own = slice(before, before + len(formula.kept))
        return lambda chunk, _: _chained(formula, chunk.kept[:, own], _tangents(chunk).signals[:, own])


Value = Callable[[Chunk, Outline], np.ndarray]


def _tangents(chunk: Chunk) -> Tangents:
    assert chunk.tangents is not None
    found: Tangents = chunk.tangents
    return found


def _chained(formula: MeasureFormula, kept: np.ndarray, tangents: np.ndarray) -> np.ndarray:
    """The derivative (runs, inputs) of a formula of what is kept (runs, kept, 2) by that of the values (runs, kept,
    inputs); of its arithmetic by differences."""
    total = np.zeros((len(kept), tangents.shape[2]))
    for n in range(kept.shape[1]):
        step = STEP * np.where(kept[:, n, 0] == 0.0, 1.0, np.abs(kept[:, n, 0]))
        slope = np.zeros(len(kept))
        for place, weight in ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12)):
            moved = kept.copy()
            moved[:, n, 0] += place * step
            slope += weight * formula.number(moved)
        total += (slope / step)[:, None] * tangents[:, n]
    return total


def _flag_words() -> str:
    return "; ".join(f"{bit}: {sentence}" for bit, sentence in MEANINGS.items())
