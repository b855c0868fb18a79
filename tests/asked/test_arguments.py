"""Every argument of every public function of geomint that has a short answer does something."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import sphere_metric
from tests.asked.asked_support import arguments_of, check

# Steps are as long as a test wants them.
# Quantities that are looked at as invariants are none of the motions here.
pytestmark = pytest.mark.filterwarnings(
    "ignore:steps of .* are so long:geomint.GeomintWarning", "ignore::geomint.DeclarationWarning"
)


@gi.field
def pushed(params, t, y, out, work):
    out[0] = params[0] * gi.sin(y[1]) * (1.0 + 0.1 * t)
    out[1] = -gi.sin(y[0])


@gi.field
def measured(params, t, y, out, work):
    out[0], out[1] = params[0] * y[0], 1.0 * len(work)


@gi.field
def upwards(params, t, y, out, work):
    out[0], out[1], out[2] = 0.0 * y[0], 0.0 * y[1], 1.0 + 0.0 * y[2]


@gi.observable
def size(params, t, y, work):
    return (1.0 + t) * params[0] * y[0] * y[0] * y[1]


@gi.observable
def rate(params, t, y, work):
    return 1.0 + 0.3 * y[0] * y[0]


IN_T = gi.Problem("pushed", (("y", 2),), [1.5], field=pushed, invariants={"size": size})
IN_TAU = dataclasses.replace(IN_T, time="tau", clock=rate)
TURNED = gi.Problem("turned", (("y", 2), ("z", 1)), field=upwards)
ONE = gi.Scene(
    system={"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    initial={"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    time={"t_end": 0.5},
    integrate={"method": "rk-4", "step": 0.125},
)
SIGNAL = np.exp(0.7j * np.arange(64)) + 0.3 * np.exp(1.3j * np.arange(64))
VALUES: dict[str, Any] = {
    "problem": (IN_T, dataclasses.replace(IN_T, params=[2.5])), "by": ("state", "parameters"),
    "y": [1.0, 2.5], "y0": [0.5, 0.6], "state": [0.5, 0.6], "states": [0.5, 0.6], "step": 0.25,
    "method": ("rk-4", "kutta-3"), "t": (0.0, 0.5), "t0": (0.0, 0.5), "time": (0.0, 0.5),
    "t_end": 1.0, "tau_end": (1.0, 2.0), "tolerance": (1e-3, 1e-4), "t_eval": (None, [0.5, 1.0]),
    "tau_eval": (None, [0.5]), "events": (None, "y[1] - 0.3"), "save_every": (None, 2),
    "observe": ((), "size"), "observe_every": (1, 3), "clock": (False, True), "breaks": ((), [0.7]),
    "longest": (None, 0.05), "f": (size, rate), "rate": (size, rate), "count": (None, 1),
    "directions": (None, [[1.0], [0.5]]), "parameters": (None, [[1.0]]), "tangents": (1, 2),
    "event": ("y[0]", "y[1]"), "end": (np.inf, 0.7), "form": ("field", "action"), "points": 2,
    "signal": (SIGNAL, SIGNAL.conj()), "name": ("one", "two"), "find_method name": ("rk-4", "gauss-4"),
    "values": (SIGNAL.real, SIGNAL.imag), "what": ("y[0]", "y[1]"), "direction": ("both", "up"),
    "terminal": (False, 2), "level": (0.0, 0.5), "purpose": ("run", "drift"), "rows": 2,
    **dict.fromkeys(("source", "scene"), (ONE, ONE.changed(time={"t_end": 0.25}))),
    "function": (measured, pushed), "params": [1.0], "pointwise points": np.ones((2, 2)),
    "sensitivities parameters": ({"c": 1.5}, {"c": 2.5}),
}  # fmt: skip


def pushed_by(c: float) -> tuple[gi.Problem, list[float]]:
    return dataclasses.replace(IN_T, params=[c]), [0.5, 0.2 * c]


# What an argument needs beside it, or in place of another one.
TO_TAU: dict[str, Any] = {"problem": IN_TAU, "t_end": None, "tau_end": 1.0}
ON_GROUP = dataclasses.replace(TURNED, action=gi.GroupAction(upwards, gi.so3(1)))
BESIDE: dict[str, dict[str, Any]] = {
    **{f"{name} tau_end": TO_TAU for name in ("solve", "sensitivities", "lyapunov", "tangent_flow")},
    "solve tau_eval": TO_TAU, "solve clock": TO_TAU, "solve tolerance": {"step": None},
    "solve longest": {"method": "dormand-prince-5-adaptive", "step": 0.01},
    "solve observe_every": {"observe": "size"}, "pointwise check": {"rows": 3},
    "sensitivities parameters": {"problem": pushed_by, "y0": None},
    "derivative form": {"problem": ON_GROUP, "y": [1.0, 2.0, 3.0]},
    "poincare_section clock": {"problem": IN_TAU}, "Integrator clock": {"problem": IN_TAU},
    "Integrator tangents": {"compiled": True},
}  # fmt: skip


def stepped(**given: Any) -> Any:
    motion = gi.Integrator(**given)
    motion.step(2)
    return [motion.restart, motion.tangents if given.get("tangents") else None]


# What is looked at, where the result alone does not say it, or needs what has a default.
RUN: Any = {"y0": [0.5, 0.6], "t_end": 1.0, "step": 0.25, "method": "rk-4"}
LOOK: dict[str, Callable[..., Any]] = {
    "solve": partial(gi.solve, **RUN, compiled=False),
    **{f: partial(getattr(gi, f), **RUN) for f in ("sensitivities", "lyapunov", "tangent_flow")},
    "poincare_section": partial(gi.poincare_section, method="rk-4", step=0.25),
    "Integrator": partial(stepped, method="rk-4", step=0.25, compiled=False),
    "load_scene": lambda source: gi.load_scene(source).sections,
    "make_plan": lambda **a: [(c.what, c.value, c.reason) for c in gi.make_plan(**a).choices],
}
# They change no result.
NOWHERE = {"compiled", "progress", "callback"}
# Functions of kernels, spaces, ensembles, files, pages: each has tests of its own.
ELSEWHERE = {
    "Method", "Product", "Reading", "RigidMotions", "Scene", "Space", "TangentSphere", "as_vector",
    "TangentStiefel", "chaos_report", "check_file", "check_folder", "cite", "compare_report",
    "draw_states", "drift_report", "event", "field", "fma", "great_circle", "helper", "load",
    "maximum", "natural_in_space", "natural_on_sphere", "observable", "open_ensemble", "packed",
    "part", "pow", "report",
    "run_methods", "run_scene", "scan_report", "section", "section_report", "select", "so3", "so_n",
    "solve_ensemble", "stress_report", "time_transformed", "translations", "turn_coefficients",
    "whole_file", "whole_folder", "atan2",
    *("cos", "exp", "log", "sin", "sqrt", "tan", "tanh", "top"),
}  # fmt: skip


def asked() -> list[str]:
    """Return the functions and classes that are no mere records of what they are given."""
    found = {name: getattr(gi, name) for name in gi.__all__ if name not in ELSEWHERE}
    own = {n: f for n, f in found.items() if callable(f) and not n.endswith(("Error", "Warning"))}
    return [n for n, f in own.items() if n == "Event" or not dataclasses.is_dataclass(f)]


@pytest.mark.parametrize("name", asked())
def test_every_argument_does_something(name: str) -> None:
    function = getattr(gi, name)
    arguments = {a: p for a, p in arguments_of(function).items() if a not in NOWHERE}
    check(name, LOOK.get(name, function), arguments, VALUES, BESIDE)


# Two values of every option of a method; `fused` changes no result.
OPTIONS: dict[str, Any] = {
    "iteration_tolerance": (0.0, 1e-4), "max_iterations": (50, 2), "iteration": ("auto", "newton"),
    "rtol": (1e-6, 1e-4), "atol": (1e-12, 1e-3), "max_step": (np.inf, 0.05), "max_steps": (10**8, 3),
    "fused": (False, True),
}  # fmt: skip


@pytest.mark.parametrize("name", gi.method_names())
def test_every_option_of_a_method_is_taken_and_no_other(name: str) -> None:
    method = gi.find_method(name)
    for option, (_, value) in OPTIONS.items():
        if option in method.options:
            other = method.with_options(**{option: value})
            assert (other.name, dict(other.options)) == (name, {**method.options, option: value})
        else:
            with pytest.raises(gi.MethodError, match=f"no option '{option}'"):
                method.with_options(**{option: value})


KINDS = ["gauss-4", "lobatto-3", "rattle-2", "bogacki-shampine-3-adaptive"]


@pytest.mark.parametrize("name", KINDS)
def test_every_option_of_a_method_does_something(name: str) -> None:
    problem = sphere_metric.problem()
    run = {"t_end": 0.4, "compiled": False, "step": 0.1}

    def solved(**options: Any) -> gi.Solution:
        method = gi.find_method(name).with_options(**options)
        return gi.solve(problem, sphere_metric.initial(problem), method=method, **run)

    kind = inspect.Parameter.KEYWORD_ONLY
    options = [option for option in gi.find_method(name).options if option != "fused"]
    arguments = {option: inspect.Parameter(option, kind, default=None) for option in options}
    check(name, solved, arguments, OPTIONS, {})


def test_a_method_says_what_it_fits() -> None:
    gauss, action = gi.Gauss(2), gi.CommutatorFree("cf-2")
    gauss.check_fits(IN_T, False)
    with pytest.raises(gi.FormError, match="no clock"):
        gauss.check_fits(IN_T, True)
    with pytest.raises(gi.FormError, match="needs the form 'action'"):
        action.check_fits(IN_T, False)
    assert (gauss.structure(IN_T), gi.RungeKutta("rk-4").structure(IN_T)) == ("symmetric", "")
