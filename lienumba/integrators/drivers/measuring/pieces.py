"""What is kept of a panel of a step piece by piece, where a value or a condition bends between them.

What is behind a bend belongs to the next piece, so that of a jump no side is seen from the other one.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, load, splat
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.events.search import finest_part
from lienumba.integrators.drivers.lobatto import fraction_of
from lienumba.integrators.drivers.measuring.conditions import keep_within
from lienumba.integrators.drivers.measuring.points import (
    look,
    look_along,
    may_turn,
    passing,
    signals,
    truth,
    turn,
    value_of,
)
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.layout import (
    KEPT_BEND,
    KEPT_BENDS,
    KEPT_TURN,
    KEPT_TURNS,
    POINTS,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.truth import BESIDE
from lienumba.numerics.operations import absolute, maximum, minimum

PIECE = 1  # behind the panel
NOWHERE = 2.0
PIECES = 4  # for each bend, at most


@inlined
def bend(plan: Plan, n: int, k: int) -> int:
    """The kth signal at whose zeros a value or its condition bends."""
    own = plan.kept[n, KEPT_BENDS]
    return plan.kept[n, KEPT_BEND] + k if k < own else plan.kept[n, KEPT_TURN] + k - own


@inlined
def _crosses(sizes: Sizes, at: Workspace, signal: int) -> Lanes:
    """1 where a signal is, or may be, on both sides of 0 in the panel, or begins or ends next to it, else 0."""
    above, turns = splat(0.0), splat(0.0)
    for k in range(POINTS):
        above = above + truth(sizes, at, 0, signal, k)
    begin, end = value_of(sizes, at, 0, signal, 0), value_of(sizes, at, 0, signal, POINTS - 1)
    beside = BESIDE * absolute(end - begin)
    turns = choose((absolute(begin) < beside) | (absolute(end) < beside), splat(1.0), turns)
    if any_lane(may_turn(sizes, at, 0, signal)):
        for k in range(POINTS - 1):
            turns = choose(turn(sizes, at, 0, signal, k) > 0.0, splat(1.0), turns)
    return choose((above > 0.0) & (above < float(POINTS)), splat(1.0), turns)


@apart
def _next_bend(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, n: int, t: Lanes,
    length: Lanes, low: Lanes, high: Lanes, lanes: Mask,
) -> Lanes:  # fmt: skip
    """Directly behind the first place between two fractions of the step at which a signal that bends others crosses 0,
    which each does at most once, or leaves it; else NOWHERE."""
    begin, end = signals(sizes, at, PIECE, 0), signals(sizes, at, PIECE, POINTS - 1)
    look(kernels, sizes, at, t, length, low, begin)
    look(kernels, sizes, at, t, length, high, end)
    place = splat(NOWHERE)
    for k in range(plan.kept[n, KEPT_BENDS] + plan.kept[n, KEPT_TURNS]):
        signal = bend(plan, n, k)
        before, after = load(begin, signal), load(end, signal)
        crosses = lanes & (((before >= 0.0) & (after < 0.0)) | ((before <= 0.0) & (after > 0.0)))
        crosses = crosses | (lanes & (before > 0.0) & (after == 0.0))
        if any_lane(crosses):
            there = passing(kernels, at, first, rows, t, length, low, high, signal, before, after, crosses)
            place = choose(crosses, minimum(place, there), place)
        place = choose(lanes & (before < 0.0) & (after == 0.0), minimum(place, high), place)
    return place


@apart
def _keep_between(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, n: int, t: Lanes,
    length: Lanes, low: Lanes, high: Lanes, last: Lanes, lanes: Mask, comes: Lanes,
) -> None:  # fmt: skip
    """The pieces between two fractions of a panel that ends at `last`. What bends because of another bend may cross 0
    between a bend and the start alone."""
    count, finest, left = plan.kept[n, KEPT_BENDS] + plan.kept[n, KEPT_TURNS], finest_part(t, length), lanes
    for piece in range(PIECES * count):
        if not any_lane(left):
            break
        place, until, seeks = splat(NOWHERE), high, left
        for _ in range(count if piece < PIECES * count - 1 else 0):
            there = _next_bend(kernels, sizes, at, first, rows, plan, n, t, length, low, until, seeks)
            seeks = seeks & (there <= until)
            if not any_lane(seeks):
                break
            place = choose(seeks, there, place)
            until = choose(seeks, maximum(there - finest, low), until)
        look_along(kernels, sizes, at, t, length, low, until, PIECE)
        end = signals(sizes, at, PIECE, POINTS - 1)
        stages.commit(left & (until >= last), end, signals(sizes, at, 0, POINTS - 1), sizes.signals)
        more = choose(place < high, 1.0, 0.0)
        ends = choose(high == last, choose(more == 0.0, comes, 0.0), 0.0)
        keep_within(kernels, sizes, at, first, rows, plan, n, t, length, low, until, PIECE, left, ends)
        left = left & (more == 1.0)
        low = choose(left, place, low)


@apart
def keep_pieces(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, n: int, t: Lanes,
    length: Lanes, low: Lanes, high: Lanes, lanes: Mask, comes: Lanes,
) -> None:  # fmt: skip
    """Keep what has to be of a panel of the step that was looked at in all of its points; comes: where an event leaves
    it at its end that has the condition, which is true there, though it may not be by rounding."""
    count, bent = plan.kept[n, KEPT_BENDS] + plan.kept[n, KEPT_TURNS], splat(0.0)
    for k in range(count):
        bent = maximum(bent, _crosses(sizes, at, bend(plan, n, k)))
    straight, crooked = lanes & (bent == 0.0), lanes & (bent > 0.0)
    if any_lane(straight):
        keep_within(kernels, sizes, at, first, rows, plan, n, t, length, low, high, 0, straight, comes)
    if not any_lane(crooked):
        return
    for gap in range(POINTS - 1):
        begin, end, place = fraction_of(gap, low, high), fraction_of(gap + 1, low, high), splat(NOWHERE)
        for k in range(count):
            there = turn(sizes, at, 0, bend(plan, n, k), gap)
            place = choose(there > 0.0, minimum(place, there), place)
        turns = crooked & (place < NOWHERE)
        middle = choose(turns, low + place * (high - low), end)
        _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, begin, middle, high, crooked, comes)
        if any_lane(turns):
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, middle, end, high, turns, comes)
