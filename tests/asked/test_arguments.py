"""Every argument of every public function of geomint does something."""

from __future__ import annotations

import dataclasses
import inspect
from collections import namedtuple
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.asked.asked_support import Tables, arguments_of, called, refused, seen

# Steps are as long as a test wants them.
# Quantities that are looked at as invariants are none of the motions here.
pytestmark = pytest.mark.filterwarnings(
    "ignore:steps of .* are so long:geomint.GeomintWarning", "ignore::geomint.DeclarationWarning"
)


@gi.field
def bent(params, t, y, out, work):
    out[0] = params[0] * gi.sin(y[1]) * (1.0 + 0.1 * t)
    out[1] = -gi.sin(y[0])


@gi.field
def turning(params, t, y, out, work):
    out[0] = -y[1]
    out[1] = y[0]


@gi.field
def spiral(params, t, y, out, work):
    out[0], out[1], out[2] = -params[0] * y[1], y[0], y[0] * y[2]


@gi.field
def upwards(params, t, y, out, work):
    out[0], out[1], out[2] = 0.0 * y[0], 0.0 * y[1], 1.0 + 0.0 * y[2]


@gi.field
def measured(params, t, y, out, work):
    out[0], out[1] = params[0] * y[0], 1.0 * len(work)


@gi.observable
def size(params, t, y, work):
    return (1.0 + t) * params[0] * y[0] * y[0] * y[1]


@gi.observable
def sum_of(params, t, y, work):
    return y[0] + y[1]


@gi.observable
def rate(params, t, y, work):
    return 1.0 + 0.3 * y[0] * y[0]


@gi.observable
def flat(params, t, y, work):
    return 0.0 * y[0]


@gi.field
def gradient(params, t, q, out, work):
    out[0], out[1] = q[0], 2.0 * q[1]


@gi.field
def other_gradient(params, t, q, out, work):
    out[0], out[1] = 2.0 * q[0], q[1]


WHOLE: dict[str, Any] = {"pieces": (("y", 2),), "params": [1.5], "field": bent}
WHOLE |= {"invariants": {"size": size}, "observables": {"sum": sum_of}}
IN_T = gi.Problem("bent", **WHOLE)
IN_TAU = gi.Problem("bent", **WHOLE, time="tau", clock=rate)
EVEN = gi.Problem("even", (("y", 2), ("z", 1)), [1.0], field=spiral)
ON_GROUP = dataclasses.replace(EVEN, action=gi.GroupAction(upwards, gi.so3(1)))
OTHER = dataclasses.replace(IN_T, params=[2.5])
SCENE = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    "time": {"t_end": 0.5},
    "integrate": {"method": "rk-4", "step": 0.125},
    "observe": {"quantities": ["energy"]},
}
ONE = gi.Scene(**SCENE)
TWO = ONE.changed(time={"t_end": 0.25})
ON_CIRCLES = [[0.6, 0.8, -0.8, 0.6], [0.8, 0.6, -0.6, 0.8]]
LAYOUTS = [
    namedtuple("Two", "first second")(1, gi.REST),
    namedtuple("Two", "second first")(1, gi.REST),
]
RUN: Any = {"y0": [0.5, 0.6], "t_end": 1.0, "step": 0.25, "method": "rk-4"}
SIGNAL = np.exp(0.7j * np.arange(64)) + 0.3 * np.exp(1.3j * np.arange(64))


def bent_by(c: float) -> tuple[gi.Problem, list[float]]:
    return dataclasses.replace(IN_T, params=[c]), [0.5, 0.2 * c]


