"""RATTLE for H = ½ pᵀM⁻¹p + V(t, q): explicit but for the multipliers of one projection."""

from __future__ import annotations

import functools
from typing import Any

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import like, maximum, select, top
from ..numbers.blocks import part
from .advance import stepper
from .compensated import add_compensated
from .fixed_point import BEGINNING, failure, finite, inverse_size, larger, solved_by_newton
from .small_matrices import along, contract, largest, solve_small
from .status import NOT_CONVERGED, NOT_FINITE, OK

__all__ = [
    "separable_rattle_memory_size",
    "separable_rattle_stepper",
    "separable_rattle_work_size",
]


def separable_rattle_memory_size(n: int, m: int, clock: int) -> int:
    """Rows: state, carry, multipliers."""
    return 2 * (2 * n + clock) + m


def separable_rattle_work_size(n: int, m: int, field_work: int) -> int:
    """Rows of scratch: seven vectors, two Jacobians, G M⁻¹, the small system, the functions'."""
    return 7 * n + 3 * m * n + m * m + m + field_work


@helper
def slopes(
    gradients: Any,
    params: Any,
    t: Any,
    q: Any,
    G: Any,
    dq: Any,
    response: Any,
    work: Any,
    n: int,
    m: int,
) -> None:
    """Write ∂V/∂q to `dq` and ``G M⁻¹`` to `response`: ∂H/∂p is linear, its argument a row of G."""
    for a in range(m):
        gradients(params, t, q, part(G, a * n, n), dq, part(response, a * n, n), work)


@helper
def displace(
    q: Any,
    carry: Any,
    free: Any,
    response: Any,
    step: Any,
    lam: Any,
    increment: Any,
    Q: Any,
    rest: Any,
    n: int,
    m: int,
) -> None:
    """Write the `increment` ``free − h²/2 M⁻¹G(q)ᵀλ``, the new q rounded (`Q`), and what that loses.

    Multiplied by h/2 and h as the momentum is: the rounding of h²/2, the same in every step, made the
    angular momentum of a pendulum drift by 0.006 ε a step.
    """
    for i in range(n):
        by = free[i] - step * (0.5 * step * along(n, m, i, response, lam))
        z = carry[i] + by
        s = q[i] + z
        shadow = s - q[i]
        increment[i] = by
        Q[i] = s
        rest[i] = (q[i] - (s - shadow)) + (z - shadow)


@helper
def project_on_manifold(
    constraint: Any,
    params: Any,
    q: Any,
    carry: Any,
    free: Any,
    response: Any,
    step: Any,
    lam: Any,
    tolerance: float,
    cap: int,
    increment: Any,
    Q: Any,
    rest: Any,
    G: Any,
    matrix: Any,
    g: Any,
    scratch: Any,
    n: int,
    m: int,
) -> tuple[int, int, float]:
    """Find λ with ``g(q + free − h²/2 M⁻¹G(q)ᵀλ) = 0`` by Newton's method, started from `lam`.

    Writes λ, the `increment` of q, the new q rounded (`Q`) and its Jacobian `G`. The part `rest`
    that rounding takes from Q enters the residual: g vanishes at Q + rest, to its own rounding.
    The iteration ends with a change that is less than the tolerance or round-off, or no longer
    falls. That is not left out: h λ would be wrong by as much, so that neighbouring steps differ by
    1/h times the rounding of q.
    """
    zero = 0.0 * q[0]
    per_force = 1.0 / (0.5 * step * step)
    q_inverse = inverse_size(larger(q, free, n))
    last = like(BEGINNING, zero)
    going = like(1.0, zero)  # 0 in the lanes that have converged: they change no more
    for iteration in range(cap):
        displace(q, carry, free, response, step, lam, increment, Q, rest, n, m)
        constraint(params, Q, g, G, scratch)
        contract(n, m, G, response, matrix)
        size = top(largest(m * m, matrix))
        if not finite(size):
            return NOT_FINITE, iteration + 1, size
        for a in range(m):
            total = G[a * n] * rest[0]
            for i in range(1, n):
                total += G[a * n + i] * rest[i]
            g[a] = g[a] + total
        solve_small(m, matrix, g)
        delta = zero
        for i in range(n):
            delta = maximum(abs(along(n, m, i, response, g)) * q_inverse, delta)
        worst = top(delta)
        if not finite(worst):
            return failure(iteration), iteration + 1, worst
        for a in range(m):
            lam[a] = select(going > 0.0, lam[a] + g[a] * per_force, lam[a])
        going = select(solved_by_newton(delta, last, tolerance), zero, going)
        if top(going) == 0.0:
            displace(q, carry, free, response, step, lam, increment, Q, rest, n, m)
            constraint(params, Q, g, G, scratch)
            return OK, iteration + 1, worst
        last = delta
    return NOT_CONVERGED, cap, top(last)


