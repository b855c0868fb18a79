"""All cases of the stress test, made once for the tests of this folder: it takes a second."""

from geomint.stress.case import stress_cases

CASES = stress_cases()
