"""RATTLE with s stages: the pair of Lobatto IIIA and IIIB, all stages at once in lanes.

With ``L_j = G(Q_j)ᵀ λ_j − (h b_j) H_q(Q_j, P_j)`` and ``K_j = (h b_j) H_p(Q_j, P_j)`` ::

    Q_i = q + Σ_j μ_ij K_j,    P_i = p + Σ_j ν_ij L_j,    g(Q_i) = 0,
    q₁ = Q_s,    p₁ = p + Σ_j L_j,    G(q₁) H_p(q₁, p₁) = 0

(Hairer, Lubich, Wanner, *Geometric Numerical Integration*, VII.1.4), where ``μ_ij + ν_ji = 1`` holds
exactly in floating point. As Q_1 = q, and no P_i sees λ_s, the constraints of the stages 2 … s
determine the multipliers of the stages 1 … s − 1, and the hidden one λ_s.

Stages are in lanes, the first in lane 0 and the last in lane 7; lanes between them that are not used
have zero weights and stay at (q, p).
"""

import functools
from collections import namedtuple

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import lane, maximum, plain, slope_count, top
from ..numbers.blocks import REST, as_lanes, part, sections
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
from .gauss import combine, eight_columns, increment, padding
from .rattle import CLEAN, NEWTON, add_normal_response, drop_rounding, project_momentum
from .small_matrices import across, along, contract, largest, near_loss, solve_small
from .status import LOST_RANK, NOT_CONVERGED, NOT_FINITE, OK

Coefficients = namedtuple(
    "Coefficients",
    "rows constraints cap tolerance clock_rows padding c b later last mu nu impulses predictors",
)
Memory = namedtuple("Memory", "state clock carry padding K L lam")
Work = namedtuple("Work", "Q P dp0 dp1 trial pushes three G1 response matrix g scratch")

FOLLOW = 4.0


@inlined
def lobatto_coefficients(substeps: int) -> Coefficients:
    """Return the layout of coefficients: in lanes c, b, which stages move, which is last; matrices.

    The matrices are in columns. Substeps: `REST`, any number.
    """
    return Coefficients(
        rows=1,
        constraints=1,
        cap=1,
        tolerance=1,
        clock_rows=1,
        padding=3,
        c=8,
        b=8,
        later=8,
        last=8,
        mu=64,
        nu=64,
        impulses=64,
        predictors=64 * substeps,
    )


@inlined
def lobatto_memory(n: int, m: int, clock: int) -> Memory:
    """Return the layout of memory: state (q, p), clock, the carries of all; K, L and λ in lanes."""
    rows = 2 * n + clock
    return Memory(2 * n, clock, rows, padding(2 * rows), 8 * n, 8 * n, 8 * m)


@inlined
def lobatto_work(n: int, m: int, scratch: int) -> Work:
    """Return the layout of scratch, in lane values; the names are those of `rattle_work`."""
    return Work(n, n, n, n, n, n, 3 * n, m * n, m * n, m * m, m, scratch)


@inlined
def lane_rows(block, rows: int):
    """Return a block of single numbers as so many lane values."""
    return as_lanes(block, 0, rows)


