"""Animations: a ball that rolls on its plane, a body about a fixed point, a direction on the sphere.

As a page a film needs nothing but itself: all frames are in it, with a button and a slider.
"""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..arguments import Array, Integers, file_path
from ..errors import DomainError
from ..problems.body_path import BodyPath
from .canvas import new_figure
from .motion_plots import FRAME, draw_globe, label_axes
from .style import COLOURS
from .view import FAINT, View, great_circles

if TYPE_CHECKING:
    from matplotlib.axes import Axes


PAGE = Path(__file__).with_name("film_page.html")


def film_page(title: str, pictures: Iterable[bytes], fps: float) -> str:
    """Return a page that shows pictures, PNG each, so many a second."""
    frames = [base64.b64encode(picture).decode("ascii") for picture in pictures]
    return PAGE.read_text(encoding="utf-8").format(
        title=escape(title),
        last=len(frames) - 1,
        frames=json.dumps(frames),
        every=f"{1e3 / fps:.6g}",
    )


ENDINGS = (".gif", ".html", ".mp4")
SIZE = (6.4, 4.4)  # inches
PART = (0.02, 0.02, 0.96, 0.84)  # of the picture, below its words
DPI = 100  # pixels: even numbers, which .mp4 needs
MARGIN = 1.6  # radii around the trace
AROUND = 4.0  # radii that are seen beside a ball that is followed
TAIL = 0.25  # of the frames: the trail of a direction
Rows = Integers
CIRCLES = COLOURS[:3]


class Scene(Protocol):
    """What a film shows: drawn once, and moved for every frame."""

    def prepare(self, axes: Axes) -> None:
        """Draw what stays, and what will move."""

    def move(self, frame: int) -> None:
        """Move everything to where it is in a frame."""


@dataclass(frozen=True)
class Stamp:
    """What is written above a film: its title, and the time of each frame.

    Attributes
    ----------
    title, time, unit : str
    times : array, shape (frames,)
    """

    title: str
    time: str
    unit: str
    times: Array

    def at(self, frame: int) -> str:
        """Return the words above a frame: as long in all of them."""
        most = float(np.max(np.abs(self.times)))
        step = float(np.min(np.abs(np.diff(self.times)), initial=np.inf)) or most
        digits = int(np.clip(np.ceil(-np.log10(step)) + 1, 0, 9)) if np.isfinite(step) else 2
        return f"{self.title}\n{self.time} = {self.times[frame]:.{digits}f} ({self.unit})"


def check_ending(file: Any) -> Path:
    """Return the path of a film, or raise for one that none can be written to.

    Raises
    ------
    DomainError
    """
    target = file_path("file", file, ENDINGS)
    if target.suffix == ".mp4":
        from matplotlib.animation import FFMpegWriter

        if not FFMpegWriter.isAvailable():
            expected = (
                "a name that ends in .gif or .html, which need nothing more; for .mp4 the program "
                "ffmpeg, to be installed (apt install ffmpeg, brew install ffmpeg, conda install "
                "ffmpeg)"
            )
            raise DomainError("file", str(target), expected)
    return target


def save_film(
    scene: Scene,
    stamp: Stamp,
    file: Path,
    fps: float,
    progress: Callable[[int, int], Any] | None = None,
) -> None:
    """Write a film; its ending says what: ``.gif``, ``.html`` with all frames in it, ``.mp4``.

    Parameters
    ----------
    progress : callable, optional
        Called with the number of the frame and how many there are.
    """
    count = len(stamp.times)
    with new_figure(*SIZE) as figure:
        axes = figure.add_axes(PART)
        scene.prepare(axes)
        words = figure.text(0.02, 0.98, stamp.at(0), ha="left", va="top", fontsize=10)

        def draw(frame: int) -> Sequence[Any]:
            scene.move(frame)
            words.set_text(stamp.at(frame))
            return ()

        def pictures() -> Iterator[bytes]:
            """Yield frames as PNG."""
            for frame in range(count):
                draw(frame)
                buffer = io.BytesIO()
                figure.savefig(buffer, format="png", dpi=DPI)
                if progress is not None:
                    progress(frame, count)
                yield buffer.getvalue()

        if file.suffix == ".html":
            file.write_text(film_page(stamp.title, pictures(), fps), encoding="utf-8")
            return

        from matplotlib.animation import FFMpegWriter, FuncAnimation, PillowWriter

        rate: Any = fps  # any number of frames a second will do
        writer = (
            PillowWriter(fps=rate)
            if file.suffix == ".gif"
            else FFMpegWriter(fps=rate, extra_args=["-pix_fmt", "yuv420p"])
        )
        film = FuncAnimation(figure, draw, frames=count, interval=1e3 / fps, blit=False)
        film.save(file, writer=writer, dpi=DPI, progress_callback=progress)


