"""What a scenario keeps of every run: tables with one record for each run, of which the dataset is made.

There are two: `run`, of every run, and in the mode "summary" `full_run`, the course of those runs that keep it.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.integrate import Chunk
from lienumba.batch.records import Layout, per_run
from lienumba.batch.statistics import MEANINGS, STATISTICS, energy_scale
from lienumba.batch.statuses import GOOD, INVALID, NOT_ASSEMBLED, UNDEFINED
from lienumba.engine.fields import Field, changes_told, fates, measured, reduced
from lienumba.engine.requirements import judge_runs, judged_of
from lienumba.errors import ScenarioError
from lienumba.integrators.tracing.program import Outline
from lienumba.mechanics.elements.quantities import XYZ, Part, owner
from lienumba.mechanics.system.joint_coordinates import JOINT_COORDINATES, UNITS
from lienumba.mechanics.system.output_variables import MODE, OUTPUT_VARIABLES, kept_at_end, kept_largest
from lienumba.scenario.base.arguments import parse_ranges
from lienumba.scenario.formulas.measures import is_formula
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.design import weights
from lienumba.scenario.start.prepare import Nominal
from lienumba.scenario.start.stored_start import start_names
from lienumba.store import layout, provenance
from lienumba.store.layout import (
    FULL,
    MARGIN,
    MET,
    RELATIVE_DRIFT,
    RUN,
    SERIES,
    VARIABLES,
    WEIGHT,
    Variable,
    is_taken,
)
from lienumba.store.names import INPUT, NOT_OF_A_NAME, SHOW, START_STATE, Name, Names, kind_of, names_in, with_failed
from lienumba.store.shards import LABEL

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.engine.sensitivities.fields import Derivatives

KEPT = "kept "  # before the names of tables of another scenario


@dataclass(frozen=True)
class Piece:
    """Some finished runs: their tables, by name, and for how long (s) cores were busy with them."""

    tables: dict[str, np.ndarray]
    seconds: float

    @property
    def codes(self) -> np.ndarray:
        codes: np.ndarray = self.tables["run"]["status"]
        return codes

    def of(self, kept: np.ndarray) -> "Piece":
        """The piece of those runs (a mask) alone."""
        labels = self.tables["run"][LABEL][kept]
        return Piece({name: x[np.isin(x[LABEL], labels)] for name, x in self.tables.items()}, self.seconds)


def joined(pieces: Sequence[Piece], seconds: float) -> Piece:
    """The piece of all these runs."""
    tables = {name: np.concatenate([piece.tables[name] for piece in pieces]) for name in pieces[0].tables}
    return Piece(tables, seconds)


class Results:
    """tables: the fields of each table; labels are kept beside them."""

    def __init__(self, resolved: Scenario, nominal: Nominal) -> None:
        data = resolved.data
        self.resolved, self.model, self.nominal = resolved, nominal.model, nominal
        self.derivatives: Derivatives | None = None
        self.layout = Layout.of(nominal.model, data.output.joint_coordinates)
        self.times = np.array(resolved.times)
        output = data.output
        self.changes = changes_told(self.model, output.max_changes)
        self.start = [] if nominal.rests is None else start_names(nominal)
        courses = [self._course(name) for name in self.layout.names if self._stored(name, output.variables)]
        courses = [field for field in courses if all(field.shape)]  # some mechanisms have no joints
        once = [field for field in self._fates() if all(field.shape)] + self._asked(taken=[x.name for x in courses])
        if output.mode == "full":
            self.tables = {"run": [*courses, *once]}
        else:
            courses_of_some = [replace(x, spec=replace(x.spec, dims=(FULL, *x.spec.dims[1:]))) for x in courses]
            self.tables = {"run": once} | ({FULL: courses_of_some} if output.full_runs and courses else {})
        self.judged = judged_of(resolved, self.names) if data.model.requirements else ()
        wanted = (len(self.judged),)
        follow = [Field(name, VARIABLES[name], wanted, None, dtype) for name, dtype in ((MARGIN, "f8"), (MET, "i1"))]
        self.tables["run"] = [*self.tables["run"], *(follow if all(wanted) else ())]
        if resolved.weighted:
            self.tables["run"].append(Field(WEIGHT, VARIABLES[WEIGHT], (), None))
        self.derivatives = self._derivatives()
        if self.derivatives is not None:
            self.tables["run"] += self.derivatives.fields()

    def _derivatives(self) -> "Derivatives | None":
        """Those that are asked for."""
        if self.resolved.data.sensitivities is None:
            return None
        from lienumba.engine.sensitivities.fields import Derivatives

        specs = {field.name: (field.spec, field.shape) for field in self.tables["run"]}
        return Derivatives(self.resolved, self.nominal, self.layout, self.times, self.names, specs)

    def with_numbers(self, resolved: Scenario, nominal: Nominal) -> "Results":
        """The same of a scenario that differs from this one in numbers of the model alone."""
        other = copy(self)
        other.resolved, other.model, other.nominal = resolved, nominal.model, nominal
        other.judged = judged_of(resolved, self.names) if self.judged else ()
        if self.derivatives is not None:
            other.derivatives = replace(self.derivatives, resolved=resolved, nominal=nominal)
        return other

    def _stored(self, name: str, variables: list[str]) -> bool:
        if name not in self.layout.quantities:
            return name in variables or name == MODE.name
        return name.partition(".")[0] in variables or owner(name)[0] in variables

    def _course(self, name: str) -> Field:
        spec, shape = self._spec(name), (len(self.times), *self.layout.shape(name))
        if single := not spec.count and self._precision(name) == "float32":
            spec = replace(spec, dtype="float32")
        return Field(
            name,
            spec,
            shape,
            lambda *found: per_run(self._lanes(name, *found), len(found[0].codes)),
            "f4" if single else "f8",
        )

    def _precision(self, name: str) -> str:
        """In which a course is stored: a part of a quantity by its own name, or else as the whole."""
        given = self.resolved.data.output.precision
        if isinstance(given, str):
            return given
        whole = (name.partition(".")[0], owner(name)[0]) if name in self.layout.quantities else ()
        return next((given[x] for x in (name, *whole) if x in given), "float64")

    def _lanes(self, name: str, chunk: Chunk, program: Outline) -> np.ndarray:
        """A variable at the stored times (blocks, times, ..., W); records have the start, too."""
        return self.layout.variable(name, chunk, program)[:, -len(self.times) :]

    def _fates(self) -> list[Field]:
        """How runs ended, and what the whole dataset has one of for each run."""
        found = [*fates(self.model, self.changes, len(self.start)), *map(self._largest, kept_largest())]
        return [*found, self._relative_drift(), *(self._last(x.name) for x in kept_at_end())]

    def _at_events(self) -> Iterator[Field]:
        """What is asked for at events."""
        events = len(self.model.events)
        for asked in self.resolved.data.output.at_events if events else ():
            for shown, name, part in self._parts(asked):
                spec, shape = self._spec(name), self.layout.shape(name)
                dims = spec.dims[2:] if part is None else ()
                text = f"{spec.long_name}{'' if part is None else ', ' + shown.rpartition('.')[2]}, at the event"
                own = Variable((*RUN, "event", *dims), spec.units, text, spec.frame)
                yield Field(f"event_{shown}", own, (events, *(shape if part is None else ())), self._seen(name, part))

    def _seen(self, name: str, part: int | None) -> Callable[[Chunk, Outline], np.ndarray]:
        def value(chunk: Chunk, program: Outline) -> np.ndarray:
            values = self.layout.at_events(name, chunk, program)
            return values if part is None else values[:, :, part]

        return value

    def _largest(self, name: str) -> Field:
        return Field(
            name,
            VARIABLES[name],
            (),
            lambda chunk, program: self.layout.largest(name, chunk, program, np.unique([0.0, *self.times])),
        )

    def _relative_drift(self) -> Field:
        """The largest energy residual by the energy that was exchanged; see `energy_scale`."""

        def value(chunk: Chunk, program: Outline) -> np.ndarray:
            times = np.unique([0.0, *self.times])
            names = ("energy_residual", "kinetic_energy", "potential_energy")
            residual, *energies = (self.layout.course(name, chunk, program, times) for name in names)
            largest = residual.largest
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                drift = np.where(largest == 0.0, 0.0, largest / energy_scale(*energies))
            return per_run(drift, len(chunk.codes))

        return Field(RELATIVE_DRIFT, VARIABLES[RELATIVE_DRIFT], (), value)

    def _last(self, name: str) -> Field:
        def value(chunk: Chunk, program: Outline) -> np.ndarray:
            states = self.layout.last(name, chunk.states)
            began = (chunk.codes != INVALID) & (chunk.codes != NOT_ASSEMBLED)
            return np.where(began.reshape(-1, *[1] * (states.ndim - 1)), states, np.nan)

        return Field(f"last_{name}", VARIABLES[f"last_{name}"], self.layout.shape(name), value)

    def _asked(self, taken: Sequence[str]) -> list[Field]:
        """What is asked for at events, and summaries; taken: names of variables."""
        events = self._named("output.at_events", self._at_events(), taken)
        summaries = self._summaries([*taken, *(field.name for field in events)])
        others = [*taken, *(field.name for field in (*events, *summaries))]
        return [*events, *summaries, *self._named("measures", self._measured(), others)]

    def _measured(self) -> Iterator[Field]:
        """Numbers of whole runs, by formulas and by functions."""
        yield from measured(self.resolved, self.model)
        output = OUTPUT_VARIABLES
        seen = [x for x in self.layout.names if x not in output or not output[x].reaction]  # these are not always there

        def courses(name: str, chunk: Chunk, program: Outline) -> np.ndarray:
            return per_run(self._lanes(name, chunk, program), len(chunk.codes))

        yield from reduced(self.resolved, seen, self.times, courses)

    def _summaries(self, taken: Sequence[str]) -> list[Field]:
        """Each once, if it is asked for in two ways."""
        data = self.resolved.data
        every = [
            self._summary(shown, name, part, statistic)
            for asked, statistics in data.output.summary.items()
            for shown, name, part in self._parts(asked)
            for statistic in statistics
        ]
        return self._named("output.summary", every, taken)

    def _named(self, asked: str, fields: Iterable[Field], taken: Sequence[str]) -> list[Field]:
        """Each of these fields once; a ScenarioError if the dataset has another variable of that name."""
        found = {field.name: field for field in fields if all(field.shape)}
        requirements = {requirement.name for requirement in self.resolved.data.model.requirements}
        for name in found:
            if name in taken or is_taken(name):
                place = "requirements" if name in requirements else asked  # whose formula is a measure of their name
                raise ScenarioError(
                    f"{place}: gives {name}, but the dataset has a variable of this name already; give one of the two "
                    "another name"
                )
        return list(found.values())

    def _parts(self, asked: str) -> list[tuple[str, str, int | None]]:
        """How a thing that is asked for is called, its variable, and which component of this it is."""
        parts = [name for name in self.layout.quantities if name.partition(".")[0] == asked]
        if parts or asked in self.layout.names:
            return [(name, name, None) for name in parts or [asked]]
        first, _, rest = asked.partition(".")
        if first in JOINT_COORDINATES:
            return [(asked, first, list(self.layout.coordinates).index(rest))]
        whole, _, last = asked.rpartition(".")
        return [(asked, whole, XYZ.index(last))]

    def _summary(self, shown: str, name: str, part: int | None, statistic: str) -> Field:
        spec, shape = self._spec(name), self.layout.shape(name)
        dims = spec.dims[2:]
        if part is not None:
            dims, shape = (), ()

        def value(chunk: Chunk, program: Outline) -> np.ndarray:
            course = self.layout.course(name, chunk, program, self.times)
            return per_run(STATISTICS[statistic](course if part is None else course.part(part)), len(chunk.codes))

        units, of = spec.units, "" if part is None else f", {shown.removeprefix(name)[1:]}"
        if part is not None and name in UNITS:
            units = UNITS[name][list(self.layout.coordinates.values())[part]]
        unit = "s" if statistic == "time_of_max" else units
        ends = statistic == "final" and any(event.stop for event in self.model.events)
        text = f"{MEANINGS[statistic]}{', or where an event ended the run' if ends else ''}: {spec.long_name}{of}"
        return Field(f"{shown}_{statistic}", Variable((*RUN, *dims), unit, text, spec.frame), shape, value)

    def _spec(self, name: str) -> Variable:
        if name in self.layout.quantities:
            return self._quantity(self.layout.quantities[name])
        return layout.course(self.layout.variables[name])

    def _quantity(self, part: Part) -> Variable:
        if not part.vector:
            return Variable(SERIES, part.units, part.long_name)
        assert part.frame is not None
        frame = "global" if part.frame < 0 else self.model.bodies[part.frame].name
        return Variable((*SERIES, "axis"), part.units, part.long_name, frame)

    def labels(self, runs: np.ndarray) -> dict[str, np.ndarray]:
        """The labels of each table, of these runs."""
        return {name: runs[self.in_full(runs)] if name == FULL else runs for name in self.tables}

    @property
    def names(self) -> Names:
        """What the dataset will have."""
        coordinates, wanted = self.layout.coordinates, self.resolved.data.model.requirements
        labels = {
            "event": [event.name for event in self.model.events],
            "body": [body.name for body in self.model.bodies],
            "joint": [joint.name for joint in self.model.joints],
            "constraint": self.layout.constraints,
            "effort": self.layout.efforts,
            "change": [*map(str, range(self.changes))],
            "requirement": [x.name for x in wanted],
            "switch": self.layout.switches,
            "coordinate": [*coordinates],
            "coordinate_units": [*coordinates.values()],
            "input": [] if self.derivatives is None else self.derivatives.by,
            **dict.fromkeys(("axis", "body_axis"), XYZ),
        }
        every = [
            x
            for field in chain(*self.tables.values())
            if field.name != START_STATE
            for x in names_in(
                field.name,
                [dim for dim in field.spec.dims if dim not in NOT_OF_A_NAME],
                labels,
                field.spec.units,
                kind_of(field.name, field.spec.dims, field.spec.measure is not None),
            )
        ]
        data = self.resolved.data
        inputs = [Name(path, path, (), INPUT, self.resolved.units(path)) for path in data.sweep.vary]
        values = {x.name: "" if is_formula(x.value) else x.value for x in wanted}
        return Names(with_failed([*every, *inputs]), [*values], values.__getitem__)

    def dtype(self, table: str) -> np.dtype[Any]:
        """Of the records of a table."""
        return self._dtypes[table]

    @cached_property
    def _dtypes(self) -> dict[str, np.dtype[Any]]:
        return {
            table: np.dtype([(LABEL, "i8"), *((x.name, x.dtype, x.shape) for x in fields)])
            for table, fields in self.tables.items()
        }

    def piece(self, chunk: Chunk, program: Outline, labels: np.ndarray) -> Piece:
        """What is kept of a chunk, which has these runs."""
        found, chunk = {}, self._judged(chunk, program)
        for table, fields in self.tables.items():
            kept = self.in_full(labels) if table == FULL else np.ones(len(labels), bool)
            records = np.empty(int(kept.sum()), self.dtype(table))
            records[LABEL] = labels[kept]
            for field in fields if kept.any() else ():
                if field.value is None:
                    continue
                values = field.value(chunk, program)
                with np.errstate(over="ignore"):  # what single precision cannot hold is infinite
                    records[field.name] = values if kept.all() else values[kept]
            found[table] = records
        if self.judged:
            judge_runs(found["run"], self.judged)
        for name, formula in self.resolved.parameters.measures.items():
            if formula.times:  # a time that there is not; whoever judged has seen that it is late, or early
                column: Any = found["run"][name]
                column[np.isinf(column)] = np.nan
        if self.resolved.weighted:
            found["run"][WEIGHT] = weights(self.resolved, labels)
        return Piece(found, chunk.seconds)

    def _judged(self, chunk: Chunk, program: Outline) -> Chunk:
        """The chunk with the runs marked of which something that is kept is not finite while they go on."""
        going = self.times <= chunk.ends[:, None]
        bad = np.zeros(len(chunk.codes), bool)
        for name in self._kept:
            finite = np.isfinite(self._lanes(name, chunk, program))
            if not finite.all():
                every = per_run(finite, len(bad)).reshape(*going.shape, -1).all(axis=2)
                bad |= (~every & going).any(axis=1)
        bad &= np.isin(chunk.codes, GOOD)
        return replace(chunk, codes=np.where(bad, UNDEFINED, chunk.codes).astype(np.int8)) if bad.any() else chunk

    @cached_property
    def _kept(self) -> list[str]:
        """What of all courses is stored or summed up."""
        output = self.resolved.data.output
        summed = {name for asked in output.summary for _, name, _ in self._parts(asked)}
        return [x for x in self.layout.names if x in summed or self._stored(x, output.variables)]

    def in_full(self, labels: np.ndarray) -> np.ndarray:
        """Which runs keep their course in the mode "summary" (runs,)."""
        return in_full(self.resolved, labels)

    def frame(self, inputs: Iterable[str], total: int) -> "xr.Dataset":
        """The dataset without any run yet."""
        none = np.empty(0)
        fields = [field for every in self.tables.values() for field in every]
        empty = {field.name: np.empty((0, *field.shape), field.dtype) for field in fields}
        return self.dataset(empty, none.astype(np.int64), dict.fromkeys(inputs, none), total)

    def dataset(
        self,
        arrays: dict[str, np.ndarray],
        labels: np.ndarray,
        samples: dict[str, np.ndarray],
        total: int,
        **more: str,
    ) -> "xr.Dataset":
        """The dataset of the tables' columns; total: of how many runs it will be; more: attributes."""
        data = self.resolved.data
        model = self.model
        return layout.dataset(
            variables=arrays,
            times=self.resolved.times,
            runs=labels.tolist(),
            full_runs=labels[self.in_full(labels)].tolist(),
            total=total,
            bodies=[body.name for body in model.bodies],
            joints=[joint.name for joint in model.joints],
            constraints=self.layout.constraints,
            efforts=self.layout.efforts,
            coordinates=self.layout.coordinates,
            events=[event.name for event in model.events],
            changes=self.changes,
            switches=self.layout.switches,
            start=self.start,
            requirements={one.requirement.name: one.units for one in self.judged},
            by={} if self.derivatives is None else dict(zip(self.derivatives.by, self.derivatives.units, strict=True)),
            shared=self.nominal.rank.shared,
            own={field.name: field.spec for fields in self.tables.values() for field in fields},
            inputs=samples,
            input_units={path: self.resolved.units(path) for path in samples},
            attributes={
                **provenance.attributes(
                    data.title, self.resolved.to_toml(), self.resolved.sha256(), data.sweep.seed, provenance.command()
                ),
                **({} if data.output.show is None else {SHOW: ", ".join(data.output.show)}),
                **more,
            },
        )


