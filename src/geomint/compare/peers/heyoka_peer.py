"""heyoka: adaptive Taylor series, compiled (F. Biscani, D. Izzo, MNRAS 504 (2021) 2614)."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from ...arguments import Array
from ...kernels.numbers.traced import Algebra
from ...problems.formulas import traced_field
from .peer import End, Motion, Peer, PeerError, Ready

COMPACT_ROWS = 40  # from there on compilation without compact mode takes minutes


def taylor(
    system: list[Any], tolerance: float, compact: bool
) -> tuple[Any, Callable[[Array, float], End]]:
    """Return heyoka's integrator of a system (variable, rate), and what runs it from y0 to an end."""
    hy = import_module("heyoka")
    integrator = hy.taylor_adaptive(
        system, [0.5] * len(system), tol=tolerance, compact_mode=compact, high_accuracy=False
    )
    reached = hy.taylor_outcome.time_limit

    def run(y0: Array, end: float) -> End:
        integrator.time = 0.0
        integrator.state[:] = y0
        outcome, _, _, steps, *_ = integrator.propagate_until(end)
        if outcome != reached:
            raise PeerError(f"{outcome} at {integrator.time:g}")
        return End(integrator.state.copy(), steps)

    return integrator, run


def start(motion: Motion) -> Callable[[float], Ready]:
    """State the motion as heyoka takes it."""
    hy = import_module("heyoka")
    algebra = Algebra(hy, hy.lt, hy.lte, hy.select)
    names = [f"y{i}" for i in range(len(motion.y0))]
    variables = [hy.expression(name) for name in names]
    system = [
        *zip(variables, traced_field(motion.problem, algebra, hy.time, variables), strict=True)
    ]

    def ready(tolerance: float) -> Ready:
        integrator, run = taylor(system, tolerance, len(system) > COMPACT_ROWS)
        return Ready(integrator.order, lambda: run(motion.y0, motion.end))

    return ready


HEYOKA = Peer("heyoka", "heyoka", start)
