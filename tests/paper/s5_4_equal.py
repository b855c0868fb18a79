"""Sections 5.3, end, and 5.4: equal parameters and the Lagrange case."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from .algebra import Array, apply, rank, skew
from .calculus import Function, derivative
from .claim import Section, Sides
from .classical import classical_field, classical_omega, tensor_of
from .equations import ham_flow, hamiltonian, hamiltonian_tau, ro, to_tau, u_of
from .integrals import integral_polynomial, relative_brackets, slopes_on_tangents
from .points import Point, lagrange_case
from .two_forms import conserved, symplectic_divergence

__all__ = ["claim"]

claim = Section("5.3, 5.4 Equal parameters and the Lagrange case", n=range(3, 8))


def equal_parameters(point: Point, groups: Sequence[int]) -> Point:
    """Return the point with a_i equal in consecutive groups of those sizes."""
    values = 0.5 + np.cumsum(point.uniform("groups", 0.2, 0.5, len(groups)))
    a = np.repeat(values, groups)
    D = np.sort(a)[-1] * np.sort(a)[-2] * 1.4
    return point.with_(n=len(a), a=a, m=D / point.rho**2)


def linear_integral(i: int, j: int, n: int) -> Function:
    """Return f_ij = γ_i p̃_j − γ_j p̃_i."""
    return lambda y: y[i] * y[n + j] - y[j] * y[n + i]


@claim(
    "text:linear-integrals",
    "a_i = a_j: f_ij = γ_ip̃_j − γ_jp̃_i is an integral of (ham_q), (ham_p)",
    "1494–1496",
)
def equal_pair(point: Point) -> Sides:
    case = equal_parameters(point, [2] + [1] * (point.n - 2))
    return conserved(linear_integral(0, 1, point.n), ham_flow(case, case.state), case.state)


def is_complete(point: Point, functions: Function) -> tuple[int, int, float]:
    """Return dim F, corank F and the largest relative bracket with H.

    Integrals F are a complete set if dim F + corank F is the dimension of the phase space, where
    dim F is the rank of dF and corank F that rank less the one of the brackets: Liouville's theorem
    if corank F = dim F, else its non-commutative version.
    """
    y = point.state
    independent = rank(slopes_on_tangents(functions, y))
    with_energy = relative_brackets(
        lambda z: np.array([*functions(z), hamiltonian_tau(point, z)]), y
    )
    among = np.linalg.svd(with_energy[:-1, :-1], compute_uv=False)
    defect = float(np.max(np.abs(with_energy[-1])))
    return independent, independent - int(np.sum(among > 1e-9)), defect


@claim(
    "text:two-pairs",
    "n = 4, a_1 = a_2 ≠ a_3 = a_4: f_12, f_34, H are a complete set of commuting integrals",
    "1496–1499",
    n=(4,),
)
def two_pairs(point: Point) -> Sides:
    case = equal_parameters(point, [2, 2])

    def functions(y: Array) -> Array:
        pairs = [linear_integral(0, 1, 4)(y), linear_integral(2, 3, 4)(y)]
        return np.array([*pairs, hamiltonian_tau(case, y)])

    return is_complete(case, functions), [3, 3, 0.0], 1.0


PATTERNS = {
    3: ([3], [2, 1]),
    4: ([3, 1], [2, 1, 1]),
    5: ([3, 1, 1], [4, 1], [3, 2]),
    6: ([3, 3], [2, 2, 2]),
}


@claim(
    "text:equal-parameters",
    "the system is integrable for equal a_i too: r_k and all f_ij; non-commutative "
    "from three equal ones on",
    "1494–1501",
    n=tuple(PATTERNS),
)
def non_commutative(point: Point) -> Sides:
    left, right = [], []
    for groups in PATTERNS[point.n]:
        case = equal_parameters(point, groups)
        ends = np.cumsum([0, *groups])
        pairs = [
            (i, j)
            for start, stop in itertools.pairwise(ends)
            for i in range(start, stop)
            for j in range(i + 1, stop)
        ]

        def functions(y: Array, case: Point = case, pairs: Any = tuple(pairs)) -> Array:
            linear = [linear_integral(i, j, case.n)(y) for i, j in pairs]
            return np.array([*linear, *integral_polynomial(case, y)])

        independent, corank, defect = is_complete(case, functions)
        left += [independent + corank, defect, float(independent > corank)]
        right += [2.0 * case.n - 2.0, 0.0, float(max(groups) > 2)]
    return left, right, 1.0


@claim(
    "remark:operators",
    "D𝓘 = 1 + DI⁻¹ ⇔ I = D(D𝓘 − 1)⁻¹ for (operator), (inertia_tensor)",
    "1503–1509",
    n=range(2, 8),
)
def operators(point: Point) -> Sides:
    script = point.special_veselova
    one = np.eye(len(script))
    inverse = point.D * np.linalg.inv(point.D * script - one)
    left = [point.D * script, inverse]
    return left, [one + point.D * np.linalg.inv(point.special), point.special]


@claim(
    "remark:operators:tr1",
    "n = 3: (tr1) has (inertia_tensor) times D, whose eigenvalues are greater than 1",
    "1510–1513",
    n=(3,),
)
def operator_of_tr1(point: Point) -> Sides:
    tensor = tensor_of(point.D * point.special_veselova)
    printed = np.eye(3) + point.D * np.linalg.inv(tensor_of(point.special))
    greater = np.min(np.linalg.eigvalsh(tensor)) > 1.0
    return [*np.ravel(tensor), float(greater)], [*np.ravel(printed), 1.0]


def equal_pairs(n: int) -> list[tuple[int, int]]:
    """Return 1 ≤ i < j ≤ n − 1."""
    return [(i, j) for i in range(n - 1) for j in range(i + 1, n - 1)]


@claim(
    "text:lagrange-integrals",
    "Lagrange case: f_ij, i < j ≤ n − 1, are integrals of (ham_q), (ham_p)",
    "1515–1518",
)
def lagrange_integrals(point: Point) -> Sides:
    case = lagrange_case(point)

    def functions(y: Array) -> Array:
        return np.array([linear_integral(i, j, case.n)(y) for i, j in equal_pairs(case.n)])

    return conserved(functions, ham_flow(case, case.state), case.state)


SI = "F_ij = (γ_ip_j − γ_jp_i)²/(γ, A⁻¹γ)"


def printed_si(case: Point, y: Array, corrected: bool) -> Array:
    """Return all F_ij of eq. (SI), or divided by U instead of multiplied."""
    factor = u_of(case, y[: case.n]) ** (-1 if corrected else 1)
    return np.array(
        [factor * linear_integral(i, j, case.n)(y) ** 2 for i, j in equal_pairs(case.n)]
    )


@claim(
    "SI",
    "F_ij = (γ, A⁻¹γ)(γ_ip_j − γ_jp_i)², i < j ≤ n − 1, are integrals of (ro1), (ro2)",
    "1518–1523",
    misprint=SI,
)
def si(point: Point, corrected: bool) -> Sides:
    case = lagrange_case(point)
    y = case.state
    return conserved(lambda z: printed_si(case, z, corrected), ro(case, y), y)


@claim(
    "text:lagrange-levels",
    "the levels of H and the integrals are two-dimensional, with an invariant measure",
    "1525–1530",
    cites=("SI",),
)
def lagrange_levels(point: Point) -> Sides:
    case = lagrange_case(point)
    y = case.state
    slopes = slopes_on_tangents(
        lambda z: np.array([*printed_si(case, z, True), hamiltonian(case, z)]), y
    )
    value, size = symplectic_divergence(lambda z: ro(case, z), y)
    rate = derivative(lambda z: np.log(u_of(case, z[: case.n])), y, ro(case, y))
    return [2 * case.n - 2 - rank(slopes), value - 0.5 * (case.n - 2) * rate], [2, 0.0], size


@claim(
    "theorem:lagrange",
    "Theorem 9: the invariant manifolds of (SI) and (hamiltonian*) are "
    "two-dimensional tori, solvable by quadratures",
    "1531–1536",
    misprint="with " + SI + " in place of (SI)",
    finding="SI",
    cites=("SI",),
)
def theorem_lagrange(point: Point, corrected: bool) -> Sides:
    """Check that the field is tangent to the levels, and they are two-dimensional."""
    case = lagrange_case(point)
    y = case.state

    def functions(z: Array) -> Array:
        return np.array([*printed_si(case, z, corrected), hamiltonian_tau(case, to_tau(case, z))])

    left, _, size = conserved(functions, ro(case, y), y)
    dimension = 2 * case.n - 2 - rank(slopes_on_tangents(functions, y))
    return [*left, dimension], [*np.zeros(len(left)), 2], size


@claim(
    "remark:right-invariance",
    "Lagrange case: the Lagrangian is invariant under the right SO(n−1)-action",
    "1538–1540",
)
def right_invariance(point: Point) -> Sides:
    case, n = lagrange_case(point), point.n
    h = np.eye(n)
    h[:-1, :-1] = np.linalg.qr(point.normal("h", n - 1, n - 1))[0]
    omega = case.omega
    return h.T @ apply(case.special, omega) @ h, apply(case.special, h.T @ omega @ h)


@claim(
    "remark:not-noether",
    "the vector fields of the right action do not satisfy (ch-constr)",
    "1540–1543",
    negative=True,
)
def not_noether(point: Point) -> Sides:
    """Note that the action moves g by gζ and r not at all: V = 0, but ρΩΓ = ρgζγ."""
    zeta = skew(point.normal("zeta", (point.n - 1) * (point.n - 2) // 2), point.n - 1)
    body = np.zeros((point.n, point.n))
    body[:-1, :-1] = zeta
    return np.zeros(point.n), point.rho * (point.g @ body @ point.gamma)


@claim(
    "remark:last",
    "n = 3, I_1 = I_2: F = k_3² − D(γ⃗, (I + D)⁻¹γ⃗)k_3² is an integral of (Chap)",
    "1543–1545",
    n=(3,),
    misprint="F = ω_3² − D(γ⃗, (I + D)⁻¹γ⃗)ω_3², at any area constant",
)
def routh(point: Point, corrected: bool) -> Sides:
    first, last = (float(x) for x in point.uniform("moments", 0.5, 3.0, 2))
    tensor = np.diag([first, first, last if abs(last - first) > 0.2 else last + 0.5])
    shifted = 1.0 / (np.diag(tensor) + point.D)

    def printed(y: Array) -> Any:
        k, gamma = y[:3], y[3:]
        chosen = classical_omega(point, tensor, k, gamma) if corrected else k
        return chosen[2] ** 2 - point.D * (gamma @ (shifted * gamma)) * chosen[2] ** 2

    y = np.concatenate([point.normal("k", 3), point.gamma])
    return conserved(printed, classical_field(point, tensor, y), y)
