"""Where Chaplygin's multiplier does not exist: a test at single states.

The reduced ball on so(n)*×S^(n−1) is almost Hamiltonian, y′ = Π ∂H/∂y, with the truncated bracket of
Hochgerner and García-Naranjo: for a function with the derivatives ξ by k and ν by γ,

    k̇ = [k, ξ] + ν∧γ − D(ωξγ)∧γ,   γ̇ = −ξγ.

Its leaves are those of the SO(n−1)-momentum, which has only Casimir functions; on T*S^(n−1), zero
momentum, it is the form of the paper. A multiplier N = 1/f makes fΠ a Poisson bracket, for which the
condition is, with θ = d log f and X = Πθ,

    [Π, Π]_ijk/2 + X_iΠ_jk + X_jΠ_ki + X_kΠ_ij = 0.

On leaves of six or more dimensions that is overdetermined for θ, at every single state: what the best
θ leaves is the *closedness defect*, the part of dw that no multiplier removes. Moreover the measure
prescribes f: the density ϱ of eq. (mu*) must be f^(1−d) on leaves of dimension 2d. What that θ leaves
is the *measure defect*, which is never less.

Both are zero for the special operator without momentum, and for n ≤ 3. From n = 4 on they are not for
the special operator with momentum, nor for other operators, such as rigid bodies with a mass tensor J.
They are about *this* bracket: forms ŵ with i_X ŵ = 0 can be added to it. For the homogeneous ball with
momentum, which has a defect here, such a form exists (see `geomint audit`, text:homogeneous-forms).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi

from .inertia import Inertia
from .manifold import Array, flat_triangle, skew_components, triangle_rows

RANK = 1e-9  # singular values of Π below this part of the largest are zero
STEP = 1e-30  # of complex steps, whose derivatives are exact


@dataclass(frozen=True)
class MultiplierDefects:
    """What keeps the bracket at a state from being Poisson, relative to the size of what it is made of.

    Parameters
    ----------
    jacobi : float
        |[Π, Π]|/2 itself: zero where the equations are Hamiltonian as they stand.
    closedness : float
        What the best θ leaves: zero where a multiplier may exist.
    measure : float
        What the θ leaves that the invariant measure prescribes.
    dimension : int
        2d, of the leaf.
    """

    jacobi: float
    closedness: float
    measure: float
    dimension: int


def almost_poisson_tensor(inertia: Inertia, D: float, y: Array) -> Array:
    """Return Π at y = (k, γ), shape (N + n, N + n), y of any dtype; y′ = Π ∂H/∂y is the ball."""
    n = inertia.n
    size = triangle_rows(n)
    k, gamma = _skew(y[:size], n), y[size:]
    omega = _skew(_omega(inertia, D, y), n)
    columns = []
    for e in np.eye(size):
        xi = _skew(e, n)
        rate = k @ xi - xi @ k - D * _wedge(omega @ xi @ gamma, gamma)
        columns.append(np.concatenate([flat_triangle(rate), -xi @ gamma]))
    columns += [np.concatenate([flat_triangle(_wedge(e, gamma)), 0.0 * gamma]) for e in np.eye(n)]
    return np.array(columns).T


def multiplier_defects(inertia: Inertia, D: float, gamma: Any, k: Any) -> MultiplierDefects:
    """Return how far the ball at a state is from having Chaplygin's multiplier.

    Parameters
    ----------
    inertia, D
        See `ChaplyginSphere`.
    gamma : array_like, shape (n,)
    k : array_like, flat or (n, n)

    Raises
    ------
    geomint.DomainError
        For what describes no state, and for k = 0, where there is nothing to test.
    """
    n = inertia.n
    y = np.concatenate([skew_components("k", k, n), gi.Sphere(n).point(gamma)])
    if not np.any(y[:-n]):
        raise gi.DomainError("k", k, "a momentum that is not zero")
    steps = [y + 1j * STEP * e for e in np.eye(len(y))]
    tensor = almost_poisson_tensor(inertia, D, y)
    slopes = np.array([almost_poisson_tensor(inertia, D, z).imag / STEP for z in steps])
    parts = np.einsum("il,ljk->ijk", tensor, slopes)
    jacobi = _cyclic(parts)
    scale = float(np.linalg.norm(parts)) or 1.0
    rank = int(np.linalg.matrix_rank(tensor, RANK * np.linalg.norm(tensor, 2)))
    basis = np.linalg.svd(tensor)[0][:, :rank]
    images = [_cyclic(np.einsum("i,jk->ijk", column, tensor)) for column in basis.T]
    matrix = np.array([image.ravel() for image in images]).T
    solution = np.linalg.lstsq(matrix, -jacobi.ravel(), rcond=None)[0]
    closed = jacobi.ravel() + matrix @ solution
    determinants = [np.linalg.det(_metric(inertia, D, z[-n:])) for z in steps]
    log_density = [-0.5 * np.log(x).imag / STEP for x in determinants]
    degrees = max(rank // 2 - 1, 1)
    push = tensor @ (-np.array(log_density) / degrees)
    prescribed = jacobi + _cyclic(np.einsum("i,jk->ijk", push, tensor))
    first, second, third = (float(np.linalg.norm(x)) / scale for x in (jacobi, closed, prescribed))
    return MultiplierDefects(first, second, third, rank)


def _cyclic(parts: Array) -> Array:
    return parts + parts.transpose(1, 2, 0) + parts.transpose(2, 0, 1)


def _skew(flat: Array, n: int) -> Array:
    matrix = np.zeros((n, n), dtype=flat.dtype)
    matrix[np.triu_indices(n, 1)] = flat
    return matrix - matrix.T


def _wedge(x: Array, y: Array) -> Array:
    return np.outer(x, y) - np.outer(y, x)


def _metric(inertia: Inertia, D: float, gamma: Array) -> Array:
    """Return the matrix of I + D pr, pr ω = ωγγᵀ + γγᵀω."""
    n = inertia.n
    shadow = np.outer(gamma, gamma)
    columns = []
    for e in np.eye(triangle_rows(n)):
        full = _skew(e, n)
        columns.append(inertia.apply(e) + D * flat_triangle(full @ shadow + shadow @ full))
    return np.array(columns).T


def _omega(inertia: Inertia, D: float, y: Array) -> Array:
    n = inertia.n
    return np.asarray(np.linalg.solve(_metric(inertia, D, y[-n:]), y[:-n]))
