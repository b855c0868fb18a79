"""Events that have happened, of one name, along a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arguments import Array
from ..kernels.compiling.sameness import Compared


@dataclass(frozen=True, eq=False)
class Met(Compared):
    """The events of one name along a run, in its order.

    Attributes
    ----------
    tau : array, shape (m,)
        The problem's own times (equal to `t` unless that is τ).
    t : array or None
        Physical times, where they were integrated.
    y : array, shape (m, rows)
        The states: real steps of the method, on its orbit; of the exact flow on the motion.
    directions : array, shape (m,)
        1 where the number rises, −1 where it falls.
    """

    tau: Array
    t: Array | None
    y: Array
    directions: Array

    def __len__(self) -> int:
        return len(self.tau)

    @property
    def table(self) -> Array:
        """All of it, an event a row: own time, direction, physical time if it is known, state."""
        times = () if self.t is None else (self.t,)
        return np.column_stack((self.tau, self.directions, *times, self.y))

    @classmethod
    def of_table(cls, table: Array, timed: bool) -> Met:
        """Return the events of a `table`, with physical times or without."""
        tau, directions, *rest = table[:, : 2 + timed].T
        y = np.ascontiguousarray(table[:, 2 + timed :])
        return cls(tau.copy(), rest[0].copy() if rest else None, y, directions.copy())
