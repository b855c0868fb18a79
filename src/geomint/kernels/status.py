"""Status codes that steppers return; `geomint.errors` turns all but OK into typed errors."""

OK = 0
NOT_CONVERGED = 1
NOT_FINITE = 2
