"""What is known of a reference solution, and its place on disk.

A reference judges errors that are `MARGIN` times what it is known to, or larger; none below.
"""

from __future__ import annotations

import hashlib
import json
import math
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import UnknownReferenceError
from ..kernels.compiling.private import private_folder
from ..problems.problem import Problem
from .confirmation import Confirmation

MARGIN = 10.0  # how far below an error a reference must be known to judge it
SMALL = 1e-5  # a reference that cannot judge even errors of this size is of no use to a comparison
RESOLUTION = 2.0**-52  # errors below this are one to float64


@dataclass(frozen=True)
class Reference:
    """A state at the end of a run, to more digits than it is given in.

    Attributes
    ----------
    own_end : float
        End in the problem's own time.
    physical_end : float or None
        Physical time there, for a problem in τ with a clock.
    y : array
        The state, rounded to float64.
    error : float
        Its own estimate: the largest difference, relative to its piece, of the two steps; of the
        exact flow the estimated error of its phases.
    steps : tuple of float
        The two steps; none of the exact flow.
    method : str
    confirmation : Confirmation or None
        What a second method of another family says.
    """

    own_end: float
    physical_end: float | None
    y: Array
    error: float
    steps: tuple[float, ...]
    method: str
    confirmation: Confirmation | None = None

    @property
    def agrees(self) -> bool:
        """Whether a second method confirms this one, as accurately as that is."""
        second = self.confirmation
        return second is not None and second.agrees(self.error)

    @property
    def known(self) -> float:
        """To what the state is known: its own estimate, if a second method does not object.

        If it does, and at the end itself, as far as the true state can be away if the second is
        right. Infinity if there is no second, or the two part before the end, or a number is NaN.
        """
        second = self.confirmation
        if self.agrees:
            known = self.error
        elif second is not None and second.own_end == self.own_end:
            known = float(np.maximum(self.error, second.difference + second.accuracy))  # or NaN
        else:
            known = math.inf
        return known if known == known else math.inf

    def for_errors(self, judges: float) -> Reference:
        """Return the reference itself if it is good enough to judge errors of that size.

        Raises
        ------
        UnknownReferenceError
            If it is not known to a tenth of that.
        """
        known = self.known
        if MARGIN * known <= judges:
            return self
        raise UnknownReferenceError(
            self._doubt(),
            known,
            judges,
            f"one that is known to {judges / MARGIN:.2g}; a shorter run may have it",
        )

    def _doubt(self) -> str:
        """Return in words what is known, and why no more."""
        if not self.error < math.inf:
            return f"the {self.method} says nothing of its own error"
        own = f"the {self.method} by its own estimate errs by {self.error:.2g} at {self.own_end:g}"
        second = self.confirmation
        if self.agrees or second is None:
            return own
        if second.accuracy == math.inf:
            return f"{own}, and no second method gets anywhere to confirm it"
        return (
            f"{own}, but at {second.own_end:g} it differs by {second.difference:.2g} from "
            f"{second.method}, known to {second.accuracy:.2g}"
        )

    def as_json(self) -> dict[str, Any]:
        """Return the numbers for reports."""
        second = self.confirmation
        return {
            "method": self.method,
            "own_end": self.own_end,
            "physical_end": self.physical_end,
            "state": self.y.tolist(),
            "error_estimate": self.error,
            "steps": list(self.steps),
            "confirmation": second and {**asdict(second), "agrees": self.agrees},
        }

    def store(self, name: str) -> None:
        """Write everything to disk; a folder that cannot be written costs time, nothing else."""
        data = {**asdict(self), "y": list(self.y)}
        with suppress(OSError):
            private_folder("references").write(name, json.dumps(data).encode())


def stored(name: str) -> Reference | None:
    """Return the reference of a name, or None; also of a file that is damaged."""
    try:
        data = json.loads(private_folder("references").read(name) or b"")
        second = data.pop("confirmation")
        data.update(y=np.array(data["y"]), steps=tuple(data["steps"]))
        return Reference(**data, confirmation=second and Confirmation(**second))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None


def name_of(problem: Problem, y0: Array, end: float) -> str:
    """Return the name of a reference's file: of all that it depends on, geomint's sources included."""
    from ..kernels.compiling.digest import source_stamp  # what they got wrong must not stay

    known = f"{source_stamp()} {problem.pieces} {problem.work} {problem.time}"
    digest = hashlib.sha256(known.encode())
    for f in (problem.field, problem.clock):
        digest.update(f.fingerprint.encode() if f is not None else b"-")
    for values in (problem.params, y0, np.array([end])):
        digest.update(np.ascontiguousarray(values).tobytes())
    return f"{digest.hexdigest()[:32]}.json"
