"""The quantities of runs by kind, and what became of them in words."""

from ..plan import MethodRun, SeveralRuns
from ..watch.kinds import KINDS
from ..watch.quantities import kind_of
from .text import OUTCOMES, what_happened

ByKind = dict[str, list[str]]  # names of quantities
SMALL = "round-off"  # whatever the class of what is so small

__all__ = ["by_roundoff", "conserved_by_kind", "kinds_in_words", "names_by_kind", "outcomes"]


def names_by_kind(result: SeveralRuns) -> ByKind:
    """Return the quantities that any method has watched, by kind, in the order of `KINDS`."""
    problems = [run.plan.problem for run in result if run.plan is not None]
    found: ByKind = {kind: [] for kind in KINDS}
    for name in dict.fromkeys(name for run in result for name in run.drift):
        found[kind_of(name, result.scene.problem, *problems)].append(name)
    return {kind: names for kind, names in found.items() if names}


def conserved_by_kind(result: SeveralRuns) -> ByKind:
    """Return the same without what is not conserved, whose changes are no errors."""
    found = names_by_kind(result)
    return {kind: names for kind, names in found.items() if KINDS[kind].conserved}


def by_roundoff(result: SeveralRuns) -> tuple[ByKind, ByKind]:
    """Return the quantities by kind: kinds that any method takes beyond round-off, and the others."""
    found = names_by_kind(result)
    kept = {
        kind
        for kind, names in found.items()
        if all(run.drift[n].within_roundoff for run in result for n in names if n in run.drift)
    }
    folded = {kind: names for kind, names in found.items() if kind in kept}
    return {kind: names for kind, names in found.items() if kind not in kept}, folded


def outcomes(result: SeveralRuns) -> list[tuple[str, str]]:
    """Return what was found in words: of one method as a whole, of several for each kind."""
    if len(result) > 1:
        return kinds_in_words(result)
    return [("", verdict(result[0], result.time))]


def verdict(run: MethodRun, time: str) -> str:
    """Return the outcome of a run in a sentence or two, the worst first."""
    named: ByKind = {kind: [] for kind in OUTCOMES}
    for name, drift in run.drift.items():
        event = what_happened(drift, time)
        named[drift.drift_class].append(f"{name} ({event})" if event else name)
    words = [f"{OUTCOMES[kind]}: {', '.join(names)}" for kind, names in named.items() if names]
    if not words:
        return f"No {'quantity' if run.status == 'success' else 'step'} was watched."
    text = "; ".join(words)
    outcome = f"{text[0].upper()}{text[1:]}."
    if all(drift.drift_class in ("roundoff", "bounded") for drift in run.drift.values()):
        return f"Nothing drifts. {outcome}"
    small = [
        name
        for name, drift in run.drift.items()
        if drift.within_roundoff and drift.drift_class != "roundoff"
    ]
    return f"{outcome} No larger than {SMALL}: {', '.join(small)}." if small else outcome


def kinds_in_words(result: SeveralRuns) -> list[tuple[str, str]]:
    """Return for each kind of quantity which methods keep it and which lose it, the best first."""
    words = []
    for kind, names in conserved_by_kind(result).items():
        by_outcome: ByKind = {}
        for run in result:
            drifts = [run.drift[name] for name in names if name in run.drift]
            if drifts:
                worst = min((drift.drift_class for drift in drifts), key=list(OUTCOMES).index)
                small = all(drift.within_roundoff for drift in drifts)
                if small and worst in ("sqrt", "undetermined", "jump"):
                    worst = SMALL
                by_outcome.setdefault(worst, []).append(run.title)
        parts = [
            f"{words}: {', '.join(by_outcome[outcome])}"
            for outcome, words in reversed({**OUTCOMES, SMALL: f"no larger than {SMALL}"}.items())
            if outcome in by_outcome
        ]
        words.append((KINDS[kind].title, "; ".join(parts)))
    return words
