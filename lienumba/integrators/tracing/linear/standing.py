"""What a mechanism stands on where it rests: the rigid stops and contacts that hold it.

While it is looked for, what touches is glued: stops, and contacts without friction, along their normals, others along
their tangents, too; what is open closes where the search meets it. Where all rests, the law of what
presses and sticks, the same as of a motion, says whether forces can hold it so. What they would have to pull opens, and
what they cannot keep from slipping slides, without friction; then the search goes on. Without friction at the end is
within Coulomb's law, too. Relative to a rotation contacts with friction stay open.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import Rows, product, solved, turned, unit_rows
from lienumba.compiler.flat import Flat, kept
from lienumba.integrators.drivers.events.search import TOUCH
from lienumba.integrators.drivers.switching.at_rest import VECTORS
from lienumba.integrators.drivers.switching.problem import FREE, PRESSES, SOLVED
from lienumba.integrators.layout import SWITCH_FIRST
from lienumba.integrators.tracing.linear.freedoms import GluedTracer
from lienumba.mechanics.mechanism.kinematics import OFF, SLIDE, STICK
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints
from lienumba.mechanics.system.switched import scales
from lienumba.mechanics.system.switches import Switch

Array = npt.NDArray[Any]
REDUNDANT = 1e-6  # of the largest row of C, beside those before it
MOST = 40  # times that a run may be judged, and still change
AT_ONCE = 1e-6  # of a step: what closes so much later than another does so with it
NOTHING = 1e-9  # of the terms of an acceleration: what is none
SMALL = 1e-13  # of the largest pivot of the masses


@cache
def _forces() -> Flat:
    return kept("lienumba.integrators.drivers.switching.at_rest", "forces")


@dataclass(frozen=True)
class Standing:
    """switches: stops and contacts, s of them, and `places` of their masks and of how they are on in a state; columns:
    of their rows, q of them, the places among the rows in use, `normals` among these q; on, slid (s, runs): how each is
    on, and whether it has slipped; friction (s, runs); turns, judged (runs,): whether a run turns, how often it was
    judged."""

    switches: tuple[Switch, ...]
    places: list[tuple[range, int]]
    columns: Array
    normals: Array
    on: Array
    slid: Array
    friction: Array
    turns: Array
    judged: Array

    @staticmethod
    def of(tracer: GluedTracer, model: Model, rows: Sequence[Any], used: Sequence[int], turns: Array) -> "Standing":
        """With all closed that touches in the states with these rows; used: see `Equations`."""
        runs, augmented = len(turns), tracer.augmented
        numbers = [n for n, x in enumerate(augmented.switches) if x.unilateral]
        found = tuple(augmented.switches[n] for n in numbers)
        first = len(rows) - augmented.rows + augmented.first_mode
        masks = [range(first + x.first, first + x.first + x.rows) for x in found]
        places = [(own, first + augmented.switched + n) for own, n in zip(masks, numbers, strict=True)]
        columns = [used.index(augmented.permanent + x.first + n) for x in found for n in range(x.rows)]
        friction, on = np.zeros((len(found), runs)), np.full((len(found), runs), OFF)
        now = tracer.instant(model, rows, 0.0)
        gaps = constraints.residual(model, now)[augmented.permanent :] if found else []
        sizes = scales.lengths(model, now) if found else []
        for s, x in enumerate(found):
            friction[s] = model.contacts[x.index].static if x.tangents else 0.0
            touches = np.asarray(gaps[x.first] <= TOUCH * sizes[x.first]) & ~(turns & (x.tangents > 0))
            on[s] = np.where(touches, STICK if x.tangents else SLIDE, OFF)
        normals = np.cumsum([0, *(x.rows for x in found)])[:-1]
        none = np.zeros(on.shape, bool)
        return Standing(found, places, np.array(columns, int), normals, on, none, friction, turns, np.zeros(runs, int))

    def may_close(self, which: Array) -> Array:
        """What is open and may close (runs, s)."""
        rough = np.array([x.tangents > 0 for x in self.switches], bool)
        found: Array = (self.on[:, which].T == OFF) & ~(self.turns[which][:, None] & rough)
        return found

    def meets(self, old: Array, new: Array, which: Array) -> tuple[Array, Array]:
        """How far a step leads until something closes (runs,), 1 where nothing does, and what does so (runs, s); old,
        new (runs, s): gaps before and after."""
        meets, old = self.may_close(which) & (new < 0.0), np.maximum(old, 0.0)
        parts = np.where(meets, old / np.where(meets, old - new, 1.0), np.inf)
        part = parts.min(axis=1, initial=np.inf)
        return np.minimum(part, 1.0), meets & (parts <= part[:, None] + AT_ONCE)

    def close(self, what: Array, which: Array) -> None:
        """what (runs, s): of these runs."""
        for s, switch in enumerate(self.switches):
            own = which[what[:, s]]
            self.on[s, own] = np.where(self.slid[s, own] | (switch.tangents == 0), SLIDE, STICK)

    def write(self, state: Array, which: Array) -> None:
        """How they are on, to the columns of states (rows, all runs)."""
        for s, (switch, (masks, on)) in enumerate(zip(self.switches, self.places, strict=True)):
            state[on, which] = self.on[s, which]
            for n, row in enumerate(masks):
                slips = n >= switch.rows - switch.tangents
                state[row, which] = self.on[s, which] == STICK if slips else self.on[s, which] != OFF

    def free(self, C: Array, most: Array) -> tuple[Rows, Array]:
        """Of C (runs, rows, n) the rows that are not theirs, and theirs along what these leave free."""
        others = C.copy()
        others[:, self.columns] = 0.0
        rows = Rows.of(unit_rows(others)[0], REDUNDANT, most)
        return rows, rows.free(product(C[:, self.columns], rows.Q))

    def stays(self, C: Array, M: Array, f: Array, most: Array, which: Array) -> tuple[Array, Array]:
        """Whether forces hold what rests (runs,), and whether anything opens or slides since they do not, which is
        then so; f (runs, n): what acts without any multipliers; all along the same coordinates."""
        runs, q = len(which), len(self.columns)
        rows, own = self.free(C, most)
        masses, right = product(turned(rows.Q), product(M, rows.Q)), product(turned(rows.Q), f)
        by = solved(masses, np.concatenate([right[:, :, None], turned(own)], axis=2), rows.rank, SMALL)
        S, b = product(own, by[:, :, 1:]), product(own, by[:, :, 0])
        law = np.where(self.on[:, which].T != OFF, float(PRESSES), float(FREE))
        x, rates, said = np.zeros((runs, q)), np.zeros((runs, q)), np.zeros(runs, np.int64)
        room, matrix = np.zeros((VECTORS, q)), np.zeros((q, q + 1))
        numbers = np.array([x.numbers for x in self.switches])
        numbers[:, SWITCH_FIRST] = self.normals
        given = np.ascontiguousarray(S), b.copy(), numbers, np.ascontiguousarray(law)
        _forces()(*given, np.ascontiguousarray(self.friction[:, which].T), x, rates, said, room, matrix)
        terms = np.abs(b) + (np.abs(S) * np.abs(x)[:, None, :]).sum(axis=2)
        moves = np.abs(rates) > NOTHING * terms
        self.judged[which] += 1
        goes_on = (said == SOLVED) & (self.judged[which] < MOST)
        held, changes = said == SOLVED, np.zeros(runs, bool)
        for n, (switch, first) in enumerate(zip(self.switches, self.normals, strict=True)):
            on = self.on[n, which]
            opens = (on != OFF) & moves[:, first] & (x[:, first] <= 0.0)
            slips = (on != OFF) & ~opens & moves[:, first + 1 : first + switch.rows].any(axis=1)
            held &= ~opens & ~slips
            changes |= opens | (slips & (on == STICK))
            self.on[n, which] = np.where(goes_on & opens, OFF, np.where(goes_on & slips, SLIDE, on))
            self.slid[n, which] |= opens | slips
        return held, changes & goes_on
