"""What a correspondence is: a map of states, and the rate at which the other system's time runs."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array

SPACING = 2.0**-10  # of the differences of order 8: their error is below 1e-13 for smooth maps
# Weights of f(x + kh) − f(x − kh), k = 1 … 4, in the derivative of order 8.
WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)


@dataclass(frozen=True)
class Correspondence:
    """A map Φ that takes motions of one problem to motions of another, in its time.

    If y(t) is a motion of the source, z = Φ(y(t)) is one of the target in the time s(t),
    ds/dt = rate(y); t and s are the problems' own times.

    Parameters
    ----------
    name : str
    source, target : Problem
    forward, backward : callable
        Φ and its inverse on the states that correspond, flat states.
    rate : recorded ``f(params, t, y, work) -> number``
        ds/dt, of the parameters and states of `source`.
    """

    name: str
    source: gi.Problem
    target: gi.Problem
    forward: Callable[[Array], Array]
    backward: Callable[[Array], Array]
    rate: Any

    def clocked(self) -> gi.Problem:
        """Return the source with s as one more piece of its state, called ``s``.

        Integrate it, and ``forward(state[:-1])`` is the target's state at the time ``state[-1]``.
        """
        return gi.with_quadrature(self.source, "s", self.rate)

    def rate_at(self, y: Any) -> float:
        """Return ds/dt at a state of the source."""
        return gi.value(self.source, self.rate, self.source.canonical(y))

    def defect(self, y: Any) -> float:
        """Return how far the field of the source, carried over, is from that of the target.

        The largest entry of DΦ(y) ẏ − rate(y) z′(Φ(y)), relative to the largest of z′; DΦ ẏ by
        differences of order 8, so that 1e-11 is zero.
        """
        state = self.source.canonical(y)
        velocity = gi.derivative(self.source, state)
        h = SPACING * float(np.max(np.abs(state))) / max(float(np.max(np.abs(velocity))), 1e-300)
        carried = sum(
            w * (self.forward(state + k * h * velocity) - self.forward(state - k * h * velocity))
            for k, w in enumerate(WEIGHTS, 1)
        )
        expected = gi.derivative(self.target, self.forward(state))
        difference = carried / h - self.rate_at(state) * expected
        return float(np.max(np.abs(difference)) / np.max(np.abs(self.rate_at(state) * expected)))
