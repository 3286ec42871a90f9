"""What a record holds: the variables of the dataset, from rows of numbers."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lienumba.batch.statistics import Course
from lienumba.groups.state import ELEMENT
from lienumba.integrators.layout import PROJECTIONS, state_rows, work_row
from lienumba.integrators.tracing.program import Outline
from lienumba.integrators.tracing.tracer import BODIES
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.elements.quantities import Part, joined
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import joint_coordinates
from lienumba.mechanics.system.constraints import constraints_of
from lienumba.mechanics.system.output_variables import MODE, OUTPUT_VARIABLES, OutputVariable, kept_largest
from lienumba.mechanics.system.switches import switch_names

if TYPE_CHECKING:
    from lienumba.batch.integrate import Chunk

AXES = {"axis": 3, "body_axis": 3}


@dataclass(frozen=True)
class Layout:
    """Names and shapes (behind run and time) of every variable that a record of this model gives; coordinates: of its
    joints, with their units, if they are recorded; quantities: what its quantities and the states of its laws give;
    switches: the names of its switched constraints."""

    bodies: int
    joints: int
    constraints: list[str]
    efforts: list[str]
    coordinates: dict[str, str]
    quantities: dict[str, Part]
    switches: tuple[str, ...] = ()

    @staticmethod
    def of(model: Model, coordinates: bool = False) -> "Layout":
        every = constraints_of(model)
        constraints = [f"{c.name}[{i}]" for c in every for i in range(c.rows)]
        driven = every[len(model.joints) :][: len(model.drivers)]
        efforts = [f"{c.name}.{axis}" if c.rows > 1 else c.name for c in driven for axis in "xyz"[: c.rows]]
        parts = {joined(q.name, part.name): part for q in model.quantities for part in quantities.parts(model, q)}
        for force in model.forces:
            for state in () if quantities.is_input(force.name) else force.initial:
                parts[f"{force.name}.{state}"] = Part(state, "1", f"state of the law {force.name}")
        own = joint_coordinates.units(model) if coordinates else {}
        return Layout(len(model.bodies), len(model.joints), constraints, efforts, own, parts, switch_names(model))

    @cached_property
    def variables(self) -> dict[str, OutputVariable]:
        """Those that are no quantities."""
        own = joint_coordinates.JOINT_COORDINATES if self.coordinates else {}
        return {**OUTPUT_VARIABLES, **own, **({MODE.name: MODE} if self.switches else {})}

    @property
    def names(self) -> list[str]:
        return [*self.variables, *self.quantities]

    def shape(self, name: str) -> tuple[int, ...]:
        if name in self.quantities:
            return (3,) if self.quantities[name].vector else ()
        return tuple(self._sizes[dim] for dim in self.variables[name].dims)

    @cached_property
    def _sizes(self) -> dict[str, int]:
        sizes = {"body": self.bodies, "joint": self.joints, **AXES}
        sizes |= {"constraint": len(self.constraints), "effort": len(self.efforts)}
        return sizes | {"coordinate": len(self.coordinates), "switch": len(self.switches)}

    def variable(self, name: str, chunk: "Chunk", program: Outline) -> np.ndarray:
        """A variable of the records of a chunk (blocks, outputs, ..., W)."""
        return Record(self, chunk.records, program, chunk.variables)[name]

    def course(self, name: str, chunk: "Chunk", program: Outline, times: np.ndarray) -> Course:
        """A variable of a chunk at its last outputs, which are at these times (times,), and where an event ended a run
        before the last of them."""
        values = self.variable(name, chunk, program)[:, -len(times) :]
        if chunk.stopped is None:
            return Course(values, times)
        from_start = np.concatenate([chunk.records[:, :1], chunk.stopped], axis=1)  # from where energies count
        ends = np.where(chunk.stopped_at < times[-1], chunk.stopped_at, np.nan)
        return Course(values, times, Record(self, from_start, program)[name][:, 1], ends)

    def largest(self, name: str, chunk: "Chunk", program: Outline, times: np.ndarray) -> np.ndarray:
        """The largest absolute value of a course (runs,); NaN for a run without any."""
        return per_run(self.course(kept_largest()[name].name, chunk, program, times).largest, len(chunk.codes))

    def at_events(self, name: str, chunk: "Chunk", program: Outline) -> np.ndarray:
        """A variable where each event first happened (runs, events, ...); NaN where it did not."""
        assert chunk.at_events is not None
        records = np.concatenate([chunk.records[:, :1], chunk.at_events], axis=1)  # energies count from the start
        return per_run(Record(self, records, program)[name][:, 1:], len(chunk.codes))

    def last(self, name: str, states: np.ndarray) -> np.ndarray:
        """A variable of the states (runs, 18 k + ...) where runs ended (runs, bodies, ...)."""
        state = OUTPUT_VARIABLES[name].state
        assert state is not None, "only of what is part of the state"
        rows = states[:, : ELEMENT * self.bodies].reshape(-1, self.bodies, ELEMENT)
        return rows[:, :, slice(*state)].reshape(len(states), *self.shape(name))


@dataclass(frozen=True)
class Record:
    """The records (blocks, outputs, rows, W) of a program; see `output_variables.Record`. known: variables that have
    been computed from them, by name."""

    layout: Layout
    rows: np.ndarray
    program: Outline
    known: dict[str, np.ndarray] = field(default_factory=dict)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.known:
            values = self.observed(name) if name in self.layout.quantities else self.layout.variables[name].values(self)
            blocks, outputs, _, width = self.rows.shape
            self.known[name] = values.reshape(blocks, outputs, *self.layout.shape(name), width)
        return self.known[name]

    def observed(self, name: str) -> np.ndarray:
        first, count = self.program.observed[name]
        first += state_rows(self.program.sizes)
        return self.rows[:, :, first : first + count]

    def state(self, first: int, end: int) -> np.ndarray:
        blocks, outputs, _, width = self.rows.shape
        bodies = self.layout.bodies
        rows = self.observed(BODIES) if BODIES in self.program.observed else self.rows[:, :, : ELEMENT * bodies]
        return rows.reshape(blocks, outputs, bodies, ELEMENT, width)[:, :, :, first:end]

    def work(self) -> np.ndarray | float:
        row = work_row(self.program.sizes)
        work: np.ndarray | float = self.rows[:, :, row] if self.program.augmented.work else 0.0
        return work

    def iterations(self, projection: int) -> np.ndarray:
        return self.rows[:, :, projection - PROJECTIONS]


def per_run(lanes: np.ndarray, runs: int) -> np.ndarray:
    """What lanes have, (blocks, ..., W), by run (runs, ...)."""
    blocks, *shape, width = lanes.shape
    by_run = lanes.transpose(0, -1, *range(1, lanes.ndim - 1))
    return by_run.reshape(blocks * width, *shape)[:runs]
