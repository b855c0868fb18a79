"""Calls of public functions with some arguments changed: what is called, and with what it works."""

from __future__ import annotations

import contextlib
import dataclasses
import tempfile
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np

import chaplygin as ch
import geomint as gi
from tests.fuzz import hostile
from tests.fuzz.judge import Judged, alarm, judged, only_finite
from tests.fuzz.scenes import mutated_content
from tests.problems import examples

__all__ = ["call_verdict", "calls"]


class Call(NamedTuple):
    """A function and arguments that it takes."""

    function: Callable[..., Any]
    given: Mapping[str, Any]


def _tried(method: gi.Method) -> Any:
    """Return two steps with a method: what it says of itself is one thing, its kernel another."""
    form = {"field": 1, "action": 5, "hamiltonian": 2, "splitting": 8}[method.needs]
    problem, y0 = examples()[form]
    options = {"step": 0.01, "t_end": 0.02, "compiled": False}
    return gi.solve(problem, y0, method=method, **options)


def _maker(make: Callable[..., gi.Method]) -> Callable[..., Any]:
    return lambda **given: _tried(make(**given))


def _solved(problem: gi.Problem, y0: Any) -> Callable[..., Any]:
    def solved(y0: Any = y0, **given: Any) -> Any:
        return gi.solve(problem, y0, **given)

    return solved


def _fields_of(x: Any) -> dict[str, Any]:
    return {f.name: getattr(x, f.name) for f in dataclasses.fields(x)}


def _problem(**given: Any) -> Any:
    """Return what a run of a changed problem gives, as far as its state still fits."""
    problem = gi.Problem(**given)
    if problem.rows >= 1000:
        return problem
    y0 = np.linspace(0.3, 0.4, problem.rows)
    observe = "all" if problem.diagnostics else ()
    form = {"field": "rk-4", "action": "cf-4", "hamiltonian": "rattle-2", "splitting": "verlet-2"}
    ends = {"tau_end": 0.01, "clock": False} if problem.time == "tau" else {"t_end": 0.01}
    given = {"method": form[problem.forms[0]], "step": 0.01, "observe": observe, **ends}
    solution = gi.solve(problem, y0, compiled=False, **given)
    with tempfile.TemporaryDirectory() as folder:
        solution.save(Path(folder) / "run.nc")
        return gi.load(Path(folder) / "run.nc", problem)


def _solves() -> dict[str, Call]:
    sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
    flow = sphere.hamiltonized()
    state = flow.state(gamma=[0.6, 0.0, 0.8], p=[0.8, 1.0, -0.6])
    common = {
        **{"step": 0.01, "save_every": 1, "observe": ["all"], "observe_every": 1},
        **{"progress": False, "compiled": False, "t_eval": None},
        **{"t_end": None, "tau_end": None, "clock": None},
    }
    field, group, bound = (examples()[i] for i in (1, 5, 2))
    starts = {
        "field": (*field, {"t_end": 0.03, "method": "gauss-2", "t_eval": [0.01, 0.02]}),
        "explicit": (*field, {"t_end": 0.03, "method": "dop853-adaptive"}),
        "group": (*group, {"t_end": 0.03, "method": "cf-4"}),
        "bound": (*bound, {"t_end": 0.03, "method": "rattle-2"}),
        "tau": (flow, state, {"tau_end": 0.03, "method": "verlet-2", "observe": ["energy"]}),
        "compiled": (*field, {"t_end": 0.03, "method": "gauss-2", "compiled": True}),
    }
    return {
        f"solve {name}": Call(_solved(problem, y0), {**common, "y0": y0, **given})
        for name, (problem, y0, given) in starts.items()
    }


def _made(**given: Any) -> Any:
    return gi.make_plan(gi.Scene(**given), costs=True).solve(progress=False)


def _exact(sphere: ch.ChaplyginSphere, y: Any) -> dict[str, Call]:
    """Return what is known of the motion through y without steps, and around it."""
    problem = sphere.hamiltonized()
    flow, chart = problem.exact(y), ch.Spheroconical([0.8, 1.1, 1.5])
    a, D = [0.8, 1.1, 1.5], 4.0
    gamma, p = np.array([0.6, 0.48, 0.64]), [0.4, 0.1, -0.45]
    return {
        "at_tau": Call(flow.at_tau, {"tau": [0.5, 2.0]}),
        "at_angles": Call(flow.at_angles, {"phi": [0.5, 2.0]}),
        "exact time": Call(flow.time, {"tau": [0.5, 2.0]}),
        "exact tau": Call(flow.tau, {"t": [0.5, 2.0]}), "angles": Call(flow.angles, {"y": y}),
        "resonances": Call(ch.resonances, {"omega": [1.0, 2.0], "order": 4, "tolerance": 1e-9}),
        "critical_energies": Call(ch.critical_energies, {"a": a, "D": D, "K": 1.0}),
        "discriminant": Call(ch.discriminant, {"a": a, "D": D, "K": 1.0, "H": 0.3}),
        "frequency_map": Call(lambda states: ch.frequency_map(problem, states).refused,
            {"states": [y, y]}),
        "chart": Call(ch.Spheroconical, {"a": a}),
        "chart coordinates": Call(chart.coordinates, {"gamma": gamma}),
        "chart point": Call(chart.point, {"gamma": gamma, "p_tilde": p}),
        "chart gamma": Call(chart.gamma, {"gaps": chart.coordinates(gamma)[1], "signs": [1, 1, 1]}),
        "gauss_map": Call(ch.gauss_map, {"a": a, "D": D}),
        "attitude": Call(ch.attitude, {"k": np.cross(gamma, p), "gamma": gamma,
            "g0": np.eye(3).tolist()}),
    }  # fmt: skip


