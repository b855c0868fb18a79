r"""How fast a state moves, its pieces made comparable: a step density for motions of any kind.

With v² = ε + Σ_k w_k \|ẏ_k\|² over the pieces of the state, σ = v^(−5/8) is the clock ``"speed"`` of
`geomint.time_transformed`. It depends on the state alone and is the same for the reversed motion.

The exponent −1 gives steps of equal arc length. But what good steps are along a motion that turns
sharply here and runs straight there is nearer to −2/3: the time r of eccentric anomaly on an ellipse
of Kepler's, where acceleration is r⁻², and N = \|A⁻¹x\|² on an ellipsoid, where it is N^(−3/2), in
which the coordinates are quotients of theta functions. Two square roots of square roots make −5/8.
"""

from typing import Any

import numpy as np

from ..arguments import Array
from ..kernels.compiling.recorded import helper
from ..kernels.numbers.arithmetic import sqrt
from .evaluate import derivative
from .problem import Problem
from .spaces.repair import length
from .time_scale import characteristic_time

# Of v² at y0. Where the motion nearly rests steps end at 2^(12.5) times those at y0.
SLOWEST = 2.0**-40


@helper
def pace(weights: Any, sizes: tuple[int, ...], rates: Any) -> Any:
    """Return v^(−5/8), the weights of the pieces and ε being given."""
    squared = 0.0 * rates[0] + weights[len(sizes)]
    first = 0
    for k in range(len(sizes)):
        piece = rates[first] * rates[first]
        for i in range(first + 1, first + sizes[k]):
            piece += rates[i] * rates[i]
        squared += weights[k] * piece
        first += sizes[k]
    fourth = sqrt(sqrt(squared))
    return 1.0 / (fourth * sqrt(sqrt(fourth)))


def pace_parameters(problem: Problem, y0: Array) -> Array:
    """Return the weights of the pieces, and ε: v = 1 at y0.

    A piece is measured by its size there, or by what its rate makes of it within the characteristic
    time, if that is more: pieces may begin at rest.
    """
    rates = derivative(problem, y0)
    time = characteristic_time(problem, y0)
    sizes, speeds = [], []
    for rows in problem.slices.values():
        speed = length(rates[rows])
        sizes.append(max(length(y0[rows]), time * speed))
        speeds.append(speed)
    shares = [
        (speed / size) if size > 0.0 else 0.0 for speed, size in zip(speeds, sizes, strict=True)
    ]
    whole = float(np.linalg.norm(shares))
    if whole == 0.0:  # an equilibrium
        return np.array([*(0.0 for _ in sizes), 1.0])
    scale = np.sqrt(1.0 - SLOWEST) / whole
    weights = [(scale / size) ** 2 if size > 0.0 else 0.0 for size in sizes]
    return np.array([*weights, SLOWEST])
