"""The ball rolling on its plane, n = 3, as an animation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import geomint as gi

from ..manifold import Array
from .view import COLOURS, FAINT, View

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..exact.reconstruction import ContactPath

__all__ = ["rolling_animation"]

FRAMES_PER_SECOND = 20
POINTS = 73  # of a great circle
DPI = 90


def rolling_animation(
    path: ContactPath,
    times: Any,
    file: Any,
    view: View | None = None,
    progress: Callable[[int, int], Any] | None = None,
) -> Path:
    """Write an animation of the rolling ball: great circles of the body, and the trace behind it.

    Parameters
    ----------
    path : ContactPath
    times : array_like
        Physical times of the frames, 20 a second.
    file : path
        Its ending says what is written: ``.gif``, or ``.html`` with all frames in it; ``.mp4`` where
        ffmpeg is installed.
    view : View, optional
    progress : callable, optional
        Called with the number of the frame and how many there are.

    Raises
    ------
    geomint.DomainError
        For an ending that is none of these, and fewer than two times.
    geomint.OutputError
        If the file cannot be written; what was there is as it was.
    """
    from matplotlib.animation import FuncAnimation
    from matplotlib.figure import Figure

    target, moments = Path(file), np.asarray(times, dtype=np.float64)
    writer = _writer(target)
    if moments.ndim != 1 or len(moments) < 2:
        raise gi.DomainError("times", times, "at least two times")
    view = View() if view is None else view
    scene = _Scene(path, moments, view)
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    scene.prepare(figure.subplots())
    film = FuncAnimation(
        figure, scene.draw, frames=len(moments), interval=1000 / FRAMES_PER_SECOND, blit=False
    )
    with gi.whole_file(target) as unfinished:
        film.save(unfinished, writer=writer, dpi=DPI, progress_callback=progress)
    return target


def _writer(target: Path) -> Any:
    from matplotlib.animation import FFMpegWriter, HTMLWriter, PillowWriter

    kinds: dict[str, Any] = {
        ".gif": lambda: PillowWriter(fps=FRAMES_PER_SECOND),
        ".html": lambda: HTMLWriter(fps=FRAMES_PER_SECOND, embed_frames=True),
        ".mp4": lambda: FFMpegWriter(fps=FRAMES_PER_SECOND),
    }
    if target.suffix not in kinds:
        raise gi.DomainError("file", str(target), f"a name that ends in one of {', '.join(kinds)}")
    if target.suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise gi.DomainError("file", str(target), "a .gif or .html: ffmpeg is not installed")
    return kinds[target.suffix]()


class _Scene:
    """What is drawn: the plane, the trace, the outline and three great circles of the body."""

    def __init__(self, path: ContactPath, times: Array, view: View) -> None:
        self._view, self._rho, self._times = view, path.rho, times
        self._attitudes, contact = path.attitude(times), path.contact(times)
        self._contact = np.concatenate([contact, np.zeros((len(times), 1))], axis=1)
        angle = np.linspace(0.0, 2 * np.pi, POINTS)
        circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(POINTS)], axis=-1)
        self._circles = [np.roll(circle, shift, axis=1) for shift in (0, 1, 2)]
        self._outline = circle[:, :2]

    def prepare(self, axis: Any) -> None:
        """Draw what stays, and the artists that move."""
        view, rho = self._view, self._rho
        low, high = self._contact.min(axis=0) - 1.5 * rho, self._contact.max(axis=0) + 1.5 * rho
        for x in np.linspace(low[0], high[0], 9):
            ends = view(np.array([[x, low[1], 0.0], [x, high[1], 0.0]]))
            axis.plot(*ends[:, :2].T, color=COLOURS["grey"], lw=0.4, alpha=0.6, zorder=0)
        for y in np.linspace(low[1], high[1], 9):
            ends = view(np.array([[low[0], y, 0.0], [high[0], y, 0.0]]))
            axis.plot(*ends[:, :2].T, color=COLOURS["grey"], lw=0.4, alpha=0.6, zorder=0)
        (self._trace,) = axis.plot([], [], color="black", lw=1.0, zorder=0.5)
        (self._edge,) = axis.plot([], [], color="black", lw=1.2, zorder=4)
        colours = [COLOURS["blue"], COLOURS["orange"], COLOURS["green"]]
        self._lines = [
            (
                axis.plot([], [], color=c, lw=2.0, zorder=3)[0],
                axis.plot([], [], color=c, lw=1.2, alpha=FAINT, zorder=2)[0],
            )
            for c in colours
        ]
        self._label = axis.set_title("t = 0")
        axis.set_aspect("equal")
        axis.set_axis_off()
        corners = view(np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
                                 for z in (0.0, 2 * rho)]))  # fmt: skip
        axis.set_xlim(corners[:, 0].min(), corners[:, 0].max())
        axis.set_ylim(corners[:, 1].min(), corners[:, 1].max())

    def draw(self, frame: int) -> None:
        """Move everything to where it is in a frame."""
        view, rho = self._view, self._rho
        centre = self._contact[frame] + np.array([0.0, 0.0, rho])
        shown = view(self._contact[: frame + 1])
        self._trace.set_data(shown[:, 0], shown[:, 1])
        middle = view(centre)[:2]
        self._edge.set_data(*(middle + rho * self._outline).T)
        for circle, (before, behind) in zip(self._circles, self._lines, strict=True):
            relative = view(rho * circle @ self._attitudes[frame].T)
            placed = relative[:, :2] + middle
            front = relative[:, 2] >= 0.0
            before.set_data(*np.where(front[:, None], placed, np.nan).T)
            behind.set_data(*np.where(front[:, None], np.nan, placed).T)
        self._label.set_text(f"t = {self._times[frame]:.1f} (dimensionless)")
