"""lielab's Runge–Kutta–Munthe-Kaas method of Verner's 8(7) pair on SO(3)."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from ...errors import FormError
from ...kernels.compiling.signatures import FIELD
from ...problems.bound import bound, called
from ...problems.groups import so3
from .peer import End, Motion, Peer, PeerError, Ready

SHORTEST = 1e-9  # step, over the whole run


def start(motion: Motion) -> Callable[[float], Ready]:
    """State the motion as a rotation g that turns the vectors of the initial state: ġ = ξ g."""
    problem, y0 = motion.problem, motion.y0
    vectors = len(y0) // 3
    if problem.action is None or problem.action.group.act is not so3(vectors).act:
        raise FormError("the state is not turned by SO(3) alone")
    if motion.end <= 0.0:
        raise FormError("it goes forwards only")
    domain = import_module("lielab.domain")
    integrate = import_module("lielab.integrate")
    generator, y, xi = called(problem, bound(problem, problem.action.generator, FIELD, out=3))
    turned, start_vectors = y.reshape(-1, 3), y0.reshape(-1, 3)

    def velocity(t: float, state: Any) -> Any:
        np.matmul(start_vectors, state.point[0].get_matrix().T, out=turned)
        generator(t=t)
        return domain.CompositeAlgebra([domain.so.from_vector(xi.tolist())])

    system = integrate.HomogeneousIVPSystem(velocity)

    def ready(tolerance: float) -> Ready:
        options = integrate.IVPOptions()
        options.method = integrate.IVPMethod.MuntheKaas
        options.coefficients = integrate.RungeKuttaCoefficients.RKV87r
        options.reltol = options.abstol = tolerance
        options.dt_min, options.dt_max = SHORTEST * abs(motion.end), abs(motion.end)

        def run() -> End:
            ends = np.array([0.0, motion.end])
            begin = domain.CompositeManifold([domain.SO(3)])
            found = integrate.solve_ivp(system, ends, begin, options)
            if not found.success:
                raise PeerError(str(found.message))
            g = np.asarray(found.ybar[-1]).reshape(3, 3)
            return End((start_vectors @ g.T).ravel(), len(found.t) - 1)

        return Ready(8, run)

    return ready


LIELAB = Peer("lielab", "lielab", start)
