"""A second opinion on a reference solution: another method, of another family.

The second is the explicit DOP853 in double precision, over the whole run: for short runs that of
SciPy on the field as it stands in Python, so that no kernel and no compiled code is shared with what
is judged; for long ones `dop853-adaptive`, compiled, in which nothing is of a Gauss method.

Its accuracy is measured: it runs twice, at tolerances that differ by a factor of ten, and the second
time from a state and parameters that are off by 2⁻⁴⁸, sixteen roundings. Three times the difference of
the two results bounds the error of the tighter one: that of its steps is some ninth of the
difference, that by roundings about as large. Where a long or chaotic run leaves nothing of it, a part
of the run is looked at.
"""

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arguments import Array
from ..errors import FormError, GeomintError
from ..methods import Adaptive, RungeKutta
from ..problems.deviation import pieces_of, relative_error, shifted, sizes_of
from ..problems.evaluate import derivative, value
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time
from ..run.solve import solve

TIGHT = {"plain": 1e-13, "compiled": 1e-14}  # ours sums with compensation, SciPy does not
LOOSER = 10.0  # tolerance of the other run
SAFETY = 3.0
SHIFT = 2.0**-48
LEAST = 2.0**-43  # 1.1e-13: no accuracy is said to be better, two short runs may err alike
USEFUL, POOR = 1e-6, 1e-3  # from the first on a part is looked at; beyond the other, no use
PARTS = 8  # how often that is made shorter,
SHORTER = 4.0  # by this factor
EVALUATIONS = 100.0  # that DOP853 takes for a characteristic time at those tolerances, about
PLAIN = 100_000  # numbers of derivatives up to which Python does it, in some seconds at most
MOST_STEPS = 2_000_000  # of the compiled one: some seconds


@dataclass(frozen=True)
class Confirmation:
    """What a second method says of a reference.

    Attributes
    ----------
    method : str
    own_end : float
        Where the two were compared, in the problem's own time: at the end, or before.
    accuracy : float
        What the second reaches there, by its own estimate, relative to each piece of the state.
    difference : float
        Between the two there; of a piece of the state, or of physical time beside τ.
    """

    method: str
    own_end: float
    accuracy: float
    difference: float

    def agrees(self, error: float) -> bool:
        """Tell whether this confirms a first method that errs by so much: they differ by no more."""
        return self.accuracy <= POOR and self.difference <= self.accuracy + error


class _TooLongError(Exception):
    """A run in Python that takes more evaluations than were allowed."""


def confirm(
    problem: Problem, y0: Array, own_end: float, first: Callable[[float], npt.NDArray[Any]]
) -> Confirmation:
    """Compare a reference with a second method.

    Parameters
    ----------
    first : callable
        The reference at any time of the problem's own up to `own_end`: the flat state and, where
        the problem has a clock, physical time.

    Returns
    -------
    Confirmation
        Of infinite accuracy and difference where no second method gets anywhere.

    Raises
    ------
    FormError
        If the problem has no field.
    """
    if problem.field is None:
        raise FormError(f"problem {problem.name!r} has no field: no reference can be confirmed")
    problem = dataclasses.replace(problem, admit=None, space=None)  # states are as they are
    turns = abs(own_end) / characteristic_time(problem, y0, direction=own_end)
    end = own_end * min(1.0, 12.0 * MOST_STEPS / max(1.0, EVALUATIONS * turns))
    found = Confirmation("DOP853", end, math.inf, math.inf)
    for _ in range(PARTS):
        try:
            method, second, accuracy = _second(problem, y0, end, turns * end / own_end)
        except GeomintError:
            end /= SHORTER
            continue
        right = named(problem, np.asarray(first(end), dtype=np.float64))
        here = Confirmation(method, end, accuracy, relative_error(second, right))
        if accuracy <= USEFUL:
            return here
        if not found.accuracy <= POOR:
            found = here
        end /= SHORTER
    return found


def _second(
    problem: Problem, y0: Array, end: float, turns: float
) -> tuple[str, dict[str, Array], float]:
    """Return the name of the second method, its result, and how accurate that is."""
    ways = [("dop853-adaptive", _compiled, TIGHT["compiled"])]
    if 2.0 * EVALUATIONS * max(turns, 1.0) * problem.rows <= PLAIN:
        ways.insert(0, ("DOP853 of SciPy, nothing compiled", _plain, TIGHT["plain"]))
    other = shifted(problem, y0, 0, SHIFT)
    for name, run, tight in ways:
        try:
            best = named(problem, run(problem, y0, end, tight))
            near = named(problem, run(*other, end, LOOSER * tight))
        except _TooLongError:
            continue
        return name, best, max(SAFETY * relative_error(near, best), LEAST)
    raise AssertionError("the compiled one is never too long")


def named(problem: Problem, y: npt.NDArray[Any]) -> dict[str, Array]:
    """Return the pieces of a state by name, and physical time, its last number beside a clock."""
    pieces = pieces_of(problem, y)
    return pieces if problem.clock is None else {**pieces, "t": y[-1:]}


def _compiled(problem: Problem, y0: Array, end: float, tolerance: float) -> Array:
    """Return the end of a run of `dop853-adaptive`."""
    least = float(np.min(sizes_of(problem, y0)))
    method = Adaptive(
        RungeKutta("dop853"), rtol=tolerance, atol=tolerance * least, max_steps=MOST_STEPS
    )
    time = "tau_end" if problem.time == "tau" else "t_end"
    clock = problem.clock is not None
    run: dict[str, Any] = {time: end, "method": method, "clock": clock, "progress": False}
    solution = solve(problem, y0, **run)
    if solution.status != "success":
        raise KeyboardInterrupt
    return np.append(solution.y[-1], solution.t[-1]) if clock else solution.y[-1]


@np.errstate(all="ignore")
def _plain(problem: Problem, y0: Array, end: float, tolerance: float) -> Array:
    """Return the end of a run of SciPy's DOP853, in units of the end and of the pieces."""
    from scipy.integrate import DOP853

    method: Any = DOP853
    sizes, rows, left = sizes_of(problem, y0), problem.rows, PLAIN // problem.rows
    start = y0 / sizes
    if problem.clock is not None:
        rate = abs(value(problem, problem.clock, y0)) or 1.0
        sizes, start = np.append(sizes, rate * abs(end)), np.append(start, 0.0)

    def rates(s: float, z: Array) -> Array:
        nonlocal left
        left -= 1
        if left < 0:
            raise _TooLongError
        y, t = (sizes * z)[:rows], s * end
        slope = derivative(problem, y, t)
        if problem.clock is not None:
            slope = np.append(slope, value(problem, problem.clock, y, t))
        return slope * (end / sizes)

    solver = method(rates, 0.0, start, 1.0, rtol=tolerance, atol=tolerance)
    while solver.status == "running":
        message = solver.step()
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            raise GeomintError(f"SciPy's DOP853: {message or 'numbers that are not finite'}")
    return sizes * solver.y
