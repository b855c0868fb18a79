"""The report of an audit: a page with the picture of all residuals, JSON, and the claims as CSV."""

from __future__ import annotations

import csv
import functools
import itertools
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import geomint as gi
from geomint.references.literature import JOVANOVIC_2010
from geomint.report.pages import (
    Picture,
    json_of,
    paper_files,
    provenance_of,
    render,
    write_files,
)
from geomint.report.paper import Paper, Table

from .claim import FAILS, HOLDS, TRUE, UNEXPLAINED, Result
from .report import COLOURS, as_json, by_section, explanation, figure_of, residuals, summary
from .run import Audit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["AUDIT_FILES", "write_audit_report"]

AUDIT_FILES = (
    "audit.csv",
    "audit.html",
    "audit.json",
    "audit.png",
    "audit.svg",
    *paper_files("audit", csv=False),
)
LEAST = 1e-17  # where residuals of exactly 0 are drawn
# Of verdicts, in the order of their list: Okabe and Ito's.
PAINTS = dict(zip(COLOURS, ("#0072B2", "#56B4E9", "#E69F00", "#009E73", "#D55E00"), strict=False))
MARKS = dict(zip(PAINTS, ("o", "s", "^", "v", "D"), strict=True))


def write_audit_report(
    audit: Audit, folder: Path, command: str | None = None, paper: bool = False
) -> Path:
    """Write the files of the report, all or none; return the path of the page.

    Raises
    ------
    geomint.OutputError
    """
    provenance = {"paper": JOVANOVIC_2010.text, **provenance_of(None, command)}
    record = {**as_json(audit), "provenance": provenance}
    citation = gi.Citation((("paper", (JOVANOVIC_2010,)), *gi.cite().parts))
    picture = Picture(residual_figure(audit))
    columns, sections = by_section(audit)
    page = render(
        "audit.html.j2",
        __package__,
        title=f"The paper, line by line, n = {_facts(audit)['dimensions']}, seed {audit.seed}",
        heading="The paper, line by line",
        source=JOVANOVIC_2010.text,
        verdict=_verdict(audit),
        facts=_facts(audit),
        columns=columns,
        sections=[{**row, "results": [_shown(r) for r in row["results"]]} for row in sections],
        findings=[_shown(r) for results in audit.findings.values() for r in results],
        unexplained=[_shown(r) for r in audit.unexplained],
        picture=picture.uri,
        provenance=provenance,
        citation=citation,
    )
    others = {"audit.csv": functools.partial(_save, record["claims"])}
    more = _paper(audit, provenance, citation) if paper else None
    pictures = {"audit": picture}
    return write_files(folder, AUDIT_FILES, page, json_of(record), pictures, others, more)


def _verdict(audit: Audit) -> str:
    said = f"{len(audit.results)} statements. " + summary(audit).split(". ", 2)[1] + "."
    if audit.unexplained:
        said = f"{len(audit.unexplained)} unexplained of {said}"
    return said


def _facts(audit: Audit) -> dict[str, str]:
    below, above = audit.gap
    return {
        "residuals of what holds": f"≤ {below:.1e}",
        "residuals of what fails": f"≥ {above:.1e}",
        "dimensions": ", ".join(map(str, audit.dimensions)),
        "points": f"{audit.points} or more for each claim, seed {audit.seed}",
        "computed in": f"{audit.seconds:.3g} s",
    }


def _shown(result: Result) -> dict[str, Any]:
    """Return a row of the tables of claims."""
    on, off = residuals(result)
    same = f", as ({result.claim.finding})" if result.claim.finding else ""
    return {
        "label": result.claim.label,
        "lines": result.claim.lines,
        "statement": result.claim.statement,
        "explanation": explanation(result),
        "residual": on or "—",
        "off": off or "—",
        "verdict": result.verdict + (same if result.verdict != TRUE else ""),
        "bad": result.verdict == UNEXPLAINED,
    }


def residual_figure(audit: Audit) -> Figure:
    """Return a figure of the residuals of all claims, a row for each section."""
    from matplotlib.figure import Figure

    sections = [name for name, _ in itertools.groupby(r.claim.section for r in audit.results)]
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


def _paper(audit: Audit, provenance: dict[str, Any], citation: gi.Citation) -> Paper:
    columns, sections = by_section(audit)
    rows = [
        [row["section"], *(str(count or "—") for count in row["counts"]), row["worst"]]
        for row in sections
    ]
    versions = provenance["versions"]
    facts = {
        "Paper": JOVANOVIC_2010.title,
        "Points": f"{_facts(audit)['points']}, in dimensions {_facts(audit)['dimensions']}",
        "Software": ", ".join(f"{name} {version}" for name, version in versions.items() if version),
    }
    caption = (
        f"Residuals of {len(audit.results)} statements, as printed: the largest difference of the two "
        f"sides of each over the largest of them. Dotted: {HOLDS:g}, below which a statement holds, "
        f"and {FAILS:g}, above which it fails. A residual of 0 is at {LEAST:g}."
    )
    table = Table(["section", *columns, "worst that holds"], rows)
    return Paper("audit", caption, table, facts, citation, command=provenance["command"])
