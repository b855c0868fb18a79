"""diffrax's Dopri8 in JAX, in double precision (P. Kidger, thesis, Oxford 2021)."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from ...errors import FormError
from ...kernels.numbers.traced import Algebra
from ...problems.formulas import traced_field
from .peer import End, Motion, Peer, PeerError, Ready

MOST_ROWS = 64  # a formula a row: beyond, XLA compiles for minutes


def start(motion: Motion) -> Callable[[float], Ready]:
    """State the motion as Diffrax takes it."""
    if len(motion.y0) > MOST_ROWS:
        raise FormError(f"more than {MOST_ROWS} numbers would be compiled one by one, for minutes")
    jax = import_module("jax")
    jnp = import_module("jax.numpy")
    diffrax = import_module("diffrax")
    double = jax.enable_x64  # only within: what else uses JAX keeps its own precision
    algebra = Algebra(jnp, jnp.less, jnp.less_equal, jnp.where)

    def field(t: Any, y: Any, args: Any) -> Any:
        return jnp.stack([*map(jnp.asarray, traced_field(motion.problem, algebra, t, list(y)))])

    def solved(y0: Any, rtol: Any) -> Any:
        return diffrax.diffeqsolve(
            diffrax.ODETerm(field),
            diffrax.Dopri8(),
            t0=0.0,
            t1=motion.end,
            dt0=None,
            y0=y0,
            saveat=diffrax.SaveAt(t1=True),
            stepsize_controller=diffrax.PIDController(rtol=rtol, atol=rtol * motion.least),
            max_steps=None,
            throw=False,
        )

    compiled = jax.jit(solved)
    with double(True):  # tells at once whether the field is a formula
        jax.eval_shape(field, 0.0, jnp.asarray(motion.y0), None)

    def ready(tolerance: float) -> Ready:
        def run() -> End:
            with double(True):
                found = compiled(jnp.asarray(motion.y0), jnp.asarray(tolerance))
                y = np.asarray(found.ys[-1])
                if found.result != diffrax.RESULTS.successful or not np.isfinite(y).all():
                    raise PeerError(str(found.result))
                return End(y, int(found.stats["num_steps"]))

        return Ready(8, run)

    return ready


DIFFRAX = Peer("diffrax", "diffrax", start)
