"""What every problem has."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import DomainError
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import Block
from ..problems.declaration import check_problem as check_declared
from ..problems.evaluate import derivative, rounding_scale, value
from ..problems.problem import Problem
from ..problems.spaces.repair import length
from .groups import check_group
from .judge import hold, small, sure

__all__ = ["check_problem"]

ROUNDING = 1e-13
SLOPES = 1e-6  # of central differences
H = 1e-5
CURVED = 100.0  # over H²: how far constraints may bend away


def check_problem(problem: Problem, states: Any = 3) -> None:
    """Raise `AssertionError` for the first property of a problem that does not hold.

    Random states are admissible; functions fit what the problem declares; all forms have one
    derivative; constraints vanish, and they and the invariants are constant along it, and none of them
    everywhere; the group is one.

    Parameters
    ----------
    problem : Problem
    states : int or sequence of arrays
        How many random states are taken, from seeds 0, 1, …; or the states, for a problem that has no
        random ones.
    """
    chosen = list(_random(problem, states) if isinstance(states, int) else states)
    for y in chosen:
        hold(problem.canonical(y), y, f"problem {problem.name!r} changes an admissible state")
        for form in problem.forms:
            check_declared(problem, y, form, clock=problem.clock is not None)
        rate = _rate(problem, y)
        for name, f in {**problem.constraints, **problem.invariants}.items():
            _check_constant(problem, name, f, y, rate)
    for name, f in {**problem.constraints, **problem.invariants}.items():
        way = np.random.default_rng(len(name)).normal(size=problem.rows)
        moves = any(value(problem, f, y + 0.1 * way) != value(problem, f, y) for y in chosen)
        sure(moves, f"{name!r} of {problem.name!r} is the same number at all states")
    if problem.action is not None:
        check_group(problem.action.group, problem.rows, 1)


def _random(problem: Problem, count: int) -> Iterator[Array]:
    """Yield random states: admissible as they are, others for other seeds."""
    before = None
    for seed in range(count):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            y = problem.random_state(seed)
        sure(before is None or (y != before).any(), f"{problem.name!r} has one random state")
        before = y
        yield y


def _rate(problem: Problem, y: Array) -> Array:
    """Return ẏ, the same by all forms."""
    rates = {}
    for form in set(problem.forms) - {"hamiltonian"}:
        others = {other: None for other in problem.forms if other != form}
        alone = dataclasses.replace(problem, **others)  # type: ignore[arg-type]
        rates[form] = derivative(alone, y)
    if not rates:
        raise DomainError("problem", problem.name, "one with an ODE, an action or a splitting")
    first, rate = next(iter(rates.items()))
    size = max(1.0, length(rate))
    for form, other in rates.items():
        text = f"{first} and {form} of {problem.name!r} are not one motion"
        small(other - rate, SLOPES * size, text)
    if problem.hamiltonian is not None:
        _check_hamiltonian(problem, y, rate)
    return rate


def _check_hamiltonian(problem: Problem, y: Array, rate: Array) -> None:
    """q̇ = ∂H/∂p, and ṗ + ∂H/∂q is normal to the constraint."""
    form, n = problem.hamiltonian, problem.rows // 2
    assert form is not None
    dq, dp = np.zeros(n), np.zeros(n)
    g, G = np.zeros(form.constraints), np.zeros(form.constraints * n)
    params, work = Block(problem.params), Block(np.zeros(problem.work))
    q, p = Block(y[:n]), Block(y[n:])
    form.gradients(params, np.float64(0.0), q, p, Block(dq), Block(dp), work)
    form.constraint(params, q, Block(g), Block(G), work)
    text, size = f"the Hamiltonian form of {problem.name!r} is another", max(1.0, length(rate))
    small(g, ROUNDING, f"{text} manifold")
    small(rate[:n] - dp, SLOPES * size, f"{text} motion of q")
    basis, _ = np.linalg.qr(G.reshape(-1, n).T)
    force = rate[n:] + dq
    small(force - basis @ (basis.T @ force), SLOPES * size, f"{text} motion of p")


def _check_constant(problem: Problem, name: str, f: Recorded, y: Array, rate: Array) -> None:
    """Hold a quantity to be constant along the motion, and to be 0 if it is a constraint."""
    h, scale = H / max(1.0, length(rate)), max(1.0, rounding_scale(problem, f, y))
    here, above, below = (value(problem, f, y + s * h * rate) for s in (0.0, 1.0, -1.0))
    text = f"{name!r} of {problem.name!r} is not constant along the motion"
    if name in problem.constraints:
        small(here, ROUNDING * scale, f"constraint {name!r} of {problem.name!r} is not 0")
        small([above, below], CURVED * H * H * scale, text)
    small((above - below) / (2.0 * h), SLOPES * scale * max(1.0, length(rate)), text)
