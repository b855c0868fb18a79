"""What an audit tells: the numbers of ``audit.json``, tables of the terminal and of the docs."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Column
from rich.text import Text

from geomint.report.columns import fitted

from .claim import (
    FAILS,
    FINDINGS,
    HOLDS,
    MISPRINT,
    ON_MANIFOLD,
    RESTRICTED,
    STRONGER,
    TRUE,
    UNCHECKED,
    UNEXPLAINED,
    Result,
)
from .run import Audit

__all__ = [
    "as_json",
    "by_section",
    "counts",
    "distinct",
    "explanation",
    "figure_of",
    "markdown",
    "print_audit",
    "residuals",
    "summary",
]

COLOURS = {
    TRUE: "green",
    ON_MANIFOLD: "cyan",
    RESTRICTED: "yellow",
    STRONGER: "blue",
    MISPRINT: "magenta",
    UNCHECKED: "dim",
    UNEXPLAINED: "bold red",
}


def counts(audit: Audit) -> dict[str, int]:
    """Return how often each verdict occurs."""
    verdicts = [result.verdict for result in audit.results]
    return {verdict: verdicts.count(verdict) for verdict in COLOURS if verdict in verdicts}


def distinct(audit: Audit) -> dict[str, int]:
    """Return how many findings there are of each kind: several claims may show one."""
    kinds = [results[0].verdict for results in audit.findings.values()]
    return {kind: kinds.count(kind) for kind in FINDINGS if kind in kinds}


def _row(result: Result) -> dict[str, Any]:
    claim = result.claim
    return {
        "label": claim.label,
        "statement": claim.statement,
        "residual": _finite(result.residual),
        "verdict": result.verdict,
        "corrected": claim.amendment or None,
        "corrected_residual": _finite(result.amended),
        "off_manifold_residual": _finite(result.off_manifold),
        "negative": claim.negative,
        "claimed_off_manifold": claim.everywhere,
        "finding": (claim.finding or claim.label) if result.verdict in FINDINGS else None,
        "cites": list(claim.cites),
        "reason": result.reason or None,
        "section": claim.section,
        "lines": claim.lines,
        "n": list(result.dimensions),
        "points": result.points,
    }


def _finite(x: float | None) -> float | str | None:
    return x if x is None or np.isfinite(x) else repr(x)


def as_json(audit: Audit) -> dict[str, Any]:
    """Return the content of ``audit.json``, but for its provenance."""
    below, above = audit.gap
    return {
        "claims": [_row(result) for result in audit.results],
        "counts": counts(audit),
        "findings": distinct(audit),
        "thresholds": {"holds": HOLDS, "fails": FAILS},
        "gap": {"largest_that_holds": below, "least_that_fails": _finite(above)},
        "n": list(audit.dimensions),
        "points": audit.points,
        "seed": audit.seed,
        "seconds": round(audit.seconds, 3),
    }


def _number(x: float | None) -> str:
    if x is None:
        return ""
    return "0" if x == 0.0 else f"{x:.1e}" if np.isfinite(x) else "no value"


def residuals(result: Result) -> tuple[str, str]:
    """Return the residuals on and off the manifold; in brackets where nothing is claimed."""
    off = _number(result.off_manifold)
    return _number(result.residual), off if result.claim.everywhere or not off else f"({off})"


def explanation(result: Result) -> str:
    """Return what holds instead with its residual, or why nothing was evaluated."""
    if result.claim.amendment:
        return f"{result.claim.amendment} ({_number(result.amended)})"
    return result.remark


def summary(audit: Audit) -> str:
    """Return what was found in some sentences."""
    below, above = audit.gap
    found = ", ".join(f"{number} {verdict}" for verdict, number in counts(audit).items())
    kinds = ", ".join(f"{number} {kind}" for kind, number in distinct(audit).items())
    return (
        f"{len(audit.results)} claims: {found}. Distinct findings: {kinds or 'none'}. "
        f"Residuals of what holds are ≤ {below:.1e}, of what fails ≥ {above:.1e}; "
        f"n = {', '.join(map(str, audit.dimensions))}, {audit.points} points or more for each claim "
        f"and as many off the manifold, seed {audit.seed}."
    )


def figure_of(result: Result) -> float:
    """Return the residual that shows the verdict: off the manifold where only that fails."""
    shown = result.off_manifold if result.verdict == ON_MANIFOLD else result.residual
    return 0.0 if shown is None else min(shown, 1.0)


def by_section(audit: Audit) -> tuple[list[str], list[dict[str, Any]]]:
    """Return the verdicts that occur, and for each section its counts of them and its worst residual.

    The worst is the largest of what holds as printed: how near it comes to the threshold.
    """
    verdicts, rows = list(counts(audit)), []
    for section, group in itertools.groupby(audit.results, lambda r: r.claim.section):
        results = list(group)
        held = [r.residual for r in results if r.verdict == TRUE and not r.claim.negative]
        known = [x for x in held if x is not None]
        rows.append(
            {
                "section": section,
                "results": results,
                "counts": [sum(r.verdict == verdict for r in results) for verdict in verdicts],
                "worst": _number(max(known)) if known else "—",
            }
        )
    return verdicts, rows


def print_audit(audit: Audit, listed: str | None = None) -> None:
    """Print a row for each section, what is unexplained in full, and a summary in words.

    Before them with `listed` ``"all"`` each claim, with ``"findings"`` those that do not simply hold.
    """
    screen = Console()
    if listed is not None:
        chosen = [r for r in audit.results if listed == "all" or r.verdict not in (TRUE, UNCHECKED)]
        _print_claims(screen, chosen)
    verdicts, rows = by_section(audit)
    headings = ("claims", "hold", "findings", "unchecked", "worst that holds")
    columns: list[str | Column] = [
        "section",
        *(Column(heading, justify="right") for heading in headings),
    ]
    cells = []
    for row in rows:
        each = dict(zip(verdicts, row["counts"], strict=True))
        found = sum(each.get(kind, 0) for kind in FINDINGS)
        numbers = (len(row["results"]), each.get(TRUE, 0), found, each.get(UNCHECKED, 0))
        cells.append((Text(row["section"]), *(str(n or "") for n in numbers), row["worst"]))
    screen.print(fitted(screen, columns, cells, ("unchecked", "hold")))
    if audit.unexplained and listed is None:
        _print_claims(screen, audit.unexplained)
    screen.print(Text(summary(audit)))
    for result in audit.unexplained:
        screen.print(Text(f"unexplained: {result.claim.label}", style=COLOURS[UNEXPLAINED]))


def _print_claims(screen: Console, results: Sequence[Result]) -> None:
    """Print a table of claims for each section."""
    for section, group in itertools.groupby(results, lambda r: r.claim.section):
        columns: list[str | Column] = [
            "label",
            Column("residual", justify="right", no_wrap=True),
            "verdict",
            "statement → what holds (its residual), or why not",
        ]
        rows = []
        for result in group:
            statement, told = Text(result.claim.statement), explanation(result)
            if told:
                statement.append(f"\n→ {told}", style=COLOURS[result.verdict])
            on, off = residuals(result)
            residual = f"{on}\noff: {off}" if off else on
            verdict = Text(result.verdict, style=COLOURS[result.verdict])
            rows.append((Text(result.claim.label), Text(residual), verdict, statement))
        screen.print(Text(section, style="italic"))
        screen.print(fitted(screen, columns, rows, ("residual",)))
        screen.print()


def markdown(audit: Audit) -> str:
    """Return the table of the docs page: what differs first, then all claims by section."""
    lines = [summary(audit), ""]
    lines += ["### What does not hold as printed", ""]
    lines += ["| label, lines | verdict | printed | what holds |", "|---|---|---|---|"]
    for r in (result for results in audit.findings.values() for result in results):
        printed = _number(r.off_manifold if r.verdict == ON_MANIFOLD else r.residual)
        cells = (
            f"{r.claim.statement}<br>({printed})",
            f"{r.claim.amendment}<br>({_number(r.amended)})",
        )
        same = f"<br>as ({r.claim.finding})" if r.claim.finding else ""
        lines.append(_line(_place(r), r.verdict + same, *cells))
    for section, group in itertools.groupby(audit.results, lambda r: r.claim.section):
        lines += ["", f"### {section}", ""]
        lines += [
            "| label, lines | statement | residual | off | verdict |",
            "|---|---|---|---|---|",
        ]
        for r in group:
            verdict = f"{r.verdict}: {r.remark}" if r.remark else r.verdict
            lines.append(_line(_place(r), r.claim.statement, *residuals(r), verdict))
    return "\n".join(lines) + "\n"


def _place(result: Result) -> str:
    """Return label and lines as a cell."""
    return f"`{result.claim.label}`<br>{result.claim.lines}"


def _line(*cells: str) -> str:
    """Return a row of a Markdown table; what Markdown would read as marks is escaped."""
    escaped = []
    for cell in cells:
        text = cell.replace("|", "\\|")
        if not cell.startswith("`"):
            text = text.replace("*", "\\*").replace("_", "\\_").replace("[", "\\[")
        escaped.append(text)
    return "| " + " | ".join(escaped) + " |"
