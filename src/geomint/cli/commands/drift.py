"""Integrate a scene for a long time and report the drift of its invariants.

If --methods or the [drift] section of the scene lists several methods, one report shows them all.
Each method integrates the representation that suits it.
"""

from contextlib import nullcontext
from functools import partial

from ...plan.duration import Estimate, expected_time
from ...plan.several import (
    MethodRun,
    SeveralRuns,
    Variants,
    drift_methods,
    plan_methods,
    run_methods,
    warming,
)
from ...reports import DRIFT_FILES
from ...reports.report import Report
from ...scene.model import DriftSection
from ...scene.provenance import scene_record
from ...scene.scene import Scene
from ..command import ENDS, STEPPED, WATCHED, Command, Listener, in_python


def plan_drift(scene: Scene) -> Variants:
    """Return the plans of the methods of ``[drift]``, or of the scene's one method."""
    return plan_methods(scene, drift_methods(scene))


def run(planned: Variants, listener: Listener) -> SeveralRuns:
    """Return the runs: of those that failed, or after Ctrl-C, with what was computed."""

    def tell(run: MethodRun) -> None:
        if run.status != "success":
            listener.failed(run.error or run.message, f"{run.label}: {run.status}")

    from ...kernels.compiling.beside import compiled_beside

    several = len(planned.plans) > 1
    with compiled_beside(partial(warming, planned.plans)) if several else nullcontext():
        return run_methods(planned, progress=listener.progress, report=tell)


def report(planned: Variants, found: SeveralRuns, command: str | None) -> Report:
    """Return the report on one or several methods."""
    from ...reports.drift_report import drift_report_of

    return drift_report_of(found, scene_record(found.scene, command))


def expected(planned: Variants) -> Estimate:
    """Return how long all runs take."""
    return expected_time(planned.plans)


DRIFT = Command(
    "drift",
    DriftSection,
    plan_drift,
    run,
    report,
    DRIFT_FILES,
    (*STEPPED, *ENDS, *WATCHED),
    use="drift",
    folder="report",
    expected=expected,
)
drift_report = in_python(DRIFT)
