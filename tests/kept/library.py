"""The runs of the packages from Python, part by part, with public names only.

Problems that the packages do not have are written here, so that both checkouts run the same text.
"""

import copy
import pickle
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi

Runs = Iterator[tuple[str, Any]]


@gi.helper
def weight(params: Any, t: Any) -> Any:
    """A gravity, or the strength of a spring, that swings: g (1 + ε cos t)."""
    return params[0] * (1.0 + params[1] * gi.cos(t))


@gi.field
def fall(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    """∂V/∂q of points of mass 1 in that gravity, along every second axis."""
    for i in range(len(q)):
        out[i] = weight(params, t) * (i % 2) + 0.0 * q[i]


@gi.field
def slopes(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
    """∂H/∂q and ∂H/∂p of these points."""
    fall(params, t, q, dq, work)
    for i in range(len(p)):
        dp[i] = 1.0 * p[i]


@gi.field
def rods(params: Any, q: Any, g: Any, G: Any, work: Any) -> None:
    """½(|x|² − 1), ½(|w − x|² − 1) of two points of the plane, and their Jacobian."""
    for i in range(2):
        d = q[2 + i] - q[i]
        G[i], G[2 + i], G[4 + i], G[6 + i] = 1.0 * q[i], 0.0 * q[i], -d, 1.0 * d
    g[0] = 0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0)
    g[1] = 0.5 * (G[6] * G[6] + G[7] * G[7] - 1.0)


@gi.field
def generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ξ of a body that changes its shape while it turns: ξ_i = −m_i/(I_i (1 + ε_i cos t)) − κγ_i."""
    for i in range(3):
        out[i] = -y[i] / (params[i] * (1.0 + params[3 + i] * gi.cos(t))) - params[6] * y[3 + i]


@gi.field
def acceleration(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    """Q̈ of Hénon and Heiles' stars, with springs that swing."""
    out[0] = -weight(params, t) * q[0] - 2.0 * q[0] * q[1]
    out[1] = -weight(params, t) * q[1] - q[0] * q[0] + q[1] * q[1]


@gi.field
def pull(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """The same on (q, p)."""
    for i in range(2):
        out[i] = 1.0 * y[2 + i]
    acceleration(params, t, gi.part(y, 0, 2), gi.part(out, 2, 2), work)


@gi.observable
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """½|p|² + ½g|q|² + q₁²q₂ − q₂³/3."""
    springs = weight(params, t) * (y[0] * y[0] + y[1] * y[1])
    bent = y[0] * y[0] * y[1] - y[1] * y[1] * y[1] / 3.0
    return 0.5 * (y[2] * y[2] + y[3] * y[3] + springs) + bent


def stars(swing: float = 0.3) -> gi.Problem:
    """Return the stars: flat, with a splitting."""
    split, form = gi.natural_in_space(acceleration), gi.SymplecticForm()
    given = {"field": pull, "splitting": split, "symplectic_form": form, "measure": gi.Measure()}
    params, known = [1.0, swing], {"energy": energy}
    return gi.Problem("stars", (("q", 2), ("p", 2)), params=params, invariants=known, **given)


def pendulum(separable: bool) -> gi.Problem:
    """Return the pendulum on the sphere, for kernels of separable Hamiltonians or for those of all."""
    space = gi.TangentSphere(3, ("q", "p"))
    form, split = space.hamiltonian(slopes, separable=separable), gi.natural_on_sphere(fall)
    given = {"hamiltonian": form, "splitting": split, "measure": gi.Measure()}
    return gi.Problem("pendulum", space=space, params=[1.3, 0.3], **given)


def _problems() -> Iterator[tuple[str, gi.Problem, Any]]:
    for name, swing in (("stars", 0.3), ("still", 0.0)):
        yield name, stars(swing), [0.1, -0.2, 0.35, 0.25]
    for name, separable in (("pendulum", True), ("pendulum-any", False)):
        yield name, pendulum(separable), [0.6, -0.8, 0.0, 0.2, 0.15, 0.9]
    form = gi.Hamiltonian(slopes, rods, 2, separable=True)
    points = gi.Problem("rods", (("q", 4), ("p", 4)), params=[1.0, 0.3], hamiltonian=form)
    yield "rods", points, [0.6, -0.8, 0.6, -1.8, 0.4, 0.3, 0.3, 0.3]
    action, params = gi.GroupAction(generator, gi.so3(2)), [1.0, 1.6, 2.3, 0.3, -0.2, 0.25, 0.4]
    body = gi.Problem("body", (("m", 3), ("gamma", 3)), params=params, action=action)
    yield "body", body, [2.1, -1.2, 3.3, 0.48, 0.6, -0.64]
    made = ch.ChaplyginSphere([0.8, 1.1, 1.5], 4.0), ch.ChaplyginSphere([0.7, 0.9, 1.2, 1.5], 4.0)
    for name, problem in (("sphere-3", made[0].hamiltonized()), ("ball-3", made[0].classical())):
        yield name, problem, problem.random_state(2)
    for name, problem in (("sphere-4", made[1].hamiltonized()), ("ball-4", made[1].ball())):
        yield name, problem, problem.random_state(4)


PROBLEMS = {name: (problem, y0) for name, problem, y0 in _problems()}


def end(problem: gi.Problem, length: float) -> dict[str, float]:
    """Return the argument that is an end in the problem's own time."""
    return {"t_end" if problem.time == "t" else "tau_end": length}


def go(name: str, method: Any, length: float, step: float | None = None, **more: Any) -> Any:
    """Return a run of a problem by its name; in plain Python unless something else is said."""
    problem, y0 = PROBLEMS[name]
    more = {"compiled": False, "step": step, **end(problem, length), **more}
    return gi.solve(problem, y0, method=method, **more)


def methods() -> Runs:
    """Every method, some compositions and options, in plain Python."""
    composed = ["gauss-1-suzuki-4", "gauss-2-suzuki-6", "verlet-2-kahan-li-8"]
    found = {name: gi.find_method(name) for name in gi.method_names() + composed}
    found["newton"] = gi.Gauss(4, iteration="newton")
    found["gauss-tolerance"] = gi.Gauss(8, iteration_tolerance=1e-9)
    found["rattle-tolerance"] = gi.Compose(gi.Rattle(iteration_tolerance=1e-9), "suzuki-4")
    found["rtol"] = gi.Adaptive(gi.RungeKutta("dormand-prince-5"), rtol=1e-6, atol=1e-8)
    for name, method in found.items():
        yield name, partial(_by_form, method)


PLAIN = {"field": ("stars", "ball-3"), "action": ("body", "ball-3")}
PLAIN |= {"hamiltonian": ("pendulum", "rods", "pendulum-any"), "splitting": ("stars", "pendulum")}
COMPILED = {"field": ("stars", "sphere-4"), "action": ("body", "ball-4")}
COMPILED |= {"hamiltonian": ("rods", "sphere-3", "sphere-4"), "splitting": ("pendulum", "sphere-4")}


def _by_form(method: gi.Method) -> dict[str, Any]:
    """Return runs in which a coefficient's last bit shows: longer ones of what costs little."""
    few = 3 if method.adaptive or getattr(method, "stages", 0) > 8 else 8
    steps = few if method.adaptive or method.name[:4] in ("gaus", "loba", "ratt") else 40
    names = PLAIN[method.needs]
    runs = zip(names, (steps, 3, 3), strict=False)
    return {name: go(name, method, 0.43 * count, 0.43, save_every=1) for name, count in runs}


def compiled() -> Runs:
    """Every method compiled, in two sizes, those of a family one after the other."""
    named = [gi.find_method(name) for name in gi.method_names()]
    for family in dict.fromkeys(method.family for method in named):
        own = [method for method in named if method.family == family]
        for name in COMPILED[own[0].needs]:
            more = {"save_every": 10, "compiled": True, "observe": "all"}
            yield f"{family} {name}", partial(_each, own, name, more)


def _each(methods: list[gi.Method], name: str, more: dict[str, Any]) -> dict[str, Any]:
    return {method.name: go(name, method, 3.0, 0.1, **more) for method in methods}


ALONG = {"rk-4": ("stars", 0.21), "dop853-adaptive": ("ball-3", 0.3), "gauss-4": ("sphere-3", 0.17)}
ALONG |= {"cf-4": ("body", 0.21), "rkmk-4": ("ball-3", 0.1), "rattle-2": ("pendulum", 0.1)}
ALONG |= {"lobatto-3": ("pendulum-any", 0.2), "verlet-4": ("stars", 0.23)}


def along() -> Runs:
    """States at wanted times, dense output, events, going on, restarts: a method of each family."""
    for method, (name, step) in ALONG.items():
        yield f"states {method}", partial(_states, method, name, step)
        yield f"events {method}", partial(_events, method, name, step)
        yield f"stepped {method}", partial(_stepped, method, name, step)
    yield "saved", _saved
    yield "scipy", _scipy


def _states(method: str, name: str, step: float) -> dict[str, Any]:
    problem, whole = PROBLEMS[name][0], 6.4 * step
    run, times = partial(go, name, method, whole, step), np.array([0, 0.31, 2, 2.71, 6.39]) * step
    timed, dense, physical = run(t_eval=times, save_every=2), run(dense=True), problem.time == "tau"
    return {
        "timed": timed,
        "own": run(tau_eval=times, clock=False) if physical else run(t0=0.7),
        "dense": dense.sol(times / whole * dense.t[-1]),
        "further": gi.solve(dense, **end(problem, 2.0 * whole), compiled=False),
        "back": go(name, method, -3.5 * step, step, save_every=1),
        "physical": run(t_end=timed.t[-1], tau_end=None) if physical else None,
        "default": go(name, method, 0.2) if problem.field is not None else None,
    }


@gi.event(direction="up")
def mixed(params: Any, t: Any, y: Any, work: Any) -> Any:
    """A number of all of the state."""
    return y[0] * y[3] - 0.3 * y[1] + 0.05


def _events(method: str, name: str, step: float) -> Any:
    piece = PROBLEMS[name][0].pieces[0][0]
    events = {"both": f"{piece}[0]", "level": gi.Event(f"{piece}[1]", "down", level=0.1)}
    events |= {"own": mixed, "last": gi.Event(f"{piece}[1]", terminal=2, level=-0.1)}
    return go(name, method, 25.0 * step, step, events=events)


def _stepped(method: str, name: str, step: float) -> list[Any]:
    motion = gi.Integrator(*PROBLEMS[name], method, step=step, compiled=False)
    motion.step(3)
    twin = copy.copy(motion)
    motion.propagate_for(1.7 * step)
    kept, motion.h = motion.state, -0.5 * step
    motion.step()
    twin.step(2)
    return [kept, motion, twin, pickle.loads(pickle.dumps(twin))]


def _saved() -> list[Any]:
    watched = {"observe": "all", "events": gi.Event("gamma[0]"), "save_every": 3}
    run = go("sphere-3", "gauss-4", 2.0, 0.17, **watched)
    with tempfile.TemporaryDirectory() as folder:
        run.save(Path(folder) / "run.nc")
        return [run, gi.load(Path(folder) / "run.nc")]


def _scipy() -> list[Any]:
    from scipy.integrate import solve_ivp

    methods = ((gi.scipy.GAUSS4, {"step": 0.3}), (gi.scipy.DOP853, {"rtol": 1e-7}))
    given = {"t_eval": [0.0, 1.3, 7.9], "events": lambda t, y: y[0]}
    run = partial(solve_ivp, lambda t, y: [y[1], 0.1 * t - y[0]], (0, 8), [1.0, 0.0], **given)
    return [run(method=method, **more) for method, more in methods]


def watch() -> Runs:
    """Drifts and their classes; of the quick ones in plain Python."""
    for method, name, step in (("rk-4", "stars", 0.2), ("gauss-2", "stars", 0.4)):
        yield f"plain {method}", partial(go, name, method, 80 * step, step, observe="all")
    every = {"observe": ["energy", "measure", "symplectic"], "observe_every": 3}
    yield "plain measure", partial(go, "stars", "verlet-2", 8.0, 0.2, **every)
    runs = [("rk-4", "still", 0.1), ("verlet-4", "still", 0.2), ("gauss-8", "sphere-3", 0.25)]
    runs += [
        ("rattle-2", "pendulum", 0.02),
        ("lobatto-3", "pendulum", 0.1),
        ("cf-4", "ball-3", 0.02),
    ]
    for method, name, step in runs:
        watched = ["all", "symplectic", "measure"][:: 1 + (name == "ball-3")]
        more = {"observe": watched, "compiled": True}
        yield f"long {method} {name}", partial(go, name, method, 4000 * step, step, **more)


def values() -> Runs:
    """Fields, quantities and derivatives of all systems and scenes, with some steps, and maps."""
    for name, (problem, y0) in PROBLEMS.items():
        yield name, partial(_values, problem, np.array(y0))
    x = np.linspace(-20.0, 20.0, 4001)
    yield "functions", lambda: [gi.sin(x), gi.cos(x), gi.log(1.0 + x * x), gi.sqrt(x * x)]
    yield "scenes", _of_scenes
    yield "maps", _maps
    yield "made", _made


def _values(problem: gi.Problem, y0: Any, form_count: int = 4) -> list[Any]:
    names = problem.diagnostics
    rates = [gi.derivative(problem, y0, 0.3, form) for form in problem.forms if form[0] in "fa"]
    known = [gi.value(problem, name, y0, 0.3) for name in names]
    slopes = [gi.gradient(problem, name, y0, 0.3) for name in list(names)[:form_count]]
    if problem.field is not None:
        slopes += [gi.jacobian(problem, y0, 0.3, by=by) for by in ("state", "parameters")]
    return [y0, rates, dict(zip(names, known, strict=True)), slopes]


def _of_scenes() -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in gi.scene_names():
        scene = gi.load_scene(name)
        for own, p in scene.model.problems.items():
            drawn = p.random_state(7) if p.make_random else None
            found[f"{name} {own}"] = drawn, _values(p, scene.model.states[own], 1)
        p, step = scene.problem, scene.content.integrate.step
        more = {"method": scene.method, "step": step, "observe": "invariants", "compiled": False}
        found[name] = gi.solve(p, scene.state, **end(p, 3 * step), **more)
    return found


def _maps() -> dict[str, Any]:
    """Return what correspondences, conversions and coordinates make of states."""
    sphere, body = ch.ChaplyginSphere([0.8, 1.1, 1.5], 4.0), ch.Veselova([0.8, 1.1, 1.5], 4.0)
    (flow, z), (_, y), reduced = PROBLEMS["sphere-3"], PROBLEMS["ball-3"], sphere.reduced()
    maps = [(ch.hamiltonization(sphere), reduced.random_state(1)), (ch.to_neumann(body, z), z)]
    maps += [(ch.to_clebsch(sphere, z), z), (ch.chaplygin_change(sphere, y), y)]
    maps += [(m, m.source.random_state(1)) for m in [ch.gauss_map([1.0, 4.0, 9.0])]]
    there = {m.name: [m.forward(x), m.backward(m.forward(x)), m.defect(x)] for m, x in maps}
    at = ch.Spheroconical([0.8, 1.1, 1.5])
    return {
        **there,
        "converted": ch.converted(z, flow, sphere.rolling(rho=1.0)),
        "coordinates": [at.coordinates(z[:3]), at.polynomial(z[:3], z[3:])],
        "bracket": [ch.poisson_tensor(sphere.inertia, 4.0, y), ch.attitude(y[:3], y[3:])],
    }


def _made() -> list[Any]:
    """Return steps of problems that are made of others."""
    (stars, x), (ball, y) = PROBLEMS["stars"], PROBLEMS["ball-3"]
    more, summed = {"step": 0.2, "compiled": False}, gi.with_quadrature(stars, "s", mixed.what)
    uneven = gi.time_transformed(ball, y0=y)
    first = gi.solve(uneven, y, tau_end=1.0, method="gauss-4", **more)
    return [first, gi.solve(summed, [*x, 0.0], t_end=2.0, method="rk-4", **more)]


def accuracy() -> Runs:
    """Steps that follow from tolerances, and what is known of the error."""
    for method, name in (("auto", "sphere-3"), ("cf-4", "ball-3"), ("dop853-adaptive", "stars")):
        more = {"tolerance": 1e-9, "compiled": True, "observe": "invariants"}
        yield f"{method} {name}", partial(go, name, method, 20.0, **more)
    more = {"estimate_error": True, "save_every": 5}
    yield "plain estimate", partial(go, "stars", "rk-4", 4.0, 0.2, **more)


def carried() -> Runs:
    """Tangents, exponents, sensitivities."""
    pairs = {"verlet-4": "stars", "gauss-4": "sphere-3", "cf-4": "body", "rattle-2": "pendulum"}
    for method, name in pairs.items():
        yield method, partial(_tangents, name, method)
    more = {"t_end": 200.0, "step": 0.2, "method": "verlet-4", "progress": False}
    yield "lyapunov", partial(gi.lyapunov, *PROBLEMS["still"], **more)
    more = {"tau_end": 3.0, "step": 0.1, "method": "rk-4", "observe": ["energy"]}
    more["parameters"] = {"D": 4.0, "a": 0.8}
    yield "sensitivities", partial(gi.sensitivities, _family, **more)


def _family(D: float, a: float) -> Any:
    problem = ch.ChaplyginSphere([a, 1.1, 1.5], D).hamiltonized()
    return problem, problem.state(gamma=[0.48, 0.6, 0.64], p=[0.8, 1.0, -1.5375])


def _tangents(name: str, method: str) -> list[Any]:
    problem, y0 = PROBLEMS[name]
    motion = gi.Integrator(problem, y0, method, step=0.1, tangents=2)
    motion.step(7)
    flow = gi.tangent_flow(problem, y0, **end(problem, 1.0), method=method, step=0.1)
    return [flow, motion.tangents]


def series() -> Runs:
    """Draws, ensembles, sections, and what is read off series."""
    yield "draws", lambda: gi.draw_states(stars(0.0), 4, at=PROBLEMS["stars"][1], seed=3)
    bins, windows = gi.Histogram("q[0]", [-1, -0.2, 0.2, 1]), gi.Windows("energy", 16)
    wanted = ["drift:energy", "frequency:q[0]", "mean:q[1]", "exponent", windows, bins]
    yield "lanes", partial(_members, "rk-4", save_every=10)
    yield "several", partial(_members, "verlet-4", [stars(0.1 * k) for k in range(9)])
    yield "at times", partial(_members, "gauss-4", t_eval=[0, 1.1, 3], events="q[0]", observe="all")
    yield "readings", partial(_members, "rk-4", readings=wanted)
    yield "growth", lambda: _members("rk-4", readings=windows, t_end=20.0).growth("energy")
    yield "on disk", _on_disk
    more = {"step": 0.2, "progress": False}
    yield "section", partial(gi.poincare_section, *PROBLEMS["still"], "q[0]", 20, **more)
    yield "signals", _signals


def _members(method: str, problems: Any = None, **more: Any) -> Any:
    states = np.array(PROBLEMS["stars"][1]) * np.linspace(0.8, 1.0, 9)[:, None]
    given = {"t_end": 3.0, "method": method, "step": 0.1, "progress": False, **more}
    return gi.solve_ensemble(problems or stars(), states, **given)


def _on_disk() -> list[Any]:
    with tempfile.TemporaryDirectory() as folder:
        many = _members("rk-4", save_every=10, out=f"{folder}/many.zarr")
        return [many.y, many.final, many.steps]


def _signals() -> list[Any]:
    run = go("still", "verlet-4", 60.0, 0.1, save_every=1)
    q, turning = run.y[:, 0], run.y[:, [0, 2]]
    read = [gi.frequencies(q, 0.1, terms=3), gi.birkhoff_average(q * q)]
    return [*read, gi.rotation_number(turning, 0.1)]


def exact() -> Runs:
    """Exact motions: tori, clocks, states, events, sections, families, the contact point."""
    names = "hamiltonized-n3 lagrange-n4 sphere-n3 ball-3d veselova-classical hamiltonized-n5"
    for name in (*names.split(), "homogeneous-n4", "rubber-ball-n3", "veselova-n4"):
        yield name, partial(_exact, name)
    yield "followed", _followed
    yield "families", _families


def _exact(name: str) -> dict[str, Any]:
    model, found = gi.load_scene(name).model, {}
    for own, problem in model.problems.items():
        if problem.make_exact is not None:
            motion, times = problem.exact(model.states[own]), [0.0, 1.7, 1e3]
            found[own] = [motion(times), _numbers(motion, times) if hasattr(motion, "ovals") else 0]
    return found


def _numbers(motion: Any, times: list[float]) -> list[Any]:
    told = [motion.frequencies, motion.mean_frequencies, motion.condition, motion.longest]
    return [*told, motion.ovals, motion.at_tau(times), motion.time(times), motion.tau(times)]


def _followed() -> dict[str, Any]:
    problem, y0 = PROBLEMS["sphere-3"]
    more = {"method": "exact", "t_eval": [0.0, 3.0, 7.5], "observe": "invariants", "dense": True}
    run = gi.solve(problem, y0, t_end=8.0, events="gamma[0]", **more)
    last = gi.Event("gamma[2]", "up", terminal=4)
    ended = gi.solve(problem, y0, t_end=1e5, method="exact", events=last)
    section = gi.poincare_section(problem, y0, "gamma[2]", 12, method="exact", progress=False)
    return {"run": run, "dense": run.sol([1.0, 2.0]), "ended": ended, "section": section}


def _families() -> list[Any]:
    (problem, y0), (ball, y) = PROBLEMS["sphere-3"], PROBLEMS["ball-3"]
    exact, path, t = problem.exact(y0), ch.ContactPath(ball.exact(y), 1.0), np.linspace(0, 2, 41)
    contact = ch.ChaplyginSphere([0.8, 1.1, 1.5], 4.0).contact(rho=1.0)
    rolled = ch.rolled_path(contact, ball, t, path.exact(t))
    many = ch.frequency_map(problem, [problem.random_state(k) for k in range(3)])
    resonant = ch.resonances(exact.frequencies, 12, 1e-2)
    return [many, ch.action_variables(exact), resonant, path.drift, path.state(t[:3]), rolled]


def scenes() -> Runs:
    """Every built-in scene to a short end, as commands run it."""
    for name in gi.scene_names():
        yield name, partial(_scene, name)


def _scene(name: str) -> Any:
    scene = gi.load_scene(name)
    own = "tau_end" if scene.content.time.tau_end else "t_end"
    ends = {own: 100 * (scene.content.integrate.step or 0.1)}
    return gi.run_scene(scene.changed(time=ends), progress=False)


def failures() -> Runs:
    """What is refused, and what fails on the way."""
    few, bound = gi.Gauss(2, iteration="fixed-point", max_iterations=3), gi.RungeKutta("dop853")
    wrong = [{"method": "gauss-17"}, {"method": "rattle-2"}, {"step": -1.0}, {"tolerance": 1e-9}]
    wrong += [{"observe": ["enrgy"]}, {"events": "q[7]"}, {"t_eval": [2.0, 1.0]}, {"tau_end": 3.0}]
    wrong += [
        {"method": few},
        {"method": gi.Adaptive(bound, max_steps=2)},
        {"y0": [1, np.nan, 0, 0]},
    ]
    wrong += [{"y0": [1e3] * 4, "method": "rk-4", "step": 1.0, "t_end": 50.0}]
    yield "solve", partial(_refused, wrong)
    yield "scene", partial(gi.load_scene, "ball-3")
    yield "system", lambda: gi.Scene(system={"name": "neuman"}, time={"t_end": 1.0, "x": 2})


def _refused(wrong: list[dict[str, Any]]) -> list[Any]:
    found: list[Any] = []
    for given in wrong:
        more = {"y0": PROBLEMS["stars"][1], "t_end": 4.0, "step": 0.2, "compiled": False, **given}
        try:
            found.append(gi.solve(stars(), **more))
        except gi.GeomintError as error:
            found.append(error)
    return found


PARTS = [methods, along, watch, values, failures, compiled, accuracy, carried, series]
PARTS += [exact, scenes]
