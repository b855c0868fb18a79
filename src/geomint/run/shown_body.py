"""What pictures show of a body: a direction in it on the sphere, its attitude, its contact point."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Array
from ..errors import DomainError, nearest
from ..problems.body_path import BodyPath
from ..problems.problem import Problem
from ..problems.spaces.rotations import Rotations
from ..problems.spaces.space import Space
from ..problems.spaces.stiefel import Orthonormal
from ..problems.spaces.tangent_bundle import TangentBundle
from .stretch import Stretch


@dataclass(frozen=True)
class Direction:
    """A direction in R³ that the state tells.

    Attributes
    ----------
    name : str
    rows : slice
        Of the state.
    """

    name: str
    rows: slice

    def along(self, states: Array) -> Array:
        """Return the unit vectors at states, one a row.

        Raises
        ------
        DomainError
            Where the vector is zero.
        """
        vectors = states[:, self.rows]
        sizes = np.sqrt((vectors * vectors).sum(axis=1, keepdims=True))
        if not sizes.all():
            raise DomainError("piece", self.name, "a vector that is nowhere zero along the motion")
        return vectors / sizes


def direction_of(problem: Problem, piece: str | None = None) -> Direction:
    """Return the direction that is named, or the one that lives on S² or is the vertical of a body.

    Raises
    ------
    DomainError
        If there is none.
    """
    slices = problem.slices
    if piece is not None:
        three = [name for name, rows in problem.pieces if rows == 3]
        if not (isinstance(piece, str) and piece in three):
            hint = nearest(str(piece), three)
            raise DomainError("piece", piece, f"a piece of three numbers, one of {three}.{hint}")
        return Direction(piece, slices[piece])
    for space in _parts(problem.space):
        (name, rows) = space.pieces[0]
        if isinstance(space, Orthonormal) and rows == 3:
            return Direction(name, slices[name])
    frame = _frame(problem)
    if frame is not None:
        return Direction("gamma", slice(frame.stop - 3, frame.stop))
    expected = (
        f"a state with a point of the sphere S² or a rotation of R³; {problem.name!r} has "
        f"{', '.join(f'{name} ({rows})' for name, rows in problem.pieces)}. The direction of any three "
        "numbers is drawn if they are named, piece=…; other states by plot_phase"
    )
    raise DomainError("piece", piece, expected)


def _parts(space: Space | None) -> list[Space]:
    """Return the factors of a space, of bundles the base."""
    factors = () if space is None else space.factors
    return [f.base if isinstance(f, TangentBundle) else f for f in factors]


def has_path(problem: Problem) -> bool:
    """Tell whether the attitude of a body is known along a motion."""
    return problem.make_path is not None or _frame(problem) is not None


def _frame(problem: Problem) -> slice | None:
    """Return the rows of the rotation of R³ that the state has."""
    frames = [f for f in _parts(problem.space) if isinstance(f, Rotations) and f.n == 3]
    return problem.slices[frames[0].name] if frames else None


def path_along(problem: Problem, stretch: Stretch, contact: bool = False) -> BodyPath:
    """Return attitude and contact point along a stretch.

    Raises
    ------
    DomainError
        If the problem does not tell them, or the stretch has no physical times.
    """
    frame = _frame(problem)
    if problem.make_path is None and (frame is None or contact):
        what = "contact point" if contact else "attitude"
        has = "has a fixed point" if frame is not None else "tells neither"
        expected = (
            f"a problem that tells the {what} (make_path), such as those of a rolling ball; "
            f"{problem.name!r} {has}"
        )
        raise DomainError("problem", problem.name, expected)
    if problem.make_path is None:
        assert frame is not None
        return BodyPath(stretch.states[:, frame].reshape(-1, 3, 3))
    if stretch.time != "t":
        expected = "clock=True in solve: attitude and contact point need physical time"
        raise DomainError("clock", False, expected)
    path = problem.make_path(stretch.times, stretch.states)
    if contact and (path.contact is None or path.contact.shape[1] < 2):
        expected = f"a contact point in a plane, n ≥ 3; {problem.name!r} has none"
        raise DomainError("problem", problem.name, expected)
    return path
