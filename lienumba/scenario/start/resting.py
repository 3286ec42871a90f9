"""The equilibria of runs: the states of bodies and laws, each run by itself."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lienumba.groups.state import ELEMENT
from lienumba.integrators.codes import NONE_FOUND
from lienumba.mechanics.elements.inputs.state import resting_inputs
from lienumba.mechanics.elements.user_laws import unsampled
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Counted, Model
from lienumba.scenario.start.stops import begin_beyond


@dataclass(frozen=True)
class Resting:
    """The states of runs in their equilibria.

    model: with the states of laws; states (runs, 18 k) of bodies; angles: those that are counted (runs,); status
    (runs,): see `codes.EQUILIBRIA`; of a run without an equilibrium the others are as they were given. force (runs,):
    the largest one left along a coordinate; growth (runs,): the largest real part of an eigenvalue (1/s); flowing: the
    model of the search, whose inputs rest at their limits; now: all runs where the search ended.
    """

    model: Model
    states: np.ndarray
    angles: dict[Counted, np.ndarray]
    status: np.ndarray
    force: np.ndarray
    growth: np.ndarray
    flowing: Model
    now: Instant

    def instant(self, run: int) -> Instant:
        """One run, in floats."""
        bodies = tuple(tuple(body.tolist()) for body in self.states[run].reshape(-1, ELEMENT))
        return Instant(bodies, 0.0, {which: float(angle[run]) for which, angle in self.angles.items()})


def resting(
    model: Model, states: np.ndarray, angles: Mapping[Counted, np.ndarray], rotation: Sequence[Any], driven: bool = True
) -> Resting:
    """Find the equilibria of runs from their assembled states.

    Parameters
    ----------
    model, states, angles
        Of all runs: the model with arrays (runs,), the states of bodies (runs, 18 k), the counted angles.
    rotation : three floats or arrays (runs,)
        The angular velocity (rad/s, global) of the axes against which they rest.
    driven : bool
        Whether states at rest get the velocities that drivers ask for.
    """
    from lienumba.integrators.tracing.linear.equilibrium import rest
    from lienumba.integrators.tracing.linear.freedoms import GluedTracer

    runs, flowing = len(states), resting_inputs(unsampled(model))
    tracer = GluedTracer.of(flowing)
    found = rest(tracer, flowing, tracer.rows_at_start(flowing, states, angles), runs, rotation, driven)
    first = len(found.rows) - tracer.augmented.rows
    now = tracer.instant(flowing, found.rows, 0.0)
    bodies = [np.broadcast_to(np.asarray(x, float), (runs,)) for body in now.bodies for x in body]
    with np.errstate(all="ignore"):
        beyond = begin_beyond(model, now, runs)
    good = (found.status != NONE_FOUND) & ~beyond & np.isfinite(bodies).all(axis=0)
    counted = dict(zip(tracer.augmented.angles, found.rows[first:], strict=False))
    return Resting(
        _with_laws(model, tracer.law_states.apart(found.rows[first - tracer.laws : first]), good),
        np.where(good[:, None], np.stack(bodies, axis=1), states),
        {which: np.where(good, counted.get(which, angle), angle) for which, angle in angles.items()},
        np.where(good, found.status, NONE_FOUND).astype(np.int8),
        found.force,
        found.growth,
        flowing,
        now,
    )


def _with_laws(model: Model, laws: Mapping[str, Sequence[Any]], good: np.ndarray) -> Model:
    """The model whose laws start with these states."""
    forces = []
    for force in model.forces:
        if force.name in laws and force.code is not None:
            settled = zip(force.initial.items(), laws[force.name], strict=True)
            force = replace(force, initial={name: np.where(good, x, before) for (name, before), x in settled})
        forces.append(force)
    return replace(model, forces=tuple(forces))
