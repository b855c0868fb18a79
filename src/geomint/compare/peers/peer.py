"""What a peer is: a package that integrates a problem to an end, at a tolerance or a step."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import NamedTuple

import numpy as np

from ...arguments import Array
from ...errors import GeomintError
from ...problems.deviation import sizes_of
from ...problems.problem import Problem


class PeerError(GeomintError):
    """A peer's run that did not get to its end; never leaves a comparison."""


class Motion(NamedTuple):
    """What is integrated: from time 0 to an end, in the problem's own time."""

    problem: Problem
    y0: Array
    end: float

    @property
    def least(self) -> float:
        """The size of the smallest piece: what absolute tolerances are relative to."""
        return float(np.min(sizes_of(self.problem, self.y0)))


class End(NamedTuple):
    """Where a run came to, and in how many steps and evaluations, as far as the peer tells."""

    y: Array
    steps: int | None
    evaluations: int | None = None


class Ready(NamedTuple):
    """A run that has been compiled: it begins anew whenever it is called."""

    order: int
    run: Callable[[], End]


@dataclass(frozen=True)
class Peer:
    """An integrator of another package.

    Attributes
    ----------
    name : str
    package : str
        The distribution that has it.
    start : callable
        ``start(motion)`` returns what makes a run `Ready` for a tolerance or, if `fixed`, a step. It
        raises `FormError` for a problem that the peer cannot state.
    fixed : bool
        Whether it runs at fixed steps.
    """

    name: str
    package: str
    start: Callable[[Motion], Callable[[float], Ready]]
    fixed: bool = False

    @property
    def version(self) -> str | None:
        """The version of the package; None where it is not installed."""
        try:
            return version(self.package)
        except PackageNotFoundError:
            return None
