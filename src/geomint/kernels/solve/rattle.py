"""RATTLE for any Hamiltonian on an embedded constraint manifold; it need not be separable."""

import functools
import math
from collections import namedtuple

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import epsilon, like, maximum, plain, select, slope_count, top
from ..numbers.blocks import REST, part, sections
from .advance import stepper
from .compensated import add_compensated
from .fixed_point import (
    BEGINNING,
    COARSE,
    NEWTON_ROUNDING,
    failure,
    finite,
    inverse_size,
    larger,
    rounding_left,
    solved,
)
from .small_matrices import across, along, contract, largest, lost_rank, near_loss, solve_small
from .status import LOST_RANK, NOT_CONVERGED, NOT_FINITE, OK

Coefficients = namedtuple("Coefficients", "rows constraints cap tolerance clock_rows")
Memory = namedtuple("Memory", "state clock carry last_q last_p lam last_h")
Work = namedtuple("Work", "P Q dq0 dp0 dq1 dp1 three G0 G1 response matrix g scratch")

RATTLE = Coefficients(1, 1, 1, 1, 1)  # the layout of coefficients: rows are those of q
SHIFT = 2.0**-20  # of p along the normals, for H_pp by differences
NEWTON = 30
# Newton's changes are squared, or divided by 1/SHIFT: after such a one the next is less than rounding.
CLEAN = 2.0**-30
FOLLOW, LATE = 3.0, 16  # iterations


@inlined
def rattle_memory(n: int, m: int, clock: int) -> Memory:
    """Return the layout of memory: state (q, p), clock, the carries of all, what starts a step.

    That are the last increments of q and of the half step of p, multipliers, and the last h.
    """
    return Memory(2 * n, clock, 2 * n + clock, n, n, m, 1)


@inlined
def rattle_work(n: int, m: int, scratch: int) -> Work:
    """Return the layout of scratch: vectors, Jacobians, the small system, the functions' own."""
    return Work(n, n, n, n, n, n, 3 * n, m * n, m * n, m * n, m * m, m, scratch)


@helper
def add_normal_response(gradients, params, t, q, p, dp, G, scale, own: Work, n: int, m: int):
    """Add ``scale · H_pp(q, p) Gᵀ`` to the response, a row a constraint, to some digits.

    `dp` holds ∂H/∂p at (q, p). p is moved along a normal by a part of its own size: by less, what is
    wanted would be lost to rounding. Iterations do the rest.
    """
    size = plain(largest(n, p))
    size = SHIFT * select(size > 0.0, size, 1.0 + size)
    out = own.response
    shifted = part(own.three, 0, n)
    dq_shifted = part(own.three, n, n)
    dp_shifted = part(own.three, 2 * n, n)
    for a in range(m):
        normal = plain(largest(n, part(G, a * n, n)))
        by = size / select(normal > 0.0, normal, 1.0 + normal)
        inverse = 1.0 / by
        for i in range(n):
            shifted[i] = p[i] + by * G[a * n + i]
        gradients(params, t, q, shifted, dq_shifted, dp_shifted, own.scratch)
        for i in range(n):
            rate = inverse * (dp_shifted[i] - dp[i])
            out[a * n + i] += scale * rate


@helper
def drop_rounding(g, G, q, n: int, m: int):
    """Set the rows of g that a rounded q and a rounded sum of n terms explain to zero.

    No q satisfies ``g(q) = 0`` better. To ask for it would move p by ε |q| / h along the normals, to
    and fro, and with it H_q: next to that a small p, or one that is zero, would be lost. What g changes
    by with the directions of tangent numbers is no rounding, and stays.
    """
    share = (1.0 + 0.25 * math.sqrt(n)) * epsilon(q[0])
    for a in range(m):
        value = plain(g[a])
        size = 0.0 * value
        for i in range(n):
            size += abs(plain(G[a * n + i]) * plain(q[i]))
        g[a] = select(abs(value) > share * size, g[a], g[a] - value)


