"""Whether a problem moves over its base, `Measure.base`, as is declared."""

from collections.abc import Iterator

import numpy as np

from ..arguments import Array
from ..kernels.compiling.recorded import Recorded
from .declaration import check_problem, check_watched
from .evaluate import derivative, value
from .problem import Problem

AGREES = {"field": 1e-10, "action": 1e-6}  # of the rates: those of actions are difference quotients
AWAY, LATER = 0.1, 0.7  # to a second state, of each piece, and to a second time
TINY = 1e-290


@np.errstate(all="ignore")
def off_base(problem: Problem, base: Problem, y: Array, t: float) -> str:
    """Return in words what is not as it is over a base; an empty string if all is.

    The first rows of the state are to move as the base does, whatever the fibre, the fibre by rates
    that are affine in it, and the densities are to be the same up to a factor. Looked at in a state
    and near it, now and later, with three fibres each.

    Raises
    ------
    DeclarationError
        If functions of the base do not fit what it declares.
    """
    assert problem.measure is not None
    assert base.measure is not None
    states, rows = list(_near(problem, base, y, t)), base.rows
    forms = [form for form in AGREES if form in problem.forms and form in base.forms]
    if not forms:
        return "they have neither a field nor an action in common"
    for form in forms:
        check_problem(base, y[:rows].copy(), form)
        check_watched(base, y[:rows].copy(), {"measure": base.measure})
        if says := _moves_otherwise(problem, base, states, form):
            return says

    def logarithm(of: Problem, density: Recorded, z: Array, s: float) -> float:
        return value(of, density, z[: of.rows].copy(), s)

    here, there = problem.measure.log_density, base.measure.log_density
    ratios = [logarithm(problem, here, *z) - logarithm(base, there, *z) for z in states]
    same = np.ptp(ratios) <= AGREES["field"] * max(1.0, float(np.max(np.abs(ratios))))
    return "" if same else "the densities differ by more than a factor"


def stretches_fibre(problem: Problem, base: Problem, y: Array) -> float:
    """Return the trace of the fibre's rates in the fibre, which is 0 where its measure is kept."""
    rows, at = range(base.rows, problem.rows), derivative(problem, y)
    return float(sum(derivative(problem, y + np.eye(problem.rows)[i])[i] - at[i] for i in rows))


def _near(problem: Problem, base: Problem, y: Array, t: float) -> Iterator[tuple[Array, float]]:
    """Yield states and times: here and near, with three fibres each in equal distances."""
    shape, near = np.cos(1.0 + np.arange(problem.rows)), y.copy()
    for rows in base.slices.values():
        near[rows] += AWAY * (float(np.abs(y[rows]).max()) or 1.0) * shape[rows]
    for z, s in ((y, t), (near, t + LATER)):
        for times in range(3):
            other = z.copy()
            other[base.rows :] += 0.25 * times * shape[base.rows :]
            yield other, s


def _moves_otherwise(
    problem: Problem, base: Problem, states: list[tuple[Array, float]], form: str
) -> str:
    rows = base.rows

    def same(found: Array, right: Array) -> bool:
        off, size = np.abs(found - right), max(np.abs(found).max(), np.abs(right).max())
        return bool((off <= AGREES[form] * size + TINY).all() or not np.isfinite(right).all())

    rates = [derivative(problem, z, s, form) for z, s in states]
    for i in (0, 3):
        z, s = states[i]
        wanted = derivative(base, z[:rows].copy(), s, form)
        if not same(rates[i][:rows], wanted):
            return "the first rows of the state do not move as the base does"
        if not (same(rates[i + 1][:rows], wanted) and same(rates[i + 2][:rows], wanted)):
            return "the first rows of the state do not move by themselves"
        if not same(rates[i][rows:] + rates[i + 2][rows:], 2.0 * rates[i + 1][rows:]):
            return "the rates of the fibre are not affine in it"
    return ""
