"""All cases of the stress test, made once for the tests of this folder: it takes some seconds."""

from geomint.stress import own_cases
from geomint.stress.case import stress_cases
from tests.problems import examples

CASES = stress_cases()
SYSTEMS = {case.system for case in CASES}
# With those of the test problems that are no part of geomint, which `geomint stress` does not know.
EVERY = [*CASES, *(case for case in own_cases.cases(examples) if case.system not in SYSTEMS)]
