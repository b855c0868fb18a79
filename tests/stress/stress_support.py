"""All cases of the stress test, made once for the tests of this folder: it takes some seconds."""

import functools
import warnings
from importlib.metadata import entry_points

import geomint as gi
from geomint.stress import sweep
from tests.problems import examples

OFFERED = {point.name: point.load() for point in entry_points(group="geomint.stress")}
CASES = sweep.stress_cases()
SYSTEMS = {case.system for case in CASES}
# With those of the test problems that are no part of geomint, which `geomint stress` does not know.
EVERY = [*CASES, *(case for case in OFFERED["geomint"](examples) if case.system not in SYSTEMS)]
AXES = list(dict.fromkeys(case.axis for case in CASES))


@functools.cache
def built(case: int) -> gi.Model:
    """Return the model of a case of `EVERY`, by its number."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gi.GeomintWarning)
        return EVERY[case].build()
