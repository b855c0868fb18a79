"""Exact Jacobians and gradients of every problem, against differences in many digits."""

from __future__ import annotations

import dataclasses

import mpmath
import numpy as np
import pytest

import geomint as gi
from geomint.kernels.numbers.blocks import Block
from geomint.problems.testproblems import henon_heiles
from geomint.scene.load import builtin_scenes

mp = mpmath.mp.clone()
mp.dps = 50
STEP = mp.mpf(10) ** -20
SCENES = sorted(builtin_scenes())


def digits(numbers) -> np.ndarray:
    return np.array([mp.mpf(float(v)) for v in numbers], dtype=object)


def field_in_digits(problem: gi.Problem, params: np.ndarray, y: np.ndarray) -> np.ndarray:
    out, work = digits(np.zeros(problem.rows)), digits(np.zeros(problem.work))
    problem.field.function(Block(params), mp.mpf(0), Block(y), Block(out), Block(work))
    return out


def value_in_digits(problem: gi.Problem, name: str, params: np.ndarray, y: np.ndarray):
    f, work = problem.diagnostics[name], digits(np.zeros(problem.work))
    return f.function(Block(params), mp.mpf(0), Block(y), Block(work))


def slopes_in_digits(f, y: np.ndarray) -> list:
    """Return central differences of f along each number of y."""
    columns = []
    for i in range(len(y)):
        ahead, behind = digits(y), digits(y)
        ahead[i], behind[i] = ahead[i] + STEP, behind[i] - STEP
        columns.append((f(ahead) - f(behind)) / (2 * STEP))
    return columns


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_every_scene(name: str) -> None:
    """The Jacobian of the field, and the gradients of all quantities, to 1e-13 of their sizes.

    By the state and by the parameters; off the manifold: on it the norms of what vanishes there have
    no gradient.
    """
    problem = gi.load_scene(name).problem
    y = problem.random_state(1) + 0.05 * np.random.default_rng(2).normal(size=problem.rows)
    params, state = digits(problem.params), digits(y)
    ways = (
        ("state", y, lambda f: lambda z: f(params, z)),
        ("parameters", problem.params, lambda f: lambda z: f(z, state)),
    )
    for by, numbers, of in ways:
        if problem.field is not None and problem.rows <= 40 and len(numbers) <= 200:
            columns = slopes_in_digits(of(lambda p, z: field_in_digits(problem, p, z)), numbers)
            expected = np.array(columns).T.astype(float)
            size = np.abs(expected).max()
            found = gi.jacobian(problem, y, by=by)
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * size)
        for quantity in problem.diagnostics if problem.rows <= 20 else ():
            f = of(lambda p, z, q=quantity: value_in_digits(problem, q, p, z))
            expected = np.array(slopes_in_digits(f, numbers)).astype(float)
            size = max(np.abs(expected).max(initial=0.0), 1e-300)
            found = gi.gradient(problem, quantity, y, by=by)
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * size)


def test_at_special_states() -> None:
    """At zero, at huge and tiny numbers: what the formulas give."""
    problem = henon_heiles.problem()
    J = gi.jacobian(problem, np.zeros(4))
    np.testing.assert_array_equal(J, [[0, 0, 1, 0], [0, 0, 0, 1], [-1, 0, 0, 0], [0, -1, 0, 0]])
    for size in (1e-200, 1e150):
        J = gi.jacobian(problem, [size, 0.0, 0.0, 0.0])
        np.testing.assert_array_equal(J[2:, :2], [[-1, -2 * size], [-2 * size, -1]])


@gi.observable
def time_squared(params, t, y, work):
    return t * t


@gi.observable
def kinked(params, t, y, work):
    return abs(y[0]) + gi.maximum(y[1], 0.0) + t * y[2]


def test_functions_of_time_and_kinks() -> None:
    """A constant has no gradient; at a kink that of the branch that is taken."""
    problem = henon_heiles.problem()
    np.testing.assert_array_equal(gi.gradient(problem, time_squared, np.ones(4), 2.0), np.zeros(4))
    found = gi.gradient(problem, kinked, [-1.0, 2.0, 3.0, 4.0], 5.0)
    np.testing.assert_array_equal(found, [-1, 1, 5, 0])
    np.testing.assert_array_equal(gi.gradient(problem, kinked, [0.0, -1, 0, 0]), [1, 0, 0, 0])


def test_wrong_input() -> None:
    problem = henon_heiles.problem()
    for function, given in ((gi.jacobian, ()), (gi.gradient, ("energy",))):
        for y in (np.zeros(3), "x", None, [[0.0] * 4]):
            with pytest.raises(gi.DomainError, match="y = "):
                function(problem, *given, y)
        with pytest.raises(gi.DomainError, match="t = "):
            function(problem, *given, np.zeros(4), "x")
        with pytest.raises(gi.DomainError, match="'state' or 'parameters'"):
            function(problem, *given, np.zeros(4), by="y")
    with pytest.raises(gi.DomainError, match="Did you mean 'energy'"):
        gi.gradient(problem, "enrgy", np.zeros(4))
    with pytest.raises(gi.DomainError, match="recorded"):
        gi.gradient(problem, 3, np.zeros(4))
    ball = gi.load_scene("ball-3d").problem
    with pytest.raises(gi.FormError, match="needs a field"):
        gi.jacobian(dataclasses.replace(ball, field=None, clock=None), ball.random_state(0))
