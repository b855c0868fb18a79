"""``geomint chaos`` from Python: the Lyapunov exponents of a scene, and their report."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from ..plan import plan_chaos
from ..report import CHAOS_FILES
from ..report.chaos_page import write_chaos_report
from ..run.exponents import Lyapunov
from ..run.files.outputs import check_folder
from ..scene import Scene, load_scene

__all__ = ["chaos_report"]


def chaos_report(
    scene: str | PathLike[str] | Mapping[str, Any] | Scene,
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
    plan = plan_chaos(load_scene(scene), count)
    check_folder(out, CHAOS_FILES)
    found = plan.run(progress)
    write_chaos_report(plan, found, Path(out), paper=paper)
    return found
