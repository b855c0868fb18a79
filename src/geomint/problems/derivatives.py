"""Exact derivatives of a problem's functions at single states, by tangent numbers in plain Python."""

from typing import Any, Literal

import numpy as np

from ..arguments import Array
from ..errors import DomainError, FormError
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import Block
from ..kernels.numbers.tangent import Tangent, TangentBlock, tangent_block
from .declaration import check_form
from .evaluate import at_state, observable_of
from .problem import Problem
from .watched_call import unwatched_call

By = Literal["state", "parameters"]


@np.errstate(all="ignore")
def jacobian(problem: Problem, y: Any, t: float = 0.0, by: By = "state") -> Array:
    """Return the derivative of the field by the state, ``J[i, j] = ∂f_i/∂y_j``, or by parameters.

    To rounding, not by differences: the field runs on numbers that carry their derivatives
    (`geomint.kernels.numbers.tangent`). The coordinates are those of the flat state, those of a
    constraint manifold among them; the field off the manifold is as it is written.

    Parameters
    ----------
    y : array_like, shape (rows,)
        In the units of the problem; it need not be on the manifold.
    t : float
        The problem's own time.
    by : ``"state"`` or ``"parameters"``
        ∂/∂y, or ∂/∂params: by the flat parameters that the problem's functions get.

    Returns
    -------
    array, shape (rows, rows) or (rows, len(params))

    Raises
    ------
    FormError
        For a problem without a field.
    DomainError
        For a state of other length, or another `by`.
    DeclarationError
        If the field does not fit the problem, or takes no numbers with derivatives, as ``**`` does not.

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
    return slopes_of(problem, problem.field, state, now, problem.rows, by)


def slopes_of(
    problem: Problem, f: Recorded, y: Array, t: float, rows: int, by: By = "state"
) -> Array:
    """Return the derivative of a function that writes so many rows, as fields do."""
    held, params, given, work = _blocks(problem, y, by)
    out = held(np.zeros(rows * held.width))
    unwatched_call(problem.name, f, params, given[0] * 0.0 + t, given, out, work)
    return out.data.reshape(rows, held.width)[:, 1:].copy()


@np.errstate(all="ignore")
def gradient(
    problem: Problem, f: Recorded | str, y: Any, t: float = 0.0, by: By = "state"
) -> Array:
    """Return the derivative of an observable by the state, or by parameters, to rounding.

    Parameters
    ----------
    f : str or function
        One of the problem's quantities by name, or one recorded with `geomint.observable`.
    y, t, by
        As of `jacobian`.

    Returns
    -------
    array, shape (rows,) or (len(params),)

    Raises
    ------
    DomainError
        For a name that the problem does not have, a state of other length, or another `by`.
    DeclarationError
        If the function does not fit the problem, or takes no numbers with derivatives.
    """
    state, now = at_state(problem, y, t)
    f = observable_of(problem, f, state)
    held, params, given, work = _blocks(problem, state, by)
    found = unwatched_call(problem.name, f, params, given[0] * 0.0 + now, given, work)
    slopes = found.slopes if isinstance(found, Tangent) else np.zeros(held.width - 1)
    return np.asarray(slopes, dtype=np.float64).copy()


def _blocks(
    problem: Problem, y: Array, by: By
) -> tuple[type[TangentBlock], Block, TangentBlock, TangentBlock]:
    """Return blocks of parameters, the state and scratch: a direction for each of their numbers."""
    if not (isinstance(by, str) and by in ("state", "parameters")):
        raise DomainError("by", by, "'state' or 'parameters'")
    moving = problem.params if by == "parameters" else y
    held, slopes = tangent_block(len(moving)), np.eye(len(moving))
    params, still = Block(problem.params), np.zeros((len(y), len(moving)))
    if by == "parameters":
        params = held(np.column_stack((problem.params, slopes)).ravel())
    given = held(np.column_stack((y, still if by == "parameters" else slopes)).ravel())
    return held, params, given, held(np.zeros(problem.work * held.width))
