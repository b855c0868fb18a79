"""The rule of the planner for the representation: the cheapest that delivers what is asked for."""

from __future__ import annotations

from ..errors import FormError
from ..problems.problem import Problem
from ..watch.observe import MEASURE, expanded, quantities_of
from .context import Choice, Context
from .cost import Cost, cost_of

__all__ = ["choose_representation", "missing_quantities", "wanted_quantities"]

_TIME = {"t": "physical time t", "tau": "its own time τ"}
_FITTING = {
    "field": "gauss-8, dop853, rk-4",
    "action": "cf-4, rkmk-4",
    "hamiltonian": "rattle-4",
    "splitting": "verlet-4",
}


def choose_representation(c: Context) -> Choice:
    """Take the representation asked for, or the scene's own, or the first that fits the method.

    Where only drifts are wanted, a cheaper one takes its place if it delivers all that is observed.
    """
    asked = c.scene.content.integrate.representation
    if asked is not None:
        return _asked(c, asked)
    fitting = _fitting(c)
    if not fitting:
        raise _nothing_fits(c)
    own = _own(c)
    first = own if own in fitting else fitting[0]
    method = c.scene.method
    if first == own:
        reason = f"the scene's own; it offers the form {method.needs!r} that {method.name} needs"
    else:
        reason = f"{own}: {_obstacle(c, own)}; the same motion from the same initial state"
    chosen, saving = _cheaper(c, first) if c.purpose == "drift" else (first, "")
    words = [saving] if own == first != chosen else [reason, saving]
    return _choice(c, chosen, "; ".join(filter(None, words)))


def _own(c: Context) -> str:
    return next(iter(c.scene.model.problems))


def _choice(c: Context, name: str, reason: str) -> Choice:
    problem = c.scene.model.problems[name]
    pieces = ", ".join(f"{piece} ({rows})" for piece, rows in problem.pieces)
    value = f"{name}: {pieces}; {problem.rows} numbers in {_TIME[problem.time]}"
    return Choice("representation", value, reason, name)


def _asked(c: Context, asked: str) -> Choice:
    name = _own(c) if asked == "own" else asked
    obstacle = _obstacle(c, name)
    if obstacle and not (c.purpose == "drift" and not _unfit(c, name)):
        problem = c.scene.model.problems[name]
        has = f"It has {', '.join(quantities_of(problem))}"
        fitting = f"Methods that fit {name!r}: {_methods_for(problem)}"
        raise FormError(
            f"representation {asked!r}, which [integrate] asks for, does not serve: {obstacle}. "
            f"{fitting if _unfit(c, name) else has}"
        )
    return _choice(c, name, f"[integrate] representation = {asked!r}")


def _fitting(c: Context) -> list[str]:
    """Return the representations that will do, in the order of the system.

    If none has all that is observed, a drift report does with those that lack least.
    """
    fitting = [name for name in c.scene.model.problems if not _obstacle(c, name)]
    if fitting or c.purpose != "drift":
        return fitting
    lacking = {
        name: len(missing_quantities(c, name))
        for name in c.scene.model.problems
        if not _unfit(c, name)
    }
    return [name for name, count in lacking.items() if count == min(lacking.values())]


def _nothing_fits(c: Context) -> FormError:
    problems, own = c.scene.model.problems, _own(c)
    obstacles = {name: _obstacle(c, name) for name in problems}
    words = "; ".join(
        f"{', '.join(name for name in problems if obstacles[name] == obstacle)}: {obstacle}"
        for obstacle in dict.fromkeys(obstacles.values())
    )
    return FormError(
        f"no representation of {c.scene.content.system.name!r} fits method "
        f"{c.scene.method.name!r} ({words}). Methods that fit {own!r}: {_methods_for(problems[own])}"
    )


def _methods_for(problem: Problem) -> str:
    return ", ".join(_FITTING[form] for form in problem.forms if form in _FITTING)


def _obstacle(c: Context, name: str) -> str:
    """Return why a representation cannot serve, or an empty string."""
    unfit, missing = _unfit(c, name), missing_quantities(c, name)
    return unfit or (f"has no {', '.join(missing)}" if missing else "")