PAIRS: dict[str, Any] = {
    "problem": [IN_T, OTHER], "by": ["state", "parameters"], "t_end": [1.0, 0.7],
    "tau_end": [1.0, 2.0], "method": ["rk-4", "kutta-3"], "tolerance": [1e-3, 1e-4],
    "t_eval": [None, [0.5, 1.0]], "tau_eval": [None, [0.5]], "events": [None, "y[1] - 0.3"],
    "save_every": [None, 2], "observe": [(), "size"], "observe_every": [1, 3], "clock": [False, True],
    "breaks": [(), [0.7]], "longest": [None, 0.05], "f": [size, sum_of], "rate": [size, sum_of],
    "directions": [None, [[1.0], [0.5]]], "parameters": [None, [[1.0]]], "count": [None, 1],
    "event": ["y[0]", "y[1]"], "end": [np.inf, 0.7], "tangents": [1, 2], "layout": LAYOUTS,
    "derivative form": ["field", "action"], "signal": [SIGNAL, SIGNAL.conj()],
    "name": ["one", "two"], "find_method name": ["rk-4", "gauss-4"],
    "section name": ["first", "second"],
    "what": ["y[0]", "y[1]"], "direction": ["both", "up"], "terminal": [False, 2],
    "source": [ONE, TWO], "scene": [ONE, TWO], "purpose": ["run", "drift"],
    "so_n pieces": [["vector"], ["vector", "frame"]], "names": [("a", "b"), ("a", "c")],
    "factors": [[gi.Sphere(2)], [gi.Sphere(2), gi.Skew(2)]], "function": [measured, turning],
    "acceleration": [gradient, other_gradient], "gradient": [gradient, other_gradient],
    "time_transformed problem": [EVEN, dataclasses.replace(EVEN, params=[2.0])],
    "time_transformed clock": ["speed", rate], "block": ON_CIRCLES, "great_circle y": ON_CIRCLES,
    "values": [{"first": 1.0, "second": 2.0}, {"first": 1.0, "second": 4.0}],
    "birkhoff_average values": [SIGNAL.real, SIGNAL.imag], "points": [2, 3], "params": [[1.0], [2.0]],
    "pointwise points": [np.ones((2, 2)), 2.0 * np.ones((2, 2))],
    "sensitivities parameters": [{"c": 1.5}, {"c": 2.5}],
    **{f"{f} {x}": pair for f in ("atan2", "fma", "maximum", "pow", "select")
       for x, pair in (("x", [1.5, 3.0]), ("y", [2.0, 4.0]), ("z", [3.0, 4.0]))},
}  # fmt: skip
NEAR: dict[str, Any] = {
    "y": [1.0, 2.5], "y0": [0.5, 0.6], "step": 0.25, "state": [0.5, 0.6], "states": [0.5, 0.6],
    "x": 0.5, "condition": True, "s": 0.1, "h": 0.1, "start": 0, "rows": 2, "n": 4, "r": 1, "m": 1,
    "vectors": 1, "time_transformed y0": [0.6, 0.8, 1.0], "t0": 0.1,
}  # fmt: skip
TO_TAU: dict[str, Any] = {"problem": IN_TAU, "t_end": None, "tau_end": 1.0}
BESIDE: dict[str, dict[str, Any]] = {
    "derivative form": {"problem": ON_GROUP, "y": [1.0, 2.0, 3.0]}, "select y": {"condition": False},
    **{f"{name} tau_end": TO_TAU for name in ("solve", "sensitivities", "lyapunov", "tangent_flow")},
    "solve tau_eval": TO_TAU, "solve clock": TO_TAU, "solve tolerance": {"step": None},
    "solve observe_every": {"observe": "size"},
    "solve longest": {"method": "dormand-prince-5-adaptive", "step": 0.01},
    "sensitivities parameters": {"problem": bent_by, "y0": None},
    "poincare_section clock": {"problem": IN_TAU}, "Integrator clock": {"problem": IN_TAU},
    "pointwise check": {"rows": 3}, "Integrator tangents": {"compiled": True},
}  # fmt: skip


def stepped(**given: Any) -> Any:
    motion = gi.Integrator(**given)
    motion.step(2)
    return [motion.restart, motion.tangents if given.get("tangents") else None]


def inside(y: Any, write: Callable[..., None]) -> Any:
    """Return what a function that only kernels can call writes."""
    write = gi.helper(write)

    def field(params, t, y, out, work):  # type: ignore[no-untyped-def]
        for i in range(4):
            out[i] = 0.0
        write(y, out)

    return gi.derivative(gi.Problem("inside", (("y", 4),), field=gi.field(field)), y)


