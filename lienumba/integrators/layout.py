"""Where everything lies in memory, stated once: kernels are traced by it, drivers read and write by it.

Memory is rows of W doubles, one lane for each run. These are plain functions of whole numbers, so that the tracer calls
them as they are, and the drivers compile them in.
"""

from typing import NamedTuple

from lienumba.compiler.rows import W
from lienumba.integrators.selection_table import table_rows
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import kernel

# The addresses of kernels, 0 where a method has no such kernel; behind them those of combine0, combine1, ...
ORDER = (
    "step", "position", "chord", "velocity", "observe", "first", "stage", "advance", "finish", "schur", "sample",
    "close", "end", "dense", "events", "place", "read", "expand", "defect", "border", "kick", "guess", "newton",
    "simplified", "measure", "keep", "slopes", "quadrature", "close_along", "watch", "closure", "carry",
)  # fmt: skip
(
    STEP, POSITION, CHORD, VELOCITY, OBSERVE, FIRST, STAGE, ADVANCE, FINISH, SCHUR, SAMPLE,
    CLOSE, END, DENSE, EVENTS, PLACE, READ, EXPAND, DEFECT, BORDER, KICK, GUESS, NEWTON, SIMPLIFIED,
    MEASURE, KEEP, SLOPES, QUADRATURE, CLOSE_ALONG, WATCH, CLOSURE, CARRY, COMBINE,
) = range(len(ORDER) + 1)  # fmt: skip

# The clock: t, the length of the part of a step, c of a stage, the time in the middle of the part, which tells in which
# piece of a table a stage lies; the fraction of the part at which the continuous extension is read, what the
# controller of steps remembers, by how much (s) t leans to the inside of the part, where a signal that jumps at its end
# is looked at, and the first of the numbers of a `step_control.Tolerance`.
TIME, LENGTH, NODE, MIDDLE, FRACTION, MEMORY, LEAN, TOLERANCE = range(8)
TOLERANCES = 6
CLOCK = TOLERANCE + TOLERANCES

# What drivers know of each lane. ITERATIONS: the most of both projections since something was stored (two rows); T: the
# time; H: the step to be tried (s); JUMP: the next discontinuity, on which a step must end; GRID: the steps of one
# length so far; UNTIL: the end of the step; DUE: the time that is stored next; BUSY: whether there is a run; FRESH:
# whether it has just begun; STALE: whether F is not known at its state; TRIAL: the code of the step; STATUS: of the
# run; BACK: whether the last step was rejected; ACCEPTED, REJECTED: how many were; PICKED: some lanes; CUT: the time
# of a change, on which the step is to end; CHANGED: whether it changes; RECENT, MANY: since when how many changes;
# GAINED: the energy (J) that comes of numbers that are set, or of bodies that are moved to close a joint; HAD: the
# energy before; MARK: when, and TRIED: how many steps had been tried when, the run had last got on.
# Of a search in the open step: SEEKS: which condition; BEFORE, AFTER: what it is at the ends of where it is searched,
# from the fraction LOW on, FOUND: at the last place; ROUGH: whether a rough place will do; DIPS: whether it is the rate
# of an open gap; NEAR: whether that is at the end of the step, which was cut for it; SEEN: 1 where the signals
# at the start of the step are those at the end of the last one, 0 where they may have jumped, -1 where bodies have.
# FREES: whether a change is but a release of what is in use. STRODE: how long (s) the last step was; CLEAR: the longest
# part of one in which loads on what holds were known by points, since something changed. A lane that is FRESH BEGINS as
# long as its run has no events yet.
# ROOT: of the margin, when it was LOOKED at; PASSES: when a singular position is to be expected, by these.
ITERATIONS, _, T, H, JUMP, GRID, UNTIL, DUE, BUSY = range(9)
FRESH, STALE, TRIAL, STATUS, BACK, ACCEPTED, REJECTED, PICKED, CUT, CHANGED, RECENT, MANY, GAINED, HAD = range(9, 23)
BEGINS = 2.0
SEEKS, LOW, BEFORE, AFTER, FOUND, ROUGH, DIPS, NEAR, MARK, TRIED, SEEN, ROOT, LOOKED, PASSES = range(23, 37)
FREES, STRODE, CLEAR, LANES = range(37, 41)
PROJECTIONS = 2  # whose iterations are counted

