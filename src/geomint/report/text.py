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
    return text.replace("-", "−") if text.startswith("-") and "e" not in text else text


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
    return f"({scaled:.{digits}f} ± {spread:.{digits}f})e{power:+03d}"


def verdict(solution: Solution) -> str:
    """Return the outcome of a run in a sentence."""
    kinds: dict[str, list[str]] = {}
    for name, drift in solution.drift.items():
        kinds.setdefault(drift.kind, []).append(name)
    if not kinds:
        return "No quantity was watched."
    growing = [
        f"{_listed(kinds[kind])} {_verb(kinds[kind], one, many)}"
        for kind, one, many in (
            ("faster", "grows faster than in proportion to time", "grow faster than that"),
            ("linear", "drifts in proportion to time", "drift in proportion to time"),
            ("sqrt", "wanders like a random walk", "wander like random walks"),
            ("undetermined", "is undetermined", "are undetermined"),
        )
        if kind in kinds
    ]
    kept = [*kinds.get("roundoff", []), *kinds.get("bounded", [])]
    if not growing:
        if "bounded" not in kinds:
            return "Nothing drifts: every quantity stays within round-off."
        return "Nothing drifts: every quantity stays within round-off or bounds."
    text = "; ".join(growing)
    if kept:
        words = [word for kind, word in (("roundoff", "within round-off"), ("bounded", "bounded")) if kind in kinds]
        text += f"; {_listed(kept)} {_verb(kept, 'stays', 'stay')} {' or '.join(words)}"
    return text[0].upper() + text[1:] + "." if not text.startswith(tuple(solution.drift)) else text + "."


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _verb(names: list[str], one: str, many: str) -> str:
    return one if len(names) == 1 else many
