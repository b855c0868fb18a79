"""What of a comparison is for a paper."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from .cite import Citation
from .compare_orders import FittedOrder
from .paper import Paper, Table, scene_facts
from .text import number

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["compare_paper"]

KEYS = ("method", "order", "representation", "step", "rtol", "error", "bound", "seconds", "steps",
        "evaluations", "repeats", "status")  # fmt: skip


def compare_paper(
    scene: Scene,
    record: Mapping[str, Any],
    orders: Mapping[str, FittedOrder],
    citation: Citation,
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
        _rows(record),
        provenance["command"],
    )


def _table(record: Mapping[str, Any], orders: Mapping[str, FittedOrder]) -> Table:
    """Return for each method its order, fitted, and the run time that each error takes."""
    wanted = [row["exponent"] for row in record["best"]]
    columns = ["method", "order", "fitted order", *(f"1e{k} (s)" for k in wanted)]
    rows = []
    for method in dict.fromkeys(point["method"] for point in record["points"]):
        own = [p for p in record["points"] if p["method"] == method]
        fitted = orders[method].text if method in orders else "—"
        times = [_fastest(own, 10.0**k) for k in wanted]
        rows.append([method, str(own[0]["order"]), fitted, *times])
    return Table(columns, rows)


def _fastest(points: list[Mapping[str, Any]], error: float) -> str:
    fit = [p["seconds"] for p in points if p["bound"] is not None and p["bound"] <= error]
    return number(min(fit), 2) if fit else "—"


def _rows(record: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    yield KEYS
    for point in record["points"]:
        yield tuple(point[key] for key in KEYS)
