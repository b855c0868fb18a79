"""Status codes that steppers return; `geomint.errors` turns all but OK into typed errors."""

OK = 0
NOT_CONVERGED = 1
NOT_FINITE = 2
OUTSIDE_CHART = 3  # a stage lies where the coordinates of the group end
STEP_TOO_SMALL = 4  # even the smallest step does not meet the tolerance
TOO_MANY_STEPS = 5  # an adaptive method may take no more
EVENT_NOT_FINITE = 6  # what an event is the zero of
EVENT_UNCLEAR = 7  # it is not smooth enough to tell how often it is zero
CHATTER = 8  # more events in a step than can be meant
LOST_RANK = 9  # constraints depend on each other

Step = tuple[int, int, float]  # status, iterations, residual
Steps = tuple[int, int, int, float]  # status, steps, iterations, residual
