"""What a kernel says of a run it could not advance; 0 is good."""

NON_FINITE = 1.0
NOT_CONVERGED = 2.0
SINGULAR = 3.0
ROTATION = 4.0

HUGE = 1e300  # a sum of squares below this is finite
REPORTS = 3  # rows behind the slopes of a stage: whether its KKT was sound, the power, the margin
