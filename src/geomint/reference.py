"""Reference solutions better than double precision.

The field's own source, compiled for double-double numbers (about 32 digits), is integrated by a
Gauss method of high order at two steps; their difference bounds the error. References are kept on
disk under a hash of everything that they depend on.
"""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .errors import ConvergenceError, FormError, NonFiniteError
from .kernels.blocks import scalar_block
from .kernels.double_double import DoubleDoubleBlock, double_double_block, lane_rows
from .kernels.gauss import gauss_header, gauss_memory_size, gauss_stepper, gauss_work_size
from .kernels.lanes import LANES
from .kernels.status import NOT_CONVERGED, OK
from .methods.compiled import compiled
from .methods.forms import field_of, piece_numbers
from .methods.gauss import Gauss, lane_positions, spread_columns, spread_vector
from .methods.method import Start
from .methods.stepper import filled_block
from .problem import Problem
from .tableaux import gauss_legendre
from .timeline import default_step

__all__ = ["Reference", "integrate_extended", "reference_solution"]

Array = npt.NDArray[np.float64]
STAGES = 12
MAX_ITERATIONS = 200
TOLERANCE = 2.0**-110
TARGET = 1e-19  # relative agreement of the two steps, beyond what double precision can show
MAX_HALVINGS = 4


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
        Largest difference, relative to its piece, of the two steps; of the exact flow the estimated
        error of its phases.
    steps : tuple of float
        The two steps; none of the exact flow.
    method : str
    """

    own_end: float
    physical_end: float | None
    y: Array
    error: float
    steps: tuple[float, ...]
    method: str = f"gauss-{STAGES}, double-double"

    def as_json(self) -> dict[str, Any]:
        """Return the numbers for reports."""
        return {
            "method": self.method,
            "own_end": self.own_end,
            "physical_end": self.physical_end,
            "state": [float(v) for v in self.y],
            "error_estimate": self.error,
            "steps": list(self.steps),
        }


def reference_solution(problem: Problem, y0: Array, own_end: float) -> Reference:
    """Integrate `problem` from `y0` at 0 to `own_end` in double-double arithmetic.

    Raises
    ------
    FormError
        If the problem has no field.
    ConvergenceError, NonFiniteError
        If the solution cannot be followed, or the two steps do not agree.
    """
    if problem.field is None:
        raise FormError(f"problem {problem.name!r} has no field: no reference can be computed")
    stored = _stored(problem, y0, own_end)
    if stored is not None:
        return stored
    h = 0.75 * default_step(problem, Gauss(8), y0)
    coarse = integrate_extended(problem, y0, own_end, h)
    for _ in range(MAX_HALVINGS):
        fine = integrate_extended(problem, y0, own_end, 0.5 * h)
        error = _difference(problem, coarse, fine)
        if error <= TARGET:
            break
        h, coarse = 0.5 * h, fine
    reference = Reference(
        own_end=own_end,
        physical_end=float(fine[-1]) if problem.clock is not None else None,
        y=fine[: problem.rows].astype(np.float64),
        error=error,
        steps=(h, 0.5 * h),
    )
    _store(problem, y0, own_end, reference)
    return reference


def _difference(problem: Problem, coarse: npt.NDArray[Any], fine: npt.NDArray[Any]) -> float:
    parts = [
        np.max(np.abs(coarse[s] - fine[s])) / max(float(np.max(np.abs(fine[s]))), 1e-300)
        for s in problem.slices.values()
    ]
    if problem.clock is not None:
        parts.append(abs(coarse[-1] - fine[-1]) / max(abs(float(fine[-1])), 1e-300))
    return float(max(parts))


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
    from .kernels import signatures
    from .kernels.compile import extended_kind

    with_clock = problem.clock is not None
    start = Start(problem, hi, t0, h, clock=with_clock)
    field, rows, _, work = field_of(start)
    groups = 2
    kind = extended_kind()
    field_signature = signatures.field(kind)
    memory = _blank(gauss_memory_size(rows, groups))
    memory.data[0 : 2 * rows : 2] = np.append(hi, clock_hi) if with_clock else hi
    memory.data[1 : 2 * rows : 2] = np.append(lo, clock_lo) if with_clock else lo
    entry = compiled(
        gauss_stepper(groups, 0), signatures.advance_signature([field_signature], kind)
    )
    status, done, iterations, residual = entry(
        compiled(field, field_signature),
        filled_block(problem.params),
        _coefficients(rows, piece_numbers(start), groups),
        filled_block(1.0, 0.0),
        memory,
        _blank(gauss_work_size(rows, groups, work)),
        rows,
        t0,
        h,
        0,
        steps,
        steps + 1,
        _blank(0),
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
    """Return the coefficient block of `geomint.kernels.gauss` in double-double numbers."""
    table, width = gauss_legendre(STAGES), LANES * groups
    at = lane_positions(STAGES, width)
    header = double_double_block(gauss_header(rows, MAX_ITERATIONS, TOLERANCE, pieces))
    parts = [header.data]
    names: tuple[Literal["c", "b"], ...] = ("c", "b")
    for name in names:
        hi, lo = table.split(name)
        parts.append(lane_rows(spread_vector(hi, at, width), spread_vector(lo, at, width)))
    hi, lo = table.split("mu")
    parts.append(lane_rows(spread_columns(hi, at, width), spread_columns(lo, at, width)))
    predictor = spread_columns(table.predictor(1.0), at, width)
    parts.append(lane_rows(predictor, np.zeros_like(predictor)))
    return DoubleDoubleBlock(filled_block(*parts).data)


def _path(problem: Problem, y0: Array, end: float) -> Any:
    from .kernels.cache import cache_folder

    digest = hashlib.sha256()
    for f in (problem.field, problem.clock):
        digest.update(f.fingerprint.encode() if f is not None else b"-")
    for numbers in (problem.params, y0, np.array([end, STAGES, TARGET])):
        digest.update(np.ascontiguousarray(numbers).tobytes())
    return cache_folder().parent / "references" / f"{digest.hexdigest()[:32]}.json"


def _stored(problem: Problem, y0: Array, end: float) -> Reference | None:
    try:
        with open(_path(problem, y0, end), encoding="utf-8") as file:
            data = json.load(file)
        return Reference(**{**data, "y": np.array(data["y"]), "steps": tuple(data["steps"])})
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _store(problem: Problem, y0: Array, end: float, reference: Reference) -> None:
    path = _path(problem, y0, end)
    data = {**reference.__dict__, "y": list(reference.y), "steps": list(reference.steps)}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_suffix(".part")
        temporary.write_text(json.dumps(data), encoding="utf-8")
        temporary.replace(path)
    except OSError:
        pass  # an unwritable cache costs time, nothing else
