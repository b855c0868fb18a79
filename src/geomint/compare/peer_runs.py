"""Peers on the problem of a comparison: at several tolerances, to the same end."""

import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from ..errors import FormError, raised
from ..methods.rattle import Rattle
from ..problems.systems import Model
from .endpoint import Endpoint
from .ladder import STEP_FACTORS
from .peers.peer import End, Motion, Peer, Ready
from .point import MAX_SECONDS, Point, timed_runs

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13)


def peer_runs(
    peers: list[Peer],
    model: Model,
    endpoint: Endpoint,
    representation: str | None,
    repeats: int | None,
    left_out: dict[str, str],
    report: Callable[[str], None],
) -> Iterator[Point]:
    """Run every peer and yield its points; note in `left_out` which did not run, and why."""
    for peer in peers:
        version = peer.version
        if version is None:
            left_out[peer.name] = f"{peer.package} is not installed: pip install {peer.package}"
            continue
        report(peer.name)
        try:
            name, motion = _motion(peer, model, endpoint, representation)
            start = peer.start(motion)
        except FormError as error:
            left_out[peer.name] = str(error)
            continue
        except (Exception, SystemExit) as error:  # whatever a broken package raises
            left_out[peer.name] = raised(error)
            continue
        blank = Point(peer.name, 0, name, 0.0, None, peer=f"{peer.package} {version}")
        expected, before = 0.0, 1.0
        for setting in _settings(peer, motion):
            own: dict[str, Any] = {"step" if peer.fixed else "rtol": setting}
            point = replace(blank, **own)
            if point.order:  # a smaller tolerance makes a run longer
                expected *= float((before / setting) ** (1.0 / (point.order + 1)))
            if expected > MAX_SECONDS:
                yield replace(point, status=f"not run: would take about {expected:.0f} s")
                continue
            report(f"{peer.name}, {'step' if peer.fixed else 'tolerance'} {setting:.1e}")
            point = _point(point, start, setting, motion, endpoint, repeats)
            blank = replace(blank, order=point.order)
            expected, before = point.seconds or 0.0, setting
            yield point


def _motion(
    peer: Peer, model: Model, endpoint: Endpoint, representation: str | None
) -> tuple[str, Motion]:
    """Return what a peer integrates: the first representation in whose own time the end is known."""
    own = next(iter(model.problems))
    wanted = own if representation == "own" else representation
    for name, problem in model.problems.items():
        end = endpoint.end_for(problem).get("tau_end" if problem.time == "tau" else "t_end")
        if end is not None and wanted in (None, name):
            return name, Motion(problem, model.states[name], end)
    raise FormError("the end is not known in the time of the problem")


def _settings(peer: Peer, motion: Motion) -> list[float]:
    if not peer.fixed:
        return list(TOLERANCES)
    base = Rattle().default_step(motion.problem, motion.y0, motion.end)
    return [factor * base for factor in STEP_FACTORS]


def _point(
    point: Point,
    start: Callable[[float], Ready],
    setting: float,
    motion: Motion,
    endpoint: Endpoint,
    repeats: int | None,
) -> Point:
    """Return the point of a peer at a setting, run until it has its repeats.

    A first run is not timed, however long it takes: what compiles when it is needed does so in it.
    """
    try:
        ready = start(setting)
        point = replace(point, order=ready.order)
        ready.run()
        runs, enough = timed_runs(repeats)
        seconds: list[float] = []
        while not seconds or (len(seconds) < runs and sum(seconds) < enough):
            found, last = _timed(ready)
            seconds.append(last)
    except Exception as error:  # whatever another package raises
        return replace(point, status=f"failed: {raised(error)}")
    return replace(
        point,
        step=abs(motion.end) / found.steps if found.steps else point.step,
        seconds=statistics.median(seconds),
        steps=found.steps,
        evaluations=found.evaluations,
        repeats=len(seconds),
        **endpoint.judged(motion.problem, found.y),
    )


def _timed(ready: Ready) -> tuple[End, float]:
    begun = time.perf_counter()
    found = ready.run()
    return found, time.perf_counter() - begun