CODE, MARGIN, VERDICT = range(3)  # rows behind the state to which a step leads, and how many
VIOLATION, ITERATE_CODE = range(2)  # rows behind the iterate to which a projection leads
TURNED, MOVED = range(2)  # rows behind one element at the end of a step by stages: squares of its rotation and its move
SOUND, POWER, STAGE_MARGIN, REPORTS = range(4)  # rows behind the slopes of a stage: of its KKT, and the power (W)
ERROR, FACTOR, REMEMBERED, CONTROL = range(4)  # rows: the square of a step's error, and `step_control.factor`

# What is said of each switched constraint (`lienumba.mechanics.system.switches`): what it is (below), its first row
# among the switched ones, its rows, how many of them, the last ones, are tangents, its first number of memory, how
# many it has, whether it shares what it carries, and the first number of how it grips among all memory, -1 without.
# on: as in `kinematics`.
(
    SWITCH_KIND, SWITCH_FIRST, SWITCH_ROWS, SWITCH_TANGENTS, SWITCH_MEMORY, SWITCH_MEMORIES, SWITCH_SHARES,
    SWITCH_GRIP, SWITCH_NUMBERS,
) = range(9)  # fmt: skip
BILATERAL, UNILATERAL, FRICTION = range(3)  # joints and locks; limits and contacts; of a joint
OFF, STICK, SLIDE = range(3)
RESTITUTION, STATIC, KINETIC, REST_SPEED, STATIC_EFFORT, KINETIC_EFFORT, SIZE, SPEED, CONTACT_NUMBERS = range(9)
# What an event does: what it is, and its targets among those of all events (switches, or rows of states), its first
# value, whether it acts only once, the switch that has to be on for that, -1 if none has, and whether its condition is
# of the scenario, not of a limit of an input.
ACTION, TARGET, TARGETS, VALUE, ONCE, NEEDS, WRITTEN, ACT_NUMBERS = range(8)
RECORDS, LOCKS, ENGAGES, RELEASES, SETS = range(5)
# What is kept of a run as a whole: how, of which signal while which other one is above 0 (-1: of none, always), which
# of the integrals that a step makes itself it is, of which event it has the condition (-1: of none), and the first
# signal, and how many, at whose zeros its own bends, and those of its condition; and the rows of each: the value, its
# time (s), NaN as long as there is none, whether the condition held where the last step ended, whether it cannot be
# known, because something was undefined, the largest size of the condition where steps ended so far, whether what is
# between the ends of this step may change it, and for `panels` whether it is no polynomial of few points in this one,
# and how often that may still be. Signals are known in POINTS of a step, of a piece of it, of a part of
# that, and ELSEWHERE; behind that, by how much each changed in the last step (CHANGES) and in the one before (EARLIER),
# and its rate at the end of that, NaN where it is not known (RATES).
(
    KEPT_KIND, KEPT_SIGNAL, KEPT_CONDITION, KEPT_QUADRATURE, KEPT_EVENT, KEPT_BEND, KEPT_BENDS,
    KEPT_TURN, KEPT_TURNS, KEPT_NUMBERS,
) = range(10)  # fmt: skip
LARGEST, SMALLEST, INTEGRATES, KEEPS_FIRST, KEEPS_LAST, COUNTS = range(6)
(
    KEPT_VALUE, KEPT_TIME, KEPT_TRUE, KEPT_UNDEFINED, KEPT_SIZE, KEPT_OPEN, KEPT_UNLIKE, KEPT_TRUST, KEPT_ROWS,
) = range(9)  # fmt: skip
POINTS = 5
INTERVALS = 4 * (POINTS - 1)  # in which conditions are looked at, where steps are long
ELSEWHERE, CHANGES, EARLIER, RATES, LARGEST_SIZES = range(3 * POINTS, 3 * POINTS + 5)
PAST = 2  # steps whose lengths (s) are known, 0 where they say nothing of what follows
OPENS, SLIDES, CONDITIONS = range(3)  # conditions of each switch; see `switched.turning`
PEAK, EXTENT, RATE, END_RATE, SWIFTEST, LAPSED, PEAKS = range(7)  # what is known of each event: see `peak_row`


