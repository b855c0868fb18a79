"""How fast directions grow along a run: Lyapunov exponents of the numerical map.

Directions are carried along by some steps at once and made orthonormal again, in their order: with
``X = Q' R`` the first k of them span what the first k have become, and log R_kk is what a volume of k
directions grows by more than one of k − 1 (G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn,
Meccanica 15 (1980) 9).
"""

from ..compiling.bound import Bound
from ..compiling.number_types import NumberType
from ..compiling.recorded import helper
from ..numbers.arithmetic import sqrt
from ..numbers.blocks import sections
from ..solve.compensated import add_compensated
from ..solve.status import NOT_FINITE, OK, Steps
from .directions import carry, gather, log_stretch, turn_stages
from .layout import kept_layout, lanes_for, sizes_of, work_layout
from .near_identity import log_one_plus
from .normals import write_normals
from .signature import sweep


@helper
def growth(
    kernel, functions, manifold, params, coefficients, fractions, layout, memory, work, numbers,
    plain, scratch, conditions, conditions_plain, t0: float, h: float, first: int, times: int,
    steps: int, sums, carries, second,
) -> Steps:  # fmt: skip
    """Add to `sums` the logarithms by which directions grow, with `carries` of the sums.

    Parameters
    ----------
    first, times, steps : int
        Steps taken before; how often so many steps are taken at once.
    second : block, shape (2,)
        The second of two vectors that began as the first two directions, in these: of length 1.

    Returns
    -------
    status, done, iterations, residual
        As a stepper does.
    """
    s = sizes_of(layout)
    method = (kernel, functions, params, coefficients, fractions)
    kept, own = sections(memory, kept_layout(s)), sections(work, work_layout(s))
    width = lanes_for(s.d)
    used = 0
    for k in range(times):
        before = first + k * steps
        status, done, iterations, residual = carry(
            method, t0, h, before, steps, s, kept, numbers, plain, scratch, own.D
        )
        used += iterations
        if status != OK:
            return status, k * steps + done, used, residual
        gather(s, plain)
        for r in range(s.rows):
            kept.state[r] = plain[r * (1 + s.at_once)]
        t = t0 + (before + steps) * h
        write_normals(manifold, params, t, kept.state, s, kept, own, conditions, conditions_plain)
        volume, size = log_stretch(s, kept, own)
        if not abs(volume) < 1e300:
            return NOT_FINITE, k * steps, used, size
        turn_stages(s, own.upper, plain)
        for i in range(s.d):
            add_compensated(sums, carries, i, 0.5 * log_one_plus(own.S[i * width + i]))
        if s.d > 1:
            along = second[0] - own.upper[1] / own.upper[width + 1] * second[1]
            across = own.upper[0] / own.upper[width + 1] * second[1]
            length = sqrt(along * along + across * across)
            second[0], second[1] = along / length, across / length
    return OK, times * steps, used, 0.0


def growth_sweep(
    kernel: Bound, functions: tuple[Bound, ...], manifold: Bound, numbers: NumberType
) -> Bound:
    """Return `growth` for a stepper's loop and the functions that it takes, all in tangent numbers."""
    return sweep(growth, kernel, functions, manifold, numbers)