def _bodies() -> dict[str, Call]:
    """Return the constructors of systems, each followed by a problem and a state of it."""
    g, p, triangle = [0.6, 0.0, 0.8], [0.8, 1.0, -0.6], [0.5, 0.2, -0.3]
    a, D = [0.8, 1.1, 1.5], 4.0
    tensor = [[2.0, 0.1, 0.0], [0.1, 2.2, 0.2], [0.0, 0.2, 2.5]]

    def ball(sphere: ch.ChaplyginSphere, **state: Any) -> Any:
        return sphere.ball().state(**state)

    def of(make: Callable[..., Any], then: Callable[..., Any]) -> Callable[..., Any]:
        return lambda **given: then(make(**given))

    def reduced(body: Any) -> Any:
        y = body.reduced().state(gamma=np.eye(body.n)[0], p=np.eye(body.n)[1])
        return bool(len(gi.derivative(body.reduced(), y))) and y

    sphere = ch.ChaplyginSphere(a=a, D=D)
    body, neumann = ch.Veselova(a, D), ch.neumann_problem(a)
    k = {"gamma": g, "k": triangle}
    return {
        "sphere": Call(of(ch.ChaplyginSphere, reduced), {"a": a, "D": D, "inertia": None}),
        "sphere moments": Call(of(ch.ChaplyginSphere.from_moments, reduced), {"moments": a, "m": 2.0,
            "rho": 0.5}),
        "sphere tensor": Call(of(ch.ChaplyginSphere.from_moments, reduced), {"moments": tensor,
            "m": 2.0, "rho": 0.5}),
        "sphere J": Call(of(ch.ChaplyginSphere.from_tensor, reduced), {"J": tensor, "m": 2.0,
            "rho": 0.5}),
        "homogeneous": Call(of(ch.ChaplyginSphere.homogeneous, reduced), {"n": 4, "s": 1.0, "D": D}),
        "special": Call(ch.SpecialInertia, {"a": a, "D": D}),
        "special moments": Call(ch.SpecialInertia.from_moments, {"moments": a, "D": D}),
        "general": Call(ch.GeneralInertia, {"values": tensor}),
        "mass tensor": Call(ch.GeneralInertia.from_mass_tensor, {"J": a}),
        "tensor": Call(ch.GeneralInertia.from_tensor, {"tensor": tensor}),
        "veselova": Call(of(ch.Veselova, reduced), {"a": a, "D": D}),
        "veselova moments": Call(of(ch.Veselova.from_moments, reduced), {"moments": a, "D": D}),
        "lr": Call(of(ch.VeselovaLR, lambda b: b.lr().state(w=[0.1, 0.2, 0.0])), {"inertia": a,
            "r": 1}),
        "lr a": Call(of(ch.VeselovaLR.from_a, lambda b: b.stiefel()), {"a": [*a, 2.0], "r": 2}),
        "rubber": Call(of(ch.RubberSphere, lambda b: b.reduced()), {"inertia": tensor, "D": D}),
        "rubber a": Call(of(ch.RubberSphere.from_a, lambda b: b.reduced()), {"a": [0.2, 0.3, 0.4],
            "D": 1.0}),
        "neumann": Call(ch.neumann_problem, {"a": a, "strength": 1.0}),
        "clebsch": Call(ch.clebsch_problem, {"a": a, "strength": 1.0, "x": 1.0, "y": 0.5}),
        "ellipsoid": Call(ch.ellipsoid_problem, {"a": a}),
        "rolling": Call(sphere.rolling, {"m": 1.0, "rho": 2.0, "k0": triangle}),
        "contact": Call(sphere.contact, {"m": 1.0, "rho": None, "k0": triangle}),
        "classical": Call(sphere.classical, {"attitude": True, "k0": p}),
        "ball": Call(sphere.ball, {"attitude": True, "k0": triangle}),
        "veselova classical": Call(body.classical, {"f1": 0.3}),
        "state p": Call(sphere.reduced().state, {"gamma": g, "p": p}),
        "state p_tilde": Call(flow_state := sphere.hamiltonized().state, {"gamma": g, "p_tilde": p}),
        "state omega": Call(flow_state, {"gamma": g, "omega": None, "p": p, "k": None}),
        "state k": Call(lambda **s: ball(sphere, **s), k),
        "state q": Call(neumann.state, {"q": g, "v": [0.0, 1.0, 0.0]}),
        "exact": Call(lambda y0, t: np.asarray(sphere.hamiltonized().exact(y0).at_tau(t)),
            {"y0": flow_state(gamma=g, p=p), "t": 1.0}),
        **_exact(sphere, flow_state(gamma=g, p=p)),
        "random": Call(sphere.ball().random_state, {"rng": 3}),
        "canonical": Call(sphere.ball().canonical, {"y": np.array([0.5, 0.2, -0.3, *g])}),
        "converted": Call(lambda y: ch.converted(y, sphere.reduced(), sphere.hamiltonized()),
            {"y": np.array([*g, *p])}),
    }  # fmt: skip


