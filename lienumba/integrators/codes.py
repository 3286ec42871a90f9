"""The numbers on which kernels and drivers agree."""

# What a kernel says of a run it could not advance; 0 is good.
NON_FINITE = 1.0
NOT_CONVERGED = 2.0
SINGULAR = 3.0
ROTATION = 4.0
EXCHANGED = 7.0  # no failure: the run needs other rows of C, which this program does not have
TOO_SHORT = 8.0  # said by a driver: the tolerance asks for a step below the shortest
STOPPED = 9.0  # no failure: an event

# Rows of the clock: t, the length of the part of a step, c of a stage, the time in the middle of the part, which tells
# in which piece of a table a stage lies; the fraction of the part at which the continuous extension is read, what the
# controller of steps remembers, and the first of the numbers of a `control.Tolerance`.
TIME, LENGTH, NODE, MIDDLE, FRACTION, MEMORY, TOLERANCE = range(7)
CLOCK = TOLERANCE + 6

REPORTS = 3  # rows behind the slopes of a stage: whether its KKT was sound, the power, the margin
CONTROL = 4  # rows: the square of a step's error, factors for the next step if it is accepted or not, what to remember

HUGE = 1e300  # a sum of squares below this is finite
