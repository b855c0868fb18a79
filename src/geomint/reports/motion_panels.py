"""The pictures with which a drift report opens: the first turns of the motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from ..arguments import Array
from ..errors import DomainError
from ..plan import SeveralRuns
from ..plan.first_turns import FirstTurns
from ..plots.motion_plots import Curves, draw_curves, draw_plane, draw_sphere, symbol
from ..plots.view import View
from ..run.shown_body import direction_of, has_path, path_along

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["MotionDraw", "motion_draws", "motion_words"]

MOST_CURVES = 6  # in one panel
MOST_OVER_TIME = 2


class MotionDraw(NamedTuple):
    """One panel.

    Attributes
    ----------
    draw : callable
    words : str
        What it shows, in place of the picture.
    square : bool
    """

    draw: Callable[[Axes], None]
    words: str
    square: bool = False


def motion_draws(result: SeveralRuns) -> list[MotionDraw]:
    """Return the panels of the first turns: an even number where that is possible.

    The direction on its sphere, or else two components; the contact point, where it is known; and
    pieces of the state over time.
    """
    motion = result.motion
    if motion is None:
        return []
    planes = list(_planes(motion))
    return planes + list(_over_time(motion))[: MOST_OVER_TIME if len(planes) != 1 else 1]


def motion_words(result: SeveralRuns) -> str:
    """Return what the panels show, in a sentence."""
    motion = result.motion
    if motion is None:
        return ""
    stretch = motion.stretch
    times = f"{symbol(stretch.time)} = {stretch.times[0]:.4g} … {stretch.times[-1]:.4g}"
    told = f"{'; ' if stretch.note else ''}{stretch.note}"
    return f"The first turns, {times}, by {motion.method}{told}."


def _planes(motion: FirstTurns) -> Iterator[MotionDraw]:
    problem, stretch = motion.problem, motion.stretch
    try:
        direction = direction_of(problem)
        points = direction.along(stretch.states)
        draw = partial(_sphere, points=points, name=direction.name, joined=stretch.joined)
        yield MotionDraw(draw, f"the path of {direction.name} on the unit sphere", True)
    except DomainError:
        yield from _components(motion)
    if has_path(problem):
        with suppress(DomainError):
            path = path_along(problem, stretch, contact=True)
            assert path.contact is not None
            labels = f"r[0] ({path.unit})", f"r[1] ({path.unit})"
            points = path.contact[:, :2]
            draw = partial(_plane, points=points, labels=labels, joined=stretch.joined)
            draw = partial(draw, title="contact point", equal=True)
            yield MotionDraw(draw, "the path of the contact point in the plane", True)


def _components(motion: FirstTurns) -> Iterator[MotionDraw]:
    """Yield the plane of the first two numbers of a piece, or of the first two pieces."""
    problem, states = motion.problem, motion.stretch.states
    if problem.rows < 2:
        return
    names = [(name, i) for name, rows in problem.pieces for i in range(rows)]
    single = problem.pieces[0][1] == 1
    labels = [symbol(n, i) if dict(problem.pieces)[n] > 1 else symbol(n) for n, i in names[:2]]
    axes = (
        f"{labels[0]} ({problem.unit(names[0][0])})",
        f"{labels[1]} ({problem.unit(names[1][0])})",
    )
    draw = partial(_plane, points=states[:, :2], labels=axes, joined=motion.stretch.joined)
    draw = partial(draw, title=f"{labels[0]}, {labels[1]}", equal=not single)
    yield MotionDraw(draw, f"the path of {labels[0]} and {labels[1]} in their plane", True)


def _over_time(motion: FirstTurns) -> Iterator[MotionDraw]:
    """Yield the pieces of the state over time, vectors before matrices."""
    problem, stretch, first = motion.problem, motion.stretch, ""
    with suppress(DomainError):
        first = direction_of(problem).name
    for name, rows in sorted(problem.pieces, key=lambda p: (p[0] != first, p[1] > MOST_CURVES)):
        shown = min(rows, MOST_CURVES)
        labels = [symbol(name, i) for i in range(shown)] if rows > 1 else [symbol(name)]
        start = problem.slices[name].start
        values, unit = stretch.states[:, start : start + shown], problem.unit(name)
        curves = Curves(symbol(name), labels, values, unit)
        draw = partial(_curve, curves=curves, motion=motion)
        yield MotionDraw(draw, f"{', '.join(labels)} over time")


def _sphere(axes: Axes, points: Array, name: str, joined: bool) -> None:
    draw_sphere(axes, points, name, joined, View())
    axes.set_title(f"{symbol(name)} on its sphere", loc="left", fontweight="bold", y=1.0)


def _plane(
    axes: Axes, points: Array, labels: tuple[str, str], joined: bool, title: str, equal: bool
) -> None:
    draw_plane(axes, points, labels, joined, equal)
    axes.set_title(title, loc="left", fontweight="bold")


def _curve(axes: Axes, curves: Curves, motion: FirstTurns) -> None:
    draw_curves(axes, motion.stretch.times, curves, motion.stretch.joined)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=6, handlelength=1.4,
                columnspacing=1.0, borderaxespad=0.1)  # fmt: skip
    time = motion.stretch.time
    axes.set_xlabel(f"{symbol(time)} ({motion.problem.unit(time)})")
