"""Where a result comes from: everything that is needed to get it again."""

import json
import math
import os
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..errors import DIGITS, quoted
from ..methods.method import Method
from .result import Result

_COUNTS = ("steps", "rejected", "iterations", "newton")
_SECONDS = ("compile_seconds", "run_seconds", "watching_seconds")
_PACKAGES = ("numpy", "numba", "llvmlite", "scipy", "matplotlib")


def environment() -> dict[str, Any]:
    """Return versions, processor and platform."""
    return {
        "versions": {
            "geomint": __version__,
            "python": platform.python_version(),
            **{name: _version(name) for name in _PACKAGES},
        },
        "cpu": cpu_model(),
        "cores": os.cpu_count(),
        "platform": platform.platform(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def run_provenance(solution: Result) -> dict[str, Any]:
    """Return all about a run, in numbers and strings that JSON can hold."""
    return {**environment(), **run_record(solution)}


def run_record(solution: Result) -> dict[str, Any]:
    """Return what was integrated, how, and at what cost."""
    problem, accuracy = solution.problem, solution.accuracy
    error, end = solution.local_error, solution.end_error
    return {
        "problem": problem.name,
        "pieces": [[name, rows] for name, rows in problem.pieces],
        "parameters": finite_json(dict(problem.parameters)),
        "time": problem.time,
        "drift_time": solution.drift_time,
        "end": finite_json(float(solution.tau[-1])) if len(solution.tau) else None,
        **method_record(solution.method),
        "route": solution.route,
        "accuracy": finite_json(accuracy and accuracy._asdict()),
        "local_error": finite_json(error and error._asdict()),
        "end_error": finite_json(end and end._asdict()),
        "warnings": [finite_json(warning.as_json()) for warning in solution.warnings],
        "step": solution.step,
        "step_sizes": solution.step_sizes._asdict(),
        **{name: getattr(solution, name) for name in _COUNTS},
        "field_evaluations": solution.evaluations,
        **{name: round(getattr(solution, name), 6) for name in _SECONDS},
        "status": solution.status,
        "message": solution.message,
    }


def method_record(method: Method) -> dict[str, Any]:
    """Return a method's name, order and options."""
    return {
        "method": method.name,
        "order": method.order,
        "method_options": finite_json(method.options),
    }


def cpu_model() -> str:
    """Return the name of the processor, as far as the platform knows it."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            key, _, name = line.partition(":")
            if key.strip() == "model name":
                return name.strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def finite_json(value: Any) -> Any:
    """Return `value` in JSON's own kinds; what is not finite becomes None."""
    if isinstance(value, Mapping):
        return {str(key): finite_json(item) for key, item in value.items()}
    if isinstance(value, np.floating):  # the long ones are no numbers of Python's
        return finite_json(float(value))
    if isinstance(value, np.ndarray | np.generic) and not isinstance(value, np.clongdouble):
        return finite_json(value.tolist())
    if isinstance(value, list | tuple):
        return [finite_json(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, int) and value.bit_length() > DIGITS:
        return quoted(value)
    if value is None or isinstance(value, str | int | bool):
        return value
    return repr(value)


def json_text(record: Mapping[str, Any]) -> str:
    """Return a record as the text of a file of strict JSON."""
    return json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