@cache
def _run() -> gi.Solution:
    problem, y0 = examples()[1]
    return gi.solve(problem, y0, t_end=0.02, step=0.01, method="rk-4", compiled=False)


def _text(path: Any) -> str:
    return path if isinstance(path, str) else "."


def _saved(path: Any) -> None:
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        if isinstance(path, str) and "/" not in path and not path.startswith("."):
            _run().save(path)  # only where the test may write


@cache
def calls() -> dict[str, Call]:
    """Return all calls by name."""
    field, y0 = examples()[1]
    bound, group, split = (examples()[i][0] for i in (2, 5, 8))
    tolerances = {"rtol": 1e-6, "atol": 1e-9, "max_step": 1.0, "max_steps": 9}
    scene = {
        "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
        "initial": {"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]},
        "time": {"t_end": 0.3},
        "integrate": {"method": "rk-4", "step": 0.1},
        "observe": {"quantities": []},
    }
    assert group.action is not None
    assert bound.hamiltonian is not None
    assert split.splitting is not None
    metric = examples()[10][0]
    measure = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).reduced().measure
    assert measure is not None
    return {
        **_solves(), **_bodies(),
        "Gauss": Call(_maker(gi.Gauss), {"stages": 2, "iteration_tolerance": 0.0,
            "max_iterations": 100, "iteration": "newton", "fused": False}),
        "RungeKutta": Call(_maker(gi.RungeKutta), {"tableau": "dop853"}),
        "RKMK": Call(_maker(gi.RKMK), {"tableau": "dop853", "coordinates": "exp"}),
        "Adaptive": Call(_maker(gi.Adaptive), {"base": gi.RungeKutta("dop853"), **tolerances}),
        "CommutatorFree": Call(_maker(gi.CommutatorFree), {"tableau": "cf-4"}),
        "Lobatto": Call(_maker(gi.Lobatto), {"stages": 3, "max_iterations": 200}),
        "Rattle": Call(_maker(gi.Rattle), {"iteration_tolerance": 0.0, "max_iterations": 200}),
        "Compose": Call(_maker(gi.Compose), {"base": gi.Gauss(1), "scheme": "suzuki-4"}),
        "find_method": Call(_maker(gi.find_method), {"name": "gauss-1-suzuki-4"}),
        "with_options": Call(_maker(gi.find_method("dop853-adaptive").with_options), {"rtol": 1e-6,
            "atol": 1e-9, "max_step": 1.0, "max_steps": 10**4}),
        "Problem field": Call(_problem, _fields_of(field)),
        "Problem group": Call(_problem, _fields_of(group)),
        "Problem bound": Call(_problem, _fields_of(metric)),
        "Group": Call(gi.Group, _fields_of(group.action.group)),
        "GroupAction": Call(gi.GroupAction, _fields_of(group.action)),
        "Hamiltonian": Call(gi.Hamiltonian, _fields_of(bound.hamiltonian)),
        "Splitting": Call(gi.Splitting, _fields_of(split.splitting)),
        "Measure": Call(gi.Measure, _fields_of(measure)),
        "SymplecticForm": Call(gi.SymplecticForm, {"constant": True}), "Scene": Call(_made, scene),
        "load_scene": Call(lambda source: gi.load_scene(source), {"source": "ball-3d"}),
        "make_plan": Call(lambda scene, purpose: gi.make_plan(gi.load_scene(scene), purpose),
            {"scene": scene, "purpose": "run"}),
        "as_vector": Call(gi.as_vector, {"name": "x", "value": [1.0, 2.0], "rows": 2}),
        "value": Call(lambda y, t: gi.value(field, next(iter(field.invariants.values())), y, t),
            {"y": y0, "t": 0.0}),
        "jacobian": Call(lambda y, t, by: bool(len(gi.jacobian(field, y, t, by))), {"y": y0,
            "t": 0.0, "by": "state"}),
        "tangent_flow": Call(gi.tangent_flow, {**{"problem": field, "y0": y0, "t_end": 1.0,
            "method": "rk-4", "step": 0.5}, **{"t0": 0.0, "directions": None, "parameters": None}}),
        "sensitivities": Call(gi.sensitivities, {**{"problem": field, "y0": y0, "t_end": 1.0,
            "method": "rk-4", "step": 0.5}, **{"t0": 0.0, "parameters": None, "observe": "energy"}}),
        "sensitivities of a family": Call(lambda parameters: gi.sensitivities(lambda **values: field,
            y0, parameters=parameters, t_end=1.0, step=0.5), {"parameters": {"D": 1.0}}),
        "lyapunov": Call(gi.lyapunov, {**{"problem": field, "y0": y0, "t_end": 1.0, "method": "rk-4",
            "step": 0.5}, **{"t0": 0.0, "count": 2, "directions": None}}),
        "gradient": Call(lambda y, t: bool(len(gi.gradient(field, "energy", y, t))), {"y": y0,
            "t": 0.0}),
        "derivative": Call(lambda y, t: bool(len(gi.derivative(field, y, t))), {"y": y0, "t": 0.0}),
        "so3": Call(gi.so3, {"vectors": 2}),
        "so_n pieces": Call(lambda n, piece: gi.so_n(n, piece), {"n": 4, "piece": "vector"}),
        "translations": Call(lambda m: gi.so_n(2, "vector") * gi.translations(m), {"m": 2}),
        "natural_in_space": Call(gi.natural_in_space, {"acceleration": field.field}),
        "natural_on_sphere": Call(gi.natural_on_sphere, {"gradient": field.field}),
        "time_transformed": Call(gi.time_transformed, {"problem": field, "clock": "energy",
            "y0": y0}),
        "with_quadrature": Call(gi.with_quadrature, {"problem": field, "name": "s",
            "rate": field.invariants["energy"]}),
        "pointwise": Call(lambda **given: bool(gi.pointwise(field.field, **given).shape),
            {"params": field.params, "points": [y0, y0], "rows": 4, "work": 0, "check": True}),
        "load": Call(lambda path: gi.load(_text(path)), {"path": "/nowhere/run.nc"}),
        "save": Call(_saved, {"path": "run.nc"}), "piece": Call(_run().piece, {"name": "q"}),
        "so_n": Call(gi.so_n, {"n": 4}),
        "birkhoff_average": Call(gi.birkhoff_average, {"values": np.cos(np.arange(64) * 0.3)}),
        "rotation_number": Call(gi.rotation_number, {"signal": np.exp(1j * np.arange(64) * 0.3),
            "step": 1.0}),
        "frequencies": Call(gi.frequencies, {"signal": np.cos(np.arange(64) * 0.3), "step": 1.0,
            "terms": 2, "order": 2}),
    }  # fmt: skip


