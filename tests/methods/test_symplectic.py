"""The symplectic defect of steps: of what keeps forms, of what does not, and against plain products."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles, neumann
from tests.families import FAMILIES, PROBLEMS
from tests.problems import spherical_pendulum, spring_pendulum


@gi.field
def prey(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Predators and prey: Hamiltonian in du∧dv/(uv)."""
    out[0], out[1] = y[0] * (1.0 - y[1]), y[1] * (y[0] - params[0])


@gi.helper
def logarithmic(params: Any, t: Any, y: Any, u: Any, v: Any, work: Any) -> Any:
    return (u[0] * v[1] - u[1] * v[0]) / (y[0] * y[1])


@gi.observable
def log_area(params: Any, t: Any, y: Any, work: Any) -> Any:
    return -gi.log(y[0] * y[1])


LOTKA = gi.Problem(
    "lotka-volterra",
    (("u", 1), ("v", 1)),
    [1.2],
    field=prey,
    measure=gi.Measure(log_area),
    symplectic_form=gi.SymplecticForm(logarithmic, constant=False),
)
OWN = {
    **{k: pair for k, pair in PROBLEMS.items() if pair[0].symplectic_form and pair[0].measure},
    "lotka": (LOTKA, np.array([0.5, 1.4])),
    "spring": (spring_pendulum.problem(), spring_pendulum.INITIAL),
}


def until(p: gi.Problem, end: float) -> dict[str, Any]:
    return {"tau_end": end, "clock": False} if p.time == "tau" else {"t_end": end}


def watched(p: gi.Problem, y0: Any, method: Any, step: float, steps: int, **run: Any) -> gi.Drift:
    """Return the drift after some steps: of few of them in plain Python."""
    run = {**until(p, steps * step), "compiled": steps > 20, **run}
    found = gi.solve(p, y0, method=method, step=step, observe=["symplectic"], **run)
    return found.drift["symplectic"]


def steps_of(name: str, p: gi.Problem, y0: np.ndarray, part: float = 1.0) -> float:
    return part * gi.find_method(name).default_step(p, y0, 1.0)


@pytest.mark.nightly
@pytest.mark.parametrize("name", [*gi.scene_names(), *OWN])
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_flows_keep_what_is_declared(name: str) -> None:
    """Steps so fine that they are those of the flow: from several states."""
    p, first = OWN.get(name) or (gi.load_scene(name).problem, gi.load_scene(name).state)
    if p.symplectic_form is None or p.field is None:
        return
    states = [p.canonical(first)]
    if p.make_random is not None:
        states += [p.random_state(seed) for seed in range(3)]
    for y0 in states:
        drift = watched(p, y0, "dop853", steps_of("gauss-8", p, y0, 0.0125), 8)
        assert drift.max_abs_error < 3e-15, y0
        assert drift.within_roundoff


PAIRS = [(n, k) for n, k in FAMILIES if k in OWN and not gi.find_method(n).adaptive]
MORE = [
    ("verlet-4", "neumann"),
    ("rk-4", "lotka"),
    ("gauss-2", "lotka"),
    ("gauss-4", "spring"),
]
FAST = [("rk-4", "lotka"), ("gauss-4", "spring"), ("rattle-2", "neumann-at-rest")]


@pytest.mark.parametrize(
    ("name", "problem"),
    [pytest.param(*p, marks=[pytest.mark.nightly] * (p not in FAST)) for p in PAIRS + MORE],
)
def test_methods(name: str, problem: str) -> None:
    """Round-off for methods that say so; else of order p + 1 in the step."""
    p, y0 = OWN[problem]
    y0, method = p.canonical(y0), gi.find_method(name)
    step = steps_of(name, p, y0)
    if "symplectic" in method.structure(p):
        few = (name, problem) in FAST
        drift = watched(p, y0, method, step, 10 if few else 200)
        assert drift.within_roundoff
        assert few or drift.drift_class == "roundoff"
        assert drift.max_abs_error < 4e-15 + 1e-14 * step
    elif method.order > 8:
        drift = watched(p, y0, method, step, 200)
        assert drift.max_abs_error < 1e-12  # too fine for its order to be seen
    else:
        coarse, fine = (watched(p, y0, method, h, 1).final_error for h in (4 * step, 2 * step))
        assert method.order + 0.4 < np.log2(coarse / fine) < method.order + 2.3


