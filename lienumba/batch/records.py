"""What a record holds: the variables of the dataset, from rows of numbers."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lienumba.groups.state import ELEMENT
from lienumba.integrators.held import Held
from lienumba.integrators.program import Program
from lienumba.mechanics import quantities
from lienumba.mechanics.constraints import constraints_of
from lienumba.mechanics.model import Model
from lienumba.mechanics.quantities import Part, joined

Values = dict[str, np.ndarray]
STATE = {
    "position": (0, 3, (3,)),
    "rotation": (3, 12, (3, 3)),
    "velocity": (12, 15, (3,)),
    "angular_velocity": (15, 18, (3,)),
}
SUMMARIES = {
    "max_position_violation": "position_violation",
    "max_velocity_violation": "velocity_violation",
    "max_energy_drift": "energy_residual",
}


@dataclass(frozen=True)
class Layout:
    """Names and shapes (behind run and time) of every variable that a record of this model gives."""

    bodies: int
    elements: int
    joints: int
    constraints: list[str]
    efforts: list[str]
    quantities: dict[str, Part]
    held: Held
    observed: dict[str, tuple[int, int]]

    @staticmethod
    def of(model: Model, program: Program) -> "Layout":
        every = constraints_of(model)
        constraints = [f"{c.name}[{i}]" for c in every for i in range(c.rows)]
        efforts = [
            f"{c.name}.{axis}" if c.rows > 1 else c.name for c in every[len(model.joints) :] for axis in "xyz"[: c.rows]
        ]
        parts = {joined(q.name, part.name): part for q in model.quantities for part in quantities.parts(model, q)}
        for force in model.forces:
            for state in force.initial:
                parts[f"{force.name}.{state}"] = Part(state, "1", f"state of the law {force.name}")
        return Layout(
            len(model.bodies), program.elements, len(model.joints), constraints, efforts, parts, program.held,
            program.observed,
        )  # fmt: skip

    @property
    def names(self) -> list[str]:
        return [
            *STATE, "joint_force", "joint_torque", "multiplier", "driver_effort",
            "energy", "kinetic_energy", "potential_energy", "work", "energy_residual",
            "position_violation", "velocity_violation", "position_iterations", "velocity_iterations",
            *self.quantities,
        ]  # fmt: skip

    @property
    def summaries(self) -> list[str]:
        return list(SUMMARIES)

    def shape(self, name: str) -> tuple[int, ...]:
        if name in STATE:
            return (self.bodies, *STATE[name][2])
        if name in ("joint_force", "joint_torque"):
            return (self.joints, 3)
        if name in self.quantities:
            return (3,) if self.quantities[name].vector else ()
        labels = {"multiplier": self.constraints, "driver_effort": self.efforts}
        return (len(labels[name]),) if name in labels else ()

    def unpack(self, records: np.ndarray) -> Values:
        """Every variable of records (runs, times, rows)."""
        runs, times, _ = records.shape
        state = records[:, :, : ELEMENT * self.bodies].reshape(runs, times, self.bodies, ELEMENT)
        values: Values = {
            name: state[..., first:end].reshape(runs, times, self.bodies, *shape)
            for name, (first, end, shape) in STATE.items()
        }
        start = ELEMENT * self.elements + self.held.rows
        for name, (first, rows) in self.observed.items():
            values[name] = records[:, :, start + first : start + first + rows].reshape(runs, times, *self.shape(name))
        values["position_iterations"] = records[:, :, -2]
        values["velocity_iterations"] = records[:, :, -1]
        values["energy"] = values["kinetic_energy"] + values["potential_energy"]
        energy = values["energy"]
        work = records[:, :, ELEMENT * self.elements + len(self.held.angles)] if self.held.work else 0.0
        values["work"] = np.where(np.isnan(energy), np.nan, work)
        with np.errstate(invalid="ignore"):  # a run may start with more energy than a number can hold
            values["energy_residual"] = energy - values["work"] - energy[:, :1]
        return values

    def summarise(self, name: str, values: Values) -> np.ndarray:
        """The largest absolute value over the stored times (runs,); NaN for a run without any."""
        series: Any = np.abs(values[SUMMARIES[name]])
        return np.where(np.isnan(series).all(axis=1), np.nan, np.nanmax(np.nan_to_num(series, nan=-1.0), axis=1))
