"""``geomint section`` from Python: the section of a scene, and its report."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from ..plan import plan_section
from ..report import SECTION_FILES
from ..report.section_page import write_section_report
from ..run.files.outputs import check_folder
from ..run.section import Section
from ..scene import Scene, load_scene

__all__ = ["section_report"]


def section_report(
    scene: str | PathLike[str] | Mapping[str, Any] | Scene,
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
    plan = plan_section(load_scene(scene), **keys)
    check_folder(out, SECTION_FILES)
    section = plan.run(progress)
    write_section_report(plan, section, Path(out), paper=paper)
    return section
