"""Implicit stages: Newton's method in all lanes that need it, each stopped by its own changes.

The first iteration of a step eliminates a matrix, at the stages that the step before lets expect; those behind it keep
it, in every lane for which changes shrink fast enough. Else the next one has its own again; where a kept matrix leads
away, or to where a new one does not agree, all others have.

Of changes that shrink by a factor q each, all that follow the last one amount to q/(1 - q) of it: where that is a
fraction of what the tolerance allows, the lane is done. Where rounding keeps them from shrinking any more, and they are
small, it is done, too.
"""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers.lane_queue import NEVER
from lienumba.integrators.drivers.stages import commit, copy
from lienumba.integrators.layout import (
    BACK,
    BUSY,
    CUT,
    JUMP,
    LOOKED,
    PASSES,
    REJECTED,
    ROOT,
    STALE,
    TRIAL,
    UNTIL,
    T,
    Workspace,
)
from lienumba.integrators.sizes import Sizes

ITERATIONS = 12
ENOUGH = 1e-6  # squared: of what the tolerance allows, what all further changes may amount to
CERTAIN = 1e-12  # squared: a change so small needs no second one
ROUNDING = 1e2  # squared: changes below this, that no longer shrink, are rounding
GROWING = 4.0  # squared: of a change to the next, beyond which it is given up
SLOW = 0.12  # squared: where changes shrink less, the next iteration is by a matrix of its own
PARTS, GROWS = 2.0**-20, 2.0  # of a step of given length: no part is shorter; of a part: no next one is longer
THROUGH, NEAR = 0.4, 0.45  # of a step: where it passes a singular position
BEFORE, BEHIND, SLACK = 0.2, 0.3, 0.05  # of a step of given length: so far from a singular position its parts end


@apart
def solve_stages(kernels: np.ndarray, sizes: Sizes, at: Workspace, fresh: Mask) -> Lanes:
    """The iterate of the step that the clock says, in all lanes; whether it was found: 0, or the code. fresh: where no
    step before says anything."""
    slopes, rows = at.slopes, sizes.iterate
    now = slopes + ROW * layout.iterate_row(sizes)
    following = slopes + ROW * layout.following_row(sizes)
    store(now, rows + layout.SPAN, choose(fresh, splat(0.0), load(now, rows + layout.SPAN)))
    for row in range(rows):  # what an earlier run has left is no number to go on with
        store(now, row, choose(fresh, splat(0.0), load(now, row)))
    call(kernels[layout.GUESS], at.state, at.parameters, at.clock, slopes, slopes, at.work)
    for row in range(rows):
        store(now, row, load(following, row))
    pending = load(at.lanes, BUSY) != 0.0
    failed, count, anew = splat(0.0), splat(0.0), splat(1.0)
    alone = splat(0.0 if kernels[layout.SIMPLIFIED] != 0 else 1.0)  # whether no kept matrix is of any use
    before, most = splat(np.inf), splat(np.inf)  # the last change; what a next one by a new matrix may be
    while any_lane(pending):
        own = pending & (anew != 0.0)  # by matrices of their own; meanwhile the others wait
        exact = any_lane(own)
        asked, limit = choose(pending, splat(1.0), splat(0.0)), before
        if exact:
            asked, limit = choose(own, splat(1.0), splat(0.0)), most
            _eliminate(kernels, sizes, at, own, any_lane(count != 0.0))
        else:
            call(kernels[layout.SIMPLIFIED], at.state, at.parameters, at.clock, slopes, slopes, at.work)
        mine = asked != 0.0
        change = load(following, rows + layout.CHANGE)
        sound = (load(following, rows + layout.SOLVED) > 0.0) & (change < codes.HUGE)
        factor = change / before  # squared: of the changes
        rest = change * factor / choose(factor < 0.25, 0.25, 1e-6)
        second = before < codes.HUGE  # one change alone says nothing of how they shrink
        done = sound & ((second & (rest <= ENOUGH)) | (change <= CERTAIN) | ((change <= ROUNDING) & (factor > 0.25)))
        taken = mine & sound & (done | (change < limit) | (change <= ROUNDING))
        commit(taken, now, following, rows)
        lost = choose(taken, splat(0.0), asked)
        if exact:
            failed = choose(lost != 0.0, splat(1.0), failed)
            most = choose(taken, GROWING * change, most)
            lost = choose(mine & (factor >= 1.0), splat(1.0), splat(0.0))  # what a kept one said was wrong
        alone = choose(lost != 0.0, splat(1.0), alone)
        anew = choose(mine, choose(taken & (factor <= SLOW), alone, splat(1.0)), anew)
        before = choose(taken, change, before)
        count = choose(taken, count + 1.0, count)
        pending = pending & (choose(mine & done, splat(0.0), splat(1.0)) != 0.0)
        failed = choose(pending & (count >= ITERATIONS), splat(1.0), failed)
        pending = pending & (failed == 0.0)
    good = failed == 0.0
    store(now, rows + layout.SINCE, load(at.clock, layout.TIME))
    store(now, rows + layout.SPAN, choose(good, load(at.clock, layout.LENGTH), splat(0.0)))
    for row in range(rows):
        store(now, row, choose(good, load(now, row), 0.0))
    return choose(good, splat(0.0), splat(codes.UNSETTLED))


