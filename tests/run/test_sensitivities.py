"""Sensitivities: against closed forms, conserved quantities, exact motions; wrong families."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi


@gi.field
def swinging(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[1]
    out[1] = -params[0] * y[0]


@gi.observable
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 0.5 * (y[1] * y[1] + params[0] * y[0] * y[0])


@gi.observable
def late(params: Any, t: Any, y: Any, work: Any) -> Any:
    return params[0] * t * y[0]


SPRING = gi.Problem(
    "spring", (("x", 1), ("v", 1)), [1.0], field=swinging, invariants={"energy": energy}
)


def spring(k: float, a: float = 0.7) -> tuple[gi.Problem, list[float]]:
    return dataclasses.replace(SPRING, params=[k * k]), [a, k * a]


@pytest.mark.parametrize("k", [0.3, 1.0, 20.0, 1e-3])
def test_a_spring(k: float) -> None:
    """x = a (cos kt + sin kt): by all that it depends on, to 1e-12."""
    t, a = 1.7 / k, 0.7
    found = gi.sensitivities(
        spring, parameters={"k": k, "a": a}, t_end=t, step=0.1 / k, observe=["energy", late]
    )
    c, s = math.cos(k * t), math.sin(k * t)
    phi = [[c, s / k], [-k * s, c]]
    by_k = a * np.array([t * (c - s), (c - s) - k * t * (s + c)])
    by_a = np.array([c + s, k * (c - s)])
    scales = np.array([a, k * a])
    assert found.parameters == ("k", "a")
    np.testing.assert_allclose(found.y, [a * (c + s), k * a * (c - s)], rtol=1e-13)
    np.testing.assert_allclose(
        found.by_state * scales / scales[:, None],
        phi * scales / scales[:, None],
        rtol=0,
        atol=1e-13,
    )
    expected = np.column_stack((by_k, by_a)) / scales[:, None]
    atol = 1e-12 * np.abs(expected).max()
    np.testing.assert_allclose(found.by_parameters / scales[:, None], expected, rtol=0, atol=atol)
    kept = found.quantities["energy"]
    assert kept.value == pytest.approx((k * a) ** 2, rel=1e-13)
    np.testing.assert_allclose(kept.by_state, [k * k * a, k * a], rtol=1e-12)
    np.testing.assert_allclose(kept.by_parameters, [2 * k * a * a, 2 * k * k * a], rtol=1e-12)
    at_end = found.quantities["late"]
    direct = 2 * k * t * found.y[0] + k * k * t * by_k[0]
    assert at_end.by_parameters[0] == pytest.approx(direct, rel=1e-12)


def test_without_parameters() -> None:
    """That is the derivative of the flow alone."""
    found = gi.sensitivities(SPRING, [0.3, 0.4], t_end=2.0, step=0.1, observe="energy")
    flow = gi.tangent_flow(SPRING, [0.3, 0.4], t_end=2.0, step=0.1)
    np.testing.assert_array_equal(found.by_state, flow.slopes)
    assert found.by_parameters.shape == (2, 0)
    np.testing.assert_allclose(found.quantities["energy"].by_state, [0.3, 0.4], rtol=1e-13)
    assert "energy" in repr(found)


def test_integrals() -> None:
    """∫ x² dt, a number of the state: its value is (2a)² t/2 over a period, k = 1 and v₀ = a."""

    @gi.observable
    def squared(params: Any, t: Any, y: Any, work: Any) -> Any:
        return y[0] * y[0]

    def watched(a: float) -> tuple[gi.Problem, list[float]]:
        problem, y0 = spring(1.0, a)
        return gi.with_quadrature(problem, "s", squared), [*y0, 0.0]

    found = gi.sensitivities(watched, parameters={"a": 0.5}, t_end=2 * math.pi, step=0.1)
    assert found.y[2] == pytest.approx(2 * math.pi * 0.25, rel=1e-13)
    assert found.by_parameters[2, 0] == pytest.approx(2 * math.pi, rel=1e-12)


def sphere(D: float, a1: float) -> tuple[gi.Problem, np.ndarray]:
    problem = ch.ChaplyginSphere(a=[a1, 1.1, 1.5], D=D).hamiltonized()
    return problem, problem.state(gamma=[0.48, 0.6, 0.64], p=[0.8, 1.0, -1.5375])


def test_against_exact_motions() -> None:
    """Of another system at another parameter each; its state depends on them too."""
    values = {"D": 4.0, "a1": 0.8}
    found = gi.sensitivities(sphere, parameters=values, tau_end=3.0, step=0.1, observe="energy")
    for i, name in enumerate(values):

        def ends(h: float, name: str = name) -> np.ndarray:
            problem, y0 = sphere(**{**values, name: values[name] + h})
            return np.append(problem.exact(y0).at_tau(3.0), gi.value(problem, "energy", y0))

        def slope(h: float, ends: Any = ends) -> np.ndarray:
            return (ends(h) - ends(-h)) / (2 * h)

        expected = (64 * slope(0.005) - 20 * slope(0.01) + slope(0.02)) / 45
        by = np.append(found.by_parameters[:, i], found.quantities["energy"].by_parameters[i])
        np.testing.assert_allclose(by, expected, rtol=0, atol=1e-9)


def test_at_the_end_of_what_is_admissible() -> None:
    """A parameter that cannot move by a tenth moves by less; one that cannot at all says why."""

    def bounded(k: float) -> gi.Problem:
        if k > 1.02:
            raise gi.DomainError("k", k, "at most 1.02")
        return dataclasses.replace(SPRING, params=[k * k])

    given = {"t_end": 1.0, "step": 0.1}
    near = gi.sensitivities(bounded, [1.0, 0.0], parameters={"k": 1.0}, **given)
    assert near.by_parameters[0, 0] == pytest.approx(-math.sin(1.0), rel=1e-11)
    with pytest.raises(gi.DomainError, match=r"at most 1\.02"):
        gi.sensitivities(bounded, [1.0, 0.0], parameters={"k": 1.02}, **given)


def test_a_parameter_that_is_zero_or_does_nothing() -> None:
    def shifted(k: float, nothing: float) -> tuple[gi.Problem, list[float]]:
        return dataclasses.replace(SPRING, params=[1.0 + k]), [1.0, 0.0]

    found = gi.sensitivities(
        shifted, parameters={"k": 0.0, "nothing": 3.0}, t_end=1.0, step=0.1
    )  # fmt: skip
    np.testing.assert_allclose(found.by_parameters[0], [-0.5 * math.sin(1.0), 0.0], rtol=1e-11)


def allowed(a: float) -> float:
    """Return a number that is above 0."""
    if a <= 0.0:
        raise gi.DomainError("a", a, "above 0")
    return a


TINY = {
    "a sum": (lambda a: 1.0 + a, lambda a: 1.0, True),
    "little of it": (lambda a: 1.0 + 1e-6 * a, lambda a: 1e-6, True),
    "its unit": (lambda a: a / TINIEST, lambda a: 1.0 / TINIEST, True),
    "a kink": (lambda a: 1.0 + abs(a), lambda a: 1.0, False),
    "a sum that ends": (lambda a: 1.0 + allowed(a), lambda a: 1.0, False),
}
TINIEST = 1e-13


@pytest.mark.parametrize("name", TINY)
@pytest.mark.parametrize("a", [TINIEST, 3e-20, 1e-200])
def test_a_parameter_that_is_tiny(name: str, a: float) -> None:
    """Differences over a part of it are rounding: over more, or refused where that is not possible."""
    of, slope, found = TINY[name]
    if name == "its unit":
        a = TINIEST

    def family(a: float) -> tuple[gi.Problem, list[float]]:
        return dataclasses.replace(SPRING, params=[of(a)]), [1.0, 0.0]

    given: dict[str, Any] = {"parameters": {"a": a}, "t_end": 1.0, "step": 0.1}
    if not found:
        with pytest.raises(gi.DomainError, match="lost in rounding"):
            gi.sensitivities(family, **given)
        return
    w = math.sqrt(of(a))
    expected = -0.5 * math.sin(w) / w * slope(a)
    off = abs(gi.sensitivities(family, **given).by_parameters[0, 0] - expected)
    assert off < 1e-10 * max(abs(expected), 1e-3)


def scaled(f: Any) -> Any:
    """Another function of the same name."""

    def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
        return 2.0 * f(params, t, y, work)

    return gi.observable(energy)


def swung(k: float) -> gi.Problem:
    """Where x = 0 nothing is seen of a k that is held."""

    @gi.field
    def held(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0], out[1] = y[1], -k * y[0]

    return dataclasses.replace(SPRING, field=held)


def driven(k: float) -> gi.Problem:
    """At time 0 nothing is seen of it."""

    @gi.field
    def held(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0], out[1] = y[1], -k * t * y[0]

    return dataclasses.replace(SPRING, field=held)


def stopped(k: float) -> gi.Problem:
    """Nothing is seen of it until the motion is beyond 1.1."""

    @gi.field
    def held(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0], out[1] = 1.0, gi.select(y[0] > 1.6, -k * y[0], 0.0 * y[1])

    return dataclasses.replace(SPRING, field=held)


def measured(k: float) -> gi.Problem:
    """A quantity holds it."""

    @gi.observable
    def held(params: Any, t: Any, y: Any, work: Any) -> Any:
        return k * y[0]

    return dataclasses.replace(SPRING, params=[k], invariants={"energy": held})


@pytest.mark.parametrize(
    ("family", "y0"),
    [
        (swung, [0.0, 1.0]),
        (swung, [0.0, 0.0]),
        (driven, [1.0, 0.0]),
        (stopped, [1.0, 0.0]),
        (measured, [1.0, 0.0]),
    ],
)
def test_constants_that_functions_hold(family: Any, y0: list[float]) -> None:
    """They are found wherever the run leads, at rest too, and in what is observed."""
    run = {"parameters": {"k": 1.3}, "t_end": 1.0, "step": 0.1, "observe": "energy"}
    with pytest.raises(gi.DomainError, match="hold this one as a constant"):
        gi.sensitivities(family, y0, **run)


@pytest.mark.parametrize("place", ["parameters", "state"])
def test_kinks_are_refused_and_what_is_fast_is_not(place: str) -> None:
    """At a kink differences of both sides have a limit that is no derivative."""

    def ends(f: Any) -> np.ndarray:
        def family(k: float) -> tuple[gi.Problem, list[float]]:
            if place == "state":
                return SPRING, [f(k), 0.0]
            return dataclasses.replace(SPRING, params=[1.0 + f(k)]), [1.0, 0.0]

        run = {"parameters": {"k": 1.0}, "t_end": 1.0, "step": 0.1}
        return gi.sensitivities(family, **run).by_parameters[0, 0]

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


def test_wrong_families() -> None:
    def captured(k: float) -> gi.Problem:
        @gi.field
        def held(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
            out[0] = k * y[0]

        return gi.Problem("held", (("x", 1),), field=held)

    def broken(k: float) -> gi.Problem:
        return dataclasses.replace(SPRING, params=[abs(k - 1.0) + 1.0])

    def grows(k: float) -> gi.Problem:
        return dataclasses.replace(SPRING, params=[1.0] * (1 if k <= 1.0 else 2))

    def divides(k: float) -> gi.Problem:
        return dataclasses.replace(SPRING, params=[1 / 0])

    def ends(k: float) -> gi.Problem:
        return dataclasses.replace(SPRING, params=[math.sqrt(k - 1.0)])

    usual = {"t_end": 1.0, "step": 0.1, "parameters": {"k": 1.0}}
    for problem, y0, changed, said in (
        (captured, [1.0], {}, "hold this one as a constant"),
        (broken, [1.0, 0.0], {}, "smooth functions"),
        (grows, [1.0, 0.0], {}, "one and the same form"),
        (SPRING, [1.0, 0.0], {}, "a function of them"),
        (3, [1.0, 0.0], {}, "a geomint.Problem, or a function"),
        (lambda k: 3, [1.0, 0.0], {}, "returns a geomint.Problem"),
        (spring, [1.0, 0.0], {}, "returns an initial state"),
        (spring, None, {"parameters": 3}, "a mapping"),
        (spring, None, {"parameters": {"k": "x"}}, "parameters"),
        (spring, None, {"parameters": {"k": math.nan}}, "parameters"),
        (spring, None, {"observe": ["enrgy"]}, "Did you mean 'energy'"),
        (spring, None, {"observe": None}, "names of quantities"),
        (spring, None, {"observe": [3]}, "a name, or a function"),
        (spring, None, {"parameters": {"kk": 1.0}}, "those of the function"),
        (spring, None, {"parameters": {}}, "those of the function"),
        (spring, None, {"parameters": {3: 1.0}}, "names to numbers"),
        (spring, None, {"observe": [energy, scaled(energy)]}, "two are 'energy'"),
        (divides, [1.0, 0.0], {}, "ZeroDivisionError"),
        (ends, [1.0, 0.0], {}, "ValueError: math domain"),
        (spring, None, {"method": "exact"}, "no steps of a given length"),
    ):
        with pytest.raises(gi.GeomintError, match=said):
            gi.sensitivities(problem, y0, **{**usual, **changed})


@gi.observable
def length(params: Any, t: Any, y: Any, work: Any) -> Any:
    return gi.sqrt(y[0] * y[0] + y[1] * y[1])


def test_a_quantity_without_a_derivative() -> None:
    """|y| of a state that stays at 0: an error, no result with NaN; next to it there is one."""

    @gi.field
    def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0], out[1] = y[1], -y[0]

    problem, run = gi.Problem("turning", (("y", 2),), field=turning), {"t_end": 1.0, "step": 0.1}
    with pytest.raises(gi.DomainError, match="derivatives where the run ends"):
        gi.sensitivities(problem, [0.0, 0.0], **run, observe=[length])
    found = gi.sensitivities(problem, [1e-9, 0.0], **run, observe=[length])
    np.testing.assert_allclose(found.quantities["length"].by_state, [1.0, 0.0], atol=1e-13)
