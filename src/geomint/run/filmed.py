"""A film of a run: which moments its frames show, at which pace, and what is seen."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import Array, positive, switch
from ..errors import DomainError, LeftOutWarning, tell
from .files.outputs import check_file, whole_file
from .shown_body import direction_of, has_path, path_along
from .stretch import Stretch, stretch_of, with_times

if TYPE_CHECKING:
    from ..plots.film import Scene
    from ..plots.motion_plots import Heading
    from ..plots.view import View
    from .solution import Solution

SECONDS = 12.0  # of a film whose speed is not given
SLOW = 0.35  # of a turn a second, of a film whose speed is not given
FAST = 1.0 / 6.0  # of a turn between frames: what turns faster is not seen to turn so
MOST_FRAMES = 10_000  # the writers of .gif and .html hold all of them


def write_film(
    solution: Solution,
    file: str | PathLike[str],
    fps: float,
    speed: float | None,
    follow: bool,
    span: Any,
    view: View | None,
    told: Callable[[Stretch], Heading],
    progress: Callable[[int, int], Any] | None,
) -> Path:
    """Write the film; see `geomint.run.pictures.Pictures.animate`.

    `told` says what is above it.
    """
    from ..plots.film import Stamp, check_ending, save_film
    from ..plots.view import View

    rate, follow = positive("fps", fps), switch("follow", follow)
    pace = None if speed is None else positive("speed", speed)
    target = check_ending(file)
    check_file(target)
    stretch = stretch_of(solution, span)
    fastest = _fastest(solution, stretch)
    times = _frames(stretch, fastest, pace, rate, cut=span is None)
    view = View() if view is None else view
    every, rows = with_times(solution, stretch, times)
    scene = _scene(solution, every, rows, view, follow)
    _tell_fast(fastest * float(np.max(np.abs(np.diff(times)))))
    shown = Stretch(
        every.time, every.times[rows], every.own[rows], every.states[rows], every.joined
    )
    time = "τ" if every.time == "tau" else "t"
    stamp = Stamp(told(shown).text, time, solution.about.unit(every.time), shown.times)
    with whole_file(target) as unfinished:
        save_film(scene, stamp, unfinished, rate, progress)
    return target


def _scene(solution: Solution, every: Stretch, rows: Any, view: View, follow: bool) -> Scene:
    """Return the body, or else a direction on its sphere."""
    from ..plots.film import BallScene, SphereScene

    problem = solution.code()
    if has_path(problem) and every.time == "t":
        path = path_along(problem, every)
        if path.attitude.shape[1] == 3:
            return BallScene(path, rows, view, follow)
    direction = direction_of(problem)
    return SphereScene(direction.along(every.states), rows, direction.name, view)


def _fastest(solution: Solution, stretch: Stretch) -> float:
    """Return the largest angular speed of what is seen, as far as the samples tell."""
    problem = solution.code()
    spans = np.abs(np.diff(stretch.times))
    moving = spans > 0.0
    path = None
    if has_path(problem) and stretch.time == "t":
        path = path_along(problem, stretch)
    if path is not None and path.attitude.shape[1] == 3:
        between = np.einsum("kij,kij->k", path.attitude[1:], path.attitude[:-1])
        cosines = 0.5 * (between - 1.0)
    else:
        points = direction_of(problem).along(stretch.states)
        cosines = np.einsum("ki,ki->k", points[1:], points[:-1])
    angles = np.arccos(np.clip(cosines, -1.0, 1.0))
    return float(np.max(angles[moving] / spans[moving], initial=0.0))


def _frames(stretch: Stretch, fastest: float, speed: float | None, fps: float, cut: bool) -> Array:
    """Return the times of the frames: all of the stretch, or its beginning if nothing is said."""
    begin, end = float(stretch.times[0]), float(stretch.times[-1])
    length = abs(end - begin)
    if speed is None:
        calm = SLOW * 2.0 * np.pi / fastest if fastest > 0.0 else length / SECONDS
        if cut:
            length = min(length, calm * SECONDS)
        speed = max(calm, length / SECONDS)
    count = round(length / speed * fps) + 1
    if count > MOST_FRAMES:
        least = length * fps / MOST_FRAMES
        raise DomainError("speed", speed, f"at least {least:.3g}: a film has {MOST_FRAMES} frames")
    direction = 1.0 if end >= begin else -1.0
    return begin + direction * length * np.linspace(0.0, 1.0, max(count, 2))


def _tell_fast(turn: float) -> None:
    """Warn if the body turns by much between two frames."""
    part = turn / (2.0 * np.pi)
    if part > FAST:
        text = (
            f"the body turns by up to {part:.2g} of a turn between two frames, which do not show "
            "how: a smaller speed or a larger fps does"
        )
        tell(LeftOutWarning(text, "turns", part))