def mutated(rng: Random, call: Call) -> dict[str, Any]:
    """Return the arguments of a call after one or two mutations."""
    given = dict(call.given)
    for _ in range(rng.choice((1, 1, 2))):
        name = rng.choice(list(given))
        what = rng.randrange(8)
        if what == 0:
            given[name] = hostile.objects(rng)
        elif what == 1:
            given[name] = hostile.arrays(rng, given[name])
        elif what == 2:
            given[name] = hostile.plain(rng)
            if isinstance(given[name], hostile.Raw):
                given[name] = str(given[name])
        elif isinstance(given[name], str | list | tuple | int | float):
            given[name] = hostile.near(rng, given[name])
        elif isinstance(given[name], np.ndarray):
            given[name] = hostile.near(rng, given[name].tolist())
        elif isinstance(given[name], Mapping):
            given[name] = {**given[name], rng.choice(hostile.STRINGS): hostile.plain(rng)}
        else:
            given[name] = hostile.plain(rng)
    return given


def call_verdict(rng: Random, seconds: float) -> Judged:
    """Return the verdict on a mutated call; a run that takes longer is interrupted."""
    names = sorted(calls())
    name = rng.choice([*names, *("solve field", "solve explicit", "solve tau") * 2])
    call = calls()[name]
    given = mutated(rng, call)
    if name == "load_scene" and rng.random() < 0.5:
        given = {"source": mutated_content(rng, False)}
    with alarm(seconds):
        found = judged(lambda: call.function(**given), only_finite)
    return Judged(found.verdict, f"{name}: {found.detail}")
