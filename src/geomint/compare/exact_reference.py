"""Exact motions (`geomint.problems.exact_motion`) as references.

Their errors do not come from steps: what grows with time is the phase that the rounding of the initial
state costs.
"""

import numpy as np

from ..arguments import Array
from ..problems.problem import Problem
from .confirmation import confirm
from .reference_record import SMALL, Reference


def exact_reference(problem: Problem, y0: Array, end: dict[str, float]) -> Reference:
    """Return the state at an end, ``{"t_end": …}`` or ``{"tau_end": …}``, by the exact motion.

    A second method confirms it (`geomint.compare.confirmation`).

    Raises
    ------
    FormError
        If the problem has no exact motion.
    DomainError
        If there is none through this state.
    UnknownReferenceError
        If its estimated error, or the second method, leaves more than a tenth of errors of 1e-5
        uncertain.
    """
    motion = problem.exact(y0)
    in_tau = problem.time == "tau"
    if "tau_end" in end:
        tau = float(end["tau_end"])
        y, own, physical = motion.at_tau(tau), tau, float(motion.time(tau))
    else:
        physical = float(end["t_end"])
        tau = float(motion.tau(physical))
        y, own = motion(physical), tau if in_tau else physical

    def first(at: float) -> Array:
        state = motion.at_tau(at) if in_tau else motion(at)
        return state if problem.clock is None else np.append(state, motion.time(at))

    return Reference(
        own_end=own,
        physical_end=physical,
        y=y,
        error=float(motion.phase_error(tau) + motion.time_error(tau)),
        steps=(),
        method="exact flow",
        confirmation=confirm(problem, y0, own, first),
    ).for_errors(SMALL)
