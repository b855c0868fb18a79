"""Mici's constrained leapfrog: RATTLE with a Newton iteration, in NumPy."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from ...arguments import Array
from ...errors import FormError
from ...kernels.compiling.bound import Bound
from ...kernels.compiling.code import reads
from ...kernels.compiling.signatures import CONSTRAINT, GRADIENTS
from ...kernels.numbers.blocks import Block, scalar_block
from .peer import End, Motion, Peer, Ready


def start(motion: Motion) -> Callable[[float], Ready]:
    """State the motion as Mici takes it."""
    problem, n = motion.problem, len(motion.y0) // 2
    form = problem.hamiltonian
    if form is None or not form.separable or reads(form.gradients.function.__code__, 1):
        raise FormError("the problem has no separable Hamiltonian with constraints, free of time")
    integrators: Any = import_module("mici.integrators")
    states: Any = import_module("mici.states")
    systems: Any = import_module("mici.systems")
    q, p, dq, dp = (scalar_block(n) for _ in range(4))
    g, jacobian = scalar_block(form.constraints), scalar_block(form.constraints * n)
    common: dict[str, Any] = {"params": Block(problem.params), "work": scalar_block(problem.work)}
    gradients = Bound(form.gradients, GRADIENTS).call(t=0.0, q=q, p=p, dq=dq, dp=dp, **common)
    constraint = Bound(form.constraint, CONSTRAINT).call(q=q, g=g, G=jacobian, **common)

    def force(at: Array) -> Array:
        q.data[:] = at
        gradients()
        return dq.data.copy()

    def constrained(at: Array) -> tuple[Array, Array]:
        q.data[:] = at
        constraint()
        return g.data.copy(), jacobian.data.reshape(-1, n).copy()

    inverse = np.empty((n, n))
    force(motion.y0[:n])
    for i, unit in enumerate(np.eye(n)):
        p.data[:] = unit
        gradients()
        inverse[:, i] = dp.data
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
