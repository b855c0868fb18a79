"""What Gauss methods need where Newton's method takes over: made when a first step asks for it."""

import functools
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ..arguments import Array
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.number_types import LANE, tangent_lanes
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block, filled_block, packed
from ..kernels.numbers.lanes import LANES
from ..kernels.numbers.tangent import tangent_block
from ..kernels.solve.gauss_newton import newton_stepper
from ..kernels.solve.stage_equations import newton_coefficients, newton_work
from ..kernels.solve.stage_jacobians import DIRECTIONS, jacobian_scratch, jacobians_of
from ..problems.bound import given_at
from ..problems.declaration import is_new, remember
from ..problems.watched_call import unwatched_call
from ..tableaux import gauss_legendre
from .flow import Kernel
from .posed import Posed


def check_derivatives(p: Posed, field: Bound) -> None:
    """Raise `DeclarationError` unless a field takes numbers with derivatives: it runs once."""
    problem = p.problem
    what = ("derivatives", field.recorded.fingerprint, problem.work)
    if not is_new(problem, what):
        return
    call = functools.partial(unwatched_call, problem.name, field.recorded)
    y, kind = np.append(p.state, [0.0] * p.clock), tangent_block(1)
    given = given_at(problem, y, t=kind(np.array([p.time, 0.0]))[0], out=len(y))
    with np.errstate(all="ignore"):
        FIELD.run(call, lambda x: kind(np.column_stack((x, 0.0 * x)).ravel()), **given)
    remember(problem, what)


def newton_kernel(
    field: Bound,
    rows: int,
    params: int,
    scratch: int,
    at: list[int],
    coefficients: Block,
    cap: int,
    patience: int,
) -> Kernel:
    """Return the kernel that takes the same steps, and by Newton's method those that do not contract.

    One for all numbers of rows: it is compiled at need, in the middle of a run, and what it gains from
    a constant is not seen beside the rest.

    Parameters
    ----------
    field : Bound
        As the kernel of the fixed-point iteration takes it.
    scratch : int
        Lane values that the field needs.
    at : list of int
        The lanes that the stages are in.
    coefficients : Block
        Of the fixed-point iteration.
    """
    tangent_lanes(DIRECTIONS).load()  # numba's half of what the Jacobians are made of
    stages, groups = len(at), 1 if len(at) <= LANES else 2
    jacobians = Bound(jacobians_of(field.as_helper), FIELD).of_type(LANE)
    numbers = packed(
        newton_coefficients(groups),
        **_eigensystem(LANES * groups, tuple(at)),
        stages=stages,
        first=at[0],
        cap=cap,
        patience=patience,
        params=params,
    )
    room = 8 * jacobian_scratch(rows, scratch)
    return Kernel(
        newton_stepper(groups),
        (field, jacobians),
        filled_block(coefficients.data, numbers.data),
        sum(newton_work(rows, groups, stages, params, room)),
    )


@functools.lru_cache(maxsize=64)
def _eigensystem(width: int, at: tuple[int, ...]) -> Mapping[str, Array]:
    """Return Λ, V⁻¹ and V of ``B A B⁻¹``, in lanes and columns, by name.

    Lanes without a stage have the first eigenvalue, so that their systems are no more singular.
    """
    table = gauss_legendre(len(at))
    values, vectors = np.linalg.eig(np.asarray(table.b)[:, None] * np.asarray(table.mu))
    inverse = np.linalg.inv(vectors)
    eigen = np.full(width, values[0], dtype=complex)
    eigen[list(at)] = values

    def columns(matrix: Array) -> Array:
        whole = np.zeros((width, width))
        whole[np.ix_(at, at)] = matrix
        return whole.T.ravel()

    return MappingProxyType(
        {
            "eigen_real": eigen.real,
            "eigen_imaginary": eigen.imag,
            "into_real": columns(inverse.real),
            "into_imaginary": columns(inverse.imag),
            "out_real": columns(vectors.real),
            "out_imaginary": columns(-vectors.imag),
        }
    )
