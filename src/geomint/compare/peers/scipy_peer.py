"""SciPy's DOP853 and LSODA, whose steps are compiled, on the compiled field."""

import warnings
from collections.abc import Callable
from functools import partial
from importlib import import_module

import numpy as np

from ...arguments import Array
from ...errors import FormError
from ...kernels.compiling.signatures import FIELD
from ...problems.bound import bound, called
from .peer import End, Motion, Peer, PeerError, Ready

MOST_STEPS = 2**31 - 1


def compiled_field(motion: Motion) -> Callable[[float, Array], Array]:
    """Return the field as a function of numpy's arrays, compiled."""
    problem = motion.problem
    if problem.field is None:
        raise FormError("the problem has no field")
    call, state, rates = called(problem, bound(problem, problem.field, FIELD))

    def field(t: float, now: Array) -> Array:
        state[:] = now
        call(t=t)
        return rates.copy()

    return field


def start(name: str, order: int, motion: Motion) -> Callable[[float], Ready]:
    """State the motion as SciPy takes it."""
    ode = import_module("scipy.integrate").ode

    field, count = compiled_field(motion), 0

    def counted(t: float, y: Array) -> Array:
        nonlocal count
        count += 1
        return field(t, y)

    def ready(tolerance: float) -> Ready:
        options = {"rtol": tolerance, "atol": tolerance * motion.least}
        solver = ode(counted).set_integrator(name, nsteps=MOST_STEPS, **options)

        def run() -> End:
            nonlocal count
            count = 0
            solver.set_initial_value(motion.y0, 0.0)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # the return code says it too
                y = solver.integrate(motion.end)
            if not solver.successful() or not np.isfinite(y).all():
                raise PeerError(f"return code {solver.get_return_code()}")
            return End(np.asarray(y), None, count)

        return Ready(order, run)

    return ready


DOP853 = Peer("scipy-dop853", "scipy", partial(start, "dop853", 8))
LSODA = Peer("scipy-lsoda", "scipy", partial(start, "lsoda", 12))
