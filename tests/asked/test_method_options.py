"""Every option of every method reaches the stepper, and does what it says."""

from __future__ import annotations

import math

import numpy as np
import pytest

import geomint as gi
from geomint.methods import Start
from geomint.methods.adaptive_stepper import AdaptiveStepper
from geomint.problems.testproblems import pulsating_body, sphere_metric
from tests.asked.asked_support import arguments_of

BOTH = {  # two values of every option
    "iteration_tolerance": (0.0, 1e-6),
    "max_iterations": (50, 60),
    "fused": (False, True),
    "iteration": ("auto", "newton"),
    "rtol": (1e-8, 1e-6),
    "atol": (1e-12, 1e-10),
    "max_step": (math.inf, 0.01),
    "max_steps": (10**8, 7),
}
MAKERS = {"adaptive": (gi.RungeKutta, gi.RKMK), "implicit": (gi.Gauss, gi.Lobatto, gi.Rattle)}

ON_SPHERE, BODY = sphere_metric.problem(), pulsating_body.problem()
STARTS = {
    "action": (BODY, pulsating_body.INITIAL),
    "field": (ON_SPHERE, sphere_metric.initial(ON_SPHERE)),
    "hamiltonian": (ON_SPHERE, sphere_metric.initial(ON_SPHERE)),
}

PAIRS = [
    (name, option) for name in gi.method_names() for option in gi.find_method(name).options
] + [("gauss-1-suzuki-4", option) for option in gi.find_method("gauss-1-suzuki-4").options]


def stepper(method: gi.Method) -> object:
    problem, y0 = STARTS[method.needs]
    return method.start(Start(problem, y0, 0.0, 0.1, compiled=False, end=1.0))


def made_of(method: gi.Method) -> object:
    s = stepper(method)
    allowed = s.allowed if isinstance(s, AdaptiveStepper) else None
    return [s.coefficients.data.tolist(), s.kernel, s.functions, allowed]


def test_every_option_of_every_method_is_in_the_table() -> None:
    known = {option for name in gi.method_names() for option in gi.find_method(name).options}
    assert known == set(BOTH)
    for makers in MAKERS.values():
        for make in makers:
            assert arguments_of(make) - {"stages", "tableau", "coordinates", "adaptive"} <= known


@pytest.mark.parametrize(("name", "option"), PAIRS)
def test_an_option_reaches_the_stepper(name: str, option: str) -> None:
    """By its keyword and through a scene's section: the same method."""
    method = gi.find_method(name)
    one, other = (method.with_options(**{option: given}) for given in BOTH[option])
    assert made_of(one) != made_of(other)
    assert made_of(one) == made_of(method.with_options(**{option: BOTH[option][0]}))
    assert other.options[option] == BOTH[option][1]
    assert other.name == method.name


@pytest.mark.parametrize("name", ["gauss-4", "cf-4", "rk-4", "rattle-2", "dop853-adaptive"])
def test_an_option_that_a_method_does_not_have_is_refused(name: str) -> None:
    method = gi.find_method(name)
    for option in BOTH.keys() - method.options.keys():
        with pytest.raises(gi.MethodError, match=f"no option '{option}'"):
            method.with_options(**{option: BOTH[option][1]})


def solved(method: gi.Method, **more: object) -> gi.Solution:
    problem, y0 = STARTS[method.needs]
    given = {"t_end": 0.4, "compiled": False, "progress": False, **more}
    return gi.solve(problem, y0, method=method, **given)


@pytest.mark.parametrize(
    "make",
    [gi.Rattle, lambda **o: gi.Gauss(2, iteration="fixed-point", **o)],
    ids=["rattle", "gauss"],
)
def test_implicit_options_do_what_they_say(make) -> None:
    full, short = (solved(make(iteration_tolerance=x), step=0.05) for x in (0.0, 1e-4))
    assert short.iterations < full.iterations
    with pytest.raises(gi.ConvergenceError, match="2 iterations"):
        solved(make(max_iterations=2), step=0.1)


@pytest.mark.parametrize("make", [gi.RungeKutta, gi.RKMK])
def test_adaptive_options_do_what_they_say(make) -> None:
    def taken(**options: object) -> int:
        return solved(gi.Adaptive(make("bogacki-shampine-3"), **options)).steps

    assert taken(rtol=1e-6) > taken(rtol=1e-4)
    assert taken(rtol=1e-6, atol=1e-3) < taken(rtol=1e-6)
    assert taken(rtol=1e-4, max_step=0.01) >= 40
    with pytest.raises(gi.StepLimitError, match="max_steps = 3"):
        taken(rtol=1e-8, max_steps=3)


def test_arguments_that_choose_the_method() -> None:
    pairs = [
        (gi.Gauss(2), gi.Gauss(3)),
        (gi.RungeKutta("rk-4"), gi.RungeKutta("kutta-3")),
        (gi.RungeKutta("dop853"), gi.Adaptive(gi.RungeKutta("dop853"))),
        (gi.RKMK("rk-4"), gi.RKMK("kutta-3")),
        (gi.RKMK("rk-4"), gi.RKMK("rk-4", coordinates="cayley")),
        (gi.RKMK("dop853"), gi.Adaptive(gi.RKMK("dop853"))),
        (gi.CommutatorFree("cf-4"), gi.CommutatorFree("cf-3")),
        (gi.Compose(gi.Gauss(1), 4), gi.Compose(gi.Gauss(1), 6)),
        (gi.Compose(gi.Gauss(1), 4), gi.Compose(gi.Rattle(), 4)),
    ]
    for one, other in pairs:
        results = [
            solved(m, t_end=0.1, **({} if m.adaptive else {"step": 0.1})).y for m in (one, other)
        ]
        assert not np.array_equal(*results), (one.name, other.name)
