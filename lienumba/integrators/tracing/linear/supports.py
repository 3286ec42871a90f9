"""The rigid stops and contacts that support a mechanism at rest.

During the search a closed contact is glued: along its normal, and with friction along its tangents. An open one closes
where the search meets it. Where all rests, the contact law of a motion decides whether the forces can hold it. A
contact that would have to pull opens. One whose friction is exceeded slides without friction from then on, which stays
within Coulomb's law; then the search goes on. Relative to a rotation contacts with friction stay open.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from lienumba.compiler.flat import Flat, kept
from lienumba.integrators.drivers.events.tolerances import CLOSED_GAP_RTOL
from lienumba.integrators.drivers.switching.at_rest import Room
from lienumba.integrators.drivers.switching.problem import FREE, PRESSES, SOLVED
from lienumba.integrators.layout import SWITCH_FIRST
from lienumba.integrators.tracing.linear.algebra import Array, NullSpace, accelerations, applied
from lienumba.integrators.tracing.linear.freedoms import GluedTracer
from lienumba.mechanics.mechanism.kinematics import OFF, SLIDE, STICK
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints
from lienumba.mechanics.system.switched import scales
from lienumba.mechanics.system.switches import Switch

LOOP_RTOL = 1e-6  # relative to the largest diagonal element of R: less is of a redundant row, in loops not quite closed
MAX_SOLUTIONS = 40  # of the contact law in a run; then its contacts no longer change
SAME_STEP = 1e-6  # of a step: contacts that close within it close together
ACCELERATION_RTOL = 1e-9  # relative to the terms of an acceleration: a smaller one is roundoff


@cache
def _forces() -> Flat:
    return kept("lienumba.integrators.drivers.switching.at_rest", "forces")


@dataclass(frozen=True)
class Supports:
    """switches: the stops and contacts, s of them; places: of their masks and modes in a state; columns (q,): of their
    rows among the rows in use; normals: the first row of each among these q; on, slid (s, runs): the mode of each, and
    whether it has slipped; friction (s, runs); turns (runs,): whether a run turns; solutions (runs,): how often its
    contact law was solved."""

    switches: tuple[Switch, ...]
    places: list[tuple[range, int]]
    columns: Array
    normals: Array
    on: Array
    slid: Array
    friction: Array
    turns: Array
    solutions: Array

    @staticmethod
    def of(tracer: GluedTracer, model: Model, rows: Sequence[Any], used: Sequence[int], turns: Array) -> "Supports":
        """With all contacts closed that touch in the states with these rows; used: see `Equations`."""
        runs, augmented = len(turns), tracer.augmented
        numbers = [n for n, x in enumerate(augmented.switches) if x.unilateral]
        switches = tuple(augmented.switches[n] for n in numbers)
        first = len(rows) - augmented.rows + augmented.first_mode
        masks = [range(first + x.first, first + x.first + x.rows) for x in switches]
        places = [(own, first + augmented.switched + n) for own, n in zip(masks, numbers, strict=True)]
        columns = [used.index(augmented.permanent + x.first + n) for x in switches for n in range(x.rows)]
        friction, on = np.zeros((len(switches), runs)), np.full((len(switches), runs), OFF)
        now = tracer.instant(model, rows, 0.0)
        gaps = constraints.residual(model, now)[augmented.permanent :] if switches else []
        sizes = scales.lengths(model, now) if switches else []
        for s, x in enumerate(switches):
            friction[s] = model.contacts[x.index].static if x.tangents else 0.0
            touches = np.asarray(gaps[x.first] <= CLOSED_GAP_RTOL * sizes[x.first]) & ~(turns & (x.tangents > 0))
            on[s] = np.where(touches, STICK if x.tangents else SLIDE, OFF)
        normals = np.cumsum([0, *(x.rows for x in switches)])[:-1]
        none = np.zeros(on.shape, bool)
        return Supports(
            switches, places, np.array(columns, int), normals, on, none, friction, turns, np.zeros(runs, int)
        )

    def may_close(self, which: Array) -> Array:
        """Which contacts are open and may close (runs, s)."""
        rough = np.array([x.tangents > 0 for x in self.switches], bool)
        open_: Array = (self.on[:, which].T == OFF) & ~(self.turns[which][:, None] & rough)
        return open_

    def meets(self, old: Array, new: Array, which: Array) -> tuple[Array, Array]:
        """The fraction of a step until the first contact closes (runs,), 1 if none does; and which close there
        (runs, s). old, new (runs, s): gaps before and after the step."""
        meets, old = self.may_close(which) & (new < 0.0), np.maximum(old, 0.0)
        parts = np.where(meets, old / np.where(meets, old - new, 1.0), np.inf)
        part = parts.min(axis=1, initial=np.inf)
        return np.minimum(part, 1.0), meets & (parts <= part[:, None] + SAME_STEP)

    def close(self, what: Array, which: Array) -> None:
        """Close these contacts (runs, s) of these runs."""
        for s, switch in enumerate(self.switches):
            own = which[what[:, s]]
            self.on[s, own] = np.where(self.slid[s, own] | (switch.tangents == 0), SLIDE, STICK)

    def write(self, state: Array, which: Array) -> None:
        """Write the modes to the columns of states (rows, all runs)."""
        for s, (switch, (masks, on)) in enumerate(zip(self.switches, self.places, strict=True)):
            state[on, which] = self.on[s, which]
            for n, row in enumerate(masks):
                slips = n >= switch.rows - switch.tangents
                state[row, which] = self.on[s, which] == STICK if slips else self.on[s, which] != OFF

    def apart(self, C: Array, most: Array) -> tuple[NullSpace, Array]:
        """The null space of the other rows of C (runs, rows, n), and the rows of contacts and stops along it."""
        others = C.copy()
        others[:, self.columns] = 0.0
        space = NullSpace.of(others, LOOP_RTOL, most)
        return space, C[:, self.columns] @ space.basis

    def stays(self, C: Array, M: Array, f: Array, most: Array, which: Array) -> tuple[Array, Array]:
        """Solve the contact law at rest, and open or release what it does not hold.

        Parameters
        ----------
        C, M, f : ndarray
            Rows (runs, rows, n), masses (runs, n, n), and forces without multipliers (runs, n), along one set of
            coordinates.
        most : ndarray (runs,)
            The rank of the other rows.
        which : ndarray (runs,)
            The runs.

        Returns
        -------
        holds, changes : ndarray (runs,)
            Whether forces keep a run at rest, and whether one of its contacts opened or began to slide.
        """
        runs, q = len(which), len(self.columns)
        space, own = self.apart(C, most)
        right = np.concatenate([applied(space.basis.mT, f)[:, :, None], own.mT], axis=2)
        by = accelerations(space.masses(M), right)
        S, b = own @ by[:, :, 1:], (own @ by[:, :, :1])[:, :, 0]
        law = np.where(self.on[:, which].T != OFF, float(PRESSES), float(FREE))
        x, rates, status = np.zeros((runs, q)), np.zeros((runs, q)), np.zeros(runs, np.int64)
        numbers = np.array([x.numbers for x in self.switches])
        numbers[:, SWITCH_FIRST] = self.normals
        given = np.ascontiguousarray(S), b.copy(), numbers, np.ascontiguousarray(law)
        _forces()(*given, np.ascontiguousarray(self.friction[:, which].T), x, rates, status, Room.of(q))
        terms = np.abs(b) + (np.abs(S) * np.abs(x)[:, None, :]).sum(axis=2)
        moves = np.abs(rates) > ACCELERATION_RTOL * terms
        self.solutions[which] += 1
        goes_on = (status == SOLVED) & (self.solutions[which] < MAX_SOLUTIONS)
        holds, changes = status == SOLVED, np.zeros(runs, bool)
        for n, (switch, first) in enumerate(zip(self.switches, self.normals, strict=True)):
            on = self.on[n, which]
            opens = (on != OFF) & moves[:, first] & (x[:, first] <= 0.0)
            slips = (on != OFF) & ~opens & moves[:, first + 1 : first + switch.rows].any(axis=1)
            holds &= ~opens & ~slips
            changes |= opens | (slips & (on == STICK))
            self.on[n, which] = np.where(goes_on & opens, OFF, np.where(goes_on & slips, SLIDE, on))
            self.slid[n, which] |= opens | slips
        return holds, changes & goes_on
