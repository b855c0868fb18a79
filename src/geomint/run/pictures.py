"""Pictures of a run's motion: what `Solution` offers beside its drifts."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import Array
from ..errors import DomainError
from ..problems.at_states import values_at
from ..problems.problem import Problem
from ..problems.units import NO_UNIT
from .events import quantity
from .shown_body import direction_of, path_along
from .stored import StoredProblem
from .stretch import Stretch, stretch_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..plots.motion_plots import Curves, Heading
    from ..plots.view import View
    from .solution import Solution

MOST_PANELS = 8  # over time
MOST_COLUMNS = 9  # in a panel: those of a rotation of R³
COMPONENT = re.compile(r"(.+?)\[(\d+)\]")
NAMES = {"t": "t", "tau": "τ"}


class Pictures:
    """Plots and films of the motion, for any stretch of a run that kept states.

    Curves need states that are dense: of ``dense=True``, which all of these use, or saved ones; saved
    ones that are too far apart are drawn as points, and the picture says so. Of a run that is too long
    for one picture its beginning is drawn, and the picture says how much.

    Of a run that was loaded nothing is unpickled for a picture. One that needs functions, for dense
    states, quantities or bodies, is a `MissingCodeError` where the problem is neither made by name nor
    given nor, with ``trust=True``, has been asked for as `Solution.problem` before.
    """

    def plot(self: Any, *names: str, span: Any = None) -> Figure:
        """Plot components of the state and quantities over time, a panel each.

        Parameters
        ----------
        *names : str
            Pieces of the state (``"gamma"``), components (``"gamma[0]"``), or quantities of the problem
            by name (``"energy"``, ``"contact-1"``, or ``"contact"`` for all of that name); by default
            all pieces.
        span : (float, float), optional
            Two times of the run, physical ones where they are known.

        Raises
        ------
        DomainError
            For names and spans that the run does not have, and for a run without states on the way.
        """
        from ..plots.motion_plots import motion_figure

        stretch = stretch_of(self, span)
        chosen = names or tuple(name for name, _ in self.about.pieces[:MOST_PANELS])
        panels = [curves_of(self, stretch, name) for name in chosen]
        label = time_label(self, stretch.time)
        return motion_figure(stretch.times, panels, label, heading_of(self, stretch))

    def plot_phase(self: Any, x: str, y: str, span: Any = None) -> Figure:
        """Plot one component or quantity against another.

        Parameters
        ----------
        x, y : str
            Components (``"gamma[0]"``) or quantities of the problem by name.
        span : (float, float), optional
            Two times of the run, physical ones where they are known.

        Raises
        ------
        DomainError
            As `plot`.
        """
        from ..plots.motion_plots import plane_figure

        stretch = stretch_of(self, span)
        found = [Named.of(self.about, name) for name in (x, y)]
        points = np.stack([each.along(self, stretch) for each in found], axis=1)
        one_piece = len({each.name.partition("[")[0] for each in found}) == 1
        labels = [f"{each.label} ({self.about.unit(each.name)})" for each in found]
        return plane_figure(points, (labels[0], labels[1]), heading_of(self, stretch), one_piece)

    def plot_sphere(
        self: Any, piece: str | None = None, span: Any = None, view: View | None = None
    ) -> Figure:
        """Plot a direction on the unit sphere: γ, the vertical in the body, unless another is named.

        Parameters
        ----------
        piece : str, optional
            A piece of three numbers, whose direction is drawn. By default the piece that lives on the
            sphere S², or else the last row of a rotation.
        span : (float, float), optional
            Two times of the run, physical ones where they are known.
        view : View, optional
            Where one looks from.

        Raises
        ------
        DomainError
            As `plot`, and for a state that has no direction in R³.
        """
        from ..plots.motion_plots import sphere_figure
        from ..plots.view import View

        direction = direction_of(self.code(), piece)
        stretch = stretch_of(self, span)
        points, view = direction.along(stretch.states), View() if view is None else view
        return sphere_figure(points, direction.name, heading_of(self, stretch), view)

    def plot_trace(self: Any, span: Any = None) -> Figure:
        """Plot the contact point of a rolling body in its plane; from n = 4 on two of its components.

        Parameters
        ----------
        span : (float, float), optional
            Two physical times of the run.

        Raises
        ------
        DomainError
            As `plot`, and for a problem that tells no contact point.
        """
        from ..plots.motion_plots import plane_figure

        stretch = stretch_of(self, span)
        path = path_along(self.code(), stretch, contact=True)
        assert path.contact is not None
        labels = f"r[0] ({path.unit})", f"r[1] ({path.unit})"
        return plane_figure(path.contact[:, :2], labels, heading_of(self, stretch), equal=True)

    def animate(
        self: Any,
        file: str | PathLike[str],
        fps: float = 25.0,
        speed: float | None = None,
        follow: bool = False,
        span: Any = None,
        view: View | None = None,
        progress: Callable[[int, int], Any] | None = None,
    ) -> Path:
        """Write a film of the motion: the body that rolls or turns, or γ on its sphere, n = 3.

        Parameters
        ----------
        file : path
            Its ending says what is written: ``.gif``; ``.html``, a page with all frames in it; ``.mp4``
            where ffmpeg is installed.
        fps : float
            Frames a second.
        speed : float, optional
            Time of the motion that passes in a second of the film. By default the fastest turn takes
            some three seconds, and the film twelve at most.
        follow : bool
            Whether the picture goes with a ball that rolls; else the whole trace is seen.
        span : (float, float), optional
            Two times of the run, physical ones where they are known.
        view : View, optional
            Where one looks from.
        progress : callable, optional
            Called with the number of the frame and how many there are.

        Returns
        -------
        Path

        Raises
        ------
        DomainError
            As `plot`, for a state that has no direction in R³, and for a file with another ending or
            one that cannot be written here.
        OutputError
            If the file cannot be written; what was there is as it was.

        Warns
        -----
        GeomintWarning
            If so much happens between two frames that they do not show how the body turns.
        """
        from .filmed import write_film

        told = partial(heading_of, self)
        return write_film(self, file, fps, speed, follow, span, view, told, progress)


def heading_of(solution: Solution, stretch: Stretch) -> Heading:
    """Return what a picture of a stretch says: system, method and interval of time."""
    from ..plots.motion_plots import Heading

    first, last = stretch.times[[0, -1]]
    way = solution.route or solution.by.name
    text = f"{solution.about.name}, {way}, {NAMES[stretch.time]} = {first:.6g} … {last:.6g}"
    unit = solution.about.unit(stretch.time)
    text += "" if unit == NO_UNIT else f" {unit}"
    if solution.status != "success":
        text += f", run {solution.status}"
    return Heading(text, stretch.note, stretch.joined)


def curves_of(solution: Solution, stretch: Stretch, name: str) -> Curves:
    """Return what a panel shows by the name of a piece, a component or a quantity.

    Raises
    ------
    DomainError
    """
    from ..plots.motion_plots import Curves, symbol

    about = solution.about
    if isinstance(name, str) and name in about.slices:
        columns = stretch.states[:, about.slices[name]]
        if columns.shape[1] > MOST_COLUMNS:
            expected = f"components, such as {name}[0]: a panel has room for {MOST_COLUMNS} numbers"
            raise DomainError("names", name, expected)
        labels = [Named.of(about, f"{name}[{i}]").label for i in range(columns.shape[1])]
        labels, label = labels if len(labels) > 1 else [symbol(name)], symbol(name)
        return Curves(label, labels, columns, about.unit(name))
    found = [Named.of(about, each) for each in _family(solution, name) or [name]]
    columns = np.stack([each.along(solution, stretch) for each in found], axis=1)
    label = found[0].label if len(found) == 1 else name
    return Curves(label, [each.label for each in found], columns, about.unit(name))


def _family(solution: Solution, name: str) -> list[str]:
    """Return the quantities NAME-1, NAME-2, … if no quantity or component has the name itself."""
    if not isinstance(name, str) or "[" in name:
        return []
    known = solution.code().diagnostics
    family = [each for each in known if re.fullmatch(re.escape(name) + r"-\d+", each)]
    return [] if name in known or len(family) > MOST_COLUMNS else family


class Named(NamedTuple):
    """A component of the state, or a quantity, by its name.

    Attributes
    ----------
    name : str
    label : str
        As a reader writes it.
    row : int or None
        Of the state.
    """

    name: str
    label: str
    row: int | None = None

    @classmethod
    def of(cls, about: Problem | StoredProblem, name: str) -> Named:
        """Return what a name means: of a file, without the code of its problem."""
        from ..plots.motion_plots import symbol

        match = COMPONENT.fullmatch(name) if isinstance(name, str) else None
        piece, i = (match[1], int(match[2])) if match else (name, 0)
        rows = dict(about.pieces).get(piece, 0) if isinstance(piece, str) else 0
        if not i < rows or (not match and rows > 1):
            return cls(name, str(name))
        index = np.unravel_index(i, about.shapes[piece]) if match else ()
        return cls(name, symbol(piece, *map(int, index)), about.slices[piece].start + i)

    def along(self, solution: Solution, stretch: Stretch) -> Array:
        """Return its values at all samples.

        Raises
        ------
        DomainError
            For a name that the problem does not have.
        """
        if self.row is not None:
            return stretch.states[:, self.row]
        problem = solution.code()
        function = quantity(problem, self.name, "name")
        return values_at(problem, function, stretch.states, stretch.own)


def time_label(solution: Solution, time: str) -> str:
    """Return the label of a time axis."""
    return f"{NAMES[time]} ({solution.about.unit(time)})"
