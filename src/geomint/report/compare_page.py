"""The comparison report: a page that opens from disk, plots, JSON, and what is for a paper."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING

from ..compare.reference_record import MARGIN, RESOLUTION
from ..compare.runs import Comparison
from ..plots.drift_plots import drift_figure
from ..plots.style import Picture
from ..run.provenance import finite_json, json_text
from ..scene.provenance import scene_record
from . import COMPARE_FILES
from .cite import Citation, cite
from .compare_orders import FittedOrder, fitted_orders
from .compare_plots import work_precision_figure
from .pages import render, write_files
from .paper import Paper, Table, scene_facts
from .text import Record, duration, number

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["compare_paper", "reference_text", "write_compare_report"]


WANTED = (-3, -6, -9, -12)  # powers of ten of the error


def write_compare_report(
    result: Comparison, scene: Scene, out: Path, command: str | None = None, paper: bool = False
) -> None:
    """Write ``compare.html``, ``compare.json`` and the plots as PNG and SVG, all or none.

    `paper`: what is for a paper too.

    Raises
    ------
    OutputError
    """
    compiling = {"compile_seconds": round(result.compile_seconds, 6)}
    provenance = {**scene_record(scene, command), **compiling}
    found = result.as_json()
    orders = fitted_orders(found["points"])
    own = {method: order._asdict() for method, order in orders.items()}
    best = _best(found["points"])
    record = finite_json({**found, "orders": own, "best": best, "provenance": provenance})
    pictures = {"compare": Picture(work_precision_figure(result.points, orders))}
    if result.drifts:
        pictures["compare-drift"] = Picture(drift_figure(result.drifts, "t"))
    citation = cite(scene, *dict.fromkeys(p["method"] for p in found["points"] if not p["peer"]))
    page = render(
        "compare.html.j2",
        title=scene.title,
        verdict=_verdict(record["points"], best),
        orders=orders,
        citation=citation,
        status=record["status"],
        points=record["points"],
        peers=any(p["peer"] for p in record["points"]),
        left_out=record["peers_left_out"],
        reference=record["reference"],
        reference_words=reference_text(record["reference"]),
        provenance=record["provenance"],
        quantities=" and ".join(record["reference"]["quantities"]),
        best=best,
        turns=_turns(record["points"]),
        newton=any(p["newton"] for p in record["points"]),
        hollow=any(p["error"] is None and p["bound"] is not None for p in record["points"]),
        figures={name: picture.uri for name, picture in pictures.items()},
    )
    more = compare_paper(scene, record, orders, citation) if paper else None
    write_files(out, COMPARE_FILES, page, json_text(record), pictures, paper=more)


def _verdict(points: list[Record], best: list[Record]) -> str:
    """Return the result in a sentence or two."""
    methods = list(dict.fromkeys(p["method"] for p in points))
    failed = sum(p["bound"] is None for p in points)
    unjudged = sum(p["error"] is None for p in points) - failed
    peers = len({p["method"] for p in points if p["peer"]})
    beside = f", {peers} of them peers," if peers else ""
    words = f"{len(methods)} methods{beside} at {len(points)} points. "
    if best:
        finest = best[-1]
        words += (
            f"An error below 1e{finest['exponent']} is reached fastest by {finest['method']}, "
            f"in {duration(finest['seconds'])}. "
        )
    if failed:
        points_have = "point has" if failed == 1 else "points have"
        words += f"{failed} {points_have} no result; the table says why. "
    if unjudged:
        points_are = "point is" if unjudged == 1 else "points are"
        words += f"{unjudged} {points_are} too near to the reference to be judged by it."
    return words.rstrip()


def _turns(points: list[Record]) -> list[str]:
    """Return in sentences why a longer step of a method takes longer, where one does for a reason."""
    ladders = sorted(
        (p for p in points if p["seconds"] and p["iterations"]), key=itemgetter("step")
    )
    words = []
    for method in dict.fromkeys(p["method"] for p in points):
        for fine, coarse in pairwise(p for p in ladders if p["method"] == method):
            more = [f"{p['iterations'] / max(p['steps'], 1):.3g}" for p in (coarse, fine)]
            why = f"a step takes {more[0]} iterations in place of {more[1]}"
            if coarse["newton"] and not fine["newton"]:
                why = "fixed-point iteration fails in some steps, which Newton's method takes"
            elif coarse["iterations"] <= fine["iterations"]:
                continue
            if coarse["seconds"] > fine["seconds"]:
                steps = (
                    f"steps of {coarse['step']:.4g} take longer than those of {fine['step']:.4g}"
                )
                words.append(f"The curve of {method} turns back: {steps}, because {why}.")
    return words


def _best(points: list[Record]) -> list[Record]:
    """Return for each of some powers of ten the fastest point with at most that error."""
    found = {exponent: _fastest(points, exponent) for exponent in WANTED}
    return [{"exponent": exponent, **point} for exponent, point in found.items() if point]


def _fastest(points: list[Record], exponent: int) -> Record | None:
    fit = [p for p in points if p["bound"] is not None and p["bound"] <= 10.0**exponent]
    return min(fit, key=itemgetter("seconds"), default=None)


def reference_text(reference: Record) -> list[str]:
    """Return in sentences what the reference is, what confirms it, and what it can judge."""
    second, known = reference["confirmation"], reference["known"]
    own = f"{max(reference['error_estimate'], 1e-19):.2g}"
    if reference["steps"]:
        coarse, fine = reference["steps"]
        first = f"steps {coarse:.4g} and {fine:.4g} agree to {own} or better, relative."
    else:
        first = f"without stepping; rounding makes an error of about {own} of its phases."
    words = [f"{reference['method']}, in “{reference['representation']}”, {first}"]
    verb = "Confirmed" if second["agrees"] else "Not confirmed"
    end = f"at its end, {reference['own_end']:.6g},"
    if second["own_end"] != reference["own_end"]:
        end = f"on a part of the way, at {second['own_end']:.6g} of {reference['own_end']:.6g},"
    words.append(
        f"{verb} {end} by {second['method']}: that is known to {second['accuracy']:.2g} there, and "
        f"the two differ by {second['difference']:.2g}."
    )
    if not second["agrees"]:
        words.append("One of the two is wrong by more than it says.")
    words.append(
        f"The quantities compared are known to {max(known, 1e-19):.2g}: errors of "
        f"{max(MARGIN * known, RESOLUTION):.2g} and more are judged."
    )
    return words


KEYS = ("method", "order", "representation", "step", "rtol", "error", "bound", "seconds", "steps",
        "evaluations", "repeats", "status")  # fmt: skip


def compare_paper(
    scene: Scene, record: Record, orders: Mapping[str, FittedOrder], citation: Citation
) -> Paper:
    """Return table, caption, data and citations of a comparison, from the content of its JSON."""
    reference, provenance = record["reference"], record["provenance"]
    caption = (
        f"{scene.title}. Run time, without compilation, against the error of "
        f"{' and '.join(reference['quantities'])} at t = {number(reference['physical_end'], 6)}, "
        f"relative to the largest entry of each; the reference, by {reference['method']}, is known to "
        f"{number(max(reference['known'], 1e-19), 2)}. Medians of the repeats on one core "
        f"({provenance['cpu']}). Dotted: slopes of the orders. In the table: fitted orders, and the "
        f"least run times in seconds for errors of at most so much."
    )
    methods = ", ".join(dict.fromkeys(point["method"] for point in record["points"]))
    facts = scene_facts(provenance, provenance["scene"]["system"]["name"], methods)
    return Paper(
        "compare",
        caption,
        _table(record, orders),
        facts,
        citation,
        [KEYS, *map(itemgetter(*KEYS), record["points"])],
        provenance["command"],
    )


def _table(record: Record, orders: Mapping[str, FittedOrder]) -> Table:
    """Return for each method its order, fitted, and the run time that each error takes."""
    wanted = [row["exponent"] for row in record["best"]]
    columns = ["method", "order", "fitted order", *(f"1e{k} (s)" for k in wanted)]
    rows = []
    for method in dict.fromkeys(point["method"] for point in record["points"]):
        own = [p for p in record["points"] if p["method"] == method]
        fitted = orders[method].text if method in orders else "—"
        fastest = [_fastest(own, k) for k in wanted]
        times = [number(None if p is None else p["seconds"], 2) for p in fastest]
        rows.append([method, str(own[0]["order"]), fitted, *times])
    return Table(columns, rows)
