"""How much a numerical step stretches the measure ``μ δ(c) dy`` on {c(y) = 0}, along a run.

The defect of a step Φ from y₀ to y₁ is, with orthonormal bases Q of ker Dc and C = Dc, ::

    log|det(Q₁ᵀ DΦ Q₀)| + ½ log det(C₀C₀ᵀ) − ½ log det(C₁C₁ᵀ) + log μ₁ − log μ₀

Only ``log|det(Q₁ᵀ DΦ Q₀)|`` has to be summed. It is taken without the rounding of numbers near one:
with the unit normals N, the tangent part X of ``DΦ Q₀`` and E = Q₀ᵀX − 1, Z = Q₁ᵀN₀, ::

    log|det(Q₁ᵀ X)| = log|det(1 + E)| − ½ log det(1 − ZᵀZ)

where E and Z are of the size of the step, and so are their errors. E comes from
`geomint.kernels.measure.tangent_map`, Z from `geomint.kernels.measure.frames`.

All is done in units of the pieces of the state: powers of two that no number of the piece has
exceeded, so that |γ| = 1 beside |p| = 1e-150 loses nothing. Determinants do not depend on them unless
the step leaves the manifold.

The seventh differences of the increments give the variance of the sum that rounding causes, and E
gives a bound of its bias: together, what the instrument cannot distinguish from zero.
"""

from __future__ import annotations

from typing import Any

from ..compiling.bound import Bound
from ..compiling.recorded import helper
from ..compiling.signatures import BLOCK, Functions, takes
from ..numbers.arithmetic import NAN
from ..numbers.blocks import as_lanes, part, sections
from ..solve.compensated import add_compensated
from .frames import enlarge_scales, make_frame, normals_turned
from .memory import (
    EPSILON,
    Lanes,
    Memory,
    Work,
    lane_layout,
    memory_layout,
    sizes_of,
    work_layout,
)
from .reflections import log_det_near_identity, reflect, reflect_back
from .tangent_map import tangent_column

__all__ = ["measure_sweep"]

# What a relative error common to all derivatives, ε/8, may add in a step: measured are ε/50 and less.
SYSTEMATIC = EPSILON / 8.0


@helper
def log_stretch(
    method: Any, layout: Any, t: float, h: float, kept: Memory, lanes: Lanes, own: Work
) -> float:
    """Return ``log|det(Q₁ᵀ DΦ Q₀)|`` for the step from the state in memory, between the two frames."""
    n, m = len(kept.scales), len(kept.condition_scales)
    d = n - m
    bias, old, new = kept.bias, part(kept.old, 1, m * n), part(kept.new, 1, m * n)
    E, q, D = own.E, own.q, own.D
    x = own.x  # also the seventh difference
    good = True
    for k in range(d):
        for i in range(n):
            q[i] = 1.0 if i == m + k else 0.0
        reflect_back(m, old, q)
        good &= tangent_column(method, layout, t, h, q, kept, k, lanes, D, x)
        if (
            m > 0
        ):  # the part of q + D that leaves the manifold, which has only rounding if Φ does not
            for i in range(n):
                x[i] = q[i] + D[i]
            reflect(m, new, x)
            for i in range(d):
                x[m + i] = 0.0
            reflect_back(m, new, x)
            for i in range(n):
                D[i] = D[i] - x[i]
            reflect(m, old, D)
        for i in range(d):
            E[i * d + k] = D[m + i]
    for i in range(d * d):
        bias[0] = bias[0] + SYSTEMATIC * E[i] * E[i]
    stretch = log_det_near_identity(d, E)
    if m > 0:
        stretch -= normals_turned(n, m, old, new, x, own.Z, own.G)
    return stretch if good else NAN


@helper
def measure(
    kernel: Any,
    functions: Any,
    density: Any,
    manifold: Any,
    params: Any,
    coefficients: Any,
    fractions: Any,
    layout: Any,
    memory: Any,
    lane_numbers: Any,
    work: Any,
    starts: Any,
    lengths: Any,
    states: Any,
    out: Any,
) -> None:
    """Write the sum of the defects after each of the steps that lead to `states`.

    Parameters
    ----------
    kernel : function
        A stepper's loop of `geomint.kernels.solve.advance`, compiled for lanes; a call takes one step.
    functions : tuple
        What it is to be called with.
    starts, lengths : blocks
        Of the steps. The first begins at the state in memory.
    states : block
        The states after the steps, one after the other.
    """
    given = sizes_of(layout)
    rows, method = given.rows, (kernel, functions, params, coefficients, fractions)
    kept, own = sections(memory, memory_layout(given)), sections(work, work_layout(given))
    lanes = sections(as_lanes(lane_numbers, 0, len(lane_numbers) // 8), lane_layout(given))
    y, scales, old, new = kept.state, kept.scales, kept.old, kept.new
    total, carry, steps, begun, origin = kept.sum, kept.carry, kept.steps, kept.begun, kept.origin
    for k in range(len(starts)):
        t = starts[k]
        h = lengths[k]
        state = part(states, k * rows, rows)
        begins = begun[0] == 0.0
        remake = enlarge_scales(layout, state, scales) or begins
        before = old[0]
        for end in range(0 if remake else 1, 2):
            x, frame = (y, old) if end == 0 else (state, new)
            first = begins and end == 0
            make_frame(
                density, manifold, params, layout, t + end * h, x, kept, frame, lanes, own, first
            )
        if remake:
            origin[0] = old[0] if begins else origin[0] + (old[0] - before)
        stretch = log_stretch(method, layout, t, h, kept, lanes, own)
        begun[0] = 1.0
        steps[0] = steps[0] + 1.0
        add_compensated(total, carry, 0, stretch)
        out[k] = total[0] + (carry[0] + (new[0] - origin[0]))
        for i in range(len(new)):
            old[i] = new[i]
        for r in range(rows):
            y[r] = state[r]


_BLOCKS = (
    *("params", "coefficients", "fractions", "layout", "memory", "lane_numbers", "work"),
    *("starts", "lengths", "states", "out"),
)


def measure_sweep(
    kernel: Bound, functions: tuple[Bound, ...], density: Bound, manifold: Bound
) -> Bound:
    """Return `measure` for a loop in lanes and the functions that it takes."""
    taken = Functions(tuple(f.signature for f in functions))
    return Bound(
        measure,
        takes(
            None,
            kernel=kernel.signature,
            functions=taken,
            density=density.signature,
            manifold=manifold.signature,
            **dict.fromkeys(_BLOCKS, BLOCK),
        ),
    )