class BallScene:
    """A ball, n = 3: three great circles of the body, the plane and the trace behind it.

    Parameters
    ----------
    path : BodyPath
        Along the motion; without a contact point the ball stays where it is.
    rows : array of int, shape (frames,)
        Which of its samples the frames show, in their order.
    view : View
    follow : bool
        Whether the picture goes with the ball; else the whole trace is seen.
    """

    def __init__(self, path: BodyPath, rows: Rows, view: View, follow: bool) -> None:
        self._view, self._radius, self._rows, self._follow = view, path.radius, rows, follow
        self._attitudes, self._rolls = path.attitude, path.contact is not None
        flat = np.zeros((len(path.attitude), 2)) if path.contact is None else path.contact
        self._trace = np.concatenate([flat, np.zeros((len(flat), 1))], axis=1)

    def prepare(self, axes: Axes) -> None:
        """Draw the plane, and the artists that move."""
        view, rho = self._view, self._radius
        trace = self._trace[: self._rows[-1] + 1]
        low, high = trace.min(axis=0) - MARGIN * rho, trace.max(axis=0) + MARGIN * rho
        if self._follow:
            low, high = low - 2.0 * AROUND * rho, high + 2.0 * AROUND * rho
        cell = rho * max(1.0, np.ceil(float((high - low)[:2].max()) / rho / 40.0))
        low, high = cell * np.floor(low / cell), cell * np.ceil(high / cell)
        if self._rolls:
            self._plane(axes, low, high, cell)
        (self._line,) = axes.plot([], [], color="black", linewidth=1.0, zorder=0.5)
        (self._edge,) = axes.plot([], [], color="black", linewidth=1.2, zorder=4)
        self._circles = [
            (
                circle,
                axes.plot([], [], color=colour, linewidth=2.0, zorder=3)[0],
                axes.plot([], [], color=colour, linewidth=1.2, alpha=FAINT, zorder=2)[0],
            )
            for circle, colour in zip(great_circles(), CIRCLES, strict=True)
        ]
        axes.set_aspect("equal")
        axes.set_axis_off()
        self._axes = axes
        corners = view(np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
                                 for z in (0.0, 2.0 * rho)]))  # fmt: skip
        axes.set_xlim(corners[:, 0].min(), corners[:, 0].max())
        axes.set_ylim(corners[:, 1].min(), corners[:, 1].max())
        self._outline = great_circles()[2][:, :2]

    def _plane(self, axes: Axes, low: Array, high: Array, cell: float) -> None:
        """Draw a grid whose lines are whole radii apart."""
        for i, j in ((0, 1), (1, 0)):
            for at in cell * np.arange(round(low[i] / cell), round(high[i] / cell) + 1):
                ends = np.zeros((2, 3))
                ends[:, i], ends[:, j] = at, (low[j], high[j])
                shown = self._view(ends)
                axes.plot(*shown[:, :2].T, color=FRAME, linewidth=0.4, alpha=0.6, zorder=0)

    def move(self, frame: int) -> None:
        """Move the ball, its circles and the end of the trace."""
        view, rho, row = self._view, self._radius, self._rows[frame]
        at = self._trace[row]
        self._line.set_data(*view(self._trace[: row + 1])[:, :2].T)
        middle = view(at + np.array([0.0, 0.0, rho]))[:2]
        self._edge.set_data(*(middle + rho * self._outline).T)
        for circle, before, hidden in self._circles:
            relative = view(rho * circle @ self._attitudes[row].T)
            placed, front = relative[:, :2] + middle, relative[:, 2:] >= 0.0
            before.set_data(*np.where(front, placed, np.nan).T)
            hidden.set_data(*np.where(front, np.nan, placed).T)
        if self._follow:
            high = AROUND * rho * (SIZE[1] * PART[3]) / (SIZE[0] * PART[2])
            self._axes.set_xlim(middle[0] - AROUND * rho, middle[0] + AROUND * rho)
            self._axes.set_ylim(middle[1] - high, middle[1] + high)


class SphereScene:
    """A unit vector on its sphere: the direction, and a trail behind it.

    Parameters
    ----------
    directions : array, shape (N, 3)
        Along the motion.
    rows : array of int, shape (frames,)
        Which of its samples the frames show, in their order.
    name : str
        Of the vector.
    view : View
    """

    def __init__(self, directions: Array, rows: Rows, name: str, view: View) -> None:
        self._directions, self._rows, self._name, self._view = directions, rows, name, view
        self._tail = max(1, round(TAIL * (rows[-1] + 1)))

    def prepare(self, axes: Axes) -> None:
        """Draw the sphere with its axes, and the artists that move."""
        draw_globe(axes, self._view)
        label_axes(axes, self._name, self._view)
        (self._front,) = axes.plot([], [], color=COLOURS[0], linewidth=1.4, zorder=3)
        (self._back,) = axes.plot([], [], color=COLOURS[0], linewidth=1.4, alpha=FAINT, zorder=1)
        (self._point,) = axes.plot([], [], "o", color=COLOURS[1], markersize=7, zorder=4)
        axes.set(xlim=(-1.3, 1.3), ylim=(-1.25, 1.25))

    def move(self, frame: int) -> None:
        """Move the point and its trail."""
        row = self._rows[frame]
        shown = self._view(self._directions[max(0, row - self._tail) : row + 1])
        front = shown[:, 2:] >= 0.0
        self._front.set_data(*np.where(front, shown[:, :2], np.nan).T)
        self._back.set_data(*np.where(front, np.nan, shown[:, :2]).T)
        x, y, near = shown[-1]
        self._point.set_data([x], [y])
        self._point.set_alpha(1.0 if near >= 0.0 else 2.0 * FAINT)
