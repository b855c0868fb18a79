"""``geomint scan`` from Python: an ensemble of a scene, and its report."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from ..errors import GeomintWarning
from ..plan import plan_scan
from ..report import SCAN_FILES
from ..report.scan_page import write_scan_report
from ..run.ensemble.result import Ensemble
from ..run.files.outputs import check_folder
from ..scene import Scene, load_scene

__all__ = ["scan_report"]


def scan_report(
    scene: str | PathLike[str] | Mapping[str, Any] | Scene,
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
    plan = plan_scan(load_scene(scene), **keys)
    for note in plan.notes:
        warnings.warn(note, GeomintWarning, stacklevel=2)
    check_folder(out, SCAN_FILES)
    many = plan.run(progress)
    write_scan_report(plan, many, Path(out), paper=paper)
    return many
