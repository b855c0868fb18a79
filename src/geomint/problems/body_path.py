"""Where a body is along a motion: its attitude, and where it touches the ground."""

from dataclasses import dataclass

from ..arguments import Array


@dataclass(frozen=True)
class BodyPath:
    """Attitude and contact point along samples of a motion: what `Problem.make_path` returns.

    Attributes
    ----------
    attitude : array, shape (N, n, n)
        The rotations from body to space; the last axis of space points upwards.
    contact : array, shape (N, n−1), or None
        The contact point in the plane; None of a body that turns about a fixed point.
    radius : float
        Of the ball around the body, in the unit of the contact point.
    unit : str
        Of the contact point, for labels.
    """

    attitude: Array
    contact: Array | None = None
    radius: float = 1.0
    unit: str = "dimensionless"
