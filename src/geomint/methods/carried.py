"""Directions at a state, and all that a sweep needs to carry them along a method's steps."""

import contextlib
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import DomainError
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.number_types import NumberType
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block, scalar_block, section
from ..kernels.tangent.layout import (
    Sizes,
    given_block,
    kept_block,
    kept_layout,
    lanes_for,
    work_layout,
)
from ..kernels.tangent.normals import CONDITIONS
from ..problems.bound import bound
from ..problems.derivatives import slopes_of
from ..problems.evaluate import derivative
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time, jacobian
from .flow import Flow
from .stepper import Stepper
from .tangent import directions_at_once, tangent_type

__all__ = ["Carried", "sizes_of_pieces"]

SMALL = 2.0**-10  # of other sizes
LEAST_ANGLE = 1e-12  # between a direction and those before: less is rounding


@Recorded
def no_conditions(params, t, y, out, work):  # type: ignore[no-untyped-def]
    """Write nothing: an open set of states has no conditions."""


class Carried:
    """Orthonormal directions at a state, and the arguments of what carries them along.

    They are tangent to the manifold that the problem's measure is on; without a measure, or with one
    on an open set, all directions are.

    Parameters
    ----------
    stepper : Stepper
        With steps of given lengths.
    directions : array, shape (rows, k), optional
        To be made orthonormal. Default: as many as the manifold has dimensions.

    Attributes
    ----------
    sizes : Sizes
    numbers, conditions : NumberType
        In which steps are taken, and conditions evaluated.
    kernel, functions, manifold : Bound, tuple of Bound, Bound
    arguments : dict
        Of a sweep, by name.
    """

    def __init__(
        self,
        problem: Problem,
        stepper: Stepper,
        y0: Array,
        time: float,
        directions: Array | None = None,
    ) -> None:
        measure, flow = problem.measure, stepper.flow
        conditions = None if measure is None else measure.manifold
        m = 0 if measure is None else measure.conditions
        d = problem.rows - m if directions is None else directions.shape[1]
        at_once = directions_at_once(flow, d)
        self.numbers, self.conditions = tangent_type(flow, at_once), CONDITIONS
        rows = flow.memory
        stages = lanes_for(2 * flow.rows) if flow.stages_in_lanes else rows
        self.sizes = Sizes(problem.rows, flow.rows, m, d, at_once, rows, stages, problem.work)
        self._take_of(flow)
        manifold = Bound(no_conditions, FIELD)
        if conditions is not None:
            manifold = bound(problem, conditions, FIELD, out=m)
        self.manifold = manifold.of_type(self.conditions)
        self._kept = self._start(problem, conditions, y0, time, directions)
        self.arguments = self._arguments(problem, flow)

    def _take_of(self, flow: Flow) -> None:
        """Let steps be those of a flow."""
        self._taken = flow
        self.kernel = flow.bound.of_type(self.numbers)
        self.functions = tuple(f.of_type(self.numbers) for f in flow.functions)

    def turn(self, stepper: Stepper) -> bool:
        """Turn to the kernel for steps that did not converge; False if there is none."""
        if not stepper.turn(self._taken):
            return False
        self._take_of(flow := stepper.flow)
        self.arguments.update(
            kernel=self.kernel,
            functions=self.functions,
            coefficients=flow.coefficients,
            scratch=self._room(self.numbers, flow.work)[0],
        )
        return True

    @property
    def remembered(self) -> tuple[Array, Array]:
        """All that the next step depends on, as copies; to be set again as long as steps are taken."""
        given = self.arguments
        return given["memory"].data.copy(), given["plain"].data.copy()

    @remembered.setter
    def remembered(self, known: tuple[Array, Array]) -> None:
        for name, numbers in zip(("memory", "plain"), known, strict=True):
            self.arguments[name].data[:] = numbers

    def _arguments(self, problem: Problem, flow: Flow) -> dict[str, Any]:
        s = self.sizes
        numbers, plain = self._room(self.numbers, -(-s.d // s.at_once) * s.memory_rows)
        conditions, conditions_plain = self._room(self.conditions, s.n + s.m + problem.work)
        return {
            "kernel": self.kernel,
            "functions": self.functions,
            "manifold": self.manifold,
            "params": flow.params,
            "coefficients": flow.coefficients,
            "fractions": flow.fractions,
            "layout": given_block(problem.pieces, s),
            "memory": self._kept,
            "work": scalar_block(sum(work_layout(s))),
            "numbers": numbers,
            "plain": plain,
            "scratch": self._room(self.numbers, flow.work)[0],
            "conditions": conditions,
            "conditions_plain": conditions_plain,
        }

    def _room(self, numbers: NumberType, rows: int) -> tuple[Block, Block]:
        """Return rows of numbers, and the float64 numbers that they are made of."""
        held = numbers.memory.held
        plain = scalar_block(rows * held.width)
        return held(plain.data), plain

    def _start(
        self,
        problem: Problem,
        conditions: Recorded | None,
        y0: Array,
        time: float,
        directions: Array | None,
    ) -> Block:
        """Return what is kept, as it is at the start: the state, its units, directions along them."""
        s, scales = self.sizes, sizes_of_pieces(problem, y0)
        gradients = np.zeros((0, s.n))
        with np.errstate(all="ignore"):
            if conditions is not None:
                gradients = scales * slopes_of(problem, conditions, y0, time, s.m)
            sizes = 1.0 / np.linalg.norm(gradients, axis=1)
        gradients = np.where(np.isfinite(gradients), gradients, 0.0)
        sizes = np.where(np.isfinite(sizes), sizes, 1.0)
        tangents = np.linalg.qr(gradients.T, mode="complete")[0][:, s.m :]
        if directions is not None:
            tangents = _orthonormal(tangents, directions, scales)
        basis = np.zeros((s.n, lanes_for(s.d)))
        basis[:, : s.d] = tangents
        state = np.append(y0, np.zeros(s.rows - s.n))
        given = {"state": state, "scales": scales, "condition_scales": sizes}
        return kept_block(s, basis=basis.ravel(), **given)

    def kept(self, name: str) -> Array:
        """Return what is kept under a name; a view."""
        return section(self._kept, kept_layout(self.sizes), name).data


def _orthonormal(tangents: Array, directions: Array, scales: Array) -> Array:
    """Return directions along the manifold, made orthonormal in their order; or `DomainError`."""
    for given in (directions, _near_one(directions)):  # one of them over the scales is a number
        with np.errstate(all="ignore"):
            wanted = _near_one(given / scales[:, None])
        if not np.isfinite(wanted).all():
            continue
        found, upper = np.linalg.qr(tangents @ (tangents.T @ wanted))
        if (np.abs(np.diag(upper)) > LEAST_ANGLE * np.linalg.norm(wanted, axis=0)).all():
            return found
    expected = "directions that are independent along the manifold of states"
    raise DomainError("directions", directions, expected)


def _near_one(columns: Array) -> Array:
    """Return columns times powers of two, which round nothing, so that their largest is near 1."""
    return np.ldexp(columns, -np.frexp(np.abs(columns).max(axis=0))[1])


def sizes_of_pieces(problem: Problem, y0: Array) -> Array:
    """Return the norms of the pieces, row by row; where one is 0, what it is after a typical time.

    A piece that is much smaller than the others, as one that is almost at rest is, has the size that
    it would have after that time if the others were changed by theirs: in units that are too small,
    the derivative of a short step would be far from 1. Pieces that stay at 0 have the sizes in which
    they move each other as much.
    """
    pieces, sizes = problem.slices.values(), np.zeros(problem.rows)
    for piece in pieces:
        sizes[piece] = _norm(y0[piece])
    if sizes.min() > SMALL * sizes.max():
        return np.where(sizes < np.inf, sizes, 1.0)
    with contextlib.suppress(DomainError):  # without a finite derivative the first step fails
        span = characteristic_time(problem, y0)
        rates = derivative(problem, y0)
        for piece in pieces:
            sizes[piece] = sizes[piece].max() or span * _norm(rates[piece])
        u = np.random.default_rng(20102).normal(size=problem.rows)
        moved = span * (derivative(problem, y0 + sizes * u / np.sqrt(problem.rows)) - rates)
        for piece in pieces:
            if sizes[piece].max() < SMALL * _norm(moved[piece]):
                sizes[piece] = _norm(moved[piece])
        _balance([piece for piece in pieces if not sizes[piece].any()], problem, y0, sizes)
    return np.where((sizes > 0.0) & (sizes < np.inf), sizes, 1.0)


def _balance(resting: list[slice], problem: Problem, y0: Array, sizes: Array) -> None:
    """Write sizes of pieces that rest at 0, in which the Jacobian's blocks between them are alike.

    By the diagonal similarity of E. E. Osborne, J. ACM 7 (1960) 338.
    """
    if len(resting) < 2:
        return
    from scipy.linalg import matrix_balance  # few runs begin at an equilibrium at 0

    J = jacobian(problem, y0, 0.0, derivative)
    blocks = np.array(
        [[np.linalg.norm(J[rows, columns]) for columns in resting] for rows in resting]
    )
    if np.isfinite(blocks).all():
        with np.errstate(invalid="ignore"):  # scipy makes whole numbers of the sizes too
            found = matrix_balance(blocks, permute=False, separate=True)[1][0]
        for piece, size in zip(resting, found, strict=True):
            sizes[piece] = size


def _norm(x: Array) -> float:
    """Return ‖x‖ whatever the size of its numbers."""
    largest = float(np.abs(x).max())
    inside = 0.0 < largest < np.inf
    return largest * float(np.linalg.norm(x / largest)) if inside else largest