@kernel
def element_rows(sizes: Sizes) -> int:
    """Of all elements of S."""
    return sizes.element * sizes.elements


@kernel
def state_rows(sizes: Sizes) -> int:
    """Of a state: its elements, and what is augmented."""
    return element_rows(sizes) + sizes.augmented


@kernel
def work_row(sizes: Sizes) -> int:
    """The row of a state in which the work is."""
    return element_rows(sizes) + sizes.work


@kernel
def first_slope(sizes: Sizes) -> int:
    """The first row of the slopes, counted from the new state, behind which they lie."""
    return state_rows(sizes) + VERDICT


@kernel
def slope_row(sizes: Sizes, element: int, slope: int) -> int:
    """The first row of a slope, counted from the first one's: all of an element side by side."""
    return sizes.coordinates * (sizes.slopes * element + slope)


@kernel
def report_row(sizes: Sizes, slope: int) -> int:
    """The first row of what a stage reports: behind the slopes of all elements, at the same distances."""
    return slope_row(sizes, sizes.elements, slope)


@kernel
def control_row(sizes: Sizes) -> int:
    """The first row of what is said of the error of a step, counted as that of a slope."""
    return slope_row(sizes, sizes.elements + 1, 0) + REPORTS


@kernel
def acceleration_row(sizes: Sizes, stage: int) -> int:
    """The first row of the accelerations that a stage reports, counted as that of a slope. Stages overwrite what those
    before them said: the last one's are read."""
    return control_row(sizes) + CONTROL + sizes.coordinates * stage


@kernel
def series_row(sizes: Sizes) -> int:
    """The first row of the coefficients of a step, counted as that of a slope: behind all of these."""
    return acceleration_row(sizes, sizes.slopes) + 6 * sizes.elements


@kernel
def quadrature_row(sizes: Sizes) -> int:
    """The first row of the integrals of a step by the weights of its stages, counted as that of a slope, where lanes
    have a time of their own; else they are behind the verdict."""
    return series_row(sizes) + sizes.series


@kernel
def said(sizes: Sizes) -> int:
    """How many numbers a stage says of signals: what those are that are integrated, and at the end of a step, where F
    is known there, the rates of all signals, and all signals themselves, as far as it tells them."""
    return sizes.integrands + sizes.seen


