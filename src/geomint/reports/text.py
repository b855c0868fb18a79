"""Numbers and sentences of reports."""

import inspect
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..errors import shortened
from ..plan import MethodRun
from ..problems.problem import Problem
from ..run.provenance import environment, finite_json
from ..run.solution import Solution
from ..scene.provenance import scene_record
from ..scene.scene import Scene
from ..watch.drift import Drift

Record = dict[str, Any]  # the content of a JSON file, or a part of it
MOST_ENTRIES = 36  # of a matrix that is shown

__all__ = [
    "OUTCOMES",
    "duration",
    "number",
    "parameter",
    "parameters_told",
    "rule_details",
    "scene_facts",
    "short_slope",
    "step_of",
    "symbol",
    "watched_to",
    "what_happened",
    "with_error",
    "with_provenance",
]


def number(value: float | None, digits: int = 3) -> str:
    """Return a number for readers: ``1.23e-11``, ``0``, ``—`` for none."""
    if value is None:
        return "—"
    if not math.isfinite(value):
        return "not finite"
    text = f"{value:.{digits}g}"
    return f"−{text[1:]}" if text.startswith("-") else text


def parameter(value: Any) -> str:
    """Return a parameter of a problem for readers: numbers to ten digits, of matrices the rows."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    shown = np.asarray(value)
    if shown.dtype.kind not in "iuf" or shown.size > MOST_ENTRIES:
        return shortened(str(value), 200)
    if shown.ndim == 0:
        return number(float(shown), 10)
    if shown.ndim == 1:
        return ", ".join(number(float(x), 10) for x in shown)
    return "; ".join(parameter(row) for row in shown)


def parameters_told(scene: Scene, problem: Problem) -> dict[str, str]:
    """Return the parameters of a scene as they were given, and then what else a problem has.

    Under their keys, with the symbol that the system has for one in brackets.
    """
    given = {key: value for key, value in scene.sections["system"].items() if key != "name"}
    fields = scene.system.parameters.model_fields
    named = {key: field.title or field.description for key, field in fields.items()}
    told = {f"{k} ({named[k]})" if named.get(k) else k: parameter(v) for k, v in given.items()}
    left = {key: value for key, value in problem.parameters.items() if key not in given}
    return told | {key: parameter(value) for key, value in left.items()}


def step_of(solution: Solution, digits: int = 6) -> str:
    """Return the step of a run; of an adaptive one mean, smallest and largest step."""
    if not solution.method.adaptive:
        return f"{abs(solution.step):.{digits}g}"
    sizes = solution.step_sizes
    return f"{sizes.mean:.4g} on average ({sizes.min:.3g} to {sizes.max:.3g})"


def with_error(value: float | None, error: float | None) -> str:
    """Return ``(1.23 ± 0.05)e-15``, or the parts that there are."""
    if value is None or error is None or not (math.isfinite(value) and math.isfinite(error)):
        return "—"
    if value == 0.0 and error == 0.0:
        return "0"
    power = math.floor(math.log10(max(abs(value), error)))
    digits = 2
    if error > 0.0:
        digits = min(max(power - math.floor(math.log10(error)) + 1, 1), 6)
    scaled, spread = value / 10.0**power, error / 10.0**power
    sign = "−" if scaled < 0.0 else ""
    return f"({sign}{abs(scaled):.{digits}f} ± {spread:.{digits}f})e{power:+03d}"


def short_slope(value: float | None, error: float | None) -> str:
    """Return a slope for a narrow table: without its error where that is below 1 %."""
    if value is not None and error is not None and abs(value) > 100.0 * abs(error) > 0.0:
        return number(value)
    return with_error(value, error)


# What the classes mean in a sentence, the worst first.
OUTCOMES = {
    "not finite": "infinite or not a number",
    "faster": "growing faster than in proportion to time",
    "linear": "drifting in proportion to time",
    "jump": "jumping",
    "sqrt": "wandering like a random walk",
    "undetermined": "undetermined",
    "bounded": "bounded",
    "roundoff": "within round-off",
}


def duration(seconds: float) -> str:
    """Return a duration with a unit: ``1.2 µs``, ``34 ms``, ``5.6 s``; ``–`` for none."""
    if seconds <= 0.0:
        return "–"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g}\u202f{unit}"
    return f"{seconds / 1e-9:.3g}\u202fns"


def rule_details() -> str:
    """Return the statistical rule as its module states it, without the markup."""
    from ..watch import growth

    # The source has it under `python -OO` too.
    plain = inspect.getsource(growth).replace("`", "").replace("\\|", "|")
    begin, end = plain.index("The window means"), plain.index("\nMeasured on")
    return plain[begin:end].rstrip()


def symbol(time: str) -> str:
    """Return how a time is written: ``"tau"`` as τ."""
    return "τ" if time == "tau" else "t"


def watched_to(drift: Drift, run: MethodRun) -> str:
    """Return how long a quantity was watched, as ``to t = 400``; empty if to the end of the run."""
    until = drift.windows.last_time
    if run.solution is None or drift.windows.samples == 0 or abs(until) >= 0.99 * abs(run.end):
        return ""
    return f"to {symbol(run.solution.drift_time)} = {until:.4g}"


def what_happened(drift: Drift, time: str) -> str:
    """Return size and time of a jump, or from when on a drift is not finite; else nothing."""
    unit = symbol(time)
    if drift.not_finite_from is not None:
        return f"from {unit} = {number(drift.not_finite_from, 4)} on"
    if drift.drift_class != "jump" or drift.jump_time is None:
        return ""
    when = "in the first step" if drift.jump_time == 0.0 else f"at {unit} = {drift.jump_time:.4g}"
    return f"by {number(drift.jump_size)} {when}"


def with_provenance(record: Record, scene: Scene | None, command: str | None) -> Record:
    """Return a record, as JSON can hold it, with versions, processor, date, and what was asked for."""
    told = {**environment(), "command": command} if scene is None else scene_record(scene, command)
    return {**finite_json(record), "provenance": told}


def scene_facts(provenance: Record, method: str, representation: str = "") -> dict[str, str]:
    """Return what was computed and how: system, parameters, initial state, method, versions.

    Parameters
    ----------
    provenance : mapping
        As `geomint.scene.provenance.scene_record` gives it.
    method, representation : str
        In words.
    """
    scene, versions = provenance["scene"], provenance["versions"]
    system = scene["system"]["name"]
    system += f", in the representation {representation}" if representation else ""
    named = {key: value for key, value in scene["system"].items() if key != "name"}
    facts = {
        "System": system,
        "Parameters": ", ".join(_values(named)),
        "Initial state": ", ".join(_values(scene.get("initial") or provenance.get("state", {}))),
        "Method": method,
        "Software": ", ".join(f"{name} {version}" for name, version in versions.items() if version),
    }
    return {heading: words for heading, words in facts.items() if words}


def _values(named: Mapping[str, Any]) -> Iterator[str]:
    for name, value in named.items():
        yield f"{name} = {_value(value)}"


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"({', '.join(_value(one) for one in value)})"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return number(float(value), 10)