@helper
def project_momentum(gradients, params, t, own: Work, n: int, m: int):
    """Move P along the normals until ``G₁ ∂H/∂p(Q, P) = 0``, by Newton's method.

    Returns the last change over the size of P, of values. For H quadratic in p there are two steps, the
    second cleans; where there are slopes, whatever their size, they follow.
    """
    q, p, dp, G, response, defect = own.Q, own.P, own.dp1, own.G1, own.response, own.g
    one = like(1.0, q[0])
    still = 0.0 * plain(one)
    last = like(BEGINNING, still)
    going = like(1.0, still)  # 0 in the lanes that have converged
    held = still
    settle = like(FOLLOW if slope_count(one) > 0 else 0.0, still)
    for iteration in range(NEWTON):
        gradients(params, t, q, p, own.dp0, dp, own.scratch)
        for i in range(m * n):
            response[i] = 0.0 * one
        add_normal_response(gradients, params, t, q, p, dp, G, one, own, n, m)
        contract(n, m, G, response, own.matrix)
        for a in range(m):
            defect[a] = across(n, a, G, dp)
        solve_small(m, own.matrix, defect)
        change = still
        size = still
        for i in range(n):
            by = along(n, m, i, G, defect)
            size = maximum(abs(plain(p[i])), size)
            change = maximum(abs(plain(by)), change)
            p[i] -= select(going > 0.0, by, 0.0 * by)
        change *= inverse_size(size)
        last = select(going > 0.0, change, last)
        if iteration > 0:
            held = select((change <= CLEAN) | (held > 0.0), held + 1.0, held)
            going = select(held > settle, still, going)
        if top(going) == 0.0 or not finite(top(change)):
            break
    return last


