"""Reference solutions better than double precision.

The field's own source, compiled for double-double numbers (about 32 digits), is integrated by a
Gauss method of high order at two steps; their difference bounds the error. A second method of
another family confirms it (`geomint.compare.confirmation`), as two steps of one method may err
alike. References are kept on disk under a hash of everything that they depend on.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arguments import Array
from ..errors import ConvergenceError, FormError, NonFiniteError
from ..kernels.compiling.number_types import EXTENDED
from ..kernels.numbers.blocks import filled_block, scalar_block, section
from ..kernels.numbers.double_double import DoubleDoubleBlock, lane_rows
from ..kernels.numbers.lanes import LANES
from ..kernels.solve.advance import bound_stepper
from ..kernels.solve.gauss import gauss_coefficients, gauss_memory, gauss_stepper, gauss_work
from ..kernels.solve.status import NOT_CONVERGED, OK
from ..methods.gauss import Gauss, lane_positions, spread_columns, spread_vector
from ..methods.posed import Posed
from ..problems.declaration import check_problem
from ..problems.deviation import relative_error
from ..problems.problem import Problem
from ..tableaux import gauss_legendre
from .confirmation import confirm, named
from .reference_record import RESOLUTION, Reference, name_of, stored

STAGES = 12
METHOD = f"gauss-{STAGES}, double-double"
MAX_ITERATIONS = 200
TOLERANCE = 2.0**-110
TARGET = 1e-19  # relative agreement of the two steps, beyond what double precision can show
MAX_HALVINGS = 4
MAX_SHORTER = 10  # halvings of a first step that is too long for the motion


def reference_solution(
    problem: Problem, y0: Array, own_end: float, *, judges: float = RESOLUTION
) -> Reference:
    """Integrate `problem` from `y0` at 0 to `own_end` in double-double arithmetic.

    The result is confirmed by a second method (`geomint.compare.confirmation`) and kept on disk
    with what that says.

    Parameters
    ----------
    judges : float
        The smallest error, relative, that it will be used to judge. Default: 2⁻⁵², the smallest
        that float64 can show.

    Raises
    ------
    FormError
        If the problem has no field.
    DeclarationError
        If a function of the problem does not fit what it declares.
    ConvergenceError, NonFiniteError
        If the solution cannot be followed.
    UnknownReferenceError
        If the two steps, or the second method, leave more than a tenth of `judges` uncertain.
    """
    if problem.field is None:
        raise FormError(f"problem {problem.name!r} has no field: no reference can be computed")
    check_problem(problem, y0, "field", problem.clock is not None)
    name = name_of(problem, y0, own_end)
    found = stored(name)
    if found is None:
        found = _computed(problem, y0, own_end)
        found.store(name)
    return found.for_errors(judges)


def _computed(problem: Problem, y0: Array, own_end: float) -> Reference:
    h, error, fine = _agreed(problem, y0, own_end)

    def first(end: float) -> npt.NDArray[Any]:
        return fine if end == own_end else integrate_extended(problem, y0, end, h)

    return Reference(
        own_end=own_end,
        physical_end=float(fine[-1]) if problem.clock is not None else None,
        y=fine[: problem.rows].astype(np.float64),
        error=error,
        steps=(2.0 * h, h),
        method=METHOD,
        confirmation=confirm(problem, y0, own_end, first),
    )


def _agreed(problem: Problem, y0: Array, own_end: float) -> tuple[float, float, npt.NDArray[Any]]:
    """Return a step, how far its end and that of twice the step are apart, and its end.

    A motion may become so much faster than it begins that the first steps are too long for it.
    """
    h = 0.75 * Gauss(8).default_step(problem, y0, own_end)
    ends: list[npt.NDArray[Any]] = []
    error, shorter = math.inf, 0
    while error > TARGET and len(ends) <= MAX_HALVINGS:
        try:
            ends.append(integrate_extended(problem, y0, own_end, h))
        except ConvergenceError:
            if shorter == MAX_SHORTER:
                raise
            ends, shorter = [], shorter + 1
        if len(ends) > 1:
            error = relative_error(named(problem, ends[-2]), named(problem, ends[-1]))
        h *= 0.5
    return 2.0 * h, error, ends[-1]


def integrate_extended(problem: Problem, y0: Array, end: float, h: float) -> npt.NDArray[Any]:
    """Return the state (and clock) at `end`, in extended precision."""
    count = int(np.ceil(abs(end) / h))
    # A step of few bits: count · step is exact, and one more step makes up the rest.
    step = _of_few_bits(end / count)
    steps = min(count, int(abs(end) / abs(step)))
    rest = end - steps * step
    state = _advance(problem, y0, np.zeros_like(y0), 0.0, 0.0, step, steps)
    if rest != 0.0:
        hi, lo = state
        rows = problem.rows
        t, t_low = (hi[rows], lo[rows]) if problem.clock is not None else (0.0, 0.0)
        state = _advance(problem, hi[:rows], lo[:rows], t, t_low, rest, 1, steps * step)
    return state[0].astype(np.longdouble) + state[1]


def _of_few_bits(x: float) -> float:
    """Return `x` rounded to 24 bits, whatever its size."""
    fraction, exponent = math.frexp(x)
    return math.ldexp(float(np.float32(fraction)), exponent)


def _advance(
    problem: Problem,
    hi: Array,
    lo: Array,
    clock_hi: float,
    clock_lo: float,
    h: float,
    steps: int,
    t0: float = 0.0,
) -> tuple[Array, Array]:
    with_clock = problem.clock is not None
    posed, groups = Posed(problem, hi, t0, with_clock), 2
    field, rows, work = posed.field, posed.rows, problem.work
    memory = _blank(sum(gauss_memory(rows, groups)))
    memory.data[0 : 2 * rows : 2] = np.append(hi, clock_hi) if with_clock else hi
    memory.data[1 : 2 * rows : 2] = np.append(lo, clock_lo) if with_clock else lo
    stepper = bound_stepper(gauss_stepper(groups, 0), (field,))
    advance = stepper.call(number_type=EXTENDED)
    status, done, iterations, residual = advance(
        functions=(field.entry(number_type=EXTENDED),),
        params=filled_block(problem.params),
        coefficients=_coefficients(rows, posed.pieces, groups),
        fractions=filled_block(1.0, 0.0),
        memory=memory,
        work=_blank(sum(gauss_work(rows, groups, 8 * work))),
        rows=rows,
        t0=t0,
        h=h,
        first=0,
        count=steps,
        every=steps + 1,
        out=_blank(0),
        ranks=scalar_block(0),
    )
    if status != OK:
        kind_of_error = ConvergenceError if status == NOT_CONVERGED else NonFiniteError
        raise kind_of_error(t0 + done * h, done, residual, iterations, "in the reference solution")
    # The carry is part of the state: add it before rounding.
    values = memory.data[: 4 * rows]
    y, y_low = values[0 : 2 * rows : 2], values[1 : 2 * rows : 2]
    return y.copy(), y_low + values[2 * rows :: 2]


def _blank(size: int) -> DoubleDoubleBlock:
    return DoubleDoubleBlock(scalar_block(2 * size).data)


def _coefficients(rows: int, pieces: list[float], groups: int) -> DoubleDoubleBlock:
    """Return the coefficient block of `geomint.kernels.solve.gauss` in double-double numbers."""
    table, width = gauss_legendre(STAGES), LANES * groups
    at = lane_positions(STAGES, width)
    layout = gauss_coefficients(rows, groups, 1)
    block = _blank(sum(layout))
    predictor = spread_columns(table.predictor(1.0), at, width)
    lanes = {
        **{name: [spread_vector(x, at, width) for x in table.split(name)] for name in ("c", "b")},
        "mu": [spread_columns(x, at, width) for x in table.split("mu")],
        "predictors": [predictor, np.zeros_like(predictor)],
    }
    given = {
        "rows": rows,
        "cap": MAX_ITERATIONS,
        "patience": -1,
        "tolerance": TOLERANCE,
        "pieces": pieces,
    }
    for name, numbers in given.items():
        section(block, layout, name).data[::2] = numbers
    for name, (hi, lo) in lanes.items():
        section(block, layout, name).data[:] = lane_rows(hi, lo)
    return block
