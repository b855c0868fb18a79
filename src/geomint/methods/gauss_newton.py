"""What Gauss methods need where Newton's method takes over: made when a first step asks for it."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ..arguments import Array
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.number_types import LANE, tangent_lanes
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block, packed
from ..kernels.numbers.lanes import LANES
from ..kernels.solve.gauss_newton import newton_coefficients, newton_stepper, newton_work
from ..kernels.solve.stage_jacobians import DIRECTIONS, jacobian_scratch, jacobians_of
from ..tableaux import gauss_legendre
from .stepper import Kernel, filled_block

__all__ = ["newton_kernel"]


def newton_kernel(
    field: Bound, unrolled: int, rows: int, stages: int, width: int, at: list[int], scratch: int,
    params: int, coefficients: Block, cap: int, patience: int,
) -> Kernel:  # fmt: skip
    """Return the kernel that takes the same steps, and by Newton's method those that do not contract.

    Parameters
    ----------
    field : Bound
        As the kernel of the fixed-point iteration takes it.
    unrolled : int
        Rows as a constant, or 0.
    width, at : int, list of int
        Lanes, and those that the stages are in.
    scratch : int
        Lane values that the field needs.
    coefficients : Block
        Of the fixed-point iteration.
    """
    tangent_lanes(DIRECTIONS).load()  # numba's half of what the Jacobians are made of
    groups = width // LANES
    jacobians = Bound(jacobians_of(field.recorded), FIELD).of_type(LANE)
    numbers = packed(
        newton_coefficients(groups),
        **_eigensystem(stages, width, tuple(at)),
        stages=stages,
        first=at[0],
        cap=cap,
        patience=patience,
        params=params,
    )
    room = 8 * jacobian_scratch(rows, scratch)
    return Kernel(
        newton_stepper(groups, 0),
        (field, jacobians),
        filled_block(coefficients.data, numbers.data),
        sum(newton_work(rows, groups, stages, params, room)),
    )


@functools.lru_cache(maxsize=64)
def _eigensystem(stages: int, width: int, at: tuple[int, ...]) -> Mapping[str, Array]:
    """Return Λ, V⁻¹ and V of ``B A B⁻¹``, in lanes and columns, by name.

    Lanes without a stage have the first eigenvalue, so that their systems are no more singular.
    """
    table = gauss_legendre(stages)
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
