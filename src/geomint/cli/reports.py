"""Commands from Python: what is computed of a scene, with its report."""

from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from ..errors import DomainError, LeftOutWarning, tell
from ..plan import SeveralRuns, common_notes, plan_chaos, plan_scan, plan_section, run_methods
from ..report import CHAOS_FILES, DRIFT_FILES, SCAN_FILES, SECTION_FILES
from ..run.calls import still
from ..run.ensemble.result import Ensemble
from ..run.exponents import Lyapunov
from ..run.files.outputs import check_folder
from ..run.section import Section
from ..scene import Scene, load_scene

Given = str | PathLike[str] | Mapping[str, Any] | Scene


@still
def chaos_report(
    scene: Given,
    out: str | PathLike[str],
    count: int | None = None,
    progress: bool | None = None,
    paper: bool = False,
) -> Lyapunov:
    """Find the Lyapunov exponents of a scene and write their report, as ``geomint chaos`` does.

    Parameters
    ----------
    scene : name, path, content or Scene
        Its end is that of the run; ``geomint chaos`` takes that of a drift report.
    out : path
        A folder; made if it is not there. Files of an earlier report are replaced.
    count : int, optional
        How many exponents, the largest. Default: all.
    progress : bool, optional
        Show progress. Default: if standard error is a terminal.
    paper : bool
        Also write what goes into a paper, as ``--paper`` does.

    Returns
    -------
    Lyapunov
        After Ctrl-C, of the time until then.

    Raises
    ------
    SceneError, FormError, DomainError, OutputError
        Before anything is computed.
    StepError
        If the method fails on the way.
    """
    from ..report.chaos_page import write_chaos_report

    plan = plan_chaos(load_scene(scene), count)
    check_folder(out, CHAOS_FILES)
    found = plan.run(progress)
    write_chaos_report(plan, found, Path(out), paper=paper)
    return found


@still
def drift_report(
    scene: Given,
    out: str | PathLike[str],
    progress: bool | None = None,
    *,
    methods: Iterable[str] | None = None,
    paper: bool = False,
) -> SeveralRuns:
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
    paper : bool
        Also write what goes into a paper, as ``--paper`` does.

    Returns
    -------
    SeveralRuns
        A sequence of runs, one for each method, each with its ``label``, ``status``, ``drift`` and
        ``solution``: of one that failed, or after Ctrl-C, with what was computed.

    Raises
    ------
    SceneError, MethodError, DomainError, OutputError
        Before anything is computed.
    FormError
        Or another error, that of the first, if every method fails before its first step.
    """
    from ..report.drift_page import write_drift_report

    chosen = load_scene(scene).for_drift()
    if isinstance(methods, str):
        raise DomainError("methods", methods, "a list of names")
    if methods is None:
        methods = chosen.content.drift.methods or [chosen.content.integrate.method]
    check_folder(out, DRIFT_FILES)
    result = run_methods(chosen, methods, progress)
    for note in common_notes(run.plan for run in result):
        tell(LeftOutWarning(note))
    write_drift_report(result, Path(out), None, paper)
    return result


@still
def scan_report(
    scene: Given,
    out: str | PathLike[str],
    progress: bool | None = None,
    paper: bool = False,
    **keys: Any,
) -> Ensemble:
    """Integrate a scene many times and write the report of that, as ``geomint scan`` does.

    Parameters
    ----------
    scene : name, path, content or Scene
    out : path
        A folder; made if it is not there. Files of an earlier report are replaced.
    progress : bool, optional
        Show how many members are done. Default: if standard error is a terminal.
    paper : bool
        Also write what goes into a paper, as ``--paper`` does.
    **keys
        Of the scene's ``[ensemble]``, in place of what is there, such as ``vary={"D": "1:4:31"}``,
        ``draws=100``, ``show=["drift:energy", "exponent"]``.

    Returns
    -------
    Ensemble
        With the `readings` that are shown; after Ctrl-C with the members that are done.

    Raises
    ------
    SceneError, FormError, DomainError, OutputError
        Before anything is computed.
    """
    from ..report.scan_page import write_scan_report

    plan = plan_scan(load_scene(scene), **keys)
    for note in plan.notes:
        tell(LeftOutWarning(note))
    check_folder(out, SCAN_FILES)
    many = plan.run(progress)
    write_scan_report(plan, many, Path(out), paper=paper)
    return many


@still
def section_report(
    scene: Given,
    out: str | PathLike[str],
    progress: bool | None = None,
    paper: bool = False,
    **keys: Any,
) -> Section:
    """Make the Poincaré section of a scene and write its report, as ``geomint section`` does.

    Parameters
    ----------
    scene : name, path, content or Scene
    out : path
        A folder; made if it is not there. Files of an earlier report are replaced.
    progress : bool, optional
        Show progress, in points. Default: if standard error is a terminal.
    paper : bool
        Also write what goes into a paper, as ``--paper`` does.
    **keys
        Of the scene's ``[section]``, in place of what is there, such as ``event="gamma[2]"``,
        ``direction="up"``, ``points=2000``, ``motions=8``.

    Returns
    -------
    Section
        After Ctrl-C, and of motions that cross no more, what was found.

    Raises
    ------
    SceneError, FormError, DomainError, OutputError
        Before anything is computed.
    StepError
        If a method fails on a motion.
    """
    from ..report.section_page import write_section_report

    plan = plan_section(load_scene(scene), **keys)
    check_folder(out, SECTION_FILES)
    section = plan.run(progress)
    write_section_report(plan, section, Path(out), paper=paper)
    return section
