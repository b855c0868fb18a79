"""The drift report: ``report.html``, ``drift.json``, ``drift.png`` and ``drift.svg``."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import Any, overload

from ..errors import DomainError, GeomintWarning
from ..plan import Plan, SeveralRuns, make_plan, run_methods
from ..plots.drift_plots import drift_figure, panel_figure
from ..plots.style import data_uri
from ..run.solution import Solution
from ..scene import Scene, load_scene
from ..scene.provenance import scene_provenance
from ..watch.drift import ROUNDOFF, Drift
from ..watch.growth import RULE
from ..watch.quantities import KINDS, kind_of
from .drift_json import drift_record, write_drift_files
from .pages import render
from .several_page import write_several_report
from .text import (
    number,
    rule_details,
    spanned,
    step_of,
    verdict,
    what_happened,
    with_error,
)

__all__ = ["drift_report", "write_drift_report"]

AnyScene = str | PathLike[str] | Mapping[str, Any] | Scene


@overload
def drift_report(
    scene: AnyScene,
    out: str | PathLike[str],
    progress: bool | None = None,
    *,
    methods: Iterable[str],
) -> SeveralRuns: ...


@overload
def drift_report(
    scene: AnyScene, out: str | PathLike[str], progress: bool | None = None, *, methods: None = None
) -> Solution | SeveralRuns: ...


def drift_report(
    scene: AnyScene,
    out: str | PathLike[str],
    progress: bool | None = None,
    *,
    methods: Iterable[str] | None = None,
) -> Solution | SeveralRuns:
    """Integrate a scene and write its drift report, as ``geomint drift`` does.

    Parameters
    ----------
    scene : name, path, content or Scene
    out : path
        A folder; made if it is not there. Files of an earlier report are replaced.
    progress : bool, optional
        Show progress. Default: if standard error is a terminal.
    methods : iterable of str, optional
        Names, or ``"NAME:STEP"``, for one report on all of them, each in the representation that
        suits it. Default: the methods of the scene's ``[drift]`` section, or else its one method.

    Returns
    -------
    Solution or SeveralRuns
        With the drifts in ``drift``; after Ctrl-C what was computed, reported as interrupted.
        `SeveralRuns`, if `methods` or the scene's ``[drift] methods`` are given, is a sequence of
        runs, each with its ``label``, ``status``, ``drift`` and ``solution``.

    Raises
    ------
    SceneError, MethodError, DomainError
        Before anything is computed.
    FormError, ConvergenceError, NonFiniteError
        For a single method. One of several that fails is reported as failed.
    """
    chosen = load_scene(scene).for_drift()
    if isinstance(methods, str):
        raise DomainError("methods", methods, "a list of names")
    names = chosen.content.drift.methods if methods is None else methods
    if names is not None:
        result = run_methods(chosen, names, progress)
        write_several_report(result, Path(out))
        return result
    plan = make_plan(chosen, "drift")
    for note in plan.notes:
        warnings.warn(note, GeomintWarning, stacklevel=2)
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
    """Write the four files of a report, all or none, and return the path of the page.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    provenance = scene_provenance(solution, scene, command)
    record = drift_record(solution.drift, provenance)
    drifts = dict(_by_kind(solution))
    figure = drift_figure([(solution.method.name, drifts)], solution.drift_time, solution.status)
    page = drift_page(solution, scene, plan, record["provenance"])
    return write_drift_files(folder, record, figure, page)


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
        rule_details=rule_details(),
        kinds=[
            kind for kind in RULE if any(d.drift_class == kind for d in solution.drift.values())
        ],
        panels=_panels(solution),
        unit="τ" if solution.drift_time == "tau" else "t",
        choices=plan.choices,
        provenance=provenance,
    )


def _facts(solution: Solution, scene: Scene) -> list[tuple[str, str]]:
    """Return what the first screen says about the run."""
    method, problem = solution.method, solution.problem
    own = "τ" if problem.time == "tau" else "t"
    structure = method.structure(problem)
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
        ("step", f"{step_of(solution, 10)} in {own}"),
        ("steps", f"{solution.steps:,}".replace(",", "\u202f")),
        ("end", f"{asked} = {end:g}"),
        ("field evaluations", f"{solution.evaluations:,}".replace(",", "\u202f")),
        ("run time", f"{solution.run_seconds:.3g} s ({rate:.2g} steps a second)"),
        ("watching", f"{solution.watching_seconds:.3g} s for what is observed"),
        ("compile time", compiled),
    ]


def _by_kind(solution: Solution) -> list[tuple[str, Drift]]:
    """Return the drifts in the order of their kinds: energy, other integrals, and so on."""
    order = list(KINDS)
    drifts = solution.drift.items()
    return sorted(drifts, key=lambda item: order.index(kind_of(item[0], solution.problem)))


def _kind_name(solution: Solution, name: str) -> str:
    kind = KINDS[kind_of(name, solution.problem)].one
    return "" if kind == name else kind


def _rows(solution: Solution) -> list[dict[str, str]]:
    """Return the table of quantities as text."""
    rows = []
    for name, drift in _by_kind(solution):
        vanishing = abs(drift.initial) <= ROUNDOFF * drift.scale  # 0, or what rounding left of it
        relative = number(drift.max_rel_error)
        if vanishing:
            relative = f"— (scale {number(drift.scale)})"
        rows.append(
            {
                "name": spanned(name, drift, solution),
                "sort": _kind_name(solution, name),
                "initial": number(drift.initial, 3 if vanishing else 8),
                "max_abs": number(drift.max_abs_error),
                "max_rel": relative,
                "final": number(drift.final_error),
                "slope": with_error(drift.slope, drift.slope_stderr),
                "bound": number(drift.trend_bound, 2),
                "kind": drift.drift_class,
                "event": what_happened(drift, solution.drift_time),
            }
        )
    return rows


def _panels(solution: Solution) -> list[dict[str, str]]:
    """Return the plots of each quantity as data URIs, with texts for those who cannot see them."""
    panels = []
    for name, drift in _by_kind(solution):
        sizes, means = (
            data_uri(panel_figure(kind, name, drift, solution.drift_time))
            for kind in ("sizes", "means")
        )
        alt = (
            f"{name}: largest deviation {number(drift.max_abs_error)}, "
            f"final {number(drift.final_error)}, {drift.drift_class} "
            f"{what_happened(drift, solution.drift_time)}".rstrip()
        )
        panels.append({"name": name, "sizes": sizes, "means": means, "alt": alt})
    return panels
