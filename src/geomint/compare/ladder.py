"""What a comparison runs: at which steps or tolerances."""

from collections.abc import Iterable

from ..arguments import Array, positive
from ..errors import DomainError, nearest
from ..methods import Method
from ..methods.adaptive import LARGEST_RTOL, LEAST_RTOL
from ..problems.problem import Problem
from ..problems.systems import Model

STEP_FACTORS = (4.0, 2.0, 1.0, 0.5, 0.25)
RTOL_POWERS = (4, 2, 0, -2, -4)  # of ten, times a method's own rtol


def checked_steps(methods: list[Method], steps: Iterable[float] | None) -> list[float] | None:
    """Return the steps that are asked for, or raise `DomainError` where they would say nothing."""
    if not methods:
        raise DomainError("methods", methods, "at least one method")
    if steps is None:
        return None
    checked = [positive("steps", step) for step in steps]
    if not checked:
        raise DomainError("steps", checked, "at least one step")
    if all(method.adaptive for method in methods):
        names = ", ".join(method.name for method in methods)
        raise DomainError("steps", checked, f"none: {names} choose their steps: give rtol")
    return checked


def check_representation(model: Model, asked: str | None) -> None:
    """Raise `DomainError` for a representation that the system does not have."""
    known = ["own", *model.problems]
    if asked is not None and asked not in known:
        raise DomainError("representation", asked, f"one of {known}.{nearest(asked, known)}")


def ladder(
    method: Method,
    problem: Problem,
    y0: Array,
    steps: list[float] | None,
    base: float | None,
    end: float,
) -> list[tuple[Method, float | None]]:
    """Return what to run: the method at several steps, an adaptive one at several tolerances."""
    if method.adaptive:
        own = method.options["rtol"]
        ratio = method.options["atol"] / own
        scaled = (own * 10.0**power for power in RTOL_POWERS)
        kept = dict.fromkeys(min(max(r, LEAST_RTOL), LARGEST_RTOL) for r in scaled)
        return [(method.with_options(rtol=r, atol=ratio * r), base) for r in kept]
    base = method.default_step(problem, y0, end) if base is None else base
    return [(method, h) for h in ([f * base for f in STEP_FACTORS] if steps is None else steps)]
