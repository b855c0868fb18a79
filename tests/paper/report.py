"""What an audit tells: a page with the picture of all residuals, JSON, CSV, the table of the docs."""

from __future__ import annotations

import csv
import functools
import itertools
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import geomint as gi
from geomint.references.literature import JOVANOVIC_2010
from geomint.reports import files_of
from geomint.reports.report import (
    Block,
    Folded,
    Images,
    Part,
    Picture,
    Printed,
    Prose,
    Report,
    Small,
    Stack,
    Table,
    Verdict,
)
from geomint.reports.text import with_provenance

from .claim import FAILS, FINDINGS, HOLDS, ON_MANIFOLD, TRUE, UNEXPLAINED, VERDICTS, Result
from .run import Audit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["AUDIT_FILES", "as_json", "audit_report", "counts", "distinct", "markdown"]

AUDIT_FILES = files_of("audit")
LEAST = 1e-17  # where residuals of exactly 0 are drawn
# Of verdicts, in the order of their list: Okabe and Ito's.
PAINTS = dict(zip(VERDICTS, ("#0072B2", "#56B4E9", "#E69F00", "#009E73", "#D55E00"), strict=False))
MARKS = dict(zip(PAINTS, ("o", "s", "^", "v", "D"), strict=True))
SHOWN = (
    "the residual of each claim on a logarithmic axis, a row for each section, coloured by verdict"
)
HOW = (
    "The largest residual of each claim over all points, as printed. Dotted: the thresholds of the "
    "rule, 1e-12 for what holds and 1e-3 for what fails. A residual of exactly 0 is at 1e-17. Right of "
    "1e-3, and none the less true, are statements that two things differ."
)
RELATIVE = (
    "Residuals are relative: the largest difference of the two sides over the largest of them. “off”: "
    "off the manifold, in brackets where nothing is claimed there."
)


def counts(audit: Audit) -> dict[str, int]:
    """Return how often each verdict occurs."""
    verdicts = [result.verdict for result in audit.results]
    known = (*VERDICTS, UNEXPLAINED)
    return {verdict: verdicts.count(verdict) for verdict in known if verdict in verdicts}


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


def _said(audit: Audit) -> tuple[str, str]:
    """Return what was found, and at which points, in sentences."""
    below, above = audit.gap
    found = ", ".join(f"{number} {verdict}" for verdict, number in counts(audit).items())
    kinds = ", ".join(f"{number} {kind}" for kind, number in distinct(audit).items())
    return (
        f"{len(audit.results)} claims: {found}. Distinct findings: {kinds or 'none'}.",
        f"Residuals of what holds are ≤ {below:.1e}, of what fails ≥ {above:.1e}; "
        f"n = {', '.join(map(str, audit.dimensions))}, {audit.points} points or more for each claim "
        f"and as many off the manifold, seed {audit.seed}.",
    )


def figure_of(result: Result) -> float:
    """Return the residual that shows the verdict: off the manifold where only that fails."""
    shown = result.off_manifold if result.verdict == ON_MANIFOLD else result.residual
    return 0.0 if shown is None else min(shown, 1.0)


def _sections(audit: Audit) -> dict[str, list[Result]]:
    grouped = itertools.groupby(audit.results, lambda result: result.claim.section)
    return {section: list(results) for section, results in grouped}


def _by_section(audit: Audit) -> Table:
    """Return for each section how often each verdict occurs, and its worst residual.

    That is the largest of what holds as printed: how near it comes to the threshold.
    """
    verdicts, rows = list(counts(audit)), []
    for section, results in _sections(audit).items():
        own = [result.verdict for result in results]
        held = [r.residual for r in results if r.verdict == TRUE and not r.claim.negative]
        worst = _number(max((x for x in held if x is not None), default=None)) or "—"
        numbers = [len(own), sum(verdict in FINDINGS for verdict in own), *map(own.count, verdicts)]
        rows.append((section, *(str(n or "") for n in numbers), worst))
    columns = ("section", "claims", "findings", *verdicts, "worst that holds")
    return Table(columns, rows, kind="quantities counts", spare=FINDINGS)


def _claims(results: Sequence[Result], told: bool) -> Table:
    rows = []
    for result in results:
        claim, verdict, what = result.claim, result.verdict, explanation(result)
        same = f", as ({claim.finding})" if claim.finding and verdict != TRUE else ""
        word = Verdict(verdict) if verdict == UNEXPLAINED else verdict + same
        statement = Stack((claim.statement, Small(f"→ {what}" if what else "")))
        residual = (x or "—" for x in residuals(result))
        rows.append((claim.label, claim.lines, word, statement, *residual))
    columns = ("label", "lines", "verdict", "statement", "residual", "off")
    spare = ("lines", "off", "residual")
    return Table(columns, rows, 4, "quantities counts", told, spare)


