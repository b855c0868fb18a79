"""Which representations a method can integrate: what run, drift, compare and stress choose by."""

from collections.abc import Mapping
from typing import Any

from ..errors import FormError
from ..methods.method import Method
from ..problems.problem import Problem
from ..problems.systems import Model


def unfit(problem: Problem, method: Method, end: Mapping[str, Any]) -> str:
    """Return why a method cannot integrate a problem to an end, or an empty string.

    Parameters
    ----------
    end : mapping
        ``{"t_end": …}``, ``{"tau_end": …}``, or nothing: an end in the problem's own time.
    """
    if method.needs not in problem.forms:
        return f"no form {method.needs!r}"
    if problem.time == "t" and "tau_end" in end:
        return "in physical time, so tau_end says nothing: give t_end"
    return ""


def obstacles(
    model: Model, method: Method, end: Mapping[str, Any], translated: bool = False
) -> dict[str, str]:
    """Return why a method cannot integrate each representation; an empty string where it can.

    Parameters
    ----------
    translated : bool
        An end in τ is that of the first representation; the others run to the physical time that is
        reached there.
    """
    own = next(iter(model.problems))
    elsewhere = {"t_end": None} if translated else end
    return {
        name: unfit(problem, method, end if name == own else elsewhere)
        for name, problem in model.problems.items()
    }


def representation_for(
    model: Model, method: Method, end: Mapping[str, Any], asked: str | None = None
) -> tuple[str, Problem]:
    """Return the representation asked for, or the first that the method fits, or raise `FormError`."""
    own = next(iter(model.problems))
    for name, obstacle in obstacles(model, method, end, translated=True).items():
        if not obstacle and (asked is None or name == (own if asked == "own" else asked)):
            return name, model.problems[name]
    if asked is not None:
        raise FormError(
            f"method {method.name!r} does not fit the representation {asked!r} that is asked for"
        )
    offered = sorted({form for problem in model.problems.values() for form in problem.forms})
    raise FormError(
        f"method {method.name!r} needs the form {method.needs!r}; "
        f"for this system and initial state there are only {', '.join(offered)}"
    )