def in_full(resolved: Scenario, labels: np.ndarray) -> np.ndarray:
    """Which runs keep their course in the mode "summary" (runs,)."""
    data = resolved.data
    kept = np.zeros(len(labels), bool)
    for part in parse_ranges(data.output.full_runs, "") if data.output.full_runs is not None else []:
        kept |= (labels >= part.start) & (labels < part.stop)
    return kept


class Twice(Results):
    """Keeps of the same runs what another scenario keeps, too, which stores fewer times of the same mechanism."""

    def __init__(self, resolved: Scenario, nominal: Nominal, original: Scenario) -> None:
        super().__init__(resolved, nominal)
        self.original = Results(original, nominal)
        records, needed = (np.unique([0.0, *times]) for times in (resolved.times, original.times))
        self.places = np.searchsorted(records, needed)

    def piece(self, chunk: Chunk, program: Outline, labels: np.ndarray) -> Piece:
        whole = super().piece(chunk, program, labels)
        tangents = chunk.tangents
        if tangents is not None:  # the last ones are of the end
            tangents = replace(tangents, records=tangents.records[:, [*self.places, -1]])
        chunk = replace(chunk, records=chunk.records[:, self.places], variables={}, tangents=tangents)
        fewer = self.original.piece(chunk, program, labels)
        return replace(whole, tables=whole.tables | {KEPT + name: table for name, table in fewer.tables.items()})

    def kept(self, piece: Piece) -> Piece:
        """What the other scenario keeps of a piece."""
        tables = {name.removeprefix(KEPT): x for name, x in piece.tables.items() if name.startswith(KEPT)}
        return replace(piece, tables=tables)
