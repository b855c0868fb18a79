"""What an audit writes: ``audit.json``, the table of the docs page, and the terminal's table."""

from __future__ import annotations

import itertools
import json
import platform
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

import geomint as gi

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

__all__ = ["as_json", "counts", "distinct", "markdown", "print_audit", "write_json"]

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
    """Return what `write_json` writes."""
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
        "provenance": {
            "paper": "B. Jovanović, Hamiltonization and integrability of the Chaplygin sphere in R^n",
            "geomint": gi.__version__,
            "numpy": np.__version__,
            "python": platform.python_version(),
            "platform": platform.platform(),
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
        },
    }


def write_json(audit: Audit, folder: Path) -> Path:
    """Write ``audit.json`` into a folder, which is made if need be, and return its path.

    Raises
    ------
    geomint.OutputError
    """
    text = json.dumps(as_json(audit), ensure_ascii=False, indent=1, allow_nan=False)
    with gi.whole_folder(folder) as unfinished:
        (unfinished / "audit.json").write_text(text + "\n", encoding="utf-8")
    return folder / "audit.json"


def _number(x: float | None) -> str:
    if x is None:
        return ""
    return "0" if x == 0.0 else f"{x:.1e}" if np.isfinite(x) else "no value"


def _residuals(result: Result) -> tuple[str, str]:
    """Return the residuals on and off the manifold; in brackets where nothing is claimed."""
    off = _number(result.off_manifold)
    return _number(result.residual), off if result.claim.everywhere or not off else f"({off})"


def _explanation(result: Result) -> str:
    """Return what holds instead with its residual, or why nothing was evaluated."""
    if result.claim.amendment:
        return f"{result.claim.amendment} ({_number(result.amended)})"
    return result.remark


def _summary(audit: Audit) -> str:
    below, above = audit.gap
    found = ", ".join(f"{number} {verdict}" for verdict, number in counts(audit).items())
    kinds = ", ".join(f"{number} {kind}" for kind, number in distinct(audit).items())
    return (
        f"{len(audit.results)} claims: {found}. Distinct findings: {kinds or 'none'}. "
        f"Residuals of what holds are ≤ {below:.1e}, of what fails ≥ {above:.1e}; "
        f"n = {', '.join(map(str, audit.dimensions))}, {audit.points} points or more for each claim "
        f"and as many off the manifold, seed {audit.seed}."
    )


def print_audit(audit: Audit, everything: bool = True) -> None:
    """Print a table of all claims, or of those that do not simply hold."""
    screen = Console()
    for section, group in itertools.groupby(audit.results, lambda r: r.claim.section):
        chosen = [r for r in group if everything or r.verdict not in (TRUE, UNCHECKED)]
        if not chosen:
            continue
        table = Table(box=None, header_style="bold", title=section, title_justify="left")
        table.add_column("label", max_width=30, overflow="fold")
        table.add_column("residual", justify="right", no_wrap=True)
        table.add_column("verdict", width=14)
        table.add_column("statement → what holds (its residual), or why not")
        for result in chosen:
            statement, explanation = Text(result.claim.statement), _explanation(result)
            if explanation:
                statement.append(f"\n→ {explanation}", style=COLOURS[result.verdict])
            on, off = _residuals(result)
            residual = f"{on}\noff: {off}" if off else on
            verdict = Text(result.verdict, style=COLOURS[result.verdict])
            table.add_row(Text(result.claim.label), Text(residual), verdict, statement)
        screen.print(table)
        screen.print()
    screen.print(Text(_summary(audit)))
    for result in audit.unexplained:
        screen.print(Text(f"unexplained: {result.claim.label}", style=COLOURS[UNEXPLAINED]))


def markdown(audit: Audit) -> str:
    """Return the table of the docs page: what differs first, then all claims by section."""
    lines = [_summary(audit), ""]
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
            lines.append(_line(_place(r), r.claim.statement, *_residuals(r), verdict))
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
