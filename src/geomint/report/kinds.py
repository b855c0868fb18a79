"""The quantities of several runs by kind, and what became of them in words."""

from __future__ import annotations

from ..plan import SeveralRuns
from ..watch.quantities import KINDS, kind_of
from .text import OUTCOMES

SMALL = "32 ε × scale"  # whatever the class of what is so small

__all__ = ["conserved_by_kind", "kinds_in_words", "names_by_kind"]


def names_by_kind(result: SeveralRuns) -> dict[str, list[str]]:
    """Return the quantities that any method has watched, by kind, in the order of `KINDS`."""
    problems = [run.plan.problem for run in result if run.plan is not None]
    found: dict[str, list[str]] = {kind: [] for kind in KINDS}
    for name in dict.fromkeys(name for run in result for name in run.drift):
        found[kind_of(name, result.scene.problem, *problems)].append(name)
    return {kind: names for kind, names in found.items() if names}


def conserved_by_kind(result: SeveralRuns) -> dict[str, list[str]]:
    """Return the same without what is not conserved, whose changes are no errors."""
    found = names_by_kind(result)
    return {kind: names for kind, names in found.items() if KINDS[kind].conserved}


def kinds_in_words(result: SeveralRuns) -> list[tuple[str, str]]:
    """Return for each kind of quantity which methods keep it and which lose it, the best first."""
    words = []
    for kind, names in conserved_by_kind(result).items():
        by_outcome: dict[str, list[str]] = {}
        for run in result:
            drifts = [run.drift[name] for name in names if name in run.drift]
            if drifts:
                worst = min((drift.drift_class for drift in drifts), key=list(OUTCOMES).index)
                small = all(drift.within_roundoff for drift in drifts)
                if small and worst in ("sqrt", "undetermined"):
                    worst = SMALL
                by_outcome.setdefault(worst, []).append(run.title)
        parts = [
            f"{words}: {', '.join(by_outcome[outcome])}"
            for outcome, words in reversed({**OUTCOMES, SMALL: f"no larger than {SMALL}"}.items())
            if outcome in by_outcome
        ]
        words.append((KINDS[kind].title, "; ".join(parts)))
    return words
