r"""Methods of geomint for SciPy's `solve_ivp`, which takes any function ``f(t, y)``.

    >>> import geomint as gi
    >>> from scipy.integrate import solve_ivp
    >>> sol = solve_ivp(lambda t, y: [y[1], -y[0]], (0, 100), [1, 0], gi.scipy.GAUSS4, step=0.5)
    >>> bool(abs(sol.y[0] ** 2 + sol.y[1] ** 2 - 1).max() < 1e-14)
    True

All options of `solve_ivp` work: ``t_eval``, ``dense_output``, ``events``, ``args``, ``vectorized``.
States between steps are those of a shorter step from the step before, so they are as accurate as the
steps are, and each costs a step. Steps are summed with compensation, as all of geomint's.

The step is the same from beginning to end: a symplectic or symmetric method whose step follows the
state is neither. Options of the methods:

step, first_step : float, optional
    The step, > 0, in the unit of t: two names of one option. The last step is shorter where the end
    is not a whole number of steps away.
rtol, atol : float, or array of shape (n,) for `atol`
    Without a step: the largest error of one step, ``atol + rtol |y|`` in the root mean square over
    components, as for SciPy's own methods, with their defaults 1e-3 and 1e-6. The step is chosen from
    it once, where a pilot run of at most 100 steps of SciPy's ``DOP853`` moves fastest, and at the
    beginning. Where a motion gets faster later, so that a step errs by more than twelve times that, a
    warning says so. The end is a whole number of steps away.
max_step : float
    No step is longer.

An ``f`` compiled by ``numba.njit``, which returns an array, is called from a compiled step: compiled
once for each ``f``, in some seconds. With ``args``, SciPy hides that it is compiled.

What fails is told as SciPy does: ``success`` is False, ``status`` −1, and ``message`` has time, step
and reason. For a field written as a `geomint.field`, `geomint.solve` takes the same steps, compiled.
"""

from .families import DOP853, GAUSS1, GAUSS2, GAUSS4, GAUSS6, GAUSS8, RK4
from .solver import FixedStep

__all__ = ["DOP853", "GAUSS1", "GAUSS2", "GAUSS4", "GAUSS6", "GAUSS8", "RK4", "FixedStep"]