def copied(cut: Callable[..., Any], *given: Any) -> Callable[..., None]:
    """Return what copies a part of a block that begins where the other does."""

    def copy(y, out):  # type: ignore[no-untyped-def]
        part = cut(y, *given)
        for i in range(len(part)):
            out[i] = part[i]

    return copy


def along(splitting: gi.Splitting) -> Any:
    problem = gi.Problem("split", (("q", 2), ("v", 2)), splitting=splitting)
    run = {"t_end": 0.2, "step": 0.1, "method": "verlet-2", "compiled": False}
    return gi.solve(problem, ON_CIRCLES[0], **run).y


# What is looked at, where the result alone does not say it, or is called in another way.
LOOK: dict[str, Callable[..., Any]] = {
    "solve": partial(gi.solve, **RUN, compiled=False),
    **{f: partial(getattr(gi, f), **RUN) for f in ("sensitivities", "lyapunov", "tangent_flow")},
    "poincare_section": partial(gi.poincare_section, method="rk-4", step=0.25),
    "Integrator": partial(stepped, method="rk-4", step=0.25, compiled=False),
    "time_transformed": partial(gi.time_transformed, y0=[0.6, 0.8, 1.0]),
    "natural_in_space": lambda acceleration: along(gi.natural_in_space(acceleration)),
    "natural_on_sphere": lambda gradient: along(gi.natural_on_sphere(gradient)),
    "great_circle": lambda h, y: inside(y, lambda y, out: gi.great_circle(h, y, out)),
    "part": lambda block, **given: inside(block, copied(gi.part, *given.values())),
    "section": lambda block, **given: inside(block, copied(gi.section, *given.values())),
    "packed": lambda layout, values: gi.packed(layout, **values).data,
    "so3": lambda vectors: grouped(gi.so3(vectors)),
    "so_n": lambda n, pieces: grouped(gi.so_n(n, *pieces)),
    "translations": lambda m: grouped(gi.translations(m)),
    "Product": lambda factors: repr(gi.Product(*factors)),
    **{
        name: lambda name=name, **given: repr(getattr(gi, name)(**given))
        for name in ("RigidMotions", "TangentSphere", "TangentStiefel")
    },
    "load_scene": lambda source: gi.load_scene(source).sections,
    "make_plan": lambda **given: [
        (c.what, c.value, c.reason) for c in gi.make_plan(**given).choices
    ],
}  # fmt: skip


def grouped(group: gi.Group) -> Any:
    return [group.name, group.algebra_rows, group.layout, group.work]


# They change no result, or what other folders look at; `out` is where a result goes.
NOWHERE = {"compiled", "progress", "callback", "out"}
ELSEWHERE = {
    "Method", "Reading", "Scene", "Space", "as_vector", "cite", "event", "field", "helper", "load",
    "check_file", "check_folder", "chaos_report", "draw_states", "drift_report", "observable",
    "open_ensemble", "run_methods", "run_scene", "scan_report", "section_report", "solve_ensemble",
    "whole_file", "whole_folder",
}  # fmt: skip


def asked() -> list[str]:
    """Return the functions and classes that are no mere records of what they are given."""
    found = {name: getattr(gi, name) for name in gi.__all__ if name not in ELSEWHERE}
    return [
        name
        for name, f in found.items()
        if callable(f) and not name.endswith(("Error", "Warning"))
        if name == "Event" or not dataclasses.is_dataclass(f)
    ]


@pytest.mark.parametrize("name", asked())
def test_every_argument_does_something(name: str) -> None:
    function = getattr(gi, name)
    arguments = {a: p for a, p in arguments_of(function).items() if a not in NOWHERE}
    look = LOOK.get(name, function)
    if any(p.kind is p.POSITIONAL_ONLY for p in inspect.signature(look).parameters.values()):
        look = lambda **given: function(*given.values())  # noqa: E731
    Tables(PAIRS, NEAR, BESIDE).check(name, look, arguments)


# --- problems and methods -------------------------------------------------------------------------