@inlined
def _eliminate(kernels: np.ndarray, sizes: Sizes, at: Workspace, own: Mask, others: bool) -> None:
    """An iteration by a matrix that is kept from now on in the lanes `own`, for later ones by the same; others: whether
    other lanes have one."""
    kept = at.slopes + ROW * layout.factors_row(sizes)
    aside = kept + ROW * sizes.factors
    if others and kernels[layout.SIMPLIFIED] != 0:
        copy(aside, kept, sizes.factors)
    call(kernels[layout.NEWTON], at.state, at.parameters, at.clock, at.slopes, at.slopes, at.work)
    if others and kernels[layout.SIMPLIFIED] != 0:
        for row in range(sizes.factors):
            store(kept, row, choose(own, load(kept, row), load(aside, row)))


@inlined
def forget(sizes: Sizes, state: Address, fresh: Mask) -> Mask:
    """Of a method that goes on with what the step before has left: in the lanes `fresh` there is none. In which lanes
    the next step begins without."""
    if sizes.history == 0:
        return splat(0.0) != 0.0
    row = layout.last_length_row(sizes)
    store(state, row, choose(fresh, splat(0.0), load(state, row)))
    return load(state, row) == 0.0


@inlined
def shorten(lanes: Address, busy: Mask, length: Lanes, step: float) -> Mask:
    """Where stages were not found in a step of given length, it is made in parts; in which lanes it is."""
    trial = load(lanes, TRIAL)
    astray = (trial == codes.UNSETTLED) | (trial == codes.ROTATION) | (trial == codes.NON_FINITE)
    astray = astray | (trial == codes.SINGULAR)
    again = busy & astray & (0.25 * length > PARTS * step)
    until = load(lanes, T) + 0.25 * length
    store(lanes, CUT, choose(again & (until < load(lanes, CUT)), until, load(lanes, CUT)))
    store(lanes, REJECTED, load(lanes, REJECTED) + choose(again, 1.0, 0.0))
    store(lanes, BACK, choose(again, splat(1.0), load(lanes, BACK)))
    return again


@inlined
def grow(sizes: Sizes, at: Workspace, step: float) -> None:
    """A step of given length whose stages were not found goes on by parts that grow: from a short one nothing is to be
    foreseen of a long one, and what is found from there may be no motion, though the stages hold it for one. step:
    the given length (s)."""
    last = load(at.slopes + ROW * layout.iterate_row(sizes), sizes.iterate + layout.SPAN)
    last, back = choose(load(at.lanes, STALE) != 0.0, 0.0, last), load(at.lanes, BACK)
    short = (back != 0.0) & (last > 0.0) & (load(at.clock, layout.LENGTH) > GROWS * last)
    store(at.lanes, BACK, choose((last > 0.0) & (GROWS * last >= step), 0.0, back))
    _end_at(at, short, load(at.lanes, T) + GROWS * last)


@inlined
def _end_at(at: Workspace, lanes: Mask, until: Lanes) -> None:
    """The step that is proposed ends there in these lanes."""
    t = load(at.lanes, T)
    store(at.lanes, UNTIL, choose(lanes, until, load(at.lanes, UNTIL)))
    store(at.clock, layout.LENGTH, choose(lanes, until - t, load(at.clock, layout.LENGTH)))
    store(at.clock, layout.MIDDLE, choose(lanes, 0.5 * (t + until), load(at.clock, layout.MIDDLE)))


@inlined
def straddle(sizes: Sizes, at: Workspace, step: float, end: float) -> None:
    """Steps pass singular positions of loops in their midst, where collocation does not feel them: next to their ends
    it is noise that says on which branch a loop is. The root of the margin, which falls evenly, foretells when.

    step: of steps of given length, else 0: where one of these would end next to such a position, it is made in parts,
    one of which goes beyond its end, though not beyond that of the run."""
    lanes, clock = at.lanes, at.clock
    t, stale, last, looked = load(lanes, T), load(lanes, STALE) != 0.0, load(lanes, ROOT), load(lanes, LOOKED)
    root = np.sqrt(load(at.slopes, layout.report_row(sizes, 0) + layout.STAGE_MARGIN))
    moved = t > looked
    passes = choose(last > root, t + (t - looked) * (root / (last - root)), splat(NEVER))
    passes = choose(stale, splat(NEVER), choose(moved, passes, load(lanes, PASSES)))
    store(lanes, PASSES, passes)
    store(lanes, ROOT, choose(stale, splat(0.0), choose(moved, root, last)))
    store(lanes, LOOKED, t)
    length, rest = load(clock, layout.LENGTH), passes - t
    if step > 0.0:
        before = choose(rest > (BEFORE + SLACK) * step, rest - BEFORE * step, rest + BEHIND * step)
        cut = (rest > 0.0) & (rest < length + BEFORE * step) & (rest > length - BEFORE * step)
    else:
        before = choose(rest > NEAR * length, rest - THROUGH * length, rest * (1.0 / THROUGH))
        cut = before < length
    last = choose(load(lanes, JUMP) < load(lanes, CUT), load(lanes, JUMP), load(lanes, CUT))
    last = choose(last < splat(end), last, splat(end))
    _end_at(at, cut, choose(t + before < last, t + before, last))
