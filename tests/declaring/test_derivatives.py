"""Exact Jacobians and gradients of every problem, against differences in many digits."""

from __future__ import annotations

import dataclasses
import math

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
    bare = dataclasses.replace(problem, invariants={}, constraints={}, observables={})
    with pytest.raises(gi.DomainError, match="has no quantities by name"):
        gi.gradient(bare, "energy", np.zeros(4))
    ball = gi.load_scene("ball-3d").problem
    with pytest.raises(gi.FormError, match="needs a field"):
        gi.jacobian(dataclasses.replace(ball, field=None, clock=None), ball.random_state(0))


def needs_derivatives(name: str) -> gi.Problem:
    """A problem that runs, and whose field or condition does what only plain numbers can do."""

    def cubed(params, t, y, out, work):
        out[0] = -(y[0] ** 3)

    def inverse(params, t, y, out, work):
        out[0] = -math.asinh(y[0])

    def rest(params, t, y, out, work):
        out[0] = -(y[0] % 2.0)

    def rounded(params, t, y, out, work):
        out[0] = -float(y[0])

    f = {"**": cubed, "asinh": inverse, "mod": rest, "float": rounded}[name]
    return gi.Problem("plain", (("x", 1),), field=gi.field(f))


@pytest.mark.parametrize("name", ["**", "asinh", "mod", "float"])
def test_functions_without_derivatives(name: str) -> None:
    """What takes plain numbers alone runs; its derivatives are refused, and the place is told."""
    problem = needs_derivatives(name)
    assert gi.solve(problem, [0.7], t_end=0.1, method="rk-4").success
    for by in ("state", "parameters"):
        with pytest.raises(gi.DeclarationError, match=r"TypeError: .*derivatives .*test_deriv"):
            gi.jacobian(problem, [0.7], by=by)
    if name == "**":
        with pytest.raises(gi.DeclarationError, match=r"write products, or gi\.pow\(x, y\) \("):
            gi.jacobian(problem, [0.7])
    with pytest.raises(gi.DeclarationError, match=r"no (numbers with )?derivatives"):
        gi.tangent_flow(problem, [0.7], t_end=0.1, step=0.05, method="rk-4")


def test_conditions_without_derivatives() -> None:
    """Those of a measure are differentiated where directions begin."""

    @gi.field
    def turning(params, t, y, out, work):
        out[0], out[1] = y[1], -y[0]

    @gi.field
    def squares(params, t, y, out, work):
        out[0] = y[0] ** 2 + y[1] ** 2 - 1.0

    @gi.observable
    def flat(params, t, y, work):
        return 0.0

    measure = gi.Measure(flat, squares, 1)
    problem = gi.Problem("circle", (("x", 2),), field=turning, measure=measure)
    run = {"t_end": 1.0, "step": 0.1, "method": "rk-4"}
    with pytest.raises(gi.DeclarationError, match="derivatives"):
        gi.lyapunov(problem, [1.0, 0.0], **run)
    with pytest.raises(gi.DeclarationError, match="derivatives"):
        gi.solve(problem, [1.0, 0.0], **run, observe=["measure"])


def test_conditions_that_are_numbers() -> None:
    """A number with derivatives is true where its value is."""

    @gi.field
    def off_zero(params, t, y, out, work):
        out[0] = 1.0 if y[0] else y[0]

    problem = gi.Problem("off-zero", (("x", 1),), field=off_zero)
    assert gi.jacobian(problem, [0.0]) == [[1.0]]
    assert gi.jacobian(problem, [0.5]) == [[0.0]]


def test_what_is_no_problem_and_divides_by_zero() -> None:
    problem = henon_heiles.problem()
    for wrong in (3, None, gi.load_scene("sphere-n3")):
        for call in (
            lambda p: gi.jacobian(p, np.zeros(4)),
            lambda p: gi.gradient(p, "energy", np.zeros(4)),
            lambda p: gi.value(p, "energy", np.zeros(4)),
        ):
            with pytest.raises(gi.DomainError, match=r"expected a geomint\.Problem"):
                call(wrong)
    with pytest.raises(gi.DomainError, match="'state' or 'parameters'"):
        gi.jacobian(problem, np.zeros(4), by=np.array([1, 2]))

    def divides(params, t, y, work):
        return 1 / 0

    for function in (gi.value, gi.gradient):
        with pytest.raises(gi.DeclarationError, match="ZeroDivisionError"):
            function(problem, divides, np.zeros(4))
