"""Starts from equilibria as a dataset stores them.

A replay begins with these numbers and does not search again: another processor, or another version of SciPy, finds
equilibria that differ by roundoff.
"""

from dataclasses import replace

import numpy as np

from lienumba.groups.state import ELEMENT
from lienumba.mechanics.mechanism.model import Model
from lienumba.scenario.start.prepare import Nominal, Prepared

PLACES = (
    *(f"position.{x}" for x in "xyz"),
    *(f"rotation.{x}{y}" for x in "xyz" for y in "xyz"),
    *(f"velocity.{x}" for x in "xyz"),
    *(f"angular_velocity.{x}" for x in "xyz"),
)


def start_names(nominal: Nominal) -> list[str]:
    """What each of the numbers is; none where runs do not start in equilibria."""
    if nominal.built[1].rotation is None:
        return []
    model = nominal.model
    bodies = [f"{body.name}.{place}" for body in model.bodies for place in PLACES]
    return [*bodies, *(f"angle.{n}" for n, _ in enumerate(nominal.assembled.angles)), *_law_states(model)]


def start_numbers(prepared: Prepared) -> np.ndarray:
    """States of bodies, angles over all turns and states of laws (runs, n); n = 0 without equilibria."""
    runs = len(prepared.states)
    if prepared.rests is None:
        return np.zeros((runs, 0))
    laws = [np.broadcast_to(x, runs) for force in prepared.model.forces for x in force.initial.values()]
    return np.column_stack([prepared.states, *prepared.angles.values(), *laws])


def with_start(prepared: Prepared, numbers: np.ndarray) -> Prepared:
    """These runs with the numbers (runs, n) of `start_numbers`."""
    bodies, angles = ELEMENT * len(prepared.model.bodies), len(prepared.angles)
    laws = iter(numbers[:, bodies + angles :].T)
    forces = [replace(x, initial={name: next(laws) for name in x.initial}) for x in prepared.model.forces]
    return prepared._replace(
        model=replace(prepared.model, forces=tuple(forces)),
        states=numbers[:, :bodies],
        angles=dict(zip(prepared.angles, numbers[:, bodies : bodies + angles].T, strict=True)),
    )


def _law_states(model: Model) -> list[str]:
    return [f"{force.name}.{state}" for force in model.forces for state in force.initial]