def audit_report(audit: Audit, command: str | None = None, listed: str | None = None) -> Report:
    """Return what an audit has found.

    With `listed` ``"all"`` a terminal shows each claim, with ``"findings"`` what does not simply hold.
    """
    record = with_provenance(as_json(audit), None, command)
    record["provenance"]["paper"] = JOVANOVIC_2010.text
    picture, (found, how) = Picture(residual_figure(audit)), _said(audit)
    findings = [result for results in audit.findings.values() for result in results]
    labels, bad = [result.claim.label for result in audit.unexplained], len(audit.unexplained)
    differing = _claims(findings, listed == "findings") if findings else Prose("Nothing.")
    table = _by_section(audit)
    seconds = f"Computed in {audit.seconds:.3g} s."
    dimensions = ", ".join(map(str, audit.dimensions))
    images = Images([(picture.uri, SHOWN)], "wide")
    blocks: list[Block] = [
        Part("Residuals", (images, Prose(HOW), table, Prose(f"{how} {seconds}"))),
        Part("What does not hold as printed", (differing,)),
        Part(
            "All claims",
            (
                *(
                    Folded(f"{name}: {len(results)} claims", (_claims(results, listed == "all"),))
                    for name, results in _sections(audit).items()
                ),
                Prose(RELATIVE),
            ),
        ),
    ]
    if bad:
        blocks.insert(0, Part("Unexplained", (_claims(audit.unexplained, listed != "all"),)))
    neither = (f"{bad} unexplained:", f"neither as printed nor as corrected: {', '.join(labels)}.")
    versions = record["provenance"]["versions"].items()
    facts = {
        "Paper": JOVANOVIC_2010.title,
        "Points": f"{audit.points} or more for each claim, seed {audit.seed}, n = {dimensions}",
        "Software": ", ".join(f"{name} {version}" for name, version in versions if version),
    }
    caption = (
        f"Residuals of {len(audit.results)} statements, as printed: the largest difference of the two "
        f"sides of each over the largest of them. Dotted: {HOLDS:g}, below which a statement holds, "
        f"and {FAILS:g}, above which it fails. A residual of 0 is at {LEAST:g}."
    )
    return Report(
        AUDIT_FILES,
        "Audit of the paper",
        "The paper, line by line",
        found,
        blocks,
        record,
        summary=how,
        lead=[JOVANOVIC_2010.text],
        alerts=[neither] if bad else [],
        pictures={"audit": picture},
        citation=gi.Citation((("paper", (JOVANOVIC_2010,)), *gi.cite().parts)),
        csv=functools.partial(_save, record["claims"]),
        printed=Printed(caption, table, facts),
        outcome="forbidden" if bad else "",
        failures=[f"unexplained: {label}" for label in labels],
    )


def residual_figure(audit: Audit) -> Figure:
    """Return a figure of the residuals of all claims, a row for each section."""
    from matplotlib.figure import Figure

    sections = list(_sections(audit))
    figure = Figure(figsize=(6.5, 1.1 + 0.27 * len(sections)), layout="constrained")
    axes = figure.subplots()
    for verdict, paint in {**PAINTS, UNEXPLAINED: "#000000"}.items():
        own = [r for r in audit.results if r.verdict == verdict and r.residual is not None]
        if own:
            axes.plot(
                [max(figure_of(r), LEAST) for r in own],
                [sections.index(r.claim.section) for r in own],
                linestyle="none", marker=MARKS.get(verdict, "X"), markersize=4.5, color=paint,
                markerfacecolor="none", markeredgewidth=1.0, label=verdict,
            )  # fmt: skip
    for level in (HOLDS, FAILS):
        axes.axvline(level, color="0.45", linestyle=(0, (1, 1.5)), linewidth=0.9, zorder=1)
    axes.set_xscale("log")
    axes.set_xlim(LEAST / 3.0, 30.0)
    axes.set_yticks(range(len(sections)), _numbered(sections))
    axes.set_ylim(max(len(sections), 1) - 0.5, -0.5)
    axes.set_xlabel("residual (dimensionless)")
    axes.set_ylabel("section of the paper")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.35, linewidth=0.5)
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc="outside upper center", ncols=3, frameon=False, fontsize=8)
    return figure


def _numbered(sections: list[str]) -> list[str]:
    """Return the numbers of sections, those that come again with a letter."""
    numbers = [re.match(r"[\d., ]*", name)[0].strip() for name in sections]  # type: ignore[index]
    again = [numbers[:k].count(number) for k, number in enumerate(numbers)]
    return [
        f"{number}{'abc'[k]}" if numbers.count(number) > 1 else number
        for number, k in zip(numbers, again, strict=True)
    ]


def _save(claims: list[dict[str, Any]], path: Path) -> None:
    """Write the claims as ``audit.json`` has them, a row each."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        names = list(claims[0]) if claims else []
        writer = csv.DictWriter(stream, names)
        writer.writeheader()
        for claim in claims:
            lists = {key: " ".join(map(str, x)) for key, x in claim.items() if isinstance(x, list)}
            writer.writerow({**claim, **lists})


def markdown(audit: Audit) -> str:
    """Return the table of the docs page: what differs first, then all claims by section."""
    lines = [" ".join(_said(audit)), ""]
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
    for section, results in _sections(audit).items():
        lines += ["", f"### {section}", ""]
        lines += [
            "| label, lines | statement | residual | off | verdict |",
            "|---|---|---|---|---|",
        ]
        for r in results:
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