STATED: dict[str, Any] = {
    **WHOLE, "name": "whole", "time": "tau", "clock": rate, "constraints": {"flat": flat},
    "measure": gi.Measure(flat), "make_state": lambda x=1.0: np.array([x, 2.0]),
    "make_random": lambda rng: {"x": rng.normal()}, "make_exact": lambda y: ("exact", y.tolist()),
    "make_path": lambda t, states: gi.BodyPath(states), "admit": lambda y: y + 0.0,
    "physical": lambda y: {"y": y}, "parameters": {"a": 1.0}, "equations": ["ẏ = f(y)"],
    "units": {"y": "m"},
}  # fmt: skip
RESTATED: dict[str, Any] = {
    "name": "other", "pieces": (("z", 2),), "params": [2.5], "field": turning, "clock": sum_of,
    "action": gi.GroupAction(gi.field(lambda params, t, y, out, work: None), gi.so_n(2, "vector")),
    "hamiltonian": gi.Hamiltonian(bent, bent, 1), "splitting": gi.Splitting(bent, 2), "work": 3,
    "time": "t", "invariants": {"other": sum_of}, "constraints": {}, "observables": {"another": size},
    "measure": gi.Measure(sum_of), "symplectic_form": gi.SymplecticForm(),
    "make_state": lambda x: np.array([5.0, 6.0]), "make_random": lambda rng: {"x": rng.uniform()},
    "make_exact": lambda y: ("another", y.tolist()), "units": {"y": "N"},
    "make_path": lambda t, states: gi.BodyPath(-states), "admit": lambda y: 2.0 * y,
    "physical": lambda y: {"half": 0.5 * y}, "parameters": {"a": 2.0}, "equations": ["ẏ = g(y)"],
    "references": (gi.cite().references[0],), "space": gi.Sphere(2, "y"),
}  # fmt: skip


def stated(**given: Any) -> Any:
    """Return what a problem is, does and runs to, and how much room its functions are given."""
    problem, rows, field = gi.Problem(**given), np.full(1, 99.0), given["field"]

    def note(params, t, y, out, work):  # type: ignore[no-untyped-def]
        rows[0] = min(rows[0], len(work))
        field(params, t, y, out, work)

    y, end = problem.canonical([0.8, 0.6]), {f"{problem.time}_end": 1.0}
    noted = dataclasses.replace(problem, field=gi.field(note))
    solution = gi.solve(noted, y, **end, step=0.25, method="rk-4", compiled=False, observe="all")
    return seen([
        problem.name, problem.forms, problem.state(x=3.0), problem.random_state(1), rows,
        problem.exact(y), problem.physical_state(y), dict(problem.parameters), solution,
        problem.slices, problem.symplectic_form is None, problem.equations, problem.units,
        problem.make_path(np.zeros(1), y[None]).attitude, problem.references,
        [problem.unit(name) for name in ("size", "sum") if name in problem.diagnostics],
    ])  # fmt: skip


def test_every_argument_of_a_problem_does_something() -> None:
    assert set(RESTATED) == set(arguments_of(gi.Problem))
    whole = called(stated, STATED)
    assert repr(called(stated, STATED)) == repr(whole)
    changed = {a: called(stated, {**STATED, a: value}) for a, value in RESTATED.items()}
    changed["time"] = called(stated, {**STATED, "time": "t", "clock": None})
    assert [a for a, found in changed.items() if repr(found) == repr(whole)] == []
    assert {a for a, found in changed.items() if refused(found)} <= {
        "action",
        "hamiltonian",
        "splitting",
    }


def test_methods_of_a_method() -> None:
    gauss, action = gi.Gauss(2), gi.CommutatorFree("cf-2")
    assert gauss.with_options(max_iterations=7).options["max_iterations"] == 7
    gauss.check_fits(IN_T, False)
    with pytest.raises(gi.FormError, match="no clock"):
        gauss.check_fits(IN_T, True)
    with pytest.raises(gi.FormError, match="needs the form 'action'"):
        action.check_fits(IN_T, False)
    assert (gauss.structure(IN_T), gi.RungeKutta("rk-4").structure(IN_T)) == ("symmetric", "")
