"""Exact derivatives of a problem's functions at single states, by tangent numbers in plain Python."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import FormError
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import Block
from ..kernels.numbers.tangent import Tangent, TangentBlock, tangent_block
from .declaration import check_form
from .evaluate import at_state, observable_of
from .problem import Problem

__all__ = ["gradient", "jacobian", "slopes_of"]


@np.errstate(all="ignore")
def jacobian(problem: Problem, y: Any, t: float = 0.0) -> Array:
    """Return the derivative of the field by the state, ``J[i, j] = ∂f_i/∂y_j``.

    To rounding, not by differences: the field runs on numbers that carry their derivatives
    (`geomint.kernels.numbers.tangent`). The coordinates are those of the flat state, those of a
    constraint manifold among them; the field off the manifold is as it is written.

    Parameters
    ----------
    y : array_like, shape (rows,)
        In the units of the problem; it need not be on the manifold.
    t : float
        The problem's own time.

    Returns
    -------
    array, shape (rows, rows)

    Raises
    ------
    FormError
        For a problem without a field.
    DomainError
        For a state of other length.
    DeclarationError
        If the field does not fit the problem.

    Examples
    --------
    >>> import geomint as gi
    >>> scene = gi.load_scene("sphere-n3")
    >>> J = gi.jacobian(scene.problem, scene.state)
    >>> J.shape
    (6, 6)
    """
    state, now = at_state(problem, y, t)
    if problem.field is None:
        raise FormError(f"a Jacobian needs a field, which problem {problem.name!r} does not have")
    check_form(problem, "field", state)
    return slopes_of(problem, problem.field, state, now, problem.rows)


def slopes_of(problem: Problem, f: Recorded, y: Array, t: float, rows: int) -> Array:
    """Return the derivative by the state of a function that writes so many rows, as fields do."""
    held, given, work = _blocks(problem, y)
    out = held(np.zeros(rows * held.width))
    f(Block(problem.params), given[0] * 0.0 + t, given, out, work)
    return out.data.reshape(rows, held.width)[:, 1:].copy()


@np.errstate(all="ignore")
def gradient(problem: Problem, f: Recorded | str, y: Any, t: float = 0.0) -> Array:
    """Return the derivative of an observable by the state, to rounding.

    Parameters
    ----------
    f : str or function
        One of the problem's quantities by name, or one recorded with `geomint.observable`.
    y, t
        As of `jacobian`.

    Returns
    -------
    array, shape (rows,)

    Raises
    ------
    DomainError
        For a name that the problem does not have, or a state of other length.
    DeclarationError
        If the function does not fit the problem.
    """
    state, now = at_state(problem, y, t)
    f = observable_of(problem, f, state)
    _, given, work = _blocks(problem, state)
    found = f(Block(problem.params), given[0] * 0.0 + now, given, work)
    slopes = found.slopes if isinstance(found, Tangent) else np.zeros(problem.rows)
    return np.asarray(slopes, dtype=np.float64).copy()


def _blocks(problem: Problem, y: Array) -> tuple[type[TangentBlock], TangentBlock, TangentBlock]:
    """Return blocks of the state, with a direction for each of its numbers, and of scratch."""
    held = tangent_block(problem.rows)
    numbers = np.column_stack((y, np.eye(problem.rows)))
    return held, held(numbers.ravel()), held(np.zeros(problem.work * held.width))
