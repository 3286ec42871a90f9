"""What a record holds: the variables of the dataset, from rows of numbers."""

from dataclasses import dataclass

import numpy as np

from lienumba.groups.state import ELEMENT
from lienumba.integrators.layout import state_rows
from lienumba.integrators.tracing.program import Program
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.elements.quantities import Part, joined
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system.constraints import constraints_of

STATE = {
    "position": (0, 3, (3,)),
    "rotation": (3, 12, (3, 3)),
    "velocity": (12, 15, (3,)),
    "angular_velocity": (15, 18, (3,)),
}
ITERATIONS = ("position_iterations", "velocity_iterations")  # the last rows
SUMMARIES = {
    "max_position_violation": "position_violation",
    "max_velocity_violation": "velocity_violation",
    "max_energy_drift": "energy_residual",
}


@dataclass(frozen=True)
class Layout:
    """Names and shapes (behind run and time) of every variable that a record of this model gives."""

    bodies: int
    joints: int
    constraints: list[str]
    efforts: list[str]
    quantities: dict[str, Part]

    @staticmethod
    def of(model: Model) -> "Layout":
        every = constraints_of(model)
        constraints = [f"{c.name}[{i}]" for c in every for i in range(c.rows)]
        efforts = [
            f"{c.name}.{axis}" if c.rows > 1 else c.name for c in every[len(model.joints) :] for axis in "xyz"[: c.rows]
        ]
        parts = {joined(q.name, part.name): part for q in model.quantities for part in quantities.parts(model, q)}
        for force in model.forces:
            for state in force.initial:
                parts[f"{force.name}.{state}"] = Part(state, "1", f"state of the law {force.name}")
        return Layout(len(model.bodies), len(model.joints), constraints, efforts, parts)

    @property
    def names(self) -> list[str]:
        return [
            *STATE, "joint_force", "joint_torque", "multiplier", "driver_effort",
            "energy", "kinetic_energy", "potential_energy", "work", "energy_residual",
            "position_violation", "velocity_violation", *ITERATIONS, *self.quantities,
        ]  # fmt: skip

    def shape(self, name: str) -> tuple[int, ...]:
        if name in STATE:
            return (self.bodies, *STATE[name][2])
        if name in ("joint_force", "joint_torque"):
            return (self.joints, 3)
        if name in self.quantities:
            return (3,) if self.quantities[name].vector else ()
        labels = {"multiplier": self.constraints, "driver_effort": self.efforts}
        return (len(labels[name]),) if name in labels else ()

    def lanes(self, name: str, records: np.ndarray, program: Program) -> np.ndarray:
        """A variable of the records (blocks, outputs, rows, W) of a program, with its shape before W."""
        blocks, outputs, _, width = records.shape
        if name in STATE:
            first, end, shape = STATE[name]
            rows = records[:, :, : ELEMENT * self.bodies].reshape(blocks, outputs, self.bodies, ELEMENT, width)
            return rows[:, :, :, first:end].reshape(blocks, outputs, self.bodies, *shape, width)
        if name in ITERATIONS:
            return records[:, :, ITERATIONS.index(name) - len(ITERATIONS)]
        if name == "energy":
            kinetic: np.ndarray = self.lanes("kinetic_energy", records, program) + self.lanes(
                "potential_energy", records, program
            )
            return kinetic
        if name == "work":
            row = ELEMENT * program.sizes.elements + len(program.augmented.angles)
            work = records[:, :, row] if program.augmented.work else 0.0
            return np.where(np.isnan(self.lanes("energy", records, program)), np.nan, work)
        if name == "energy_residual":
            energy = self.lanes("energy", records, program)
            with np.errstate(invalid="ignore"):  # a run may start with more energy than a number can hold
                residual: np.ndarray = energy - self.lanes("work", records, program) - energy[:, :1]
                return residual
        first, count = program.observed[name]
        first += state_rows(program.sizes)
        return records[:, :, first : first + count].reshape(blocks, outputs, *self.shape(name), width)

    def summary(self, name: str, records: np.ndarray, program: Program, runs: int) -> np.ndarray:
        """The largest absolute value over the stored times (runs,); NaN for a run without any."""
        largest = np.fmax.reduce(np.abs(self.lanes(SUMMARIES[name], records, program)), axis=1)
        return per_run(largest, runs)

    def last(self, name: str, states: np.ndarray) -> np.ndarray:
        """A variable of the states (runs, rows) where runs ended (runs, bodies, ...)."""
        first, end, shape = STATE[name]
        rows = states[:, : ELEMENT * self.bodies].reshape(-1, self.bodies, ELEMENT)
        return rows[:, :, first:end].reshape(len(states), self.bodies, *shape)


def per_run(lanes: np.ndarray, runs: int) -> np.ndarray:
    """What lanes have, (blocks, ..., W), by run (runs, ...)."""
    by_run: np.ndarray = np.moveaxis(lanes, -1, 1).reshape(lanes.shape[0] * lanes.shape[-1], *lanes.shape[1:-1])[:runs]
    return by_run
