"""RATTLE for H = ½ pᵀM⁻¹p + V(t, q): explicit but for the multipliers of one projection."""

from collections import namedtuple

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import like, maximum, select, top
from ..numbers.blocks import REST, part, sections
from .compensated import add_compensated
from .fixed_point import BEGINNING, failure, finite, inverse_size, larger, solved_by_newton
from .rattle import Coefficients, rattle_stepper
from .small_matrices import across, along, contract, largest, lost_rank, near_loss, solve_small
from .status import LOST_RANK, NOT_CONVERGED, NOT_FINITE, OK, Step

Memory = namedtuple("Memory", "state clock carry lam")
Work = namedtuple("Work", "kick free increment Q rest force unused G0 G1 response matrix g scratch")


@inlined
def separable_rattle_memory(n: int, m: int, clock: int) -> Memory:
    """Return the layout of memory: state (q, p), clock, the carries of all, multipliers."""
    return Memory(2 * n, clock, 2 * n + clock, m)


@inlined
def separable_rattle_work(n: int, m: int, scratch: int) -> Work:
    """Return the layout of scratch: vectors, Jacobians, G M⁻¹, the small system, the functions'."""
    return Work(n, n, n, n, n, n, n, m * n, m * n, m * n, m * m, m, scratch)


@helper
def slopes(gradients, params, t, q, G, dq, response, work, n: int, m: int):
    """Write ∂V/∂q to `dq` and ``G M⁻¹`` to `response`: ∂H/∂p is linear, its argument a row of G."""
    for a in range(m):
        gradients(params, t, q, part(G, a * n, n), dq, part(response, a * n, n), work)


@helper
def displace(q, carry, step, lam, own: Work, n: int, m: int):
    """Write the `increment` ``free − h²/2 M⁻¹G(q)ᵀλ``, the new q rounded (`Q`), and what that loses.

    Multiplied by h/2 and h as the momentum is: the rounding of h²/2, the same in every step, made the
    angular momentum of a pendulum drift by 0.006 ε a step.
    """
    for i in range(n):
        by = own.free[i] - step * (0.5 * step * along(n, m, i, own.response, lam))
        z = carry[i] + by
        s = q[i] + z
        shadow = s - q[i]
        own.increment[i] = by
        own.Q[i] = s
        own.rest[i] = (q[i] - (s - shadow)) + (z - shadow)


@helper
def project_on_manifold(
    constraint, params, given: Coefficients, q, carry, step, lam, own: Work, n: int, m: int
) -> Step:
    """Find λ with ``g(q + free − h²/2 M⁻¹G(q)ᵀλ) = 0`` by Newton's method, started from `lam`.

    Writes λ, the `increment` of q, the new q rounded (`Q`) and its Jacobian `G1`. The part `rest`
    that rounding takes from Q enters the residual: g vanishes at Q + rest, to its own rounding.
    The iteration ends with a change that is less than the tolerance or round-off, or no longer
    falls. That is not left out: h λ would be wrong by as much, so that neighbouring steps differ by
    1/h times the rounding of q.
    """
    Q, rest, G = own.Q, own.rest, own.G1
    response, matrix, g = own.response, own.matrix, own.g
    cap, tolerance = int(given.cap[0]), given.tolerance[0]
    zero = 0.0 * q[0]
    per_force = 1.0 / (0.5 * step * step)
    q_inverse = inverse_size(larger(q, own.free, n))
    last = like(BEGINNING, zero)
    going = like(1.0, zero)  # 0 in the lanes that have converged: they change no more
    for iteration in range(cap):
        displace(q, carry, step, lam, own, n, m)
        constraint(params, Q, g, G, own.scratch)
        contract(n, m, G, response, matrix)
        size = top(largest(m * m, matrix))
        if not finite(size):
            return NOT_FINITE, iteration + 1, size
        for a in range(m):
            g[a] += across(n, a, G, rest)
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
            displace(q, carry, step, lam, own, n, m)
            constraint(params, Q, g, G, own.scratch)
            return OK, iteration + 1, worst
        last = delta
    return LOST_RANK if near_loss(m, matrix) else NOT_CONVERGED, cap, top(last)


@inlined
def separable_rattle_step(
    functions, params, given: Coefficients, memory, work, t, h, n: int, m: int
) -> Step:
    """One step of Hairer, Lubich, Wanner, *Geometric Numerical Integration*, VII.1 (1.27).

    ::

        P  = p − h/2 (V_q(t₀, q) + G(q)ᵀ λ)
        q₁ = q + h M⁻¹P,                              g(q₁) = 0
        p₁ = P − h/2 (V_q(t₁, q₁) + G(q₁)ᵀ μ),        G(q₁) M⁻¹p₁ = 0

    The second line fixes λ, by Newton's method with the matrix ``h²/2 G(q₁) M⁻¹ G(q)ᵀ``; the
    third is linear in μ. A clock row is integrated by the trapezoidal rule: symmetric, so
    compositions raise its order too.
    """
    gradients, constraint, clock = functions
    clock_rows = int(given.clock_rows[0])
    qp, passed, carry, lam = sections(memory, separable_rattle_memory(n, m, clock_rows))
    q, p, p_carry = part(qp, 0, n), part(qp, n, n), part(carry, n, n)
    own = sections(work, separable_rattle_work(n, m, REST))
    kick, free, increment, Q, _, force, unused, G0, G1, response, matrix, g, scratch = own
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
        free[i] *= step
    status, iterations, residual = project_on_manifold(
        constraint, params, given, q, carry, step, lam, own, n, m
    )
    if status != OK:
        return status, iterations, residual

    slopes(gradients, params, t1, Q, G1, force, response, scratch, n, m)
    for i in range(n):
        kick[i] = (kick[i] - half * along(n, m, i, G0, lam)) - half * force[i]
        free[i] = p[i] + (p_carry[i] + kick[i])
    contract(n, m, G1, response, matrix)
    for a in range(m):
        g[a] = across(n, a, response, free)
    solve_small(m, matrix, g)
    worst = 0.0 * step
    for i in range(n):
        kick[i] -= along(n, m, i, G1, g)
        worst = maximum(abs(kick[i]), worst)
    largest = top(worst)
    if not finite(largest):
        return NOT_FINITE, iterations, largest
    if m > 1 and lost_rank(m, matrix, n, p, kick, largest, force, step):
        return LOST_RANK, iterations, largest
    for i in range(n):
        add_compensated(q, carry, i, increment[i])
        add_compensated(p, p_carry, i, kick[i])
    if clock_rows > 0:
        end_rate = clock(params, t1, qp, scratch)
        by = half * (start_rate + end_rate)
        add_compensated(passed, part(carry, 2 * n, 1), 0, by)
    return OK, iterations, residual


def separable_rattle_stepper(n: int, m: int) -> Recorded:
    """Return the stepper of RATTLE for separable H, as `rattle_stepper` does for any."""
    return rattle_stepper(n, m, separable_rattle_step)