@kernel
def said_row(sizes: Sizes, n: int, slope: int) -> int:
    """That of the nth of these, counted as that of a slope: at the same distances."""
    size = max(sizes.coordinates, 1)
    return quadrature_row(sizes) + sizes.integrands + size * (sizes.slopes * (n // size) + slope) + n % size


# ---------------------------------------------------------------- implicit stages, in the place of a series
CHANGE, SOLVED, SINCE, SPAN, IMPLICIT = range(5)  # rows behind an iterate; of its polynomial the start and length (s)


@kernel
def iterate_row(sizes: Sizes) -> int:
    """The first row of what stages are, counted as that of a slope."""
    return series_row(sizes)


@kernel
def following_row(sizes: Sizes) -> int:
    """Of what an iteration makes of it, and says of that."""
    return iterate_row(sizes) + sizes.iterate + IMPLICIT


@kernel
def factors_row(sizes: Sizes) -> int:
    """Of the eliminated matrix that is kept; behind it there is room for another one."""
    return following_row(sizes) + sizes.iterate + IMPLICIT


@kernel
def implicit_rows(sizes: Sizes) -> int:
    """All of these."""
    return 2 * (sizes.iterate + IMPLICIT + sizes.factors)


@kernel
def last_length_row(sizes: Sizes) -> int:
    """The row of a state in which the length (s) of the step before is, 0 where there is none: the first of what a
    method carries on."""
    return element_rows(sizes) + sizes.first_history


# ---------------------------------------------------------------- switched constraints
@kernel
def mask_row(sizes: Sizes) -> int:
    """The row of a state where the masks of the switched rows begin: 1 for a row in use."""
    return element_rows(sizes) + sizes.first_mode


@kernel
def on_row(sizes: Sizes) -> int:
    """Where it is said how each switch is on."""
    return mask_row(sizes) + sizes.switched


@kernel
def memory_row(sizes: Sizes) -> int:
    """Where their memory begins."""
    return on_row(sizes) + sizes.switches


@kernel
def conditions(sizes: Sizes) -> int:
    """How many conditions are looked at: of the events, and behind them `CONDITIONS` of each switch."""
    return sizes.events + CONDITIONS * sizes.switches


@kernel
def peak_row(sizes: Sizes) -> int:
    """Of each event the most that its condition has been while it is true; behind these the largest size that it has
    been at all, its rates at the start and at the end of the open step (1/s, NaN where not known), the largest size
    that these have been, and when a change last made it false; counted from the first condition."""
    return conditions(sizes) + max(2 * conditions(sizes), event_rows(sizes))


@kernel
def rise_row(sizes: Sizes) -> int:
    """Behind them, by how much each condition, also of switches, changed in the step before, infinite without one."""
    return peak_row(sizes) + PEAKS * sizes.events


@kernel
def inside_row(sizes: Sizes, point: int) -> int:
    """Behind that, all conditions, and the rates of those of events, in a point inside of the open step, from 1 on: as
    many as `INTERVALS` make."""
    return rise_row(sizes) + conditions(sizes) + (point - 1) * (conditions(sizes) + sizes.events)


@kernel
def event_rows(sizes: Sizes) -> int:
    """What the kernel `events` writes: the conditions, the values that events read, with the kinetic and the potential
    energy (J) behind them, how fast switches move that should not, and the rates of the conditions of events."""
    return rate_row(sizes) + sizes.events


@kernel
def pushing_row(sizes: Sizes) -> int:
    """Where it is said of each switch how fast (m/s or rad/s) what touches moves along its friction, which should be
    against it, or what holds moves although it does; behind the energies."""
    return conditions(sizes) + (sizes.values + 2 if sizes.values > 0 else 0)


@kernel
def rate_row(sizes: Sizes) -> int:
    """Where the rates of the conditions of events are (1/s), NaN where they are not known."""
    return pushing_row(sizes) + sizes.switches


@kernel
def border_place(i: int, j: int) -> int:
    """Where S[i, j] is in its lower triangle, j <= i; S begins at row 0 of what `border` writes."""
    return i * (i + 1) // 2 + j


@kernel
def border_rates(sizes: Sizes) -> int:
    """Behind S: the rate w of every switched row."""
    return sizes.switched * (sizes.switched + 1) // 2


@kernel
def border_accelerations(sizes: Sizes) -> int:
    """b: how fast the rates would change if no switched row had a reaction."""
    return border_rates(sizes) + sizes.switched


@kernel
def border_gaps(sizes: Sizes) -> int:
    """The residual of every switched row (m, or 1); 0 of those below position level."""
    return border_accelerations(sizes) + sizes.switched


@kernel
def border_alone(sizes: Sizes) -> int:
    """The diagonal of S as it would be without permanent rows: what rounding in S compares with."""
    return border_gaps(sizes) + sizes.switched


@kernel
def border_numbers(sizes: Sizes) -> int:
    """`CONTACT_NUMBERS` of each switch: its coefficients, its length (m, or 1) and its speed (m/s or rad/s)."""
    return border_alone(sizes) + sizes.switched


@kernel
def border_memory(sizes: Sizes) -> int:
    """The memory of all switches as it would be if they were turned on now."""
    return border_numbers(sizes) + CONTACT_NUMBERS * sizes.switches


@kernel
def border_rows(sizes: Sizes) -> int:
    """All that `border` writes."""
    return border_memory(sizes) + sizes.memory


@kernel
def kick_energy(sizes: Sizes) -> int:
    """What `kick` says of the change of energy (J), behind the whole state; behind it the new rates."""
    return state_rows(sizes)


@kernel
def kick_rates(sizes: Sizes) -> int:
    """The rate of every switched row after the impulses."""
    return kick_energy(sizes) + 1


@kernel
def kick_rows(sizes: Sizes) -> int:
    """All that `kick` writes."""
    return kick_rates(sizes) + sizes.switched


CHANGE_VECTORS = 29  # rows of numbers with which changes of one run are worked out


@kernel
def change_impulses(sizes: Sizes) -> int:
    """The impulses of all switched rows, behind what `border` writes."""
    return border_rows(sizes)


@kernel
def change_speeds(sizes: Sizes) -> int:
    """The largest speed so far of every switch."""
    return change_impulses(sizes) + sizes.switched


@kernel
def change_forces(sizes: Sizes) -> int:
    """The force (N or N m) that every switch is compared with."""
    return change_speeds(sizes) + sizes.switches


@kernel
def change_room(sizes: Sizes) -> int:
    """Behind them, where one lane at a time is worked on: three matrices of q rows, and vectors."""
    return change_forces(sizes) + sizes.switches


@kernel
def change_rows(sizes: Sizes) -> int:
    """Of all this; none without switches."""
    q = sizes.switched
    return change_room(sizes) - (-q * (3 * q + 1 + CHANGE_VECTORS) // W) if q > 0 else 0


@kernel
def signal_row(sizes: Sizes, point: int) -> int:
    """The first row of all signals in a point, behind what is kept of them."""
    return KEPT_ROWS * sizes.kept + sizes.signals * point


@kernel
def gain_row(sizes: Sizes) -> int:
    """The first row of what the step adds to integrals, as it says itself, and where a tolerance chooses steps what
    the kernel `quadrature` says of the errors of these."""
    return signal_row(sizes, LARGEST_SIZES + 1)


@kernel
def open_row(sizes: Sizes) -> int:
    """The row that says whether what is between the ends of this step may change anything that is kept."""
    return gain_row(sizes) + 3 * sizes.integrands


@kernel
def seen_row(sizes: Sizes) -> int:
    """The first row of what is said of signals at the end of the step (`said`)."""
    return open_row(sizes) + 1


@kernel
def length_row(sizes: Sizes) -> int:
    """The first row of the lengths of the last steps, the latest first."""
    return seen_row(sizes) + sizes.seen


@kernel
def measure_rows(sizes: Sizes) -> int:
    """Of all this; none where nothing is kept."""
    return length_row(sizes) + PAST if sizes.kept > 0 else 0


@kernel
def record_rows(sizes: Sizes) -> int:
    """Of what is stored: a state, what is observed of it, and the iterations of the projections."""
    return state_rows(sizes) + sizes.observed + PROJECTIONS


# ---------------------------------------------------------------- the memory of a driver
class Workspace(NamedTuple):
    """The first row of each region; as addresses in a driver.

    state, parameters: of the runs in the lanes; new: a state with what a kernel says behind it; slopes, control: see
    above; now, following: iterates of a projection, for which there is room in `state` as well, and in `new` where the
    slopes are no longer needed; u: the argument of a stage; conditions: of events, at the start and
    at the end of a step, with all that `events` writes, when they come true, and what they have been; change: what
    decides about modes; measures: what is kept of runs as a whole, and signals; work: of the kernels.
    """

    state: int
    new: int
    slopes: int
    control: int
    now: int
    following: int
    clock: int
    lanes: int
    u: int
    conditions: int
    table: int
    change: int
    measures: int
    parameters: int
    work: int


@kernel
def workspace(sizes: Sizes) -> Workspace:
    """The regions, one behind the other."""
    iterate = max(state_rows(sizes) + sizes.correction + VERDICT + sizes.chord, event_rows(sizes))
    iterate = max(max(iterate, sizes.signals), first_slope(sizes) + sizes.integrands)
    if sizes.switches > 0:
        iterate = max(iterate, kick_rows(sizes))
    new = iterate
    slopes = new + first_slope(sizes)
    control = slopes + control_row(sizes)
    groups = -(-said(sizes) // max(sizes.coordinates, 1))
    now = slopes + max(said_row(sizes, sizes.coordinates * groups, 0), iterate)
    following = now + iterate
    clock = following + iterate
    lanes = clock + CLOCK
    u = lanes + LANES
    places = u + sizes.coordinates * sizes.elements + sizes.augmented + 1
    table = places + inside_row(sizes, INTERVALS + 1)
    change = table + table_rows(sizes.exchangeable)
    measures = change + change_rows(sizes)
    parameters = measures + measure_rows(sizes)
    work = parameters + sizes.parameters
    return Workspace(
        0, new, slopes, control, now, following, clock, lanes, u, places, table, change, measures, parameters, work
    )
