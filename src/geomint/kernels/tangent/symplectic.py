"""How much a numerical step changes a symplectic form, of each step of a run.

With an orthonormal basis Q of the tangent space at y₀ and the tangent part X = Q + D of DΦ Q at y₁,
the form has changed by ::

    E(i, j) = ω_y₁(X_i, X_j) − ω_y₀(Q_i, Q_j)
            = ω_y₁(M_i, D_j) + ω_y₁(D_i, M_j) + (ω_y₁ − ω_y₀)(Q_i, Q_j)

with M = Q + ½ D: of a form that is the same everywhere the last term is 0, and E is known to the
relative accuracy of D, which is of the size of the step. The defect is ‖E‖ over ‖ω_y₁(X_i, X_j)‖
(Frobenius), all in units of the pieces, so that it has no unit.
"""

from ..compiling.bound import Bound
from ..compiling.number_types import NumberType
from ..compiling.recorded import helper
from ..numbers.arithmetic import NAN, sqrt
from ..numbers.blocks import part, sections
from ..solve.status import OK
from .directions import begin_at, carry, log_stretch, settle, turn_stages
from .layout import Kept, Sizes, Work, kept_layout, lanes_for, sizes_of, work_layout
from .normals import write_normals
from .signature import sweep


@helper
def write_column(s: Sizes, kept: Kept, A, factor: float, B, column: int, out):
    """Write a column of ``A + factor B``, in the numbers of the state."""
    width = lanes_for(s.d)
    for r in range(s.n):
        at = r * width + column
        out[r] = kept.scales[r] * (A[at] + factor * B[at])


@helper
def form_defect(
    form, constant: int, params, t: float, h: float, y, state, s: Sizes, kept: Kept, work: Work
) -> float:
    """Return ‖E‖ over ‖ω‖ of a step from y to `state`; NaN if the form is 0."""
    before, after = part(y, 0, s.n), part(state, 0, s.n)
    X, D, u, v = work.X, work.D, work.u, work.v
    changed, size = 0.0, 0.0
    for i in range(s.d):
        for j in range(i):
            write_column(s, kept, X, -0.5, D, i, u)
            write_column(s, kept, D, 0.0, D, j, v)
            change = form(params, t + h, after, u, v, work.scratch)
            write_column(s, kept, D, 0.0, D, i, u)
            write_column(s, kept, X, -0.5, D, j, v)
            change += form(params, t + h, after, u, v, work.scratch)
            if constant == 0:
                write_column(s, kept, X, -1.0, D, i, u)
                write_column(s, kept, X, -1.0, D, j, v)
                here = form(params, t + h, after, u, v, work.scratch)
                change += here - form(params, t, before, u, v, work.scratch)
            write_column(s, kept, X, 0.0, D, i, u)
            write_column(s, kept, X, 0.0, D, j, v)
            value = form(params, t + h, after, u, v, work.scratch)
            changed += change * change
            size += value * value
    return sqrt(changed / size) if size > 0.0 else NAN


@helper
def symplectic(
    kernel, functions, manifold, params, coefficients, fractions, layout, memory, work, numbers,
    plain, scratch, conditions, conditions_plain, form, constant: int, starts, lengths, states, out,
):  # fmt: skip
    """Write the defects of the steps that lead to `states`; the arguments are those of `measure`."""
    s = sizes_of(layout)
    method = (kernel, functions, params, coefficients, fractions)
    kept, own = sections(memory, kept_layout(s)), sections(work, work_layout(s))
    y = kept.state
    for k in range(len(starts)):
        t, h = starts[k], lengths[k]
        state = part(states, k * s.rows, s.rows)
        settle(layout, manifold, params, t, state, s, kept, own, conditions, conditions_plain)
        write_normals(
            manifold, params, t + h, state, s, kept, own, conditions, conditions_plain
        )  # fmt: skip
        defect = NAN
        begin_at(s, y, plain)
        if carry(method, t, h, 0, 1, s, kept, numbers, plain, scratch, own.D)[0] == OK:
            _, squares = log_stretch(s, kept, own)
            turn_stages(s, own.upper, plain)
            defect = form_defect(form, constant, params, t, h, y, state, s, kept, own)
            kept.variance[0] = max(kept.variance[0], squares)
        out[k] = defect
        for r in range(s.rows):
            y[r] = state[r]


def symplectic_sweep(
    kernel: Bound, functions: tuple[Bound, ...], form: Bound, manifold: Bound, numbers: NumberType
) -> Bound:
    """Return `symplectic` for a stepper's loop and the functions that it takes, in tangent numbers."""
    return sweep(symplectic, kernel, functions, manifold, numbers, form=form.signature)