@inlined
def lobatto_step(
    functions, params, coefficients, substep: int, memory, work, t, h, n: int, m: int
) -> tuple[int, int, float]:
    """Solve for the stages by fixed-point iteration; inside each a Newton step for all multipliers.

    A stage that lacks w of its constraints is moved along ``R_i = H_pp G(Q_i)ᵀ``, and the multipliers
    by what would move the stages so if G H_pp Gᵀ were the same at all of them; near to where it loses
    rank, and is not, by `push_along_normals`. A clock row is integrated by Lobatto's quadrature, as a
    component of q would be.
    """
    gradients, constraint, _ = functions
    given = sections(coefficients, lobatto_coefficients(REST))
    cap, tolerance = int(top(given.cap[0])), top(given.tolerance[0])
    clock_rows = int(top(given.clock_rows[0]))
    c, b = lane_rows(given.c, 1)[0], lane_rows(given.b, 1)[0]
    later, final = lane_rows(given.later, 1)[0], lane_rows(given.last, 1)[0]
    kept = sections(memory, lobatto_memory(n, m, clock_rows))
    q, p = part(kept.state, 0, n), part(kept.state, n, n)
    carry_q, carry_p = part(kept.carry, 0, n), part(kept.carry, n, n)
    K, L, lam = lane_rows(kept.K, n), lane_rows(kept.L, n), lane_rows(kept.lam, m)
    lanes = as_lanes(work, 0, len(work) // 8)
    own = sections(lanes, lobatto_work(n, m, REST))
    Q, P, dq, dp, trial, pushes, _, G, response, matrix, g, scratch = own
    zero = 0.0 * c
    one = zero + 1.0
    times = zero + t + c * h
    weights = b * h
    inverse_h = 1.0 / h

    columns = eight_columns(as_lanes(given.predictors, 64 * substep, 8), 0, 0, 1)
    for i in range(n):
        K[i] = combine(columns, K[i], zero)
        L[i] = combine(columns, L[i], zero)
    for a in range(m):
        lam[a] = (one - final) * combine(columns, lam[a], zero)
    mu = eight_columns(lane_rows(given.mu, 8), 0, 0, 1)
    nu = eight_columns(lane_rows(given.nu, 8), 0, 0, 1)
    impulses = eight_columns(lane_rows(given.impulses, 8), 0, 0, 1)
    for i in range(n):
        Q[i] = q[i] + combine(mu, K[i], zero + carry_q[i])
        P[i] = p[i] + combine(nu, L[i], zero + carry_p[i])
        pushes[i] = zero
    last = BEGINNING
    before = BEGINNING
    coarse = True
    near = False  # to where constraints depend on each other
    held = 0.0  # iterations since values have converged: slopes, whose rounding is larger, follow
    settle = FOLLOW if slope_count(q[0]) > 0 else 0.0
    q_inverse = 0.0
    p_inverse = 0.0
    for iteration in range(cap):
        gradients(params, times, Q, P, dq, dp, scratch)
        for i in range(n):
            K[i] = weights * dp[i]
            trial[i] = q[i] + combine(mu, K[i], zero + carry_q[i])
        constraint(params, trial, g, G, scratch)
        drop_rounding(g, G, trial, n, m)
        if coarse:
            for i in range(m * n):
                response[i] = zero
            add_normal_response(gradients, params, times, Q, P, dp, G, one, own, n, m)
        contract(n, m, G, response, matrix)
        size = top(largest(m * m, matrix))
        if not finite(size):
            return failure(iteration), iteration + 1, size
        solve_small(m, matrix, g)
        for a in range(m):
            g[a] *= later
        if coarse:
            q_inverse = inverse_size(max(top(larger(q, q, n)), top(larger(K, K, n))))
            p_inverse = inverse_size(max(top(larger(p, p, n)), top(larger(L, L, n))))
        worst = 0.0 * plain(c)
        near = near_loss(m, matrix) if coarse and iteration < 2 else near
        if near:
            push_along_normals(impulses, -inverse_h, L, weights, coarse, lam, own, n, m)
        else:
            for a in range(m):
                lam[a] -= inverse_h * combine(impulses, g[a], zero)
        for i in range(n):
            push = weights * dq[i]
            L[i] = along(n, m, i, G, lam) - push
            lack = along(n, m, i, response, g)
            new = trial[i] - lack
            worst = maximum(abs(plain(new) - plain(Q[i])) * q_inverse, worst)
            worst = maximum(abs(plain(lack)) * q_inverse, worst)
            worst = maximum(abs(plain(push) - plain(pushes[i])) * p_inverse, worst)
            Q[i] = new
            P[i] = p[i] + combine(nu, L[i], zero + carry_p[i])
            pushes[i] = push
        delta = top(worst)
        if not finite(delta):
            return failure(iteration), iteration + 1, delta
        rounding = rounding_left(delta, c) or (near and delta <= NEWTON_ROUNDING)
        done = solved(delta, last, before, tolerance, rounding, iteration + 1 == cap)
        held = held + 1.0 if done or held > 0.0 else held
        if held > settle:
            end = zero + (t + h)
            left = finish(functions, params, kept, own, lanes, times, weights, final, end, n, m)
            if not left <= CLEAN:
                return NOT_CONVERGED if finite(left) else NOT_FINITE, NEWTON, left
            return OK, iteration + 1, delta
        coarse = delta > COARSE
        before = last
        last = delta
    return LOST_RANK if near else NOT_CONVERGED, cap, last


@helper
def push_along_normals(impulses, per, L, weights, coarse: bool, lam, own: Work, n: int, m: int):
    """Add to the multipliers what moves the stages by what they lack, a vector of R^n each.

    The forces that do so are found as vectors, and split along the normals of the stages that they act
    on: a normal that is short, or changes its sign, has a multiplier that is large, or does so too, but
    a force that is smooth. For the same reason multipliers begin with what L holds along the normals,
    not with those of the last step.
    """
    aim, hold, by = part(own.three, 0, n), part(own.three, n, n), part(own.three, 2 * n, m)
    zero = 0.0 * weights
    for i in range(n):
        aim[i] = per * combine(impulses, along(n, m, i, own.response, own.g), zero)
        hold[i] = L[i] + weights * own.dp0[i]
    for a in range(m):
        by[a] = across(n, a, own.G1, aim)
        if coarse:
            by[a] += across(n, a, own.response, hold)
            lam[a] = zero
    contract(n, m, own.G1, own.response, own.matrix)
    solve_small(m, own.matrix, by)
    for a in range(m):
        lam[a] += by[a]


@helper
def finish(
    functions, params, kept: Memory, own: Work, lanes, times, weights, final, end, n: int, m: int
):
    """Add the update of solved stages, with the multiplier of the last; where it is found, in memory.

    Returns what `project_momentum` does: the update is not added where that has not ended. What is
    done for one state only is done in all lanes alike.
    """
    gradients, constraint, clock = functions
    q, p = part(kept.state, 0, n), part(kept.state, n, n)
    carry_q, carry_p = part(kept.carry, 0, n), part(kept.carry, n, n)
    K, L, lam = lane_rows(kept.K, n), lane_rows(kept.L, n), lane_rows(kept.lam, m)
    Q, P, by, G, g = own.Q, own.P, own.trial, own.G1, own.g
    zero = 0.0 * times
    passed = zero
    if len(kept.clock) > 0:
        passed = weights * clock(params, times, part(lanes, 0, 2 * n), own.scratch)
    for i in range(n):
        by[i] = zero + (increment(K, i, 1, n) - lane(along(n, m, i, own.response, g), 7))
        Q[i] = zero + (q[i] + (carry_q[i] + lane(by[i], 0)))
        P[i] = zero + (p[i] + (carry_p[i] + increment(L, i, 1, n)))
    constraint(params, Q, g, G, own.scratch)
    left = top(project_momentum(gradients, params, end, own, n, m))
    if left <= CLEAN:
        for i in range(n):
            add_compensated(q, carry_q, i, lane(by[i], 0))
            without = increment(L, i, 1, n)
            pushed = lane(P[i], 0) - (p[i] + (carry_p[i] + without))
            by[i] = zero + pushed
            L[i] += final * pushed
            add_compensated(p, carry_p, i, without + pushed)
        contract(n, m, G, G, own.matrix)
        for a in range(m):
            g[a] = across(n, a, G, by)
        solve_small(m, own.matrix, g)
        for a in range(m):
            lam[a] += final * g[a]
        if len(kept.clock) > 0:
            by[0] = passed
            add_compensated(kept.clock, part(kept.carry, 2 * n, 1), 0, increment(by, 0, 1, n))
    return left


@functools.cache
def lobatto_stepper(n: int, m: int) -> Recorded:
    """Return the stepper; it takes (gradients, constraint, clock), all for eight numbers at once.

    The length n of q and the number m of constraints are constants to the compiler; (0, 0): any.
    """

    @helper
    def lobatto(functions, params, coefficients, substep, memory, work, t, h):
        given = sections(coefficients, lobatto_coefficients(REST))
        rows = n if n > 0 else int(top(given.rows[0]))
        rank = m if m > 0 else int(top(given.constraints[0]))
        return lobatto_step(
            functions, params, coefficients, substep, memory, work, t, h, rows, rank
        )

    return stepper(lobatto)