@pytest.mark.parametrize(
    "name",
    [
        "rk-4",
        *(pytest.param(n, marks=pytest.mark.nightly) for n in ("gauss-1", "rattle-2", "lobatto-4")),
    ],
)
def test_against_plain_products(name: str) -> None:
    """DΦ of one step, canonical form and projections in numpy."""
    p = gi.load_scene("hamiltonized-n3").problem
    J = np.kron([[0.0, 1.0], [-1.0, 0.0]], np.eye(3))
    for seed in range(4):
        y0, h = p.random_state(seed), 0.2
        flow = gi.tangent_flow(p, y0, tau_end=h, method=name, step=h)
        scales = np.repeat([np.linalg.norm(y0[:3]), np.linalg.norm(y0[3:])], 3)[:, None]
        bases = []
        for y in (y0, flow.y):
            C = np.array([gi.gradient(p, name, y) for name in p.constraints]) * scales[:, 0]
            bases.append(np.linalg.qr(C.T, mode="complete")[0][:, 2:])
        Q, Q1 = bases
        X = Q1 @ (Q1.T @ (flow.slopes * scales.T / scales) @ Q)
        before, after = ((scales * A).T @ J @ (scales * A) for A in (Q, X))
        expected = np.linalg.norm(after - before) / np.linalg.norm(after)
        found = watched(p, y0, name, h, 1, compiled=True).final_error
        assert found == pytest.approx(expected, rel=1e-9, abs=2e-15)


@pytest.mark.parametrize("name", ["rattle-2", pytest.param("gauss-4", marks=pytest.mark.nightly)])
def test_special_states(name: str) -> None:
    """At an equilibrium, at rest, with tiny momenta, backwards."""
    p = neumann.problem()
    for momentum in (None, 0.0, 1e-9):
        y0 = np.eye(6)[2] if momentum is None else neumann.initial() * ([1.0] * 3 + [momentum] * 3)
        for end in (1.0, -1.0):
            drift = watched(p, y0, name, 0.2, 5, t_end=end)
            assert drift.max_abs_error < (1e-7 if name == "gauss-4" else 4e-15)


def test_what_has_none() -> None:
    """No form, no manifold to restrict it to, quadratures beside; "all" does not mean it."""
    reduced = gi.load_scene("sphere-n3")
    with pytest.raises(gi.DomainError, match="states no symplectic form"):
        gi.solve(reduced.problem, reduced.state, t_end=1.0, observe=["symplectic"])
    free = gi.Problem("free", (("y", 2),), params=[1.0], field=prey)
    for name, where in (("symplectic", "SymplecticForm"), ("measure", "Measure")):
        with pytest.raises(gi.DomainError, match=rf"another name: .* see geomint\.{where}"):
            gi.solve(free, [1.0, 0.5], t_end=1.0, observe=[name])
    p = gi.load_scene("hamiltonized-n3").problem
    bare = dataclasses.replace(p, measure=None, space=None)
    with pytest.raises(gi.DomainError, match="states no measure"):
        gi.solve(bare, p.random_state(0), tau_end=1.0, observe=["symplectic"])
    assert gi.with_quadrature(henon_heiles.problem(), "s", log_area).symplectic_form is None
    y0, asked = henon_heiles.INITIAL, {"observe": ["all"], "compiled": False}
    run = gi.solve(henon_heiles.problem(), y0, t_end=0.5, step=0.25, **asked)
    assert "measure" in run.drift
    assert "symplectic" not in run.drift


def test_wrong_forms() -> None:
    @gi.helper
    def outside(params: Any, t: Any, y: Any, u: Any, v: Any, work: Any) -> Any:
        return u[0] * v[7]

    given = {"name": "x", "pieces": (("q", 2),), "field": prey, "params": [1.0]}
    for form, said in ((3, "SymplecticForm"), (gi.SymplecticForm, "SymplecticForm")):
        with pytest.raises(gi.DomainError, match=said):
            gi.Problem(**given, symplectic_form=form)
    with pytest.raises(gi.DomainError, match="recorded"):
        gi.SymplecticForm(lambda *_: 0.0)
    bad = gi.Problem(**given, symplectic_form=gi.SymplecticForm(outside))
    with pytest.raises(gi.DeclarationError, match="symplectic_form"):
        gi.solve(bad, [0.5, 0.6], t_end=1.0)


def test_structure_says_so() -> None:
    """Gauss methods where the form is constant and space is flat; RATTLE on manifolds."""
    flat, sphere = henon_heiles.problem(), spherical_pendulum.problem()
    assert "symplectic" in gi.Gauss(4).structure(flat)
    assert "symplectic" not in gi.Gauss(4).structure(LOTKA)
    assert "symplectic" not in gi.Gauss(4).structure(gi.load_scene("hamiltonized-n3").problem)
    assert "symplectic" in gi.Rattle().structure(sphere)
    assert "symplectic" not in gi.RungeKutta("rk-4").structure(flat)
