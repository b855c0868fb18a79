"""Steps of general first-order systems: of any function ``f(t, y)``, in numpy or compiled by numba.

Fields of geomint are loops over blocks and have the kernels of `geomint.kernels.solve`. A function of
SciPy's users returns an array and may do anything, so here a stage is an array operation.
"""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

ITERATIONS = 100
OK, NOT_CONVERGED, NOT_FINITE, TOO_SHORT = 0, 1, 2, 3
REASONS = {
    NOT_CONVERGED: f"the iteration of the stages did not converge in {ITERATIONS} iterations: "
    "give a smaller step=",
    NOT_FINITE: "the function or the state is not finite",
    TOO_SHORT: "it is too short for the run: give a longer step=, or larger rtol and atol",
}


def explicit(f: Any, times: Any, y: Any, h: float, A: Any, b: Any, L: Any) -> Any:
    """Return the increments of an explicit step, evaluations and status."""
    K = np.zeros_like(L)
    for i in range(len(b)):
        K[i] = h * f(times[i], y + np.dot(A[i], K))
    L = K * b.reshape(-1, 1)
    return L, len(b), OK if np.all(np.isfinite(L)) else NOT_FINITE


def gauss(f: Any, times: Any, y: Any, h: float, mu: Any, b: Any, L: Any) -> Any:
    """Return the increments ``L_i = h b_i f(Y_i)``, from a guess of them; evaluations and status.

    The iteration ends where twice running every component's change is 0, or rounding that no longer
    falls. Twice, because components may take turns: those of a rotation do.
    """
    least, settled = np.full(y.shape, np.inf), False
    small = np.zeros(y.shape, np.bool_)
    for iteration in range(1, ITERATIONS + 1):
        Y = y + np.dot(mu, L)
        new = np.empty_like(L)
        for i in range(len(b)):
            new[i] = (h * b[i]) * f(times[i], Y[i])
        change = np.abs(new - L).sum(axis=0)
        if not np.all(np.isfinite(change)):
            return new, iteration * len(b), NOT_FINITE if iteration == 1 else NOT_CONVERGED
        size = np.abs(y) + np.abs(new).sum(axis=0)
        small = change <= 2.0**-48 * size.max()
        ended = (change == 0.0) | ((change >= least) & (small | (change <= 2.0**-40 * size)))
        least, L, again = np.minimum(least, change), new, settled
        settled = bool(np.all(ended))
        if (settled and again) or np.all(change == 0.0):
            return L, iteration * len(b), OK
    return L, ITERATIONS * len(b), OK if np.all(small) else NOT_CONVERGED


@functools.cache
def compiled(kernel: Callable[..., Any]) -> Any:
    """Return a step that numba compiles, once for every function that it is called with."""
    import numba

    return numba.njit(kernel)


def added(y: Any, carry: Any, increments: Any) -> tuple[Any, Any]:
    """Return ``y + carry`` and increments as an unevaluated sum (Knuth's TwoSum)."""
    z = carry + increments.sum(axis=0)
    s = y + z
    shadow = s - y
    return s, (y - (s - shadow)) + (z - shadow)
