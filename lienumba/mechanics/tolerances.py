"""Tolerances of the equations of motion, of projections and of ranks."""

# Elimination of the KKT system. A pivot compares with the diagonal element of C A^-1 C^T of its row.
SINGULAR_PIVOT = 1e-12  # a smaller pivot is zero
WEAK_PIVOT = 1e-5  # in closed loops the right-hand side of a row whose pivot is smaller is faded
HALF_FADED_PIVOT = 1e-6  # to one half at this pivot
LEAST_PIVOT = 1e-13  # smaller pivots are replaced by it
HALF_FADED_MARGIN = 1e-9  # of runs that coast: at this margin the correction of what is expected is halved
SCALE_ROUNDOFF = 1e-24  # relative to the other part of a squared scale: a smaller part is roundoff
MULTIPLIER_SHIFT = 1e-6  # of the diagonal, absolute: multipliers of least norm
MULTIPLIER_RTOL = 1e-12  # the same, relative, for their refinement

# Projections.
ROUNDOFF = 16.0 * 2.0**-52  # relative to the size of a joint and to the distance of its bodies: less is no violation
SINGULAR_VIOLATION = 1e-9  # relative: as much may be left of a row in a singular position
SINGULAR_RATE = 1e-6  # m/s or rad/s: the same of its rate
BRANCH_ENERGY = (
    0.05  # of the kinetic energy: a correction of the velocities with more means that a loop left its branch
)
LEAP_SPEED = 1e-3  # of the speed of the bodies: a closed contact that moves faster along its normal has leapt

# Ranks by singular values, relative to the largest.
RANK_RTOL = 1e-9  # a smaller one is zero
CERTAIN_RANK = 1e-12  # of the square of the smallest: if it is larger, the rank is full beyond doubt
START_RANK_RTOL = 1e-6  # a smaller one is zero where the state does not fulfil the constraints yet
DEPENDENCE_RTOL = 1e-6  # of a unit null vector: rows with a larger component depend on one another
CONTRADICTION_RTOL = 1e-6  # relative to the largest right-hand side: what is left of a row contradicts the others
MET_RTOL = 1e-9  # relative to the size, distance or speed of joints: less is fulfilled
MET_ATOL = 1e-13  # m/s^2 or rad/s^2: the same, absolute
LOOK_AHEAD_TIME, LOOK_AHEAD_TURN = 1e-2, 0.05  # s and rad: how far ahead of the start drivers are compared
LOOK_AHEAD_STEPS = 8  # of Newton's method, which follows the drivers

# Motion through a singular position.
PASS_TURN, PASS_TIME = 0.01, 0.01  # rad and s: how far to either side of it, at most
PASS_CORRECTIONS = 6  # projections of the state there
PASS_ROUNDS = 3  # each with the accelerations of the one before

# Times and formulas.
SAME_TIME_RTOL = 1e-9  # times that differ by less are one
MAX_WHOLE_NUMBERS = 1e5  # that a formula with floor or ceil may pass in a run

# Choice of axes by counting operations.
DIVISION_COST = 16  # operations that take as long as a division
MAX_COUNTED_BODIES = 20  # for more bodies counting takes longer than it saves
MAX_TRIED_BODIES = 3  # up to which the axes of every body are tried for all
