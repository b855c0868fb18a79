"""One side of a comparison: the runs in one checkout, each as a flat mapping of names to values.

`compare` starts this file as a process, which writes a pickle for each run to its standard output.
"""

import os
import pickle
import sys
import time
import warnings
from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

# What is read off a result, by its class: the one place to say that an attribute has another name
# in an older checkout, as "name|older-name". A class that is called anew is one more line.
ATTRIBUTES = {
    "Solution": "t tau y step step_sizes steps rejected iterations evaluations status message route "
    "drift drift_time events error_estimate accuracy",
    "Drift": "initial max_abs_error max_rel_error scale final_error slope slope_stderr drift_class "
    "windows trend_bound jump_size jump_time not_finite_from kind label note within_roundoff",
    "Windows": "initial last_time last length samples max_abs closed",
    "Met": "tau t y directions",
    "Section": "name tau t y directions motions status step steps axes",
    "Lyapunov": "exponents errors t running sali y unit steps iterations status verdict",
    "TangentFlow": "y slopes",
    "Sensitivities": "y by_state parameters by_parameters quantities",
    "Quantity": "value by_state by_parameters",
    "Ensemble": "tau y counts final steps status drift events errors readings error_estimate",
    "EnsembleGrowth": "exponent exponent_stderr drift_class size",
    "Term": "frequency amplitude",
    "Average": "value digits gained verdict",
    "Integrator": "time state steps iterations h",
    "RolledPath": "t states attitude contact error",
    "FrequencyMap": "frequencies conditions refused rotation_numbers",
    "OdeResult": "t y nfev status message t_events",
}


def flat(value: Any, name: str = "") -> dict[str, Any]:
    """Return a result as a flat mapping of names to arrays and texts."""
    if value is None or isinstance(value, str | bool | int):
        return {name: str(value)}
    if isinstance(value, float | complex | np.ndarray | np.generic):
        return {name: np.asarray(value)}
    if isinstance(value, BaseException):
        partial = flat(getattr(value, "partial", None), f"{name}.partial")
        return {name: f"{type(value).__name__}: {value}", **partial}
    if isinstance(value, list | tuple):
        value = dict(enumerate(value))
    if not isinstance(value, Mapping):
        listed = [ATTRIBUTES[c.__name__] for c in type(value).__mro__ if c.__name__ in ATTRIBUTES]
        if not listed:
            raise TypeError(f"{type(value).__name__}: no line of ATTRIBUTES says what to compare")
        value = {names.split("|")[0]: _read(value, names.split("|")) for names in listed[0].split()}
    found: dict[str, Any] = {f"{name}.names": " ".join(map(str, value))}
    for key, part in value.items():
        found.update(flat(part, f"{name}.{key}" if name else str(key)))
    return found


def _read(value: Any, names: list[str]) -> Any:
    """Return an attribute by the first name that is there, or why it has no value."""
    try:
        return getattr(value, next((name for name in names if hasattr(value, name)), names[0]))
    except Exception as error:
        return error


def outcome(run: Any) -> dict[str, Any]:
    """Return what a run gives, and its warnings; of one that fails the error."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            found = flat(run())
        except Exception as error:
            found = flat(error, "error")
    own = [f"{w.category.__name__}: {w.message}" for w in told]
    return {**found, "warnings": "\n".join(w for w in own if w.startswith("Geomint"))}


def main(checkout: str, *patterns: str) -> None:
    """Run what fits a pattern, the last first after ``--backwards``; write (name, values, seconds)."""
    with os.fdopen(os.dup(1), "wb") as results:
        os.dup2(2, 1)  # what a run prints by itself is no result
        import geomint
        from tests.kept import commands, library

        if not Path(geomint.__file__).is_relative_to(checkout):
            sys.exit(f"geomint is {geomint.__file__}, not of {checkout}")
        parts = [(part.__name__, part()) for part in (*library.PARTS, *commands.PARTS)]
        runs = [(f"{part}/{name}", run) for part, own in parts for name, run in own]
        runs = [run for run in runs if any(fnmatchcase(run[0], p) for p in patterns)]
        pickle.dump([name for name, _ in runs], results)
        for name, run in reversed(runs) if "--backwards" in patterns else runs:
            begun = time.process_time()
            pickle.dump((name, outcome(run), time.process_time() - begun), results)
            results.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