@inlined
def separable_rattle_step(
    functions: Any,
    params: Any,
    coefficients: Any,
    substep: int,
    memory: Any,
    work: Any,
    t: float,
    h: float,
    n: int,
    m: int,
) -> tuple[int, int, float]:
    """One step of Hairer, Lubich, Wanner, *Geometric Numerical Integration*, VII.1 (1.27).

    ::

        P  = p − h/2 (V_q(t₀, q) + G(q)ᵀ λ)
        q₁ = q + h M⁻¹P,                              g(q₁) = 0
        p₁ = P − h/2 (V_q(t₁, q₁) + G(q₁)ᵀ μ),        G(q₁) M⁻¹p₁ = 0

    The second line fixes λ, by Newton's method with the matrix ``h²/2 G(q₁) M⁻¹ G(q)ᵀ``; the
    third is linear in μ. A clock row is integrated by the trapezoidal rule: symmetric, so
    compositions raise its order too.
    """
    gradients = functions[0]
    constraint = functions[1]
    clock = functions[2]
    clock_rows = int(coefficients[4])
    rows = 2 * n + clock_rows
    q = part(memory, 0, n)
    p = part(memory, n, n)
    qp = part(memory, 0, 2 * n)
    carry = part(memory, rows, rows)
    p_carry = part(carry, n, n)
    lam = part(memory, 2 * rows, m)
    kick = part(work, 0, n)
    free = part(work, n, n)
    increment = part(work, 2 * n, n)
    Q = part(work, 3 * n, n)
    rest = part(work, 4 * n, n)
    force = part(work, 5 * n, n)
    unused = part(work, 6 * n, n)
    at = 7 * n
    G0 = part(work, at, m * n)
    G1 = part(work, at + m * n, m * n)
    response = part(work, at + 2 * m * n, m * n)
    at += 3 * m * n
    matrix = part(work, at, m * m)
    g = part(work, at + m * m, m)
    at += m * m + m
    scratch = part(work, at, len(work) - at)
    t0 = like(t, q[0])
    t1 = like(t + h, q[0])
    step = like(h, q[0])
    half = 0.5 * step

    constraint(params, q, g, G0, scratch)
    slopes(gradients, params, t0, q, G0, force, response, scratch, n, m)
    start_rate = clock(params, t0, qp, scratch) if clock_rows > 0 else 0.0 * step

    for i in range(n):
        kick[i] = -half * force[i]
        Q[i] = p[i] + (p_carry[i] + kick[i])
    gradients(params, t0, q, Q, unused, free, scratch)
    for i in range(n):
        free[i] = step * free[i]
    status, iterations, residual = project_on_manifold(
        constraint,
        params,
        q,
        carry,
        free,
        response,
        step,
        lam,
        coefficients[3],
        int(coefficients[2]),
        increment,
        Q,
        rest,
        G1,
        matrix,
        g,
        scratch,
        n,
        m,
    )
    if status != OK:
        return status, iterations, residual

    slopes(gradients, params, t1, Q, G1, force, response, scratch, n, m)
    for i in range(n):
        kick[i] = (kick[i] - half * along(n, m, i, G0, lam)) - half * force[i]
        free[i] = p[i] + (p_carry[i] + kick[i])
    contract(n, m, G1, response, matrix)
    for a in range(m):
        total = response[a * n] * free[0]
        for i in range(1, n):
            total += response[a * n + i] * free[i]
        g[a] = total
    solve_small(m, matrix, g)
    worst = 0.0 * step
    for i in range(n):
        kick[i] = kick[i] - along(n, m, i, G1, g)
        worst = maximum(abs(kick[i]), worst)
    largest = top(worst)
    if not finite(largest):
        return NOT_FINITE, iterations, largest
    for i in range(n):
        add_compensated(q, carry, i, increment[i])
        add_compensated(p, p_carry, i, kick[i])
    if clock_rows > 0:
        end_rate = clock(params, t1, qp, scratch)
        by = half * (start_rate + end_rate)
        add_compensated(part(memory, 2 * n, 1), part(carry, 2 * n, 1), 0, by)
    return OK, iterations, residual


@functools.cache
def separable_rattle_stepper(n: int, m: int) -> Recorded:
    """Return the stepper of RATTLE for separable H; it takes (gradients, constraint, clock).

    The length n of q and the number m of constraints are constants to the compiler, which unrolls,
    at the price of a compilation for each pair; (0, 0) serves any. 1.8 times as fast at (3, 1).
    """

    @helper
    def separable_rattle(functions, params, coefficients, substep, memory, work, t, h):
        rows = n if n > 0 else int(coefficients[0])
        rank = m if m > 0 else int(coefficients[1])
        return separable_rattle_step(
            functions, params, coefficients, substep, memory, work, t, h, rows, rank
        )

    return stepper(separable_rattle, 3)
