"""Runs of a model in one mode: what is on stays on, whatever happens."""

from dataclasses import replace
from typing import Any

import numpy as np

from lienumba.batch.execute import execute, tasks
from lienumba.batch.integrate import Batch
from lienumba.batch.records import Layout, per_run
from lienumba.integrators.tracing.compiled import compiled
from lienumba.integrators.tracing.joint import states as joint_states
from lienumba.integrators.tracing.program import Method
from lienumba.integrators.tracing.row_selection import UNIQUE
from lienumba.integrators.tracing.template import split
from tests.facade import Instant, Model

STICK, SLIDE = 1.0, 2.0
On = dict[str, tuple[float, tuple[float, ...]]]


def integrate(
    model: Model, now: Instant, on: On, step: float, steps: int, coordinates: str = "lie", **method: Any
) -> tuple[int, dict[str, np.ndarray]]:
    """The status of one run, and all variables at its end. on: by the name of a switch how it is on, and its memory."""
    settings = replace(Method("rk4", "local", "mass", coordinates=coordinates), **method)
    program, machine = compiled(model, settings)
    held, sizes = program.augmented, program.sizes
    augmented = held.start(now.angles, UNIQUE, 1)
    for n, switch in enumerate(program.switches):
        how, memory = on.get(switch.name, (0.0, (0.0,) * switch.memories))
        rows = switch.rows - (switch.tangents if how == SLIDE else 0) if how else 0
        first = held.first_mode + switch.first
        augmented[:, first : first + switch.rows] = np.arange(switch.rows) < rows
        augmented[:, held.first_mode + held.switched + n] = how
        kept = held.first_mode + held.switched + sizes.switches + switch.memory
        augmented[:, kept : kept + switch.memories] = memory
    bodies = np.ravel(now.bodies)[None]
    by_joints = coordinates == "joint"
    first_rows = joint_states.start(model, program.law_states, 1) if by_joints else bodies
    states = np.concatenate([first_rows, augmented], axis=1)
    times = np.array([0.0, step * steps])
    batch = Batch(
        machine, split(model)[1], states, np.zeros(1, np.int8), step * steps, step, times, 1e-12, 10,
        bodies=len(model.bodies), placed=bodies if by_joints else None,
    )  # fmt: skip
    (chunk,) = execute(tasks(batch, 1, lambda chunk: chunk), 1, lambda done: None)
    layout = Layout.of(model)
    names = ["position", "velocity", "joint_force", "joint_torque", "energy_residual", "position_violation"]
    values = {name: per_run(layout.variable(name, chunk, program), 1)[0, -1] for name in names}
    return int(chunk.codes[0]), values
