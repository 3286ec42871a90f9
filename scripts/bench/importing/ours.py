"""An imported scenario at many starts: what its bodies do, by the equations that kernels are traced from, in numbers,
and by machine code.

Bodies are told apart by where they are: the body of a link of MuJoCo's model is the one whose mass centre moves as the
link's does, whatever both are called; between their axes there is one rotation, the same at all states.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import lienumba
from lienumba.groups.state import ELEMENT
from lienumba.integrators.tracing.law_states import LawStates
from lienumba.integrators.tracing.row_selection import initial_selection
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.system import kkt
from lienumba.mechanics.tree import equations
from lienumba.mechanics.tree.links import tree_of
from lienumba.mechanics.tree.motion import read_state
from lienumba.mechanics.tree.posture import Posture
from lienumba.mechanics.tree.spanning import closing_rows
from lienumba.scenario.resolve import resolve
from lienumba.scenario.start.prepare import Prepared, prepare

Array = np.ndarray
Columns = Mapping[str, Array]
BY_JOINTS = {"integrator.coordinates": "joint", "integrator.method": "rk4"}
ALIKE = 1e-9  # of rotation matrices
SAME = 1e-9  # m: two bodies are the same whose mass centres are as close at all states


@dataclass(frozen=True)
class Seen:
    """Of all bodies: masses, mass centres r (n, k, 3), rotations R (n, k, 3, 3); linear, angular: accelerations of the
    mass centres, and angular ones (n, k, 3), global axes; fits: which of the states lienumba starts from (n,)."""

    fits: Array
    masses: Array
    r: Array
    R: Array
    linear: Array
    angular: Array


def prepared_at(source: Mapping[str, Any], columns: Columns) -> Prepared:
    """The runs of a table of starts."""
    count = len(next(iter(columns.values())))
    sweep = {"sampler": "table", "runs": count, "table": {"columns": {key: x.tolist() for key, x in columns.items()}}}
    scenario = resolve(source, overrides={"sweep": sweep, "output.variables": [], **BY_JOINTS})
    return prepare(scenario, list(range(count)))


def accelerations(source: Mapping[str, Any], columns: Columns) -> Seen:
    """At the starts of a table, by the freedoms of the joints."""
    start = prepared_at(source, columns)
    model, runs = start.model, len(start.states)
    bodies = start.states.reshape(runs, -1, ELEMENT)
    with np.errstate(all="ignore"):
        tree = tree_of(model)
        laws = LawStates.of(model, Instant(tuple(tuple(x) for x in bodies[0]), 0.0, dict.fromkeys(start.angles, 0.0)))
        z = read_state(model, tree, tuple(tuple(body.T) for body in bodies.transpose(1, 0, 2)))
        posture = Posture(model, tree, z, 0.0, start.angles, states=laws.initial(model))
        dropped = _redundant(start)
        structure = kkt.Structure.closing(model, tree.joints, (), dropped)
        mask = [float(row not in dropped) for row in range(structure.rows)]
        solution = equations.accelerations(posture, structure, mask)
        found = equations.body_accelerations(posture, solution.links)
    every = np.stack(np.broadcast_arrays(*found, np.zeros(runs))[:-1], axis=1).reshape(runs, -1, 6)
    R = bodies[..., 3:12].reshape(runs, -1, 3, 3)
    masses = np.array([np.mean(body.mass) for body in model.bodies])
    return Seen(
        start.codes == 0, masses, bodies[..., :3], R, every[..., :3], np.einsum("nkij,nkj->nki", R, every[..., 3:])
    )


def _redundant(start: Prepared) -> tuple[int, ...]:
    nominal = start.nominal
    exchangeable = tuple(row for row in nominal.rank.exchangeable if row in closing_rows(nominal.model))
    return initial_selection(nominal.model, exchangeable, nominal.typical).dropped


def motion(source: Mapping[str, Any], step: float, times: Array) -> tuple[Array, Array]:
    """Mass centres (times, k, 3) and rotations (times, k, 3, 3) from its own start, by machine code."""
    settings = {
        **BY_JOINTS, "integrator.step": step, "integrator.end_time": float(times[-1]),
        "output": {"times": times.tolist(), "variables": ["position", "rotation"]},
    }  # fmt: skip
    ds = lienumba.run(source, overrides=settings)
    if ds.status.values[0] != 0:
        raise ValueError(f"the run ended with status {ds.status.values[0]}")
    return ds.position.values[0], ds.rotation.values[0]


def bodies_of_links(seen: Seen, masses: Array, r: Array, R: Array) -> list[int]:
    """Of each link the body that weighs as much, and at all states is where it is and turned as it is. r, R: of the
    links (n, links, ...)."""
    found: list[int] = []
    for n, mass in enumerate(masses):
        apart = np.abs(seen.r - r[:, n : n + 1]).max(axis=(0, 2))
        apart[np.abs(seen.masses - mass) > 1e-9 * mass] = np.inf
        near = np.flatnonzero(apart < SAME * max(1.0, np.abs(r).max()))
        if not len(near):
            raise ValueError(f"no body is where link {n} is: the nearest is {apart.min():.2g} m away")
        turned = [turned_alike(seen.R[:, [body]], R[:, [n]]) for body in near]
        if min(turned) > ALIKE:
            raise ValueError(f"the body where link {n} is turns otherwise: by {min(turned):.2g}")
        found.append(int(near[int(np.argmin(turned))]))
    return found


def turned_alike(R: Array, theirs: Array) -> float:
    """How much the rotations between the axes of both (n, links, 3, 3) change from state to state."""
    between = np.einsum("nkji,nkjl->nkil", R, theirs)
    return float(np.abs(between - between[:1]).max(initial=0.0))
