"""Compare methods on a scene: run time against error.

The exit code is 2 if a method has no result: it does not fit the scene, or its runs fail.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from operator import itemgetter

from ...compare.of_scene import compare_scene, comparison_time, warming
from ...compare.reference_record import MARGIN, RESOLUTION
from ...compare.runs import Comparison
from ...plan.choice import Asked
from ...plan.duration import Estimate
from ...plan.planned import Planned
from ...plots.style import Picture
from ...reports import COMPARE_FILES
from ...reports.compare_orders import FittedOrder, fitted_orders
from ...reports.report import (
    Block,
    Cell,
    Images,
    Num,
    Part,
    Printed,
    Prose,
    Report,
    Small,
    Stack,
    Table,
    Verdict,
)
from ...reports.text import Record, duration, number, scene_facts
from ...run.provenance import finite_json
from ...scene.model import CompareSection
from ...scene.provenance import scene_record
from ...scene.scene import Scene
from ..command import ENDS, Command, Listener, in_python

WANTED = (-3, -6, -9, -12)  # powers of ten of the error


def plan_compare(scene: Scene) -> Planned:
    """Return the scene: what its methods integrate is found for each."""
    asked = Asked(scene, "run")
    return Planned(scene=scene, route=asked.route(asked.own))


def expected(planned: Planned) -> Estimate:
    """Return how long the reference and the first points take."""
    return comparison_time(planned.scene)


def run(planned: Planned, listener: Listener) -> Comparison:
    """Compare; the code of methods that are still to come is compiled beside."""
    from ...kernels.compiling.beside import compiled_beside

    at = [""]

    def doing(text: str) -> None:
        at[0] = text
        listener.doing(text)

    with compiled_beside(lambda: warming(planned.scene, at[0])):
        return compare_scene(planned.scene, doing)


def report(planned: Planned, result: Comparison, command: str | None) -> Report:
    """Return run times against errors, who is fastest, orders, drifts, and what the reference is."""
    from ...plots.drift_plots import drift_figure
    from ...reports.cite import cite
    from ...reports.compare_plots import work_precision_figure

    scene, found = planned.scene, result.as_json()
    compiling = {"compile_seconds": round(result.compile_seconds, 6)}
    provenance = {**scene_record(scene, command), **compiling}
    orders = fitted_orders(found["points"])
    own = {method: order._asdict() for method, order in orders.items()}
    best = _best(found["points"])
    record = finite_json({**found, "orders": own, "best": best, "provenance": provenance})
    pictures = {"compare": Picture(work_precision_figure(result.points, orders))}
    blocks = [Part("Run time against error", (*_times(record, pictures["compare"], orders),))]
    if result.drifts:
        pictures["compare-drift"] = Picture(drift_figure(result.drifts, "t"))
        said = (
            "Each method at its smallest step above. The dashed line is the round-off level, 32 ε × "
            "scale."
        )
        drifts = Images([(pictures["compare-drift"].uri, DRIFTS)], "wide")
        blocks.append(Part("Drift over physical time", (drifts, Prose(said))))
    blocks.append(Part("All points", (_points(record), *_left_out(record))))
    words = " ".join(reference_text(record["reference"]))
    blocks.append(Part("Reference", (Prose(words, small=False),)))
    status = result.status
    cut = "What follows had been measured by then."
    none = result.without_result
    return Report(
        COMPARE_FILES,
        "Comparison of methods",
        scene.title,
        _verdict(record["points"], best),
        blocks,
        record,
        status,
        f"reference: {words}",
        alerts=[] if status == "success" else [(f"The comparison was {status}.", cut)],
        pictures=pictures,
        citation=cite(scene, *dict.fromkeys(p["method"] for p in found["points"] if not p["peer"])),
        printed=_printed(scene, record, orders),
        outcome="failed" if none and status == "success" else "",
        failures=[f"{method}: no result: {why}" for method, why in none.items()],
    )


DRIFTS = "largest deviation of each conserved quantity over time, a line for each method"


def _times(record: Record, picture: Picture, orders: Mapping[str, FittedOrder]) -> list[Block]:
    """Return the picture and what it shows, who is fastest, and the orders."""
    points, reference = record["points"], record["reference"]
    quantities = " and ".join(reference["quantities"])
    provenance = record["provenance"]
    said = (
        f"All methods end at the same physical time t = {number(reference['physical_end'])}, whatever "
        f"time and representation they work in. The error is the largest deviation of {quantities} "
        f"from the reference, relative to the largest entry of each. Run times are medians of the "
        f"repeats, without compilation ({number(provenance['compile_seconds'])} s in all)."
    )
    if any(p["peer"] for p in points):
        said += (
            " Peers are integrators of other packages, on the same field, at tolerances; theirs are "
            "times on the wall of the whole run, a first run, in which they compile, not counted. "
            f"Machine: {provenance['cpu']}."
        )
    if any(p["error"] is None and p["bound"] is not None for p in points):
        said += (
            " Hollow marks and ≤: too near to the reference to be judged by it, so the largest that "
            "the error may be."
        )
    if any(p["newton"] for p in points):
        said += " Ringed: Newton's method took some of the steps, which costs many times as much."
    image = Images([(picture.uri, "run time against error, a line for each method")], "wide")
    blocks: list[Block] = [image, Prose(said)]
    blocks += [Prose(sentence, small=False) for sentence in _turns(points)]
    if record["best"]:
        rows = [
            (
                f"1e{row['exponent']}",
                row["method"],
                Num(row["step"]),
                Num(row["seconds"]),
                _error(row),
            )
            for row in record["best"]
        ]
        columns = ("error at most", "fastest method", "step", "run time (s)", "error")
        blocks.append(Part("Fastest at an error", (Table(columns, rows, 2, told=False),)))
    if orders:
        blocks.append(Part("Orders", (_orders(orders), Prose(HOW_FITTED))))
    return blocks


HOW_FITTED = (
    "The slope of log error over log step, by least squares, with its standard error, in the longest "
    "part where neighbouring points agree on it to a fifth: where steps are small enough, and errors "
    "are not rounding. Dotted in the picture: how run time and error go together at an order."
)


def _error(point: Record) -> Num:
    exact = point["error"] is not None
    return Num(point["error"] if exact else point["bound"], bound=not exact)


def _orders(orders: Mapping[str, FittedOrder]) -> Table:
    rows: list[list[Cell]] = []
    for method, found in orders.items():
        row: list[Cell] = [method, str(found.order)]
        if found.fitted is None:
            row.append("no three points where the error falls steadily")
        else:
            between = f"{number(found.steps[0])} to {number(found.steps[-1])}"
            row += [found.text, str(len(found.steps)), between]
        rows.append(row)
    return Table(("method", "order", "fitted", "points", "step sizes"), rows, told=False)


def _points(record: Record) -> Table:
    """Return a row for each point: step or tolerance, error, run time; or why there is no result."""
    columns = ["method", "representation", "order", "step", "error", "run time", "steps"]
    columns += ["evaluations", "iterations a step", "status"]
    rows: list[list[Cell]] = []
    for p in record["points"]:
        row: list[Cell] = [f"{p['method']} ({p['peer']})" if p["peer"] else p["method"]]
        step = number(p["step"], 4) if p["step"] else "–"
        step += f", rtol {number(p['rtol'])}" if p["rtol"] else ""
        row += [p["representation"] or "none", str(p["order"]), step]
        if p["bound"] is None:
            word = p["status"].partition(":")[0] if p["representation"] else "does not fit"
            row.append(Stack((Verdict(word), Small(p["status"]))))
        else:
            told: list[Cell] = [Verdict(p["status"]), *(Small(w["kind"]) for w in p["warnings"])]
            iterations = (
                number(p["iterations"] / p["steps"], 3) if p["iterations"] and p["steps"] else "–"
            )
            iterations += ", Newton's method" if p["newton"] else ""
            counts = ["–" if p[key] is None else str(p[key]) for key in ("steps", "evaluations")]
            row += [_error(p), duration(p["seconds"]), *counts, iterations, Stack(told)]
        rows.append(row)
    spare = ("evaluations", "iterations a step", "representation", "order", "steps", "status")
    return Table(columns, rows, 2, spare=spare)


def _left_out(record: Record) -> list[Block]:
    left_out = "; ".join(f"{name}: {why}" for name, why in record["peers_left_out"].items())
    return [Prose(f"Peers that did not run: {left_out}.")] if left_out else []


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


def _printed(scene: Scene, record: Record, orders: Mapping[str, FittedOrder]) -> Printed:
    """Return table, caption and data of a comparison, from the content of its JSON."""
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
    data = [KEYS, *map(itemgetter(*KEYS), record["points"])]
    return Printed(caption, _table(record, orders), scene_facts(provenance, methods), data)


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


COMPARE = Command(
    "compare",
    CompareSection,
    plan_compare,
    run,
    report,
    COMPARE_FILES,
    ENDS,
    use="compare",
    folder="report",
    expected=expected,
)
compare_report = in_python(COMPARE)
