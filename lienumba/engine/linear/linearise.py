"""`lienumba.linearise`: the linear system of every run, as a labelled dataset."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.engine.linear.states import Asked, At
from lienumba.errors import ScenarioError
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.linear.outputs import DERIVATIVES, LinearOutputs, inputs_of, visible
from lienumba.integrators.tracing.linear.systems import STILL, Recorded, States, Systems
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.tree.links import Link
from lienumba.store.linear_layout import SYSTEMS

if TYPE_CHECKING:
    import os

    import xarray as xr

XYZ = ("x", "y", "z")


def linearise(
    scenario: "Any | xr.Dataset | str | os.PathLike[str]",
    *,
    at: At = 0.0,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    rotation: Sequence[float] = STILL,
    runs: Sequence[int] | None = None,
    overrides: Mapping[str, Any] | None = None,
    allow_code: bool = False,
) -> "xr.Dataset":
    """Linearise the equations of motion of every run about its motion at some times.

    x' = A x + B u, y = C x + D u, in as many coordinates as the mechanism has freedoms: coordinates of joints, and of
    free bodies and balls along the axes of what they hang on, then their rates, then the states of laws. At an
    equilibrium, static or relative to `rotation`, A is constant; elsewhere it is that of this moment.

    Parameters
    ----------
    scenario : path, dict, System or xarray.Dataset
        A scenario, or a dataset (or its .nc file). Where a dataset holds the states of its runs at a time they are
        taken from there, else the runs are simulated up to it; `origin` says which.
    at : float, "end" or several of them
        Times in s, from 0 to the end.
    inputs : sequence of str, optional
        Numbers of forces and what drivers prescribe, such as "forces.motor.value" or "drivers.crank"; by default every
        formula of a force, and all drivers. Of what is driven also the rate and the acceleration are inputs, whether
        they act or not.
    outputs : sequence of str, optional
        Quantities; by default all that need no more than positions and velocities.
    rotation : three floats
        The angular velocity in rad/s, global frame, of axes along which free bodies and balls are looked at.
    runs : sequence of int, optional
        Labels of runs; all by default.
    overrides : mapping, optional
        New values of the scenario by path.
    allow_code : bool
        Run Python code that a file brings.

    Returns
    -------
    xarray.Dataset
        A, B, C, D on (run, time, ...), `origin` on time; NaN for runs that are not there at a time, or whose freedoms
        are others than those of most. The state is in the units of its coordinates (m, rad, s).

    Raises
    ------
    ScenarioError
        For bad input, with a sentence for each problem.
    """
    asked = Asked.of(scenario, at, runs, overrides, allow_code)
    prepared = asked.prepared()
    tracer, model = FreedomTracer.of(prepared.model), prepared.nominal.model
    added, seen = inputs_of(model, inputs), visible(model, outputs)
    recorded = Recorded.of(tracer, LinearOutputs(tuple(added), tuple(seen)), prepared.model)
    names_u = [x.name + more for x in added for more in DERIVATIVES]
    names_x: list[str] | None = None
    whole: dict[str, np.ndarray] = {}
    origins = []
    for k, states in enumerate(asked.states(tracer, prepared)):
        check_states(tracer, states)
        origins.append(states.origin)
        for system in largest_first(recorded.systems(states, turning(rotation))):
            if names_x is None:
                names_x = state_names(tracer, model, system)
                n, shape = len(names_x), (len(asked.labels), len(asked.times))
                sizes = {"A": (n, n), "B": (n, len(names_u)), "C": (len(seen), n), "D": (len(seen), len(names_u))}
                whole = {name: np.full((*shape, *size), np.nan) for name, size in sizes.items()}
            if names_x == state_names(tracer, model, system):
                for name, x in (("A", system.A), ("B", system.B), ("C", system.C), ("D", system.D)):
                    whole[name][system.runs, k] = x
    if names_x is None:
        raise ScenarioError("no run is there at these times: the runs fail before; see their status with lienumba run")
    dims = {"A": ("state", "by_state"), "B": ("state", "input"), "C": ("output", "by_state"), "D": ("output", "input")}
    columns = [n for n, x in enumerate(product(added, DERIVATIVES)) if x[0].kind == "drivers" or not x[1]]
    return asked.dataset(
        SYSTEMS,
        {name: (("run", "time", *dims[name]), x, {"long_name": LONG[name]}) for name, x in whole.items()}
        | asked.origins(origins, tracer, prepared),
        {"time": asked.times, "state": names_x, "by_state": names_x, "input": names_u, "output": seen},
        rotation=list(map(float, rotation)),
    ).isel(input=columns)  # forces see no derivatives


LONG = {
    "A": "x' by x", "B": "x' by the inputs", "C": "outputs by x", "D": "outputs by the inputs",
}  # fmt: skip


def turning(rotation: Sequence[float]) -> tuple[float, float, float]:
    """Three finite numbers."""
    try:
        x, y, z = (float(c) for c in rotation)
    except (TypeError, ValueError):
        raise ScenarioError.at(
            "rotation", "must be three numbers in rad/s", "give them, such as 0,0,5", rotation
        ) from None
    if not np.isfinite([x, y, z]).all():
        raise ScenarioError.at("rotation", "must be finite", "give numbers such as 0,0,5", rotation)
    return x, y, z


def check_states(tracer: FreedomTracer, states: States) -> None:
    """Sliding contacts have no part in the equations that are linearised."""
    switches = tracer.augmented.switches
    first = len(states.rows) - len(switches) - tracer.augmented.memory
    for n, switch in enumerate(switches):
        on = np.broadcast_to(states.rows[first + n], states.good.shape)
        if switch.tangents and np.any(on[states.good] > 1.5):
            raise ScenarioError(
                f"{switch.name} slides at t = {states.t:g} s, and what slides with Coulomb friction has no linear "
                "equations; choose another time, or regularised friction (coulomb with a velocity)"
            )


def largest_first(systems: Iterator[Systems]) -> list[Systems]:
    """Sort systems, those of the most runs first."""
    return sorted(systems, key=lambda system: -len(system.runs))


def state_names(tracer: FreedomTracer, model: Model, system: Systems) -> list[str]:
    """The names of the numbers of x: coordinates of joints and free bodies, their rates, states of laws."""
    links = tracer.tree(tracer.graph()[1]).links
    names: list[str] = []
    for link in links:
        names += _names(model, link, [x for x in links if x.joint == link.joint and x.joint is not None])
    places, rates = system.chosen
    laws = [f"{law}.{n}" for law, size in tracer.law_states.sizes.items() for n in _law_names(model, law, size)]
    return [*(names[n] for n in places), *(f"{names[n]}.rate" for n in rates), *laws]


def _names(model: Model, link: Link, siblings: Sequence[Link]) -> list[str]:
    if link.joint is None:
        assert link.body is not None
        body = model.bodies[link.body].name
        return [f"{body}.{what}.{axis}" for what in ("position", "turn") for axis in XYZ]
    joint, count = model.joints[link.joint].name, link.move.freedoms
    if count == len(XYZ):
        return [f"{joint}.turn.{axis}" for axis in XYZ]
    kind = "angle" if link.move.turns else "displacement"
    alike = [x for x in siblings if x.move.turns == link.move.turns and x.move.freedoms == 1]
    return [f"{joint}.{kind}" + (str(1 + alike.index(link)) if len(alike) > 1 else "")] * count


def _law_names(model: Model, law: str, size: int) -> list[str]:
    own = next((list(force.initial) for force in model.forces if force.name == law), [])
    return [*own, *(f"held{n}" for n in range(size - len(own)))]
