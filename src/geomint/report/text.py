"""Numbers and sentences of reports."""

from __future__ import annotations

import math

from ..solution import Solution

__all__ = ["number", "verdict", "with_error"]


def number(value: float | None, digits: int = 3) -> str:
    """Return a number for readers: ``1.23e-11``, ``0``, ``—`` for none."""
    if value is None:
        return "—"
    if not math.isfinite(value):
        return "not finite"
    text = f"{value:.{digits}g}"
    return f"−{text[1:]}" if text.startswith("-") else text


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


_OUTCOMES = {
    "faster": "growing faster than in proportion to time",
    "linear": "drifting in proportion to time",
    "sqrt": "wandering like a random walk",
    "undetermined": "undetermined",
    "bounded": "bounded",
    "roundoff": "within round-off",
}


def verdict(solution: Solution) -> str:
    """Return the outcome of a run in a sentence, the worst first."""
    named: dict[str, list[str]] = {kind: [] for kind in _OUTCOMES}
    for name, drift in solution.drift.items():
        named[drift.kind].append(name)
    told = [f"{_OUTCOMES[kind]}: {', '.join(names)}" for kind, names in named.items() if names]
    if not told:
        return "No quantity was watched."
    if set(solution.drift) == {*named["roundoff"], *named["bounded"]}:
        return f"Nothing drifts. {_sentence('; '.join(told))}"
    return _sentence("; ".join(told))


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."