def _unfit(c: Context, name: str) -> str:
    """Return why the method cannot integrate a representation to the end of the scene."""
    problem, method, time = c.scene.model.problems[name], c.scene.method, c.scene.content.time
    if method.needs not in problem.forms:
        return f"no form {method.needs!r}"
    if problem.time == "t" and time.tau_end is not None:
        return "in physical time, so tau_end says nothing: give t_end"
    if problem.time == "tau" and method.needs == "action":
        if time.t_end is not None:
            return f"{method.name} cannot integrate physical time beside it: give tau_end"
        if c.purpose == "run" and c.scene.content.save.t_eval is not None:
            return f"{method.name} cannot integrate physical time beside it, which t_eval is"
    return ""


def wanted_quantities(c: Context, name: str) -> list[str]:
    """Return the names that are observed, if a representation is integrated.

    Groups are those of the scene's own representation, but constraints those of what is integrated: a
    group says "whatever keeps the state on its manifold". A constraint that is named is meant itself.
    """
    own, constraints = c.scene.problem, list(c.scene.model.problems[name].constraints)
    wanted: list[str] = []
    for quantity in c.scene.content.observe.quantities:
        if quantity == "constraints":
            wanted += constraints
        elif quantity == "all":
            wanted += [q for q in quantities_of(own) if q not in own.constraints] + constraints
        else:
            wanted += expanded(own, [quantity])
    return list(dict.fromkeys(wanted))


def missing_quantities(c: Context, name: str) -> list[str]:
    """Return what is observed and a representation does not have."""
    has = quantities_of(c.scene.model.problems[name])
    return [quantity for quantity in wanted_quantities(c, name) if quantity not in has]


def _cheaper(c: Context, first: str) -> tuple[str, str]:
    """Return the cheapest representation that may take the place of `first`, and why.

    It must be in the same time, be cheaper (`Cost.below`), and have every quantity that is observed
    in `first`; the group "constraints" means its own ones. If one or two quantities stand in the
    way, the reason names them.
    """
    costs = {first: _cost(c, first)}
    for name, problem in c.scene.model.problems.items():
        if problem.time == c.scene.model.problems[first].time and not _unfit(c, name):
            costs[name] = _cost(c, name)
    smaller = [name for name in costs if costs[name].below(costs[first])]
    lacking = {name: _lacking(c, first, name) for name in smaller}
    whole = [name for name in smaller if not lacking[name]]
    if whole:
        name = min(whole, key=costs.__getitem__)
        return name, _saving(c, first, name, costs)
    nearly = [name for name in smaller if len(lacking[name]) <= 2]
    if not nearly:
        return first, ""
    name = min(nearly, key=lambda name: (len(lacking[name]), costs[name]))
    names = ", ".join(lacking[name])
    keep = "keeps" if len(lacking[name]) == 1 else "keep"
    return first, f"{names} {keep} it: else {name} would do, {_compared(costs, first, name)}"


def _cost(c: Context, name: str) -> Cost:
    model = c.scene.model
    return cost_of(model.problems[name], c.scene.method.needs, model.states[name])


def _lacking(c: Context, first: str, name: str) -> list[str]:
    problems = c.scene.model.problems
    wanted = [name for name in c.scene.content.observe.quantities if name != "constraints"]
    observed = dict.fromkeys(expanded(problems[first], wanted))
    # The measure is that of the numerical map of one representation.
    has = {*quantities_of(problems[name])} - {MEASURE}
    would = set(quantities_of(problems[first]))
    return [quantity for quantity in observed if quantity in would and quantity not in has]


def _saving(c: Context, first: str, name: str, costs: dict[str, Cost]) -> str:
    model = c.scene.model
    kept = {piece for piece, _ in model.problems[name].pieces}
    gone = [piece for piece, _ in model.problems[first].pieces if piece not in kept]
    condition = model.conditions.get(name)
    words = [condition] if condition and first not in model.conditions else []
    words.append(
        f"nothing observed needs {_alternatives(gone)}" if gone else "all observed is there"
    )
    return f"{first} → {name}: {', '.join(words)}: {_compared(costs, first, name)}"


def _alternatives(names: list[str]) -> str:
    return " or ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def _compared(costs: dict[str, Cost], first: str, name: str) -> str:
    small, large = costs[name], costs[first]
    return (
        f"{small.rows} numbers instead of {large.rows}, "
        f"{small.operations} operations an evaluation instead of {large.operations}"
    )
