"""``geomint drift`` from Python: a scene is integrated, and its drift report written."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from ..errors import DomainError, GeomintWarning
from ..plan import SeveralRuns, common_notes, run_methods
from ..report import DRIFT_FILES
from ..report.drift_page import write_drift_report
from ..run.files.outputs import check_folder
from ..scene import Scene, load_scene

__all__ = ["drift_report"]


def drift_report(
    scene: str | PathLike[str] | Mapping[str, Any] | Scene,
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
    chosen = load_scene(scene).for_drift()
    if isinstance(methods, str):
        raise DomainError("methods", methods, "a list of names")
    if methods is None:
        methods = chosen.content.drift.methods or [chosen.content.integrate.method]
    check_folder(out, DRIFT_FILES)
    result = run_methods(chosen, methods, progress)
    for note in common_notes(run.plan for run in result):
        warnings.warn(note, GeomintWarning, stacklevel=2)
    write_drift_report(result, Path(out), None, paper)
    return result
