"""Mici's constrained leapfrog: RATTLE with a Newton iteration, in NumPy."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from ...arguments import Array
from ...errors import FormError
from ...kernels.compiling.signatures import CONSTRAINT, GRADIENTS
from ...problems.bound import bound, called
from .peer import End, Motion, Peer, Ready


def start(motion: Motion) -> Callable[[float], Ready]:
    """State the motion as Mici takes it."""
    problem, n = motion.problem, len(motion.y0) // 2
    form = problem.hamiltonian
    if form is None or not form.separable or GRADIENTS.reads(form.gradients, "t"):
        raise FormError("the problem has no separable Hamiltonian with constraints, free of time")
    integrators: Any = import_module("mici.integrators")
    states: Any = import_module("mici.states")
    systems: Any = import_module("mici.systems")
    gradients, q, p, dq, dp = called(problem, bound(problem, form.gradients, GRADIENTS))
    constraint, point, g, jacobian = called(problem, bound(problem, form.constraint, CONSTRAINT))

    def force(at: Array) -> Array:
        q[:] = at
        gradients()
        return dq.copy()

    def constrained(at: Array) -> tuple[Array, Array]:
        point[:] = at
        constraint()
        return g.copy(), jacobian.reshape(-1, n).copy()

    inverse = np.empty((n, n))
    force(motion.y0[:n])
    for i, unit in enumerate(np.eye(n)):
        p[:] = unit
        gradients()
        inverse[:, i] = dp
    system = systems.DenseConstrainedEuclideanMetricSystem(
        neg_log_dens=lambda at: 0.0,  # the value of the potential is not needed for steps
        grad_neg_log_dens=force,
        constr=lambda at: constrained(at)[0],
        jacob_constr=lambda at: constrained(at)[1],
        metric=np.linalg.inv(inverse),
    )

    def ready(step: float) -> Ready:
        steps = max(1, round(abs(motion.end) / step))
        integrator = integrators.ConstrainedLeapfrogIntegrator(
            system, step_size=abs(motion.end) / steps
        )

        def run() -> End:
            state = states.ChainState(
                pos=motion.y0[:n].copy(), mom=motion.y0[n:].copy(), dir=int(np.sign(motion.end))
            )
            for _ in range(steps):
                state = integrator.step(state)
            return End(np.concatenate([state.pos, state.mom]), steps)

        return Ready(2, run)

    return ready


MICI = Peer("mici", "mici", start, fixed=True)
