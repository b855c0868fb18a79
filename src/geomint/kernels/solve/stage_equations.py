"""The equations of a step for all stages of a Gauss method: what they lack, Jacobians, factors.

Unknown are the increments L of `geomint.kernels.solve.gauss`, and what is to vanish is
``R_i = L_i − h b_i f(t + c_i h, y + Σ_j μ_ij L_j)``. Its derivative is approximated in two ways:

- with one Jacobian J for all stages, the mean of theirs. With ``B A B⁻¹ = V Λ V⁻¹``, B = diag(b), the
  change of L is ``V (1 − h Λ ⊗ J)⁻¹ V⁻¹ R``: complex systems of the size of the state, one for each
  stage and each in a lane of its own (J. C. Butcher, BIT 16 (1976) 237; T. A. Bickart, SIAM J. Numer.
  Anal. 14 (1977) 1005; Hairer, Wanner, Solving Ordinary Differential Equations II, IV.8);
- with the Jacobian of each stage, a system for all of them together.

Matrices are plain numbers; L, and what is solved for, may have derivatives.
"""

from collections import namedtuple

from ..compiling.recorded import helper, inlined
from ..numbers.arithmetic import lane, like, plain, total
from ..numbers.blocks import REST, as_lanes, as_numbers, part, sections, set_lane
from .gauss import combine, eight_columns, gauss_coefficients, gauss_memory, padding, stage_sums
from .stage_matrices import factor_lanes, factor_whole, padded, solve_lanes, solve_whole

MOST_WHOLE = 1024  # unknowns of all stages together: their matrix takes 8 MB, factors 0.2 s

Numbers = namedtuple(
    "Numbers", "stages first cap patience params padding eigen_real eigen_imaginary into_real "
    "into_imaginary out_real out_imaginary"
)  # fmt: skip
Work = namedtuple(
    "Work",
    "Y F scales padding begun change real imaginary vector params jacobian matrix order scratch",
)
Stages = namedtuple(
    "Stages", "y carry L begun change real imaginary Y F scales scratch vector matrix order jacobian "
    "values jacobian_scratch params c b mu pieces numbers first count"
)  # fmt: skip


@inlined
def newton_coefficients(groups: int) -> Numbers:
    """Return the layout of what stands behind the coefficients of the fixed-point iteration.

    How many stages there are and in which lane the first is; the cap on iterations; how many numbers
    `params` has; in lanes Λ, and the columns of V⁻¹ and V, those of the imaginary part of V negative.
    """
    lanes = 8 * groups
    return Numbers(
        stages=1,
        first=1,
        cap=1,
        patience=1,
        params=1,
        padding=3,
        eigen_real=lanes,
        eigen_imaginary=lanes,
        into_real=lanes * lanes,
        into_imaginary=lanes * lanes,
        out_real=lanes * lanes,
        out_imaginary=lanes * lanes,
    )


@inlined
def whole_size(rows: int, stages: int) -> int:
    """Return the number of unknowns of all stages together, 0 where they are too many."""
    size = rows * stages
    return size if size <= MOST_WHOLE else 0


@inlined
def newton_work(rows: int, groups: int, stages: int, params: int, scratch: int) -> Work:
    """Return the layout of scratch, in numbers; `scratch` for the field, and for its Jacobian."""
    size, whole = 8 * groups * rows, whole_size(rows, stages)
    return Work(
        Y=size,
        F=size,
        scales=rows,
        padding=padding(rows),
        begun=size,
        change=size,
        real=size,
        imaginary=size,
        vector=padded(max(whole, rows)),
        params=padded(params),
        jacobian=size * rows,
        matrix=max(2 * size * rows, whole * padded(whole)),
        order=padded(max(whole, rows)),
        scratch=scratch,
    )


