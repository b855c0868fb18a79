"""How much a numerical step stretches the measure ``μ δ(c) dy`` on {c(y) = 0}, along a run.

The defect of a step Φ from y₀ to y₁ is, with orthonormal bases Q of ker Dc and C = Dc, ::

    log|det(Q₁ᵀ DΦ Q₀)| + ½ log det(C₀C₀ᵀ) − ½ log det(C₁C₁ᵀ) + log μ₁ − log μ₀

Only the first term has to be summed. With the tangent part X of ``DΦ Q₀``, the one that the normals
N₁ leave of it, it is ``½ log det(XᵀX)``, and with D = X − Q₀, which the compensated sums of a step
know to its own relative precision, ::

    XᵀX = 1 + S,   S = MᵀD + DᵀM,   M = Q₀ + ½ D

where S is of the size of the step, and so are its errors. The factor R of ``RᵀR = 1 + S`` gives the
determinant and the next directions, ``X R⁻¹``: what a method remembers of a step stays of use.

All is done in units of the pieces of the state. For a step that leaves the manifold they decide what
"the tangent part" is: see `geomint.watch.measure`.
"""

from ..compiling.bound import Bound
from ..compiling.number_types import NumberType
from ..compiling.recorded import helper
from ..numbers.arithmetic import NAN
from ..numbers.blocks import part, sections
from ..solve.compensated import add_compensated
from ..solve.status import OK
from .directions import begin_at, carry, log_stretch, settle, turn_stages
from .layout import kept_layout, sizes_of, work_layout
from .normals import write_normals
from .signature import sweep

EPSILON = 2.0**-52
# What a step may add to the sum whatever its rounding does: a relative error common to all derivatives
# (measured: up to 0.21 ε ‖D‖²), and for each condition what states are off the manifold in the mean
# (measured: up to ε/400).
SYSTEMATIC, OFF = EPSILON / 2.0, EPSILON / 128.0


@helper
def log_density_at(density, manifold, params, t, y, s, kept, work, numbers, plain):
    """Write the normals at y; return ``log μ − ½ log det(C Cᵀ)``."""
    volume = write_normals(manifold, params, t, y, s, kept, work, numbers, plain)
    return density(params, t, part(y, 0, s.n), work.scratch) - volume


@helper
def measure(
    kernel, functions, manifold, params, coefficients, fractions, layout, memory, work, numbers,
    plain, scratch, conditions, conditions_plain, density, starts, lengths, states, out,
):  # fmt: skip
    """Write the sum of the defects after each of the steps that lead to `states`.

    Parameters
    ----------
    kernel : function
        A stepper's loop of `geomint.kernels.solve.advance`, in tangent numbers.
    functions : tuple
        What it is to be called with.
    memory, work : block
        What is kept from step to step, and scratch: see `geomint.kernels.tangent.layout`.
    numbers, plain, scratch : block
        The stepper's memory, and the numbers that it is made of; its scratch.
    conditions, conditions_plain : block
        Room for a state, what `manifold` writes and its scratch, and the numbers that it is made of.
    starts, lengths : block
        Of the steps. The first begins at the state in memory.
    states : block
        The states after the steps, one after the other.
    """
    s = sizes_of(layout)
    method = (kernel, functions, params, coefficients, fractions)
    kept, own = sections(memory, kept_layout(s)), sections(work, work_layout(s))
    y, volume, origin = kept.state, kept.volume, kept.origin
    for k in range(len(starts)):
        t, h = starts[k], lengths[k]
        state = part(states, k * s.rows, s.rows)
        begins, before = kept.begun[0] == 0.0, volume[0]
        if settle(layout, manifold, params, t, state, s, kept, own, conditions, conditions_plain):
            volume[0] = log_density_at(
                density, manifold, params, t, y, s, kept, own, conditions, conditions_plain
            )
            origin[0] = volume[0] if begins else origin[0] + (volume[0] - before)
        volume[0] = log_density_at(
            density, manifold, params, t + h, state, s, kept, own, conditions, conditions_plain
        )  # fmt: skip
        stretch, squares = NAN, 0.0
        begin_at(s, y, plain)
        if carry(method, t, h, 0, 1, s, kept, numbers, plain, scratch, own.D)[0] == OK:
            stretch, squares = log_stretch(s, kept, own)
            turn_stages(s, own.upper, plain)
        kept.bias[0] += SYSTEMATIC * squares + OFF * s.m
        kept.variance[0] += EPSILON * EPSILON * squares
        add_compensated(kept.sum, kept.carry, 0, stretch)
        out[k] = kept.sum[0] + (kept.carry[0] + (volume[0] - origin[0]))
        for r in range(s.rows):
            y[r] = state[r]


def measure_sweep(
    kernel: Bound,
    functions: tuple[Bound, ...],
    density: Bound,
    manifold: Bound,
    numbers: NumberType,
) -> Bound:
    """Return `measure` for a stepper's loop and the functions that it takes, all in tangent numbers."""
    return sweep(measure, kernel, functions, manifold, numbers, density=density.signature)
