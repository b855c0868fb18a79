"""The points of a Poincaré section: their coordinates, pictures and files."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

from ..arguments import Array, Integers
from ..errors import GeomintWarning
from ..kernels.compiling.sameness import Compared
from ..methods.method import Method
from ..problems.at_states import values_at
from ..problems.problem import Problem
from ..problems.shown import Shown
from .events import Event, component, quantity
from .files.outputs import write_table
from .plane import Boundary, Plane, boundary, plane_of
from .reported import Reported

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SectionStatus = Literal["success", "interrupted", "incomplete", "failed"]


@dataclass(eq=False, repr=False)
class Section(Shown, Compared, Reported):
    """Points of a section, one a row, those of each motion in its order.

    Attributes
    ----------
    event : Event
    name : str
    tau : array, shape (m,)
        The problem's own times.
    t : array or None
        Physical times, where they were integrated.
    y : array, shape (m, rows)
        The states: real steps of the method, on its orbit; of the exact flow on the motion.
    directions : array, shape (m,)
        1 where the number rises, −1 where it falls.
    motions : array of int, shape (m,)
        Which of the initial states a point belongs to.
    status : str
        ``"success"``: every motion has as many points as were asked for; ``"interrupted"``;
        ``"incomplete"``: one has ended before, or crosses no more; ``"failed"``: a step of one has.
    step : float
        Of the method in the problem's own time; of an adaptive one the mean.
    steps : int
        Of all motions.
    warnings : tuple of GeomintWarning
        All that has been told, as `geomint.Solution.warnings`.
    """

    problem: Problem
    method: Method
    event: Event
    name: str
    tau: Array
    t: Array | None
    y: Array
    directions: Array
    motions: Integers
    status: SectionStatus
    step: float
    steps: int
    warnings: tuple[GeomintWarning, ...] = ()

    def __len__(self) -> int:
        return len(self.tau)

    @property
    def complete(self) -> bool:
        """Whether every motion has as many points as were asked for."""
        return self.status == "success"

    def values(self, name: str) -> Array:
        """Return a component (``"gamma[0]"``) or a quantity of the problem at all points."""
        row = component(self.problem, name, "name")
        if row is not None:
            return self.y[:, row].copy()
        return values_at(self.problem, quantity(self.problem, name, "name"), self.y, self.tau)

    @property
    def components(self) -> list[str]:
        """The names of the numbers of a state, in their order."""
        pieces = self.problem.pieces
        return [f"{piece}[{i}]" for piece, rows in pieces for i in range(rows)]

    @cached_property
    def plane(self) -> Plane | None:
        """The plane of the section where it is known, see `geomint.run.plane`."""
        return plane_of(self.problem, self.event)

    @property
    def axes(self) -> tuple[str, str]:
        """What a picture shows if nothing is named: the plane, or two components that are free."""
        if self.plane is not None:
            return self.plane.axes
        names = self.components
        pieces = [name.partition("[")[0] for name in names]
        free = [name for name in names if name != self.event.what] or names
        first = free[0]
        other = [n for n in free if pieces[names.index(n)] != pieces[names.index(first)]]
        return first, (other or free[1:] or free)[0]

    def coordinates(self, x: str | None = None, y: str | None = None) -> tuple[Array, Array]:
        """Return two numbers for every point: those named, by default those of `axes`."""
        if x is None and y is None and self.plane is not None:
            return self.plane.coordinates(self.y)
        first, second = x or self.axes[0], y or self.axes[1]
        return self.values(first), self.values(second)

    @cached_property
    def boundary(self) -> Boundary | None:
        """The least energy over the plane, where that is known, and all motions have one energy."""
        return None if self.plane is None else boundary(self.problem, self.plane, self.y)

    def plot(self, x: str | None = None, y: str | None = None) -> Figure:
        """Plot the points over two components or quantities, a colour for each motion.

        Over the section's own plane with the boundary that the energy sets, where these are known.
        """
        from ..plots.section_plot import section_figure

        own = x is None and y is None
        names = x or self.axes[0], y or self.axes[1]
        return section_figure(
            self.coordinates(x, y),
            self.motions,
            names,
            f"{self.name}, {self.event.direction}",
            self.boundary if own else None,
        )

    def save(self, path: str | PathLike[str]) -> None:
        """Write the points as CSV: motion, times, direction, and the state by its components.

        Raises
        ------
        OutputError
        """
        times = {self.problem.time: self.tau} | ({} if self.t is None else {"t": self.t})
        columns = [self.motions, *times.values(), self.directions.astype(int), *self.y.T]
        write_table(path, ["motion", *times, "direction", *self.components], columns)

    def _shown(self) -> tuple[str, dict[str, Any]]:
        facts = {
            "points": str(len(self)),
            "motions": str(len(set(self.motions.tolist()))),
            "status": self.status,
            "steps": f"{self.steps} of {self.step:.6g}",
        }
        return f"section of {self.problem.name!r} at {self.name!r} by {self.method.name}", facts
