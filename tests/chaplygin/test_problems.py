"""Every problem that is made here, and its space, is held to the public suite of geomint.

That is: its forms are one motion, constraints and integrals stay, the measure is invariant. What the
suite does not know, whether the motion is the right one, is seen by the tests beside this one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

import chaplygin as ch
import geomint as gi
from geomint.testing import check_problem, check_space
from tests.chaplygin.support import (
    MAKERS,
    kinds,
    of_operator,
    of_parameters,
    operator_of,
    quiet_state,
    random_rotation,
    random_triangle,
    seeds,
)
from tests.paper.algebra import coordinates, skew
from tests.rows import examples

# Of all kinds of operators: what reads the operator itself. Others see ω, or the solve for it.
OF_ALL = {"reduced", "ball", "rolling", "contact", "rubber", "lr-1", "stiefel-1"}


def small() -> dict[str, gi.Problem]:
    """Return the problems for n = 3: of each class, and of each kind of its operator."""
    found = {}
    for kind in MAKERS:
        for name, problem in of_operator(kind, 3).items():
            if name in OF_ALL or kind == "full" or name.startswith("classical"):
                found[f"{name}-{kind}"] = problem
    found |= of_parameters(3)
    # With integrals of their own: γ_1 p_2 − γ_2 p_1, and r_1.
    equal = of_parameters(4, equal=2)
    found |= {f"{name}-equal": equal[name] for name in ("body-reduced", "sphere-hamiltonized")}
    found["units"] = ch.Ball(mass=0.4, radius=0.1, moments=[1.2e-3, 1.6e-3, 2.0e-3]).problem()
    return found


SMALL = small()


@pytest.mark.parametrize("name", SMALL)
def test_every_problem_is_one(name: str) -> None:
    check_problem(SMALL[name], 1)


@given(st.sampled_from([2, 4, 5]), kinds, st.integers(0, 99), seeds)
@examples(8)
def test_problems_of_any_dimension_are_ones(n: int, kind: str, which: int, seed: int) -> None:
    every = [*of_operator(kind, n, seed).values(), *of_parameters(n, seed).values()]
    problem = every[which % len(every)]
    assume(problem.rows < 30)
    check_problem(problem, [problem.random_state(seed)])


@given(st.integers(2, 5), kinds, seeds)
@examples(4)
def test_momentum_in_space_is_constant(n: int, kind: str, seed: int) -> None:
    """|Ad_g k − k_0|, of all that carry g: what it says, and its square is constant."""
    inertia, D = operator_of(kind, n, seed)
    m, rho = D / 0.7**2, 0.7
    g, k = random_rotation(n, seed), random_triangle(n, seed)
    in_space = coordinates(g @ skew(k, n) @ g.T)
    for k0, off in ((in_space, 0.0), (0 * k, np.sqrt(k @ k))):
        problems = [
            ch.ball_problem(inertia, D, True, k0),
            ch.cotangent_problem(inertia, D, skew(k0, n)),
            ch.rolling_problem(inertia, m, rho, k0),
            ch.contact_problem(inertia, m, rho, k0),
        ]
        if n == 3:
            problems.append(ch.classical_problem(inertia, D, True, [-k0[2], k0[1], -k0[0]]))
        for problem in problems:
            y = quiet_state(problem, g=g, k=skew(k, n), **gamma_of(problem, g))
            assert gi.value(problem, "spatial-momentum", y) == pytest.approx(off, abs=1e-13)
            if off:
                slope = gi.gradient(problem, "spatial-momentum", y)
                assert abs(slope @ gi.derivative(problem, y)) < 1e-12


def gamma_of(problem: gi.Problem, g: Any) -> dict[str, Any]:
    return {"gamma": g[-1]} if "gamma" in problem.slices else {}


SPACES = {repr(problem.space): problem.space for problem in SMALL.values()}
SPACES["another ellipsoid"] = ch.ellipsoid_problem((0.3, 1.0, 2.5, 7.0)).space


@pytest.mark.parametrize("space", SPACES.values(), ids=SPACES)
def test_every_space_is_one(space: Any) -> None:
    check_space(space, 2)
