"""Compute Lyapunov exponents of a scene and test whether its motion is chaotic.

By default the run ends where the drift report of the scene ends. Exponents are those of the problem's
own time, by steps of one length.
"""

import numpy as np

from ...errors import FormError, SceneError, StepError, quoted
from ...plan.choice import Asked
from ...plan.fitting import unfit
from ...plan.planned import Planned
from ...plan.tolerance import wanted_step
from ...plots.style import Picture
from ...reports import files_of
from ...reports.cite import cite
from ...reports.report import Images, Num, Part, Printed, Prose, Report, Table, of_warnings
from ...reports.text import Record, number, scene_facts, symbol
from ...run.exponents import Lyapunov
from ...run.lyapunov import lyapunov
from ...run.provenance import finite_json, method_record
from ...scene.model import ChaosSection
from ...scene.provenance import scene_record
from ...scene.scene import Scene
from ..command import Command, Listener, in_python

SAID = {
    "chaotic": "Chaotic: neighbouring motions part exponentially.",
    "regular": "Regular: neighbouring motions part like a power of time, as far as this run tells.",
    "undecided": "Undecided: a longer run may tell.",
}


def plan_chaos(scene: Scene) -> Planned:
    """Return what is integrated: the scene's own representation unless another one is asked for.

    A part of the state has a part of the exponents.

    Raises
    ------
    SceneError, FormError
        For an end in physical time of a problem in τ, and where the method takes no steps of a given
        length.
    """
    asked, content = Asked(scene, "drift"), scene.content
    if content.integrate.exact or scene.method.adaptive:
        name = "the exact flow" if content.integrate.exact else repr(scene.method.name)
        raise FormError(f"exponents are those of steps of one length, which {name} does not take")
    route = asked.route(asked.representation or asked.own)
    obstacle = unfit(route.problem, scene.method, {})
    if obstacle:
        raise FormError(f"{route.name!r} {obstacle}: choose another method or representation")
    if route.problem.time == "tau" and "tau_end" not in asked.end:
        expected = "tau_end, as exponents are those of the problem's own time (--tau-end)"
        raise SceneError(
            f"scene {quoted(scene.name)} ends at t = {asked.end['t_end']:g}: expected {expected}"
        )
    return Planned(scene=scene, route=route)


def run(planned: Planned, listener: Listener) -> Lyapunov:
    """Return the exponents; after Ctrl-C, or where a step fails, those of the time until then."""
    scene, route = planned.scene, planned.route
    method, step = wanted_step(scene, route.problem, route.state)
    given = {**scene.content.time.end, "method": method, "step": step}
    given |= {"count": scene.content.chaos.count, "progress": listener.progress}
    try:
        return lyapunov(route.problem, route.state, **given)
    except StepError as error:
        found = error.partial
        if not isinstance(found, Lyapunov) or not len(found.t):
            raise
        listener.failed(error, "")
        return found


def chaos_record(planned: Planned, found: Lyapunov, command: str | None) -> Record:
    """Return the content of ``chaos.json``; the exponents over time are in ``chaos.csv``.

    `reference` is ln(t/T)/t at the end, T the characteristic time `unit`: about what a regular motion
    has; `grown` is λ₁ t, and `alignment` the smaller alignment index there.
    """
    end = float(found.t[-1]) if len(found.t) else 0.0
    record = {
        "verdict": found.verdict,
        "exponents": found.exponents.tolist(),
        "errors": found.errors.tolist(),
        "sum": float(np.sum(found.exponents)),
        "all": planned.scene.content.chaos.count is None,
        "grown": float(found.exponents[0] * end),
        "reference": float(np.log(end / found.unit) / end) if end > found.unit else None,
        "alignment": None if found.sali is None or not end else float(found.sali[-1]),
        "end": end,
        "unit": found.unit,
        "status": found.status,
        "representation": planned.route.name,
        "time": planned.route.problem.time,
        "steps": found.steps,
        "iterations": found.iterations,
        **method_record(planned.scene.method),
        "initial": planned.route.state.tolist(),
        "warnings": [warning.as_json() for warning in found.warnings],
        "provenance": scene_record(planned.scene, command),
    }
    return finite_json(record)


def report(planned: Planned, found: Lyapunov, command: str | None) -> Report:
    """Return the exponents with their errors, and the picture of their sizes over time."""
    record, title = chaos_record(planned, found, command), planned.scene.title
    time = symbol(record["time"])
    pairs = zip(record["exponents"], record["errors"], strict=True)
    rows = [(f"λ{k}", Num(x, 4), Num(error, 2)) for k, (x, error) in enumerate(pairs, 1)]
    rows += [("sum", Num(record["sum"], 2), Num(None))] if record["all"] else []
    exponents = Table(("exponent", f"per unit of {time}", "standard error"), rows)
    picture = Picture(found.plot())
    failed, verdict = record["status"] != "success", SAID[record["verdict"]]
    at = f"at {time} = {number(record['end'])}."
    alerts = [(f"Not all of the run: {record['status']}", at)] if failed else []
    caption = (
        f"{title}. Sizes of the Lyapunov exponents, per unit of {time}, over time up to "
        f"{time} = {number(record['end'], 6)}; dotted: ln t / t, as of a regular motion. {verdict}"
    )
    method = f"{record['method']}, order {record['order']}, {record['steps']} steps"
    return Report(
        CHAOS.files,
        "Lyapunov exponents",
        title,
        verdict,
        (
            Part("Exponents", (exponents, Prose(" ".join(_words(record, time))))),
            Part("Over time", (Images([(picture.uri, OVER)], "wide"), Prose(HOW))),
        ),
        record,
        found.status,
        f"{record['steps']} steps by {record['method']} to {time} = {record['end']:.6g}",
        alerts=[*alerts, *of_warnings(record["warnings"])],
        pictures={"chaos": picture},
        citation=cite(planned.route.problem, planned.scene.method),
        csv=found.save,
        printed=Printed(
            caption, exponents, scene_facts(record["provenance"], method, planned.route.name)
        ),
    )


OVER = "sizes of the exponents over time on logarithmic axes, and the alignment index"
HOW = (
    "Exponents of a regular motion fall like the dotted line, a power of time; others become level. "
    "Dashed: the second half of the exponents shown. The numbers are in `chaos.csv`."
)


def _words(record: Record, time: str) -> list[str]:
    """Return what there is to say of the exponents, in sentences."""
    words = [
        f"{record['steps']} steps by {record['method']}, to {time} = {record['end']:.6g}; "
        f"representation: {record['representation']}.",
        f"The largest exponent × time is {record['grown'] or 0.0:.4g}",
    ]
    if record["reference"] is not None:
        least = record["reference"] * record["end"]
        words[-1] += (
            f"; a regular motion has about ln({time}/T) = {least:.3g}, T = {record['unit']:.3g} a "
            f"characteristic time"
        )
    words[-1] += "."
    if record["alignment"] is not None:
        words.append(
            f"The alignment index, by how much two vectors that the motion carries along differ in "
            f"direction, is {record['alignment']:.2g}: 0 up to rounding where motions part "
            "exponentially."
        )
    return [*words, "The sum is the mean growth of volumes."] if record["all"] else words


CHAOS = Command("chaos", ChaosSection, plan_chaos, run, report, files_of("chaos"), use="drift")
chaos_report = in_python(CHAOS)