@inlined
def rattle_step(
    functions, params, given: Coefficients, memory, work, t, h, n: int, m: int
) -> tuple[int, int, float]:
    """One step of Hairer, Lubich, Wanner, *Geometric Numerical Integration*, VII.1 (1.26).

    ::

        P  = p − h/2 (H_q(q, P) + G(q)ᵀ λ)
        q₁ = q + h/2 (H_p(q, P) + H_p(q₁, P)),      g(q₁) = 0
        p₁ = P − h/2 (H_q(q₁, P) + G(q₁)ᵀ μ),       G(q₁) H_p(q₁, p₁) = 0

    (P, q₁) by fixed-point iteration started from the last step's increments; inside each iteration
    a Newton step for λ with the matrix ``h²/4 G(q₁) (H_pp(q) + H_pp(q₁)) G(q)ᵀ``. A clock row is
    integrated by the trapezoidal rule: symmetric, so compositions raise its order too.
    """
    gradients, constraint, clock = functions
    cap, tolerance, clock_rows = int(given.cap[0]), given.tolerance[0], int(given.clock_rows[0])
    kept = sections(memory, rattle_memory(n, m, clock_rows))
    qp, passed, carry, last_q, last_p, lam, last_h = kept
    q, p = part(qp, 0, n), part(qp, n, n)
    own = sections(work, rattle_work(n, m, REST))
    P, Q, dq0, dp0, dq1, dp1, three, G0, G1, response, matrix, g, scratch = own
    trial, free = part(three, 0, n), part(three, n, n)
    t0 = like(t, q[0])
    t1 = like(t + h, q[0])
    half = like(0.5 * h, q[0])
    zero = 0.0 * half

    constraint(params, q, g, G0, scratch)
    started = top(abs(last_h[0])) > 0.0
    ratio = half / (0.5 * last_h[0]) if started else zero
    for i in range(n):
        P[i] = p[i] + ratio * last_p[i]
        Q[i] = q[i] + ratio * last_q[i]
    gradients(params, t0, q, P, dq0, dp0, scratch)
    gradients(params, t1, Q, P, dq1, dp1, scratch)
    for i in range(m * n):
        response[i] = zero
    add_normal_response(gradients, params, t0, q, P, dp0, G0, half * half, own, n, m)
    add_normal_response(gradients, params, t1, Q, P, dp1, G0, half * half, own, n, m)
    still = 0.0 * plain(q[0])
    last = like(BEGINNING, still)
    before = like(BEGINNING, still)
    going = like(1.0, still)  # 0 in the lanes that have converged: they change no more
    coarse = like(1.0, still)  # 1 in the lanes whose sizes are still to be found
    held = still  # iterations since values have converged: slopes, whose rounding is larger, follow
    settle = like(FOLLOW if slope_count(q[0]) > 0 else 0.0, still)
    q_inverse = still
    p_inverse = still
    near = False  # to where roundings of multipliers move p: along normals, for its projection
    for iteration in range(cap):
        if iteration > 0:
            gradients(params, t0, q, P, dq0, dp0, scratch)
            gradients(params, t1, Q, P, dq1, dp1, scratch)
        for i in range(n):
            free[i] = half * (dp0[i] + dp1[i])
            trial[i] = q[i] + (carry[i] + free[i])
        constraint(params, trial, g, G1, scratch)
        drop_rounding(g, G1, trial, n, m)
        contract(n, m, G1, response, matrix)
        size = top(largest(m * m, matrix))
        if not finite(size):
            return NOT_FINITE, iteration + 1, size
        solve_small(m, matrix, g)
        for a in range(m):
            lam[a] = select(going > 0.0, lam[a] + g[a], lam[a])
        q_inverse = select(coarse > 0.0, inverse_size(larger(q, last_q, n)), q_inverse)
        p_inverse = select(coarse > 0.0, inverse_size(larger(p, last_p, n)), p_inverse)
        if iteration % LATE == LATE - 1 and top(last) <= CLEAN:
            near = near_loss(m, matrix)
            p_inverse = still if near else p_inverse
        delta = still
        for i in range(n):
            by_q = free[i] - along(n, m, i, response, g)
            by_p = -half * (dq0[i] + along(n, m, i, G0, lam))
            last_q[i] = select(going > 0.0, by_q, last_q[i])
            last_p[i] = select(going > 0.0, by_p, last_p[i])
            new_q = q[i] + (carry[i] + last_q[i])
            new_p = p[i] + (carry[n + i] + last_p[i])
            delta = maximum(abs(plain(new_q) - plain(Q[i])) * q_inverse, delta)
            delta = maximum(abs(plain(new_p) - plain(P[i])) * p_inverse, delta)
            Q[i] = new_q
            P[i] = new_p
        worst = top(delta)
        if not finite(worst):
            return failure(iteration), iteration + 1, worst
        rounding = rounding_left(delta, still) | (delta <= (NEWTON_ROUNDING if near else -1.0))
        done = solved(delta, last, before, tolerance, rounding, iteration + 1 == cap)
        held = select(done | (held > 0.0), held + 1.0, held)
        going = select(held > settle, still, going)
        coarse = select(delta > COARSE, going, still)
        if top(going) == 0.0:
            start_rate = clock(params, t0, qp, scratch) if clock_rows > 0 else zero
            gradients(params, t1, Q, P, dq1, dp1, scratch)
            constraint(params, Q, g, G1, scratch)
            for i in range(n):
                dq1[i] = last_p[i] - half * dq1[i]  # the increment of p but for its projection
                P[i] = p[i] + (carry[n + i] + dq1[i])
                dq0[i] = P[i]
            left = project_momentum(gradients, params, t1, own, n, m)
            if not top(left) <= CLEAN:
                return NOT_CONVERGED if finite(top(left)) else NOT_FINITE, NEWTON, top(left)
            for i in range(n):
                dq1[i] += P[i] - dq0[i]
            moved = top(plain(largest(n, dq1))) if m > 1 else 0.0
            if m > 1 and lost_rank(m, matrix, n, p, dq1, moved, dp0, 2.0 * half):
                return LOST_RANK, iteration + 1, moved
            for i in range(n):
                add_compensated(q, carry, i, last_q[i])
                add_compensated(p, part(carry, n, n), i, dq1[i])
            if clock_rows > 0:
                end_rate = clock(params, t1, qp, scratch)
                by = half * (start_rate + end_rate)
                add_compensated(passed, part(carry, 2 * n, 1), 0, by)
            last_h[0] = 2.0 * half
            return OK, iteration + 1, worst
        before = last
        last = delta
    return LOST_RANK if near else NOT_CONVERGED, cap, top(last)


@functools.cache
def rattle_stepper(n: int, m: int, step: Recorded = rattle_step) -> Recorded:
    """Return the stepper of RATTLE; it takes (gradients, constraint, clock).

    The length n of q and the number m of constraints are constants to the compiler, which unrolls,
    at the price of a compilation for each pair; (0, 0) serves any. 1.8 times as fast at (3, 1).
    """

    @helper
    def rattle(functions, params, coefficients, substep, memory, work, t, h):
        given = sections(coefficients, RATTLE)
        rows = n if n > 0 else int(given.rows[0])
        rank = m if m > 0 else int(given.constraints[0])
        return step(functions, params, given, memory, work, t, h, rows, rank)

    return stepper(rattle)
