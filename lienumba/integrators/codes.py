"""What a kernel says of a run it could not advance; 0 is good."""

NON_FINITE = 1.0
NOT_CONVERGED = 2.0
SINGULAR = 3.0
ROTATION = 4.0
EXCHANGED = 7.0  # no failure: the run needs other rows of C, which this program does not have

HUGE = 1e300  # a sum of squares below this is finite
CONTROL = 4  # rows: of the error of a step its square, factors for the next step if it is accepted or not, what to remember
REPORTS = 3  # rows behind the slopes of a stage: whether its KKT was sound, the power, the margin