@inlined
def stages_of(coefficients, memory, work, groups: int, rows: int):
    """Return all that Newton's iteration reads and writes, by name."""
    given = sections(coefficients, gauss_coefficients(rows, groups, REST))
    layout = newton_coefficients(groups)
    behind = part(coefficients, len(coefficients) - sum(layout), sum(layout))
    numbers = sections(behind, layout)
    count, first = int(numbers.stages[0]), int(numbers.first[0])
    y, carry, _, increments = sections(memory, gauss_memory(rows, groups))
    own = sections(work, newton_work(rows, groups, count, int(numbers.params[0]), REST))
    size = rows * groups
    free = as_numbers(own.scratch)
    return Stages(
        y=y,
        carry=carry,
        L=as_lanes(increments, 0, size),
        begun=as_lanes(own.begun, 0, size),
        change=as_lanes(own.change, 0, size),
        real=as_lanes(own.real, 0, size),
        imaginary=as_lanes(own.imaginary, 0, size),
        Y=as_lanes(own.Y, 0, size),
        F=as_lanes(own.F, 0, size),
        scales=own.scales,
        scratch=as_lanes(own.scratch, 0, len(own.scratch) // 8),
        vector=own.vector,
        matrix=as_numbers(own.matrix),
        order=as_numbers(own.order),
        jacobian=as_lanes(as_numbers(own.jacobian), 0, size * rows),
        values=as_lanes(as_numbers(own.real), 0, size),
        jacobian_scratch=as_lanes(free, 0, len(own.scratch) // 8),
        params=part(as_numbers(own.params), 0, int(numbers.params[0])),
        c=as_lanes(given.c, 0, groups),
        b=as_lanes(given.b, 0, groups),
        mu=as_lanes(given.mu, 0, 8 * groups * groups),
        pieces=given.pieces,
        numbers=numbers,
        first=first,
        count=count,
    )


@inlined
def write_lack(field, params, s, t, h, groups: int, rows: int):
    """Write R into `change`, and the stages into Y."""
    stage_sums(eight_columns(s.mu, 0, 0, groups), s.mu, s.L, s.y, s.carry, s.Y, groups, rows)
    for g in range(groups):
        field(
            params, t + s.c[g] * h, part(s.Y, g * rows, rows), part(s.F, g * rows, rows), s.scratch
        )
    for g in range(groups):
        weights = s.b[g] * h
        for r in range(g * rows, (g + 1) * rows):
            s.change[r] = s.L[r] - weights * s.F[r]


@inlined
def write_jacobians(jacobians, s, t, h, groups: int, rows: int):
    """Write the Jacobian at each stage Y."""
    for i in range(groups * rows):
        s.values[i] = plain(s.Y[i])
    for g in range(groups):
        out = part(s.jacobian, g * rows * rows, rows * rows)
        own = part(s.values, g * rows, rows)
        jacobians(s.params, t + s.c[g] * h, own, out, s.jacobian_scratch)


@helper
def transform(columns, source, target, more: bool, groups: int, rows: int):
    """Write, or add, ``Σ_j columns_ij source_j`` for all stages."""
    for own in range(groups):
        for other in range(groups):
            n = eight_columns(columns, other, own, groups)
            for r in range(rows):
                known = source[other * rows + r]
                start = target[own * rows + r] if more or other > 0 else like(0.0, known)
                target[own * rows + r] = combine(n, known, start)


@helper
def factor_mean(s, h, groups: int, rows: int):
    """Factor ``1 − h Λ ⊗ J``, J the mean of the Jacobians at the stages."""
    size = rows * rows
    real = as_lanes(s.numbers.eigen_real, 0, groups)
    imaginary = as_lanes(s.numbers.eigen_imaginary, 0, groups)
    for g in range(groups):
        p = as_lanes(s.matrix, 16 * g * size, size)
        q = as_lanes(s.matrix, 16 * g * size + 8 * size, size)
        u, v = h * real[g], h * imaginary[g]
        for e in range(size):
            mean = total(s.b[0] * s.jacobian[e])
            for other in range(1, groups):
                mean += total(s.b[other] * s.jacobian[other * size + e])
            p[e] = (1.0 if e % (rows + 1) == 0 else 0.0) - u * mean
            q[e] = -(v * mean)
        factor_lanes(rows, p, q, part(s.order, g * rows, rows))


@helper
def solve_mean(s, groups: int, rows: int):
    """Replace R in `change` by the change of L that the factors of `factor_mean` give."""
    n, size, columns = s.numbers, rows * rows, 8 * groups * groups
    transform(as_lanes(n.into_real, 0, columns), s.change, s.real, False, groups, rows)
    transform(as_lanes(n.into_imaginary, 0, columns), s.change, s.imaginary, False, groups, rows)
    for g in range(groups):
        p = as_lanes(s.matrix, 16 * g * size, size)
        q = as_lanes(s.matrix, 16 * g * size + 8 * size, size)
        x, y = part(s.real, g * rows, rows), part(s.imaginary, g * rows, rows)
        solve_lanes(rows, p, q, part(s.order, g * rows, rows), x, y)
    transform(as_lanes(n.out_real, 0, columns), s.real, s.change, False, groups, rows)
    transform(as_lanes(n.out_imaginary, 0, columns), s.imaginary, s.change, True, groups, rows)


@helper
def factor_stages(s, h, groups: int, rows: int):
    """Factor the derivative of R by L, with the Jacobian of each stage."""
    n = s.count * rows
    width, lanes = padded(n), 8 * groups
    b, mu, J = as_numbers(s.b), as_numbers(s.mu), as_numbers(s.jacobian)
    for i in range(s.count):
        at = s.first + i
        own = (at // 8) * rows * rows
        for r in range(rows):
            row = (i * rows + r) * width
            for j in range(s.count):
                weight = h * b[at] * mu[(s.first + j) * lanes + at]
                for k in range(rows):
                    unit = 1.0 if i == j and r == k else 0.0
                    slope = J[8 * (own + r * rows + k) + at % 8]
                    s.matrix[row + j * rows + k] = unit - weight * slope
            for k in range(n, width):
                s.matrix[row + k] = 0.0
    factor_whole(n, s.matrix, s.order)


@helper
def solve_stages(s, rows: int):
    """Write into `vector` what the factors of `factor_stages` make of R."""
    for i in range(s.count):
        at = s.first + i
        for r in range(rows):
            s.vector[i * rows + r] = lane(s.change[(at // 8) * rows + r], at % 8)
    solve_whole(s.count * rows, s.matrix, s.order, s.vector)


@helper
def solve_all(s, groups: int, rows: int):
    """Replace R in `change` by the change of L that the factors of `factor_stages` give."""
    solve_stages(s, rows)
    for i in range(groups * rows):
        s.change[i] = like(0.0, s.L[i])
    for i in range(s.count):
        at = s.first + i
        for r in range(rows):
            set_lane(s.change, (at // 8) * rows + r, at % 8, s.vector[i * rows + r])
