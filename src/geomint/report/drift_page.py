"""The drift report: ``report.html``, ``drift.json``, ``drift.png`` and ``drift.svg``."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from ..drift import ROUNDOFF
from ..growth import RULE
from ..plan import Plan, make_plan
from ..scene import Scene, load_scene
from ..solution import Solution
from .drift_json import drift_record, write_drift_json
from .pages import render
from .plots import drift_figure, panel_figure
from .provenance import run_provenance
from .style import data_uri, save_figure
from .text import number, verdict, with_error

__all__ = ["drift_report", "write_drift_report"]


def drift_report(
    scene: str | PathLike[str] | Mapping[str, Any] | Scene,
    out: str | PathLike[str],
    progress: bool | None = None,
) -> Solution:
    """Integrate a scene and write its drift report, as ``geomint drift`` does.

    Parameters
    ----------
    scene : name, path, content or Scene
    out : path
        A folder; made if it is not there. Files of an earlier report are replaced.
    progress : bool, optional
        Show progress. Default: if standard error is a terminal.

    Returns
    -------
    Solution
        With the drifts in ``drift``; after Ctrl-C what was computed, reported as interrupted.
    """
    chosen = load_scene(scene).for_drift()
    plan = make_plan(chosen, "drift")
    solution = plan.solve(progress)
    write_drift_report(solution, chosen, Path(out), plan)
    return solution


def write_drift_report(
    solution: Solution,
    scene: Scene,
    folder: Path,
    plan: Plan,
    command: str | None = None,
) -> Path:
    """Write the four files of a report and return the path of the page."""
    folder.mkdir(parents=True, exist_ok=True)
    provenance = run_provenance(solution, scene, command)
    record = drift_record(solution.drift, provenance)
    write_drift_json(folder / "drift.json", record)
    figure = drift_figure([(solution.method.name, solution.drift)], solution.drift_time)
    save_figure(figure, folder, "drift")
    page = folder / "report.html"
    page.write_text(drift_page(solution, scene, plan, record["provenance"]), encoding="utf-8")
    return page


def drift_page(solution: Solution, scene: Scene, plan: Plan, provenance: Mapping[str, Any]) -> str:
    """Return the page as one self-contained HTML text."""
    return render(
        "drift.html.j2",
        title=scene.title,
        description=" ".join(scene.content.description.split()),
        solution=solution,
        verdict=verdict(solution),
        facts=_facts(solution, scene),
        rows=_rows(solution),
        rule=RULE,
        rule_details=_rule_details(),
        kinds=[kind for kind in RULE if any(d.kind == kind for d in solution.drift.values())],
        panels=_panels(solution),
        unit="τ" if solution.drift_time == "tau" else "t",
        choices=plan.choices,
        provenance=provenance,
    )


def _facts(solution: Solution, scene: Scene) -> list[tuple[str, str]]:
    """Return what the first screen tells about the run."""
    method, problem = solution.method, solution.problem
    own = "τ" if problem.time == "tau" else "t"
    structure = " and ".join(w for w in ("symmetric", "symplectic") if getattr(method, w))
    pieces = ", ".join(f"{name} ({rows})" for name, rows in problem.pieces)
    time = scene.content.time
    asked, end = ("t", time.t_end) if time.tau_end is None else ("τ", time.tau_end)
    rate = solution.steps / solution.run_seconds if solution.run_seconds > 0.0 else 0.0
    compiled = "from the cache"
    if solution.compile_seconds > 0.0:
        compiled = f"{solution.compile_seconds:.2f} s"
    return [
        ("system", scene.content.system.name),
        ("state", f"{problem.name}: {pieces}"),
        ("method", f"{method.name}, order {method.order}{', ' + structure if structure else ''}"),
        ("step", f"{abs(solution.step):.10g} in {own}"),
        ("steps", f"{solution.steps:,}".replace(",", "\u202f")),
        ("end", f"{asked} = {end:g}"),
        ("field evaluations", f"{solution.evaluations:,}".replace(",", "\u202f")),
        ("run time", f"{solution.run_seconds:.3g} s ({rate:.2g} steps a second)"),
        ("watching", f"{solution.watching_seconds:.3g} s for what is observed"),
        ("compile time", compiled),
    ]


def _rows(solution: Solution) -> list[dict[str, str]]:
    """Return the table of quantities as text."""
    rows = []
    for name, drift in solution.drift.items():
        vanishing = abs(drift.initial) <= ROUNDOFF * drift.scale  # 0, or what rounding left of it
        relative = number(drift.max_rel_error)
        if vanishing:
            relative = f"— (scale {number(drift.scale)})"
        rows.append(
            {
                "name": name,
                "initial": number(drift.initial, 3 if vanishing else 8),
                "max_abs": number(drift.max_abs_error),
                "max_rel": relative,
                "final": number(drift.final_error),
                "slope": with_error(drift.slope, drift.slope_stderr),
                "kind": drift.kind,
            }
        )
    return rows


def _panels(solution: Solution) -> list[dict[str, str]]:
    """Return the plots of each quantity as data URIs, with texts for those who cannot see them."""
    panels = []
    for name, drift in solution.drift.items():
        sizes, means = (
            data_uri(panel_figure(kind, name, drift, solution.drift_time))
            for kind in ("sizes", "means")
        )
        told = (
            f"{name}: largest deviation {number(drift.max_abs_error)}, "
            f"final {number(drift.final_error)}, {drift.kind}"
        )
        panels.append({"name": name, "sizes": sizes, "means": means, "told": told})
    return panels


def _rule_details() -> str:
    """Return the statistical rule as its module states it, without the markup."""
    from .. import growth

    text = (growth.__doc__ or "").split("The window means", 1)[1]
    plain = text.replace("``", "").replace("\\|", "|").replace("`", "")
    return "The window means" + plain.split("\nMeasured on", 1)[0].rstrip()
