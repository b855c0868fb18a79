"""Test all methods on all systems until each fails."""

from __future__ import annotations

import pickle
from os import PathLike
from pathlib import Path
from typing import Any

import click

from ...arguments import positive, whole
from ...errors import DomainError
from ...reports import STRESS_FILES
from ...run.calls import still
from ...run.files.outputs import check_folder
from ...scene.load import load_changed
from .. import options


@click.command("stress")
@click.argument("scene", required=False)
@options.folder_option("stress", "stress.html, stress.json, stress.png and stress.svg")
@options.list_option("--methods", help="Methods, separated by commas; default: all.")
@options.list_option("--systems", help="Systems, separated by commas; default: all.")
@options.list_option("--axis", help="Axes of the map, separated by commas; default: all.")
@click.option("--quick", is_flag=True, help="Run a small part, in less than a minute.")
@click.option(
    "--seconds",
    type=click.FloatRange(min=0.0, min_open=True),
    default=60.0,
    show_default=True,
    help="Time limit of one test, in seconds.",
)
@click.option(
    "--workers", type=click.IntRange(1), default=2, show_default=True, help="Number of processes."
)
@options.quiet_option
@options.debug_option
def command(scene: str | None, out: Path, quiet: bool, **keys: Any) -> int:
    """Test all methods on all systems until each fails; or on one system, that of SCENE.

    The exit code is 1 if geomint returns a number that is not finite, loses accuracy or a conserved
    quantity without a warning, raises an error without a type, or hangs.
    """
    from ...reports.terminal import show

    if scene is not None:
        options.tell_file(scene)
    line = options.reproducing_command()
    report = _stressed(scene, out, None, not quiet, line, **keys)._make()
    if not quiet:
        show(report)
        options.say_report(f"report{options.partly(report.status)}", out / report.page)
    return options.exit_code(report.outcome or report.status)


@still
def stress_report(
    what: Any,
    out: str | PathLike[str],
    *,
    y0: Any = None,
    methods: Any = None,
    systems: Any = None,
    axis: Any = None,
    quick: bool = False,
    seconds: float = 60.0,
    workers: int = 2,
    progress: bool | None = None,
) -> Any:
    """Test methods until each fails, as ``geomint stress`` does, and write the report of that.

    Parameters
    ----------
    what : Problem, Scene, name or path, optional
        One's own problem with its state `y0`, or a scene; None: all systems there are.
    out : path
        A folder; made if it is not there. Files of an earlier report are replaced.
    y0 : array_like, optional
        A usual state of a problem of one's own.
    methods, systems, axis : sequences of str, optional
        Names of methods, of systems and of axes, all unless given.
    quick : bool
        Whether to run a small part.
    seconds : float
        Time limit of one test.
    workers : int
        Number of processes.
    progress : bool, optional
        Show progress. Default: if standard error is a terminal.

    Returns
    -------
    Result
        With its `cells`, each with a `verdict`.

    Raises
    ------
    GeomintError, OutputError
        Before anything is computed.
    """
    keys = {"methods": methods, "systems": systems, "axis": axis}
    for name, names in keys.items():
        if isinstance(names, str):
            raise DomainError(name, names, "a list of names")
    positive("seconds", seconds)
    whole("workers", workers, 1)
    given: dict[str, Any] = {"quick": quick, "seconds": seconds, "workers": workers, **keys}
    return _stressed(what, Path(out), y0, progress, None, **given)


def _stressed(
    what: Any,
    out: Path,
    y0: Any,
    progress: bool | None,
    line: str | None,
    *,
    methods: Any,
    systems: Any,
    axis: Any,
    quick: bool,
    seconds: float,
    workers: int,
) -> Any:
    from ...stress.own_cases import own_cases
    from ...stress.report import stress_record, stress_report
    from ...stress.sweep import Selection, run_selection
    from ...stress.terminal import Watch

    selection = Selection(tuple(methods or ()), tuple(systems or ()), tuple(axis or ()), quick)
    cases = None
    if what is not None:
        scene = load_changed(what, "section", None if line is None else options.written, y0)
        cases = own_cases(scene.problem, scene.state)
        pickle.dumps(cases)  # what no process could be sent is told before, and of no method
    check_folder(out, STRESS_FILES)
    with Watch(progress is not False) as watch:
        found = run_selection(selection, watch, cases=cases, seconds=seconds, workers=workers)
    numbers = found.cells, found.axes, found.seconds, line, found.interrupted
    found._make = lambda: stress_report(stress_record(*numbers), found.methods)
    found.report(out)
    return found
