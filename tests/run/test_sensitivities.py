"""Sensitivities: against closed forms, conserved quantities, exact motions; wrong families."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.run.motions import second, swing


@gi.observable
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 0.5 * (y[1] * y[1] + params[0] * y[0] * y[0])


@gi.observable
def late(params: Any, t: Any, y: Any, work: Any) -> Any:
    return params[0] * t * y[0]


SPRING = dataclasses.replace(swing(), invariants={"energy": energy})


def spring(k: float, a: float = 0.7) -> tuple[gi.Problem, list[float]]:
    return dataclasses.replace(SPRING, params=[k * k, 0.0, 0.0]), [a, k * a]


@pytest.mark.parametrize("k", [0.3, 1.0, 20.0, 1e-3])
def test_a_spring(k: float) -> None:
    """x = a (cos kt + sin kt): by all that it depends on, to 1e-12."""
    t, a = 1.7 / k, 0.7
    run = {"t_end": t, "step": 0.1 / k, "observe": ["energy", late]}
    found = gi.sensitivities(spring, parameters={"k": k, "a": a}, **run)
    c, s, unit = math.cos(k * t), math.sin(k * t), np.array([[1.0], [k]])
    phi = [[c, s], [-s, c]]
    by_k, by_a = [t * (c - s), (c - s) / k - t * (s + c)], [c + s, c - s]
    assert found.parameters == ("k", "a")
    np.testing.assert_allclose(found.y, [a * (c + s), k * a * (c - s)], rtol=1e-13)
    np.testing.assert_allclose(found.by_state * unit.T / unit, phi, rtol=0, atol=1e-13)
    expected = np.column_stack((np.multiply(a, by_k), by_a))
    atol = 1e-12 * np.abs(expected).max()
    np.testing.assert_allclose(found.by_parameters / unit, expected, rtol=0, atol=atol)
    kept = found.quantities["energy"]
    assert kept.value == pytest.approx((k * a) ** 2, rel=1e-13)
    np.testing.assert_allclose(kept.by_state, [k * k * a, k * a], rtol=1e-12)
    np.testing.assert_allclose(kept.by_parameters, [2 * k * a * a, 2 * k * k * a], rtol=1e-12)
    direct = 2 * k * t * found.y[0] + k * k * t * a * by_k[0]
    assert found.quantities["late"].by_parameters[0] == pytest.approx(direct, rel=1e-12)


def sphere(D: float, a1: float) -> tuple[gi.Problem, np.ndarray]:
    problem = ch.ChaplyginSphere(a=[a1, 1.1, 1.5], D=D).hamiltonized()
    return problem, problem.state(gamma=[0.48, 0.6, 0.64], p=[0.8, 1.0, -1.5375])


def test_against_exact_motions() -> None:
    """Of another system at another parameter each; its state depends on them too."""
    values = {"D": 4.0, "a1": 0.8}
    run = {"tau_end": 3.0, "step": 0.1}
    found = gi.sensitivities(sphere, parameters=values, **run, observe="energy")
    for i, name in enumerate(values):

        def ends(h: float, name: str = name) -> np.ndarray:
            problem, y0 = sphere(**{**values, name: values[name] + h})
            return np.append(problem.exact(y0).at_tau(3.0), gi.value(problem, "energy", y0))

        def slope(h: float, ends: Any = ends) -> np.ndarray:
            return (ends(h) - ends(-h)) / (2 * h)

        expected = (64 * slope(0.005) - 20 * slope(0.01) + slope(0.02)) / 45
        by = np.append(found.by_parameters[:, i], found.quantities["energy"].by_parameters[i])
        np.testing.assert_allclose(by, expected, rtol=0, atol=1e-9)


UNIT = {"t_end": 1.0, "step": 0.1}


def of_square(square: Any, start: Any = lambda k: 1.0) -> Any:
    """Return a spring from rest whose k² and whose x are functions of a parameter."""
    return lambda k: (dataclasses.replace(SPRING, params=[square(k), 0.0, 0.0]), [start(k), 0.0])


def test_at_the_end_of_what_is_admissible() -> None:
    """A parameter that cannot move by a tenth moves by less; one that cannot at all says why."""

    def bounded(k: float) -> float:
        if k > 1.02:
            raise gi.DomainError("k", k, "at most 1.02")
        return k * k

    near = gi.sensitivities(of_square(bounded), parameters={"k": 1.0}, **UNIT)
    assert near.by_parameters[0, 0] == pytest.approx(-math.sin(1.0), rel=1e-11)
    with pytest.raises(gi.DomainError, match=r"at most 1\.02"):
        gi.sensitivities(of_square(bounded), parameters={"k": 1.02}, **UNIT)


def test_a_parameter_that_is_zero_or_does_nothing() -> None:
    def shifted(k: float, nothing: float) -> Any:
        return of_square(lambda k: 1.0 + k)(k)

    found = gi.sensitivities(shifted, parameters={"k": 0.0, "nothing": 3.0}, **UNIT)
    np.testing.assert_allclose(found.by_parameters[0], [-0.5 * math.sin(1.0), 0.0], rtol=1e-11)


def allowed(a: float) -> float:
    """Return a number that is above 0."""
    if a <= 0.0:
        raise gi.DomainError("a", a, "above 0")
    return a


TINY = {
    "a sum": (lambda a: 1.0 + a, 1.0, True),
    "little of it": (lambda a: 1.0 + 1e-6 * a, 1e-6, True),
    "a kink": (lambda a: 1.0 + abs(a), 1.0, False),
    "a sum that ends": (lambda a: 1.0 + allowed(a), 1.0, False),
}


@pytest.mark.parametrize("name", TINY)
@pytest.mark.parametrize("a", [1e-13, 3e-20, 1e-200])
def test_a_parameter_that_is_tiny(name: str, a: float) -> None:
    """Differences over a part of it are rounding: over more, or refused where that is not possible."""
    of, slope, possible = TINY[name]
    if not possible:
        with pytest.raises(gi.DomainError, match="lost in rounding"):
            gi.sensitivities(of_square(of), parameters={"k": a}, **UNIT)
        return
    w = math.sqrt(of(a))
    expected = -0.5 * math.sin(w) / w * slope
    found = gi.sensitivities(of_square(of), parameters={"k": a}, **UNIT)
    assert abs(found.by_parameters[0, 0] - expected) < 1e-10 * max(abs(expected), 1e-3)


def scaled(f: Any, k: float = 2.0) -> Any:
    """Another function of the same name, that holds a constant."""

    def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
        return k * f(params, t, y, work)

    return gi.observable(energy)


def holding(force: Any) -> Any:
    """Return a family of springs whose force holds the parameter."""

    def family(k: float) -> gi.Problem:
        held = gi.helper(force(k))
        field = second("held", lambda p, t, y: held(t, y[0])).field
        return dataclasses.replace(SPRING, field=field)

    return family


# A force that holds k, and where nothing is seen of it: where x = 0, at time 0, until x is 1.6.
HELD = [
    (holding(lambda k: lambda t, x: -k * x), [0.0, 1.0]),
    (holding(lambda k: lambda t, x: -k * x), [0.0, 0.0]),
    (holding(lambda k: lambda t, x: -k * t * x), [1.0, 0.0]),
    (holding(lambda k: lambda t, x: gi.select(x > 1.6, -k * x, 0.0 * x)), [1.0, 1.0]),
    (lambda k: dataclasses.replace(SPRING, invariants={"energy": scaled(energy, k)}), [1.0, 0.0]),
]


@pytest.mark.parametrize(("family", "y0"), HELD)
def test_constants_that_functions_hold(family: Any, y0: list[float]) -> None:
    """They are found wherever the run leads, at rest too, and in what is observed."""
    with pytest.raises(gi.DomainError, match="hold this one as a constant"):
        gi.sensitivities(family, y0, parameters={"k": 1.3}, **UNIT, observe="energy")


@pytest.mark.parametrize("place", ["parameters", "state"])
def test_kinks_are_refused_and_what_is_fast_is_not(place: str) -> None:
    """At a kink differences of both sides have a limit that is no derivative."""

    def ends(f: Any) -> np.ndarray:
        family = of_square(lambda k: 1.0, f)
        if place == "parameters":
            family = of_square(lambda k: 1.0 + f(k))
        return gi.sensitivities(family, parameters={"k": 1.0}, **UNIT).by_parameters[0, 0]

    for kinked in (
        lambda k: abs(k - 1.0),
        lambda k: max(k, 1.0),
        lambda k: 1.0 + 1e-3 * abs(k - 1.0),
    ):
        with pytest.raises(gi.DomainError, match="smooth functions"):
            ends(kinked)
    of_one = ends(lambda k: k - 1.0)
    for f, slope in ((lambda k: math.sin(200.0 * (k - 1.0)), 200.0), (lambda k: k**50 - 1.0, 50.0)):
        assert ends(f) == pytest.approx(slope * of_one, rel=1e-9)


def of_params(params: Any) -> Any:
    """Return a family whose flat parameters are a function of k."""
    return lambda k: dataclasses.replace(SPRING, params=params(k))


REST = [1.0, 0.0]
WRONG: list[tuple[Any, Any, dict[str, Any], str]] = [
    (of_params(lambda k: [abs(k - 1.0) + 1.0]), REST, {}, "smooth functions"),
    (of_params(lambda k: [1.0] * (1 if k <= 1.0 else 2)), REST, {}, "one and the same form"),
    (of_params(lambda k: [1 / 0]), REST, {}, "ZeroDivisionError"),
    (of_params(lambda k: [math.sqrt(k - 1.0)]), REST, {}, "ValueError: math domain"),
    (SPRING, REST, {}, "a function of them"),
    (3, REST, {}, "a geomint.Problem, or a function"),
    (lambda k: 3, REST, {}, "returns a geomint.Problem"),
    (spring, REST, {}, "returns an initial state"),
    (spring, None, {"parameters": 3}, "a mapping"),
    (spring, None, {"parameters": {"k": math.nan}}, "parameters"),
    (spring, None, {"parameters": {"kk": 1.0}}, "those of the function"),
    (spring, None, {"parameters": {}}, "those of the function"),
    (spring, None, {"parameters": {3: 1.0}}, "names to numbers"),
    (spring, None, {"observe": ["enrgy"]}, "Did you mean 'energy'"),
    (spring, None, {"observe": [energy, scaled(energy)]}, "two are 'energy'"),
    (spring, None, {"method": "exact"}, "no steps of a given length"),
]


@pytest.mark.parametrize(("family", "y0", "changed", "said"), WRONG)
def test_wrong_families(family: Any, y0: Any, changed: dict[str, Any], said: str) -> None:
    with pytest.raises(gi.GeomintError, match=said):
        gi.sensitivities(family, y0, **{"parameters": {"k": 1.0}, **UNIT, **changed})


@gi.observable
def length(params: Any, t: Any, y: Any, work: Any) -> Any:
    return gi.sqrt(y[0] * y[0] + y[1] * y[1])


def test_without_parameters() -> None:
    """That is the derivative of the flow alone; |y| has none for a state that stays at 0."""
    with pytest.raises(gi.DomainError, match="derivatives where the run ends"):
        gi.sensitivities(SPRING, [0.0, 0.0], **UNIT, observe=[length])
    found = gi.sensitivities(SPRING, [1e-9, 0.0], **UNIT, observe=length)
    np.testing.assert_allclose(found.quantities["length"].by_state, [1.0, 0.0], atol=1e-13)
    flow = gi.tangent_flow(SPRING, [1e-9, 0.0], **UNIT)
    np.testing.assert_array_equal(found.by_state, flow.slopes)
    assert found.by_parameters.shape == (2, 0)
    assert "length" in repr(found)
