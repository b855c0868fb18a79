"""The exact flow as a method: no steps, where a problem has an exact motion through every state."""

from dataclasses import dataclass
from typing import Any

from ..errors import FormError, MethodError
from ..problems.problem import Problem
from .flow import Flow
from .method import Method, fitting
from .posed import Posed


@dataclass(frozen=True, repr=False)
class Exact(Method):
    """The exact motion of a problem that has one (`geomint.Problem.exact`), in place of steps.

    For `geomint.solve` and `geomint.poincare_section`. States are the exact ones at the times that are
    asked for, and events are looked for on the motion itself. There is no order, which is 0 here, and
    no step; what errors there are grow with the phase, see `geomint.problems.exact_motion.ExactMotion`.
    """

    def __post_init__(self) -> None:
        self._set(
            name="exact",
            order=0,
            needs="exact",
            step_fraction=1.0,
            family="Exact flow",
            summary="the motion itself, where a problem has it; no steps",
        )

    def flow(self, p: Posed) -> Flow:
        raise MethodError(f"method {self.name!r} {NO_STEPS}")

    def default_step(
        self, problem: Problem, y0: Any, span: float, start: float = 0.0, rate_at: Any = None
    ) -> float:
        """Return the span: the whole run is one."""
        return abs(span)

    def check_fits(self, problem: Problem, clock: bool) -> None:
        """Raise `FormError`, naming what would fit, unless the problem has an exact motion."""
        if problem.make_exact is None:
            raise FormError(
                f"method {self.name!r} needs an exact motion (make_exact), which problem "
                f"{problem.name!r} does not have in this representation; another one may "
                f"(scene.model.problems). {fitting(problem)}"
            )


NO_STEPS = (
    "takes no steps, and here they are needed: geomint.solve and geomint.poincare_section take it, "
    "and scenes as exact = true in [integrate]"
)
