"""Every argument of every public function of geomint does something."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import sys
from collections import namedtuple
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.cli import reports as in_python
from geomint.kernels.numbers.blocks import scalar_block
from geomint.plan import Plan
from geomint.report import drift_page
from geomint.run import solve as integrate
from tests.asked.asked_support import arguments_of, called, methods_of, seen

# Steps are as long as a test wants them.
# Quantities that are looked at as invariants are none of the motions here.
pytestmark = pytest.mark.filterwarnings(
    "ignore:steps of .* are so long:geomint.GeomintWarning", "ignore::geomint.DeclarationWarning"
)


@gi.field
def forced(params, t, y, out, work):
    out[0] = params[0] * y[1] + gi.cos(t)
    out[1] = -y[0]


@gi.field
def turning(params, t, y, out, work):
    out[0] = -y[1]
    out[1] = y[0]


@gi.field
def spiral(params, t, y, out, work):
    out[0] = -params[0] * y[1]
    out[1] = y[0]
    out[2] = y[0] * y[2]


@gi.observable
def turned(params, t, y, work):
    return y[0] * y[0] + 1.0


@gi.observable
def size(params, t, y, work):
    return y[0] * y[0] + y[1] * y[1] + t


@gi.observable
def scaled(params, t, y, work):
    return params[0] * y[0] + t


@gi.field
def bent(params, t, y, out, work):
    out[0] = (1.0 + t) * y[1] * y[1]
    out[1] = -y[0] * y[0]


@gi.observable
def bent_size(params, t, y, work):
    return (1.0 + t) * params[0] * y[0] * y[0] * y[1]


@gi.observable
def sum_of(params, t, y, work):
    return y[0] + y[1]


@gi.observable
def rate(params, t, y, work):
    return 1.0 + 0.3 * y[0]


@gi.field
def gradient(params, t, q, out, work):
    for i in range(len(q)):
        out[i] = (1.0 + i) * q[i]


@gi.field
def other_gradient(params, t, q, out, work):
    for i in range(len(q)):
        out[i] = (2.0 - i) * q[i]


@gi.observable
def flat(params, t, y, work):
    return 0.0 * y[0]


@gi.field
def around(params, t, y, out, work):
    out[0], out[1], out[2] = -y[1], y[0], 0.0 * y[2]


@gi.field
def upwards(params, t, y, out, work):
    out[0], out[1], out[2] = 0.0 * y[0], 0.0 * y[1], 1.0 + 0.0 * y[2]


SCENE = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    "time": {"t_end": 0.5},
    "integrate": {"method": "rk-4", "step": 0.125},
    "observe": {"quantities": ["energy"]},
}
ONE = gi.Scene(**SCENE)
TWO = ONE.changed(time={"t_end": 0.25})
IN_T = gi.Problem(
    "forced", (("y", 2),), [1.5], field=forced, invariants={"size": size}, measure=gi.Measure(flat)
)
IN_TAU = gi.Problem("turning", (("y", 2),), field=turning, time="tau", clock=rate)
AROUND = gi.Problem("around", (("x", 3),), field=around, action=gi.GroupAction(upwards, gi.so3(1)))
EVEN = gi.Problem("even", (("y", 2), ("z", 1)), [1.0], field=spiral)
BENT = gi.Problem("bent", (("y", 2),), [1.5], field=bent)


def bent_by(c: float) -> tuple[gi.Problem, list[float]]:
    return dataclasses.replace(BENT, params=[c]), [0.5, 0.2 * c]


BLOCK = scalar_block(4)
BLOCK.data[:] = [0.6, 0.8, -0.8, 0.6]
OTHER_BLOCK = scalar_block(4)
OTHER_BLOCK.data[:] = [0.8, 0.6, -0.6, 0.8]
LAYOUT = namedtuple("Two", "first second")(1, gi.REST)
OTHER_LAYOUT = namedtuple("Swapped", "second first")(1, gi.REST)
SIGNAL = np.exp(1j * np.arange(64) * 0.7) + 0.3 * np.exp(1j * np.arange(64) * 1.3)
RUN = {"problem": IN_T, "y0": [0.8, 0.6], "t_end": 1.0, "step": 0.25, "method": "rk-4"}
RUN |= {"compiled": False}
OBSERVED = {"observe": ["size", "measure"]}


def increment(h: float, y: Any, out: Any) -> Any:
    gi.great_circle(h, y, out)
    return out.data.copy()


def flow_of(splitting: gi.Splitting) -> Any:
    out = scalar_block(4)
    splitting.flow(0, BLOCK, 0.0, 0.1, BLOCK, out, scalar_block(4))
    return out.data.copy()


def group_of(group: gi.Group) -> Any:
    return [group.name, group.algebra_rows, group.layout, group.work]


# name: (arguments, another value of each), and what is looked at of the result.
CALLS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "as_vector": (
        {"name": "v", "value": [1.0], "rows": 2, "detail": " each"},
        {"name": "w", "value": [3.0], "rows": 1, "detail": " in all"},
    ),
    "cos": ({"x": 1.0}, {"x": 2.0}),
    "sin": ({"x": 1.0}, {"x": 2.0}),
    "log": ({"x": 1.0}, {"x": 2.0}),
    "exp": ({"x": 1.0}, {"x": 2.0}),
    "tan": ({"x": 1.0}, {"x": 2.0}),
    "tanh": ({"x": 1.0}, {"x": 2.0}),
    "pow": ({"x": 1.5, "y": 2.0}, {"x": 3.0, "y": 4.0}),
    "atan2": ({"y": 1.0, "x": 2.0}, {"y": 3.0, "x": 4.0}),
    "sqrt": ({"x": 1.0}, {"x": 2.0}),
    "top": ({"x": 1.0}, {"x": 2.0}),
    "fma": ({"x": 1.0, "y": 2.0, "z": 3.0}, {"x": 2.0, "y": 3.0, "z": 4.0}),
    "maximum": ({"x": 1.0, "y": 2.0}, {"x": 3.0, "y": 4.0}),
    "select": (
        {"condition": True, "x": 1.0, "y": 2.0},
        {"condition": False, "x": 3.0},
    ),
    "turn_coefficients": ({"s": 0.1}, {"s": 0.2}),
    "section": (
        {"block": BLOCK, "layout": LAYOUT, "name": "first"},
        {"block": OTHER_BLOCK, "layout": OTHER_LAYOUT, "name": "second"},
    ),
    "packed": (
        {"layout": LAYOUT, "values": {"first": 1.0, "second": 2.0}},
        {"layout": OTHER_LAYOUT, "values": {"first": 1.0, "second": 4.0}},
    ),
    "part": (
        {"block": BLOCK, "start": 0, "rows": 2},
        {"block": OTHER_BLOCK, "start": 1, "rows": 3},
    ),
    "derivative": (
        {"problem": IN_T, "y": [1.0, 2.0], "t": 0.0},
        {"problem": IN_TAU, "y": [1.0, 3.0], "t": 1.0},
    ),
    "derivative by a form": (
        {"problem": AROUND, "y": [1.0, 2.0, 3.0], "form": "field"},
        {"problem": EVEN, "y": [2.0, 2.0, 3.0], "form": "action"},
    ),
    "jacobian": (
        {"problem": BENT, "y": [1.0, 2.0], "t": 0.0, "by": "state"},
        {"problem": IN_T, "y": [2.0, 3.0], "t": 1.0, "by": "parameters"},
    ),
    "tangent_flow": (
        {
            "problem": BENT,
            "y0": [0.5, 0.6],
            "t_end": 0.5,
            "method": "rk-4",
            "step": 0.1,
            "t0": 0.0,
            "directions": [[1.0], [0.5]],
        },
        {
            "problem": IN_T,
            "y0": [0.4, 0.6],
            "t_end": 0.7,
            "method": "kutta-3",
            "step": 0.25,
            "t0": 0.2,
            "directions": [[0.3], [0.5]],
        },
    ),
    "gradient": (
        {"problem": BENT, "f": bent_size, "y": [1.0, 2.0], "t": 0.0, "by": "state"},
        {
            "problem": dataclasses.replace(BENT, params=[2.5]),
            "f": size,
            "y": [2.0, 3.0],
            "t": 1.0,
            "by": "parameters",
        },
    ),
    "value": (
        {"problem": IN_T, "f": scaled, "y": [1.0, 2.0], "t": 0.0},
        {"problem": dataclasses.replace(IN_T, params=[2.5]), "f": size, "y": [2.0, 3.0], "t": 1.0},
    ),
    "birkhoff_average": ({"values": SIGNAL.real}, {"values": SIGNAL.imag}),
    "rotation_number": (
        {"signal": SIGNAL, "step": 1.0},
        {"signal": SIGNAL.conj(), "step": 2.0},
    ),
    "frequencies": (
        {"signal": SIGNAL, "step": 1.0, "terms": 1, "order": 2},
        {"signal": SIGNAL.conj(), "step": 2.0, "terms": 2, "order": 3},
    ),
    "find_method": ({"name": "rk-4"}, {"name": "gauss-4"}),
    "load_scene": ({"source": ONE}, {"source": TWO}),
    "make_plan": (
        {"scene": ONE, "purpose": "run", "costs": False},
        {"scene": TWO, "purpose": "drift", "costs": True},
    ),
    "natural_in_space": ({"acceleration": gradient}, {"acceleration": other_gradient}),
    "natural_on_sphere": ({"gradient": gradient}, {"gradient": other_gradient}),
    "so3": ({"vectors": 1}, {"vectors": 2}),
    "so_n": ({"n": 4, "pieces": ("vector",)}, {"n": 5, "pieces": ("vector", "frame")}),
    "translations": ({"m": 1}, {"m": 2}),
    "Product": ({"factors": [gi.Sphere(2)]}, {"factors": [gi.Sphere(2), gi.Skew(2)]}),
    **{
        name: ({"n": 3, "names": ("a", "b")}, {"n": 4, "names": ("a", "c")})
        for name in ("RigidMotions", "TangentSphere")
    },
    "TangentStiefel": (
        {"n": 3, "r": 2, "names": ("a", "b")},
        {"n": 4, "r": 1, "names": ("a", "c")},
    ),
    "time_transformed": (
        {"problem": EVEN, "clock": "speed", "y0": [0.6, 0.8, 1.0]},
        {
            "problem": dataclasses.replace(EVEN, params=[2.0]),
            "clock": turned,
            "y0": [1.0, 2.0, 3.0],
        },
    ),
    "with_quadrature": (
        {"problem": IN_TAU, "name": "s", "rate": size},
        {"problem": IN_T, "name": "u", "rate": sum_of},
    ),
    "great_circle": (
        {"h": 0.1, "y": BLOCK, "out": scalar_block(4)},
        {"h": 0.2, "y": OTHER_BLOCK},
    ),
    "solve": (
        RUN,
        {
            "problem": dataclasses.replace(IN_T, params=[2.5]),
            "y0": [0.6, 0.8],
            "t_end": 2.0,
            "method": "kutta-3",
            "step": 0.125,
            "t_eval": [0.5, 1.0],
            "dense": True,
            "events": "y[1]",
            "save_every": 2,
            "observe": "size",
            "t0": 0.25,
            "estimate_error": True,
            "breaks": [0.7],
        },
    ),
    "solve in variable steps": (
        {**RUN, "method": "dormand-prince-5-adaptive", "step": 0.01},
        {"longest": 0.05},
    ),
    "solve in tau": (
        {**RUN, "problem": IN_TAU, "t_end": None, "tau_end": 1.0},
        {"tau_end": 2.0, "clock": False, "tau_eval": [0.5]},
    ),
    "solve to a tolerance": (
        {**RUN, "step": None, "tolerance": 1e-3},
        {"tolerance": 1e-4},
    ),
    "sensitivities": (
        {
            "problem": BENT,
            "y0": [0.5, 0.6],
            "t_end": 0.5,
            "method": "rk-4",
            "step": 0.1,
            "t0": 0.0,
            "observe": [size],
        },
        {
            "problem": IN_T,
            "y0": [0.4, 0.6],
            "t_end": 0.7,
            "method": "kutta-3",
            "step": 0.25,
            "t0": 0.25,
            "observe": [sum_of],
        },
    ),
    "sensitivities of a family": (
        {"problem": bent_by, "parameters": {"c": 1.5}, "t_end": 0.5, "step": 0.1, "method": "rk-4"},
        {"parameters": {"c": 2.5}},
    ),
    "sensitivities in tau": (
        {
            "problem": IN_TAU,
            "y0": [0.5, 0.6],
            "t_end": None,
            "tau_end": 1.0,
            "step": 0.25,
            "method": "rk-4",
        },
        {"tau_end": 2.0},
    ),
    "lyapunov": (
        {
            "problem": BENT,
            "y0": [0.5, 0.6],
            "t_end": 0.5,
            "method": "rk-4",
            "step": 0.1,
            "t0": 0.0,
            "count": 1,
        },
        {
            "problem": IN_T,
            "y0": [0.4, 0.6],
            "t_end": 0.7,
            "method": "kutta-3",
            "step": 0.25,
            "t0": 0.25,
            "count": 2,
        },
    ),
    "lyapunov along directions": (
        {
            "problem": BENT,
            "y0": [0.5, 0.6],
            "t_end": 0.5,
            "step": 0.1,
            "method": "rk-4",
            "directions": [[1.0], [0.5]],
        },
        {"directions": [[0.3], [0.5]]},
    ),
    "lyapunov in tau": (
        {
            "problem": IN_TAU,
            "y0": [0.5, 0.6],
            "t_end": None,
            "tau_end": 1.0,
            "step": 0.25,
            "method": "rk-4",
        },
        {"tau_end": 2.0},
    ),
    "tangent_flow by parameters": (
        {
            "problem": IN_T,
            "y0": [0.5, 0.6],
            "t_end": 1.0,
            "step": 0.25,
            "parameters": [[1.0]],
            "method": "rk-4",
        },
        {"parameters": [[2.0]]},
    ),
    "tangent_flow in tau": (
        {
            "problem": IN_TAU,
            "y0": [0.5, 0.6],
            "t_end": None,
            "tau_end": 1.0,
            "step": 0.25,
            "method": "rk-4",
        },
        {"tau_end": 2.0},
    ),
    "solve with observers": (
        {**RUN, **OBSERVED},
        {"observe_every": 3, "observe": {"size": {}, "measure": {"steps": 2}}},
    ),
}
CALLS["poincare_section"] = (
    {
        "problem": IN_TAU,
        "states": [1.0, 0.0],
        "event": "y[0]",
        "points": 3,
        "step": 0.25,
        "method": "rk-4",
    },
    {
        "problem": dataclasses.replace(IN_TAU, params=[2.5]),
        "states": [[0.6, 0.8]],
        "event": "y[1]",
        "points": 2,
        "method": "kutta-3",
        "step": 0.125,
        "end": 3.0,
        "clock": True,
    },
)
CALLS["Event"] = (
    {"what": "y[0]"},
    {"what": "y[1]", "direction": "up", "terminal": 2, "level": 0.5},
)
CALLS["Integrator"] = (
    {"problem": IN_TAU, "state": [1.0, 0.0], "step": 0.25, "method": "rk-4"},
    {
        "problem": dataclasses.replace(IN_T, params=[2.5]),
        "state": [0.6, 0.8],
        "method": "kutta-3",
        "step": 0.125,
        "time": 1.0,
        "clock": True,
        "compiled": False,
    },
)
CALLS["Integrator with directions"] = (
    {"problem": IN_TAU, "state": [1.0, 0.0], "step": 0.25, "method": "rk-4", "tangents": 1},
    {"tangents": 2},
)


def stepped(**given: Any) -> Any:
    motion = gi.Integrator(**given)
    motion.step(2)
    carried = motion.tangents if given.get("tangents") else None
    return [motion.restart, motion.stepper.compiled, carried]


LOOK: dict[str, Callable[..., Any]] = {
    "derivative by a form": gi.derivative,
    "Integrator": stepped,
    "Integrator with directions": stepped,
    "natural_in_space": lambda **given: flow_of(gi.natural_in_space(**given)),
    "natural_on_sphere": lambda **given: flow_of(gi.natural_on_sphere(**given)),
    "great_circle": increment,
    "so3": lambda vectors: group_of(gi.so3(vectors)),
    "so_n": lambda n, pieces: group_of(gi.so_n(n, *pieces)),
    "translations": lambda m: group_of(gi.translations(m)),
    "Product": lambda factors: repr(gi.Product(*factors)),
    **{
        name: lambda name=name, **given: repr(getattr(gi, name)(**given))
        for name in ("RigidMotions", "TangentSphere", "TangentStiefel")
    },
    "part": lambda **given: gi.part(**given).data,
    "section": lambda **given: gi.section(**given).data,
    "packed": lambda layout, values: gi.packed(layout, **values).data,
    "load_scene": lambda source: gi.load_scene(source).sections,
    "make_plan": lambda **given: [
        (c.what, c.value, c.reason) for c in gi.make_plan(**given).choices
    ],
    "solve in tau": gi.solve,
    "solve in variable steps": gi.solve,
    "solve to a tolerance": gi.solve,
    "tangent_flow in tau": gi.tangent_flow,
    "tangent_flow by parameters": gi.tangent_flow,
    "sensitivities of a family": gi.sensitivities,
    "sensitivities in tau": gi.sensitivities,
    "lyapunov along directions": gi.lyapunov,
    "lyapunov in tau": gi.lyapunov,
    "solve with observers": gi.solve,
}
# What the tests below this table are about, and those of other files.
BELOW = {
    "great_circle": {"out"},
    "select": {"y"},
    "solve": {"progress", "compiled", "callback"},  # callback: tests/methods/test_callback.py
    "lyapunov": {"progress"},
    "drift_report": {"scene", "out", "progress", "methods", "paper"},  # paper: tests/report
    "chaos_report": {
        "scene",
        "out",
        "count",
        "progress",
        "paper",
    },  # tests/report/test_chaos_page.py
    "scan_report": {"scene", "out", "progress", "paper", "keys"},  # tests/report/test_scan_page.py
    "section_report": {
        "scene",
        "out",
        "progress",
        "paper",
        "keys",
    },  # tests/report/test_section_page.py
    "run_scene": {"scene", "progress"},
    "run_methods": {"scene", "methods", "progress", "report"},
    "pointwise": {"function", "params", "points", "rows", "work", "check"},
    "load": {"method", "path", "problem", "trust"},  # tested in tests/outputs/test_saved_runs.py
    # Tested in tests/outputs.
    **{name: {"path"} for name in ("check_file", "whole_file")},
    **{name: {"path", "names"} for name in ("check_folder", "whole_folder")},
    **{name: {"function"} for name in ("field", "helper", "observable")},
    "poincare_section": {"progress"},
    "event": {"function", "options"},  # tested in tests/methods/test_events.py
    "cite": {"what"},  # tested in tests/report/test_cite.py
}
FAMILIES = (
    "Adaptive", "CommutatorFree", "Compose", "Gauss", "Lobatto", "RKMK", "Rattle", "RungeKutta",
    "Verlet",
)  # fmt: skip
READINGS = ("Exponents", "Histogram", "Reading", "SectionPoints", "Windows")
# All but the families: tests/ensemble.
ELSEWHERE = {
    *FAMILIES,
    *READINGS,
    "Method",
    "Ensemble",
    "EnsembleGrowth",
    "draw_states",
    "open_ensemble",
    "solve_ensemble",
}
OF_METHODS = {
    "check_fits", "default_step", "start", "start_adaptive", "structure", "with_options",
}  # fmt: skip
METHODS_BELOW = {  # methods of classes
    "Problem": {"canonical", "exact", "physical_state", "random_state", "state", "unit"},
    **dict.fromkeys((*FAMILIES, "Method", "Exact"), OF_METHODS),
    "Scene": {
        "changed", "changed_integration", "changed_observation", "from_content", "hash_of", "place",
    },
    "Drift": {"stretched"},
    "Reference": {"at"},  # tested in tests/report/test_cite.py, as the next
    "Citation": {"keys"},
    "Ensemble": {"growth", "piece", "single"},  # tested in tests/ensemble
    **{name: {"check", "read"} for name in READINGS},
    "Event": {"function", "row"},
    "Section": {"coordinates", "plot", "save", "values"},  # tested in tests/methods/test_section.py
    "Lyapunov": {"save"},  # tested in tests/methods/test_lyapunov.py
    # Tested in tests/pictures as well.
    "Solution": {
        "piece", "save", "words", "plot", "plot_phase", "plot_sphere", "plot_trace", "animate",
        "code",  # tested in tests/outputs/test_saved_runs.py
    },
    "View": {"draw_curve"},
    # Tested in tests/methods/test_integrator.py; the last ones by all runs.
    "Integrator": {
        "propagate_for", "propagate_until", "reset", "step",
        "failure", "of", "take",
    },
    # Tested in tests/watch; those of one's own by check_watcher.
    "Watcher": methods_of(gi.Watcher),
    # Tested in tests/spaces, by geomint.testing.
    **{
        name: methods_of(kind) for name, kind in {n: getattr(gi, n) for n in gi.__all__}.items()
        if inspect.isclass(kind) and issubclass(kind, gi.Space)
    },
}  # fmt: skip


def public(module: Any) -> dict[str, Any]:
    return {
        name: getattr(module, name)
        for name in module.__all__
        if callable(getattr(module, name)) and not name.endswith(("Error", "Warning"))
    }


RECORDS = {
    name: f
    for name, f in public(gi).items()
    if dataclasses.is_dataclass(f) and not issubclass(f, gi.Method)
}


def test_every_argument_is_in_a_table() -> None:
    for name, function in public(gi).items():
        if name in RECORDS or name in ELSEWHERE or name == "Scene":
            continue
        entries = [CALLS[key] for key in CALLS if key == name or key.startswith(f"{name} ")]
        known = {argument for _, others in entries for argument in others}
        assert known | BELOW.get(name, set()) == arguments_of(function), name
    for name, function in public(gi).items():
        if inspect.isclass(function):
            assert methods_of(function) == METHODS_BELOW.get(name, set()), name


@pytest.mark.parametrize(
    ("name", "argument"), [(name, a) for name, (_, others) in CALLS.items() for a in others]
)
def test_an_argument_does_something(name: str, argument: str) -> None:
    given, others = CALLS[name]
    look = LOOK.get(name) or getattr(gi, name)
    one, other = (called(look, {**given, **more}) for more in ({}, {argument: others[argument]}))
    assert one != other


# --- functions that are better asked in words -----------------------------------------------------


def test_select_takes_the_other_value() -> None:
    assert gi.select(False, 1.0, 2.0) == 2.0


@pytest.mark.parametrize("record", [gi.field, gi.helper, gi.observable])
def test_recorders_record_what_they_are_given(record) -> None:
    def two():
        return 2

    assert record(two).function is two


def test_solve_shows_progress_and_compiles_if_told_to(monkeypatch: pytest.MonkeyPatch) -> None:
    shown, started = [], []

    class Told(integrate.Progress):
        def __init__(self, show: Any, *args: Any) -> None:
            shown.append(show)
            super().__init__(False, *args)

    def start(*args: Any, **kwargs: Any) -> Any:
        started.append(kwargs["compiled"])
        return original(*args, **{**kwargs, "compiled": False})

    original = integrate.Start
    monkeypatch.setattr(integrate, "Progress", Told)
    monkeypatch.setattr(integrate, "Start", start)
    for progress in (True, False, None):
        for compiled in (True, False):
            gi.solve(**{**RUN, "compiled": compiled}, progress=progress)
    assert shown == [True, True, False, False, None, None]
    assert started == 3 * [True, False]


def test_runs_of_scenes_pass_on_what_they_get(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[Any] = []

    def planned(plan: Plan, progress: Any = None) -> Any:
        asked.append((plan.scene.content.time.t_end, plan.scene.method.name, progress))
        raise gi.StepLimitError(0.0, 0, 0.0, 0)

    monkeypatch.setattr(Plan, "solve", planned)

    def ask(function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        asked.clear()
        with contextlib.suppress(gi.StepLimitError):
            function(*args, **kwargs)
        return list(asked)

    for scene, progress in ((ONE, True), (TWO, False)):
        end = scene.content.time.t_end
        assert ask(gi.run_scene, scene, progress) == [(end, "rk-4", progress)]
        assert ask(gi.drift_report, scene, tmp_path, progress) == [(end, "rk-4", progress)]
    told: list[Any] = []

    def several(scene: gi.Scene, methods: Any, progress: Any) -> Any:
        told.append((scene.content.time.t_end, list(methods), progress))
        return []

    monkeypatch.setattr(in_python, "run_methods", several)
    monkeypatch.setattr(in_python, "common_notes", lambda plans: [])
    monkeypatch.setattr(drift_page, "write_drift_report", lambda *args: told.append(args))
    gi.drift_report(ONE, tmp_path / "a", True, methods=["rk-4"])
    gi.drift_report(TWO, tmp_path / "b", False, methods=["cf-4"], paper=True)
    assert told == [
        (0.5, ["rk-4"], True), ([], tmp_path / "a", None, False),
        (0.25, ["cf-4"], False), ([], tmp_path / "b", None, True),
    ]  # fmt: skip


def test_run_methods_tells_of_every_run(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[Any] = []
    monkeypatch.setattr(Plan, "solve", lambda plan, progress: called_with(told, plan, progress))

    def called_with(told: list[Any], plan: Plan, progress: Any) -> gi.Solution:
        told.append((plan.scene.content.time.t_end, plan.scene.method.name, progress))
        return gi.solve(**RUN)

    for scene, progress in ((ONE, False), (TWO, True)):
        told.clear()
        heard: list[Any] = []
        runs = gi.run_methods(scene, ["rk-4", "kutta-3"], progress, heard.append)
        end = scene.content.time.t_end
        assert told == [(end, "rk-4", progress), (end, "kutta-3", progress)]
        assert heard == list(runs)
        assert [run.label for run in runs] == ["rk-4", "kutta-3"]


def test_pointwise(monkeypatch: pytest.MonkeyPatch) -> None:
    scratch: list[int] = []

    def block(rows: int) -> Any:
        scratch.append(rows)
        return scalar_block(rows)

    monkeypatch.setattr(sys.modules["geomint.problems.pointwise"], "scalar_block", block)
    points = np.array([[1.0, 2.0], [3.0, 4.0]])
    base = gi.pointwise(turning, [1.0], points, 2)
    np.testing.assert_array_equal(base, [[-2.0, 1.0], [-4.0, 3.0]])
    assert not np.array_equal(base, gi.pointwise(forced, [1.0], points, 2))
    assert not np.array_equal(
        gi.pointwise(forced, [1.0], points, 2), gi.pointwise(forced, [2.0], points, 2)
    )
    assert not np.array_equal(base, gi.pointwise(turning, [1.0], points[::-1], 2))
    with pytest.raises(gi.DeclarationError, match="never writes row 2 of out, which has 3"):
        gi.pointwise(turning, [1.0], points, 3)
    checked: list[int] = []
    monkeypatch.setattr(
        sys.modules["geomint.problems.pointwise"],
        "_check",
        lambda *given: checked.append(given[-1]),
    )
    gi.pointwise(turning, [1.0], points, 2, work=9, check=False)
    assert checked == []
    gi.pointwise(turning, [1.0], points, 2, work=7)
    assert checked == [7]
    assert scratch[-1] == 7
    assert scratch[0] == 0


def test_what_is_saved_is_loaded_from_there(tmp_path: Path) -> None:
    solution = gi.solve(**{**RUN, "save_every": 1})
    for name, end in (("one", 1.0), ("two", 0.5)):
        gi.solve(**{**RUN, "t_end": end, "save_every": 1}).save(tmp_path / f"{name}.nc")
        saved = gi.load(tmp_path / f"{name}.nc")
        assert saved.tau[-1] == end
        assert saved.piece("y").shape == (len(saved.tau), 2)
        with pytest.raises(gi.DomainError, match="'z'"):
            saved.piece("z")
    with pytest.raises(gi.DomainError, match="'z'"):
        solution.piece("z")


# --- records and their methods --------------------------------------------------------------------


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_keeps_what_it_is_given(name: str) -> None:
    """Every argument is an attribute of its name."""
    assert arguments_of(RECORDS[name]) <= {f.name for f in dataclasses.fields(RECORDS[name])}


def test_methods_of_a_scene() -> None:
    pairs = [
        (ONE.changed(name="one"), ONE.changed(name="two"), "name"),
        (ONE.changed(time={"t_end": 1.0}), ONE.changed(time={"t_end": 2.0}), "sections"),
        (ONE.changed_integration("rk-4"), ONE.changed_integration("cf-4"), "sections"),
        (ONE.changed_integration(step=0.1), ONE.changed_integration(step=0.2), "sections"),
        (
            ONE.changed_integration(representation="own"),
            ONE.changed_integration(representation="ball"),
            "sections",
        ),
        (ONE.changed_observation(["K"]), ONE.changed_observation(["energy"]), "sections"),
        (ONE.changed_observation(every=2), ONE.changed_observation(every=3), "sections"),
        (gi.Scene("one", **SCENE), gi.Scene("two", **SCENE), "name"),
        (gi.Scene(**SCENE), TWO, "sections"),
        (gi.Scene.from_content("one", SCENE), gi.Scene.from_content("two", SCENE), "name"),
    ]
    for one, other, attribute in pairs:
        assert getattr(one, attribute) != getattr(other, attribute)
    assert gi.Scene.from_content("s", TWO.sections).sections != ONE.sections
    assert gi.Scene.from_content("s", SCENE, "text").toml() == "text"
    assert ONE.hash_of("time") != ONE.hash_of("system")
    assert ONE.hash_of("time") != TWO.hash_of("time")


def test_methods_of_a_method() -> None:
    gauss, action = gi.Gauss(2), gi.CommutatorFree("cf-2")
    assert gauss.with_options(max_iterations=7).options["max_iterations"] == 7
    gauss.check_fits(IN_T, False)
    with pytest.raises(gi.FormError, match="no clock"):
        gauss.check_fits(IN_T, True)
    with pytest.raises(gi.FormError, match="needs the form 'action'"):
        action.check_fits(IN_T, False)
    assert (gauss.structure(IN_T), gi.RungeKutta("rk-4").structure(IN_T)) == ("symmetric", "")


# --- problems -------------------------------------------------------------------------------------


def make_state(**components: Any) -> Any:
    return np.array([components.get("x", 1.0), 2.0])


WHOLE: dict[str, Any] = {
    "name": "whole",
    "pieces": (("y", 2),),
    "params": [1.5],
    "field": forced,
    "work": 0,
    "time": "tau",
    "clock": rate,
    "invariants": {"size": size},
    "constraints": {"flat": flat},
    "observables": {"sum": sum_of},
    "measure": gi.Measure(flat),
    "make_state": make_state,
    "make_random": lambda rng: {"x": rng.normal()},
    "make_exact": lambda y: ("exact", y.tolist()),
    "make_path": lambda t, states: gi.BodyPath(states),
    "admit": lambda y: y + 0.0,
    "physical": lambda y: {"y": y},
    "parameters": {"a": 1.0},
    "equations": ["ẏ = f(y)"],
    "units": {"y": "m"},
    "references": (),
}
PULSATING = gi.GroupAction(gi.field(lambda params, t, y, out, work: None), gi.so_n(2, "vector"))
OTHERS: dict[str, Any] = {
    "name": "other",
    "pieces": (("z", 2),),
    "params": [2.5],
    "field": turning,
    "action": PULSATING,
    "hamiltonian": gi.Hamiltonian(forced, forced, 1),
    "splitting": gi.Splitting(forced, 2),
    "work": 3,
    "time": "t",
    "clock": sum_of,
    "invariants": {"sum": sum_of},
    "constraints": {},
    "observables": {"size": size},
    "measure": gi.Measure(sum_of),
    "symplectic_form": gi.SymplecticForm(),
    "make_state": lambda **components: np.array([5.0, 6.0]),
    "make_random": lambda rng: {"x": rng.uniform()},
    "make_exact": lambda y: ("another", y.tolist()),
    "make_path": lambda t, states: gi.BodyPath(-states),
    "admit": lambda y: 2.0 * y,
    "physical": lambda y: {"half": 0.5 * y},
    "parameters": {"a": 2.0},
    "equations": ["ẏ = g(y)"],
    "units": {"y": "N"},
    "references": (gi.cite().references[0],),
    "space": gi.Sphere(2, "y"),
}


def of_problem(**given: Any) -> Any:
    problem = gi.Problem(**given)
    y = problem.canonical([0.8, 0.6])
    end = {"t_end": 1.0} if problem.time == "t" else {"tau_end": 1.0}
    rows, field = np.full(1, 99.0), given["field"]

    def note(params, t, y, out, work):  # type: ignore[no-untyped-def]
        rows[0] = min(rows[0], len(work))
        field(params, t, y, out, work)

    noted = dataclasses.replace(problem, field=gi.field(note))
    solution = gi.solve(noted, y, **end, step=0.25, method="rk-4", compiled=False, observe="all")
    return [
        problem.name, problem.forms, problem.state(x=3.0), problem.random_state(1),
        problem.exact(y), problem.physical_state(y), dict(problem.parameters), rows[0],
        solution, problem.slices, problem.symplectic_form is None, problem.equations, problem.units,
        problem.make_path(np.zeros(1), y[None]).attitude,
        problem.references,
    ]  # fmt: skip


def test_every_argument_of_a_problem_is_in_the_table() -> None:
    assert set(OTHERS) == arguments_of(gi.Problem)


@pytest.mark.parametrize("argument", OTHERS)
def test_an_argument_of_a_problem_does_something(argument: str) -> None:
    more = {argument: OTHERS[argument]} | ({"clock": None} if argument == "time" else {})
    assert called(of_problem, WHOLE) != called(of_problem, {**WHOLE, **more})


def test_methods_of_a_problem() -> None:
    problem = gi.Problem(**WHOLE)
    for method, one, other in (
        (problem.canonical, [1.0, 2.0], [2.0, 1.0]),
        (problem.exact, [1.0, 2.0], [2.0, 1.0]),
        (problem.physical_state, np.ones(2), np.zeros(2)),
        (problem.random_state, 1, 2),
        (problem.unit, "y[0]", "size"),
    ):
        assert seen(method(one)) != seen(method(other))
    assert problem.state(x=1.0)[0] != problem.state(x=2.0)[0]
    plain = gi.Problem("plain", (("a", 1), ("b", 1)), field=turning)
    with pytest.raises(gi.DomainError, match="c = 1"):
        plain.state(a=1.0, b=2.0, c=1.0)
