"""Where everything lies in memory, stated once: kernels are traced by it, drivers read and write by it.

Rows have W doubles, one lane for each run. Functions are plain ones of whole numbers, for the tracer and for drivers.
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

# Rows of the clock, one number for each lane.
TIME = 0  # t (s)
LENGTH = 1  # of the part of a step (s)
NODE = 2  # c of a stage
MIDDLE = 3  # the time in the middle of the part (s): in which piece of a table a stage lies
FRACTION = 4  # of the part: where the continuous extension is read
MEMORY = 5  # of the controller of steps
LEAN = 6  # by how much (s) t leans to the inside of the part, where a signal that jumps at its end is evaluated
TOLERANCE = 7  # the first of the numbers of a `step_control.Tolerance`
TOLERANCES, CLOCK = 6, TOLERANCE + 6

# Rows of what drivers know of each lane.
ITERATIONS = 0  # the most of both projections since something was stored: two rows
PROJECTIONS = 2
T = 2  # the time (s)
H = 3  # the step to be tried (s)
JUMP = 4  # the next discontinuity (s), on which a step has to end
GRID = 5  # how many steps of given length have been done
UNTIL, DUE = 6, 7  # the end of the current step (s), and the time that is stored next (s)
BUSY = 8  # whether the lane has a run
FRESH = 9  # whether that has just begun; BEGINS as long as it has no events yet
BEGINS = 2.0
STALE = 10  # whether F is not known at the state
TRIAL, STATUS, BACK = 11, 12, 13  # the code of the step, that of the run, and whether the last step was rejected
ACCEPTED, REJECTED = 14, 15  # how many steps were
PICKED = 16  # a selection of lanes, for code that goes through them one by one
CUT = 17  # the time (s) of a change, on which the step is to end
CHANGED = 18  # whether the mechanism changes
RECENT, MANY = 19, 20  # since when (s) how many changes
GAINED, HAD = 21, 22  # energy (J) by numbers that are set, or bodies moved to close a joint, and the energy before
NEAR_END = 23  # whether crossings were located next to the end of a step that was cut for them
MARK, TRIED = 24, 25  # when (s), and after how many steps, the run had last got on
SEEN = 26  # 1: signals go on from the last step; 0: they may have jumped; -1: bodies have
ROOT, LOOKED, PASSES = 27, 28, 29  # the root of the margin, when (s), and the singular position (s) by that
FREES, STRODE = 30, 31  # whether a change only releases constraints that are in use; how long (s) the last step was
RESOLVED = 32  # the longest part (s) of a step in which samples resolved all guard functions, since the last change
LANES = 33

# Rows behind other ones.
CODE, MARGIN, VERDICT = range(3)  # behind the state to which a step leads, and how many
VIOLATION, ITERATE_CODE = range(2)  # behind the iterate to which a projection leads
TURNED, MOVED = range(2)  # behind one element at the end of a step by stages: squares of its rotation and its move
NONSINGULAR, POWER, STAGE_MARGIN, REPORTS = range(4)  # behind the slopes of a stage: of its KKT, and the power (W)
ERROR, FACTOR, REMEMBERED, CONTROL = range(4)  # the square of a step's error, and `step_control.factor`

# Numbers of each switched constraint (`lienumba.mechanics.system.switches`). How one is on: as in `kinematics`.
SWITCH_KIND = 0  # BILATERAL: joints and locks; UNILATERAL: stops and contacts; FRICTION: of a joint
SWITCH_FIRST, SWITCH_ROWS = 1, 2  # its first row among the switched ones, and how many it has
SWITCH_TANGENTS = 3  # how many of its rows, the last ones, are tangents
SWITCH_MEMORY, SWITCH_MEMORIES = 4, 5  # its first number of memory, and how many it has
SWITCH_SHARES, SWITCH_COMPLIANCE = 6, 7  # whether it shares what it carries; its first number of that in memory, or -1
SWITCH_NUMBERS = 8
BILATERAL, UNILATERAL, FRICTION = range(3)
OFF, STICK, SLIDE = range(3)
RESTITUTION, STATIC, KINETIC, REST_SPEED, STATIC_EFFORT, KINETIC_EFFORT, SIZE, SPEED, CONTACT_NUMBERS = range(9)
OPENS, SLIDES, CONDITIONS = range(3)  # its guard functions; see `switched.turning`

# Numbers of each event.
ACTION = 0  # RECORDS, LOCKS, ENGAGES, RELEASES or SETS
TARGET, TARGETS = 1, 2  # the first of its targets among those of all events, and how many: switches, or rows of states
VALUE, ONCE = 3, 4  # the first of its values, and whether it acts only once
NEEDS, WRITTEN = 5, 6  # the switch that has to be on, -1 if none; whether its condition is of the scenario
CLOCK_ROW = 7  # the row of states that is its latest time (s), -1 if none
ACT_NUMBERS = 8
RECORDS, LOCKS, ENGAGES, RELEASES, SETS = range(5)

# Rows of what is known of each event: see `peak_row`.
PEAK, EXTENT = 0, 1  # the largest value of its guard function since that is above 0, and its largest size at all
RATE, END_RATE = 2, 3  # its rates at the start and at the end of the current step (1/s), NaN where not known
SWIFTEST, LAPSED = 4, 5  # the largest size of its rates so far, and when (s) a change last made it false
PEAKS = 6
POINTS, GUARD_NODES = 5, 9  # Lobatto's, and samples of guard functions in a part of a step
# Rows of each guard function behind its nodes, while a step is subdivided.
ABOVE_ZERO = GUARD_NODES  # whether it is, as far as the step has been searched
LOW_PLACE, LOW_VALUE = GUARD_NODES + 1, GUARD_NODES + 2  # the last fraction at which it was not, and its value there
SEARCHES = 3

# A record of a run as a whole: how, of which signal while which other one is above 0 (-1: of none, always), of which
# event it has the condition (-1: of none), and its first guard, and how many, in the list of all guards
# (`Plan.guards`). Its rows: the value, its time (s), NaN as long as there is none, the most that the condition has been
# since it holds, 0 where it does not, whether it cannot be known, because something was undefined, the largest size of
# the condition where steps ended so far, and whether what is between the ends of this step may
# change it. Signals are known in NODES of a step and of a subinterval of it, and ELSEWHERE; behind that, by how much
# each changed in the last step (CHANGES) and in the one before (EARLIER), its rate at the end of that, NaN where it is
# not known (RATES), and the largest sizes of the signal and of its rate so far.
KEPT_NUMBERS = 6
LARGEST, SMALLEST, INTEGRATES, KEEPS_FIRST, KEEPS_LAST, COUNTS = range(6)
KEPT_VALUE, KEPT_TIME, KEPT_PEAK, KEPT_UNDEFINED, KEPT_SIZE, KEPT_OPEN, KEPT_ROWS = range(7)
NODES = 7  # Lobatto's points of a subinterval, and two more at which their polynomial is tested
ELSEWHERE, CHANGES, EARLIER, RATES, LARGEST_SIZES, LARGEST_RATES = range(2 * NODES, 2 * NODES + 6)
PAST = 2  # steps whose lengths (s) are known, 0 where they say nothing of what follows


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
def node_row(sizes: Sizes, node: int) -> int:
    """Behind that, all guard functions at a node of a part of the step; behind the nodes ABOVE_ZERO and so on."""
    return rise_row(sizes) + conditions(sizes) * (1 + node)


@kernel
def node_rate_row(sizes: Sizes, node: int) -> int:
    """Behind that, the rates of the guard functions of events at the nodes (1/s)."""
    return node_row(sizes, GUARD_NODES + SEARCHES) + sizes.events * node


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


CHANGE_VECTORS = 27  # rows of numbers with which changes of one run are worked out


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
    """Behind them, where one lane at a time is worked on: three matrices of q rows, vectors, and
    what `switching.pivoting` works in."""
    return change_forces(sizes) + sizes.switches


@kernel
def change_rows(sizes: Sizes) -> int:
    """Of all this; none without switches."""
    q = sizes.switched
    return change_room(sizes) - (-(q * (19 * q + 45 + CHANGE_VECTORS) + 2) // W) if q > 0 else 0


@kernel
def signal_row(sizes: Sizes, point: int) -> int:
    """The first row of all signals in a point, behind what is kept of them."""
    return KEPT_ROWS * sizes.kept + sizes.signals * point


@kernel
def gain_row(sizes: Sizes) -> int:
    """The first row of what the step adds to integrals, as it says itself, and where a tolerance chooses steps what
    the kernel `quadrature` says of the errors of these."""
    return signal_row(sizes, LARGEST_RATES + 1)


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
    table = places + node_rate_row(sizes, GUARD_NODES)
    change = table + table_rows(sizes.exchangeable)
    measures = change + change_rows(sizes)
    parameters = measures + measure_rows(sizes)
    work = parameters + sizes.parameters
    return Workspace(
        0, new, slopes, control, now, following, clock, lanes, u, places, table, change, measures, parameters, work
    )
