"""Exact Jacobians and gradients of every problem, against differences in many digits."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from tests.methods.textbook import Rows

mp = mpmath.mp.clone()
mp.dps = 50
STEP = mp.mpf(10) ** -20


def digits(numbers: Any) -> Rows:
    return np.array([mp.mpf(float(v)) for v in numbers], dtype=object).view(Rows)


def differences(f: Callable[[Any], Any], y: np.ndarray) -> np.ndarray:
    """Central differences of f along each number of y, a column each."""
    columns = []
    for i in range(len(y)):
        ahead, behind = digits(y), digits(y)
        ahead[i], behind[i] = ahead[i] + STEP, behind[i] - STEP
        columns.append((f(ahead) - f(behind)) / (2 * STEP))
    return np.array(columns).T.astype(float)


@given(st.sampled_from(gi.scene_names()), st.sampled_from(["state", "parameters"]))
def test_every_scene(name: str, by: str) -> None:
    """The Jacobian of the field, and the gradients of all quantities, to 1e-13 of their sizes.

    Off the manifold: on it the norms of what vanishes there have no gradient.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gi.GeomintWarning)
        problem = gi.load_scene(name).problem
    y = problem.random_state(1) + 0.05 * np.random.default_rng(2).normal(size=problem.rows)
    numbers, work = (y if by == "state" else problem.params), digits(np.zeros(problem.work))

    def given_at(z: Any) -> tuple[Any, ...]:
        params, state = (digits(problem.params), z) if by == "state" else (z, digits(y))
        return params, mp.mpf(0), state

    def field(z: Any) -> Any:
        out = digits(np.zeros(problem.rows))
        problem.field.function(*given_at(z), out, work)
        return np.asarray(out)

    checks = []
    if problem.field is not None and problem.rows <= 40 and len(numbers) <= 200:
        checks.append((field, gi.jacobian(problem, y, by=by)))
    for quantity, f in problem.diagnostics.items() if problem.rows <= 20 else ():
        found = gi.gradient(problem, quantity, y, by=by)
        checks.append((lambda z, f=f: f.function(*given_at(z), work), found))
    for f, found in checks:
        expected = differences(f, numbers)
        size = max(np.abs(expected).max(initial=0.0), 1e-300)
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
    problem, zero = henon_heiles.problem(), np.zeros(4)
    bare = dataclasses.replace(problem, invariants={}, constraints={}, observables={})
    ball = gi.load_scene("ball-3d").problem

    @gi.observable
    def divides(params, t, y, work):
        return 1 / 0

    asked = [((gi.jacobian, p, zero), {}, r"expected a geomint\.Problem") for p in (3, None, mp)]
    for function, name in ((gi.jacobian, ()), (gi.gradient, ("energy",))):
        asked += [
            ((function, problem, *name, y), {}, "y = ")
            for y in (np.zeros(3), "x", None, [[0.0] * 4])
        ]
        asked.append(((function, problem, *name, zero, "x"), {}, "t = "))
        asked += [
            ((function, problem, *name, zero), {"by": by}, "'state' or 'parameters'")
            for by in ("y", np.array([1, 2]))
        ]
    asked += [
        ((gi.gradient, None, "energy", zero), {}, r"expected a geomint\.Problem"),
        ((gi.value, None, "energy", zero), {}, r"expected a geomint\.Problem"),
        ((gi.gradient, problem, "enrgy", zero), {}, "Did you mean 'energy'"),
        ((gi.gradient, problem, 3, zero), {}, "recorded"),
        ((gi.gradient, bare, "energy", zero), {}, "has no quantities by name"),
        ((gi.value, problem, divides, zero), {}, "ZeroDivisionError"),
        ((gi.gradient, problem, divides, zero), {}, "ZeroDivisionError"),
    ]
    for (function, *arguments), more, said in asked:
        with pytest.raises((gi.DomainError, gi.DeclarationError), match=said):
            function(*arguments, **more)
    with pytest.raises(gi.FormError, match="needs a field"):
        gi.jacobian(dataclasses.replace(ball, field=None, clock=None), ball.random_state(0))


def cubed(params, t, y, out, work):
    out[0] = -(y[0] ** 3)


def inverse(params, t, y, out, work):
    out[0] = -math.asinh(y[0])


def rest(params, t, y, out, work):
    out[0] = -(y[0] % 2.0)


def rounded(params, t, y, out, work):
    out[0] = -float(y[0])


@pytest.mark.parametrize("f", [cubed, inverse, rest, rounded])
def test_functions_without_derivatives(f: Any) -> None:
    """What takes plain numbers alone runs; its derivatives are refused, and the place is told."""
    problem = gi.Problem("plain", (("x", 1),), field=gi.field(f))
    assert gi.solve(problem, [0.7], t_end=0.1, step=0.05, method="rk-4", compiled=False).success
    for by in ("state", "parameters"):
        with pytest.raises(gi.DeclarationError, match=r"TypeError: .*derivatives .*test_deriv"):
            gi.jacobian(problem, [0.7], by=by)
    if f is cubed:
        with pytest.raises(gi.DeclarationError, match=r"write products, or gi\.pow\(x, y\) \("):
            gi.jacobian(problem, [0.7])
    with pytest.raises(gi.DeclarationError, match=r"no (numbers with )?derivatives"):
        gi.tangent_flow(problem, [0.7], t_end=0.1, step=0.05, method="rk-4")


@gi.field
def turning(params, t, y, out, work):
    out[0], out[1] = y[1], -y[0]


@gi.field
def squares(params, t, y, out, work):
    out[0] = y[0] ** 2 + y[1] ** 2 - 1.0


@gi.observable
def flat(params, t, y, work):
    return 0.0


def test_conditions_without_derivatives() -> None:
    """Those of a measure are differentiated where directions begin."""
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
