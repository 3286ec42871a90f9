"""What is stored of every run over time: a record for each variable, with how it is computed and how it is read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from lienumba.keys.registry import Registry
from lienumba.mechanics.elements.quantities import Observed
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints, dynamics, projection
from lienumba.numerics.number import Number


@dataclass(frozen=True)
class Observation:
    """A state, and what accelerations and multipliers say of it, computed where it is asked for; look: gives that, and
    the multipliers."""

    model: Model
    now: Instant
    look: Callable[[], tuple[Observed, Sequence[Number]]]

    @cached_property
    def _seen(self) -> tuple[Observed, Sequence[Number]]:
        return self.look()

    @property
    def observed(self) -> Observed:
        return self._seen[0]

    @property
    def multipliers(self) -> Sequence[Number]:
        return self._seen[1]

    def holding(self, rows: Sequence[Number]) -> list[Number]:
        """0 in the rows of constraints that do not hold now."""
        return projection.masked(rows, constraints.in_use(self.model, self.now))

    @cached_property
    def energies(self) -> tuple[Number, Number]:
        """Kinetic and potential (J)."""
        kinetic, potential = dynamics.energies(self.model, self.now)
        return kinetic, potential


class Record(Protocol):
    """What is stored of some runs: arrays (blocks, times, ..., lanes)."""

    def __getitem__(self, name: str) -> np.ndarray:
        """A variable."""

    def observed(self, name: str) -> np.ndarray:
        """The numbers of a variable that were computed when it was stored, in one row."""

    def state(self, first: int, end: int) -> np.ndarray:
        """Rows of the state of every body, from `first` to before `end`."""

    def work(self) -> np.ndarray | float:
        """Integrated along the step, with what changes have done; 0 where nothing ever works on the system."""

    def iterations(self, projection: int) -> np.ndarray:
        """The iterations of the projection of the positions (0) or the velocities (1)."""


@dataclass(frozen=True)
class OutputVariable:
    """A variable (run, time, *dims).

    rows(observation): its numbers, computed where a state is stored; read(record): its values, if they are not these
    numbers; state: the first row of it in each body's state, and the end; it is known where a run ended, too; count: a
    whole number, which a failed run has none of; flags: what each such number, from 0 on, means; since: of the interval
    since the stored time before; reaction: whether it is one of many where joints do the same; largest,
    largest_text: what the largest absolute value at the stored times is called, if that is kept of each run; asked: it
    is stored only where it is named, since others say the same.
    """

    name: str
    units: str
    long_name: str
    frame: str | None = None
    dims: tuple[str, ...] = ()
    rows: Callable[[Observation], Sequence[Number]] | None = None
    read: Callable[[Record], np.ndarray] | None = None
    state: tuple[int, int] | None = None
    count: bool = False
    flags: tuple[str, ...] = ()
    since: bool = False
    reaction: bool = False
    largest: str = ""
    largest_text: str = ""
    asked: bool = False

    def values(self, record: Record) -> np.ndarray:
        """(blocks, times, ..., lanes), its dimensions behind the bodies in one row."""
        if self.read is not None:
            return self.read(record)
        return record.observed(self.name) if self.state is None else record.state(*self.state)


def _work(record: Record) -> np.ndarray:
    work = record.work()
    since = work - work[:, :1] if isinstance(work, np.ndarray) else work  # what changes at the start is the start
    return np.where(np.isnan(record["energy"]), np.nan, since)


def _energy_residual(record: Record) -> np.ndarray:
    energy = record["energy"]
    with np.errstate(invalid="ignore"):  # a run may start with more energy than a number can hold
        residual: np.ndarray = energy - record["work"] - energy[:, :1]
        return residual


BODY, JOINT = ("body", "axis"), ("joint", "axis")
OUTPUT_VARIABLES: Registry[OutputVariable] = Registry("output variable", lambda variable: variable.name)
for variable in (
    OutputVariable("position", "m", "position of the mass centre", "global", BODY, state=(0, 3)),
    OutputVariable(
        "rotation", "1", "rotation matrix", "body to global", (*BODY, "body_axis"), state=(3, 12)
    ),
    OutputVariable("velocity", "m s-1", "velocity of the mass centre", "global", BODY, state=(12, 15)),
    OutputVariable("angular_velocity", "rad s-1", "angular velocity", "body", BODY, state=(15, 18)),
    OutputVariable(
        "joint_force", "N", "force of the joint on its second body, at its point", "global", JOINT,
        rows=lambda x: x.observed.forces, reaction=True,
    ),
    OutputVariable(
        "joint_torque", "N m", "torque of the joint on its second body, about its point", "global", JOINT,
        rows=lambda x: x.observed.torques, reaction=True,
    ),
    OutputVariable(
        "multiplier", "1", "Lagrange multiplier (N, or N m of an angle)", dims=("constraint",),
        rows=lambda x: x.multipliers, reaction=True, asked=True,
    ),
    OutputVariable(
        "driver_effort", "1", "force (N) or torque (N m) of the driver",
        "of a joint: along or about its axis; point: global; orientation: body; angular_velocity: that of its value",
        ("effort",), rows=lambda x: [effort for driver in x.observed.efforts for effort in driver], reaction=True,
    ),
    OutputVariable(
        "energy", "J", "total energy", read=lambda record: record["kinetic_energy"] + record["potential_energy"]
    ),
    OutputVariable("kinetic_energy", "J", "kinetic energy", rows=lambda x: [x.energies[0]]),
    OutputVariable("potential_energy", "J", "potential energy", rows=lambda x: [x.energies[1]]),
    OutputVariable("work", "J", "work done on the system since the start", read=_work),
    OutputVariable(
        "energy_residual", "J", "total energy minus work minus initial energy", read=_energy_residual,
        largest="max_energy_drift", largest_text="largest absolute energy residual at the stored times",
    ),
    OutputVariable(
        "position_violation", "m", "largest component of the position constraints",
        rows=lambda x: [constraints.largest(x.holding(constraints.residual(x.model, x.now)))],
        largest="max_position_violation", largest_text="largest position violation at the stored times",
    ),
    OutputVariable(
        "velocity_violation", "m s-1", "largest component of the velocity constraints",
        rows=lambda x: [constraints.largest(x.holding(constraints.rate_and_bias(x.model, x.now)[0]))],
        largest="max_velocity_violation", largest_text="largest velocity violation at the stored times",
    ),
    OutputVariable(
        "position_iterations", "1", "iterations of the position projection", count=True, since=True,
        read=lambda record: record.iterations(0),
    ),
    OutputVariable(
        "velocity_iterations", "1", "iterations of the velocity projection", count=True, since=True,
        read=lambda record: record.iterations(1),
    ),
):  # fmt: skip
    OUTPUT_VARIABLES.add(variable)


# Of a mechanism that changes: kept over the time without being asked for.
MODE = OutputVariable(
    "mode", "1", "how each switched constraint is on", dims=("switch",), count=True, flags=("off", "closed", "sliding")
)  # fmt: skip


def usual() -> list[str]:
    """The names of the variables that are stored where none are named."""
    return [name for name, x in OUTPUT_VARIABLES.items() if not x.asked]


def kept_at_end() -> list[OutputVariable]:
    """The variables that are also known where a run ended."""
    return [x for x in OUTPUT_VARIABLES.values() if x.state is not None]


def kept_largest() -> dict[str, OutputVariable]:
    """The variables whose largest absolute value is kept, by its name; what is derived from others comes last."""
    found = {x.largest: x for x in OUTPUT_VARIABLES.values() if x.largest}
    return dict(sorted(found.items(), key=lambda item: item[1].rows is None))
