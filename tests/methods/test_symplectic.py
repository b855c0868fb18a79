"""The symplectic defect of steps: of what keeps forms, of what does not, and against plain products."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.derivatives import slopes_of
from geomint.problems.testproblems import henon_heiles, neumann
from geomint.scene.load import builtin_scenes
from tests.families import FAMILIES, PROBLEMS
from tests.problems import spherical_pendulum


@gi.field
def prey(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Predators and prey: Hamiltonian in du∧dv/(uv)."""
    out[0] = y[0] * (1.0 - y[1])
    out[1] = y[1] * (y[0] - params[0])


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
}
DECLARED = sorted(
    name for name in builtin_scenes() if gi.load_scene(name).problem.symplectic_form is not None
)


def until(p: gi.Problem, end: float) -> dict[str, Any]:
    return {"tau_end": end, "clock": False} if p.time == "tau" else {"t_end": end}


def watched(p: gi.Problem, y0: Any, method: Any, step: float, steps: int) -> gi.Drift:
    run = gi.solve(
        p, y0, **until(p, steps * step), method=method, step=step, observe=["symplectic"]
    )
    return run.drift["symplectic"]


def steps_of(name: str, p: gi.Problem, y0: np.ndarray, part: float = 1.0) -> float:
    return part * gi.find_method(name).default_step(p, y0, 1.0)


@pytest.mark.nightly
@pytest.mark.parametrize("name", [*DECLARED, *OWN])
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_flows_keep_what_is_declared(name: str) -> None:
    """Steps so fine that they are those of the flow: from several states."""
    p, first = OWN.get(name) or (gi.load_scene(name).problem, gi.load_scene(name).state)
    states = [p.canonical(first)]
    if p.make_random is not None:
        states += [p.random_state(seed) for seed in range(3)]
    for y0 in states:
        assert p.field is not None
        drift = watched(p, y0, "dop853", steps_of("gauss-8", p, y0, 0.0125), 8)
        assert drift.max_abs_error < 3e-15, y0
        assert drift.within_roundoff


PAIRS = [(n, k) for n, k in FAMILIES if k in OWN and not gi.find_method(n).adaptive]
MORE = [
    ("verlet-4", "neumann"),
    ("rk-4", "lotka"),
    ("gauss-2", "lotka"),
    ("gauss-4", "henon-heiles"),
]


@pytest.mark.parametrize(("name", "problem"), [*PAIRS, *MORE])
def test_methods(name: str, problem: str) -> None:
    """Round-off for methods that say so; else of order p + 1 in the step."""
    p, y0 = OWN[problem]
    y0, method = p.canonical(y0), gi.find_method(name)
    step = steps_of(name, p, y0)
    drift = watched(p, y0, method, step, 200)
    if "symplectic" in method.structure(p):
        assert drift.drift_class == "roundoff"
        assert drift.max_abs_error < 2e-15 + 1e-14 * step
        return
    if method.order > 8:
        assert drift.max_abs_error < 1e-12  # too fine for its order to be seen
        return
    coarse, fine = (watched(p, y0, method, h, 1).final_error for h in (4 * step, 2 * step))
    order = np.log2(coarse / fine)
    assert method.order + 0.4 < order < method.order + 2.3


@pytest.mark.parametrize("name", ["rk-4", "gauss-1", "rattle-2", "verlet-2", "lobatto-4"])
def test_against_plain_products(name: str) -> None:
    """DΦ of one step, canonical form and projections in numpy."""
    p = gi.load_scene("hamiltonized-n3").problem
    J = np.kron([[0.0, 1.0], [-1.0, 0.0]], np.eye(3))
    for seed in range(4):
        y0, h = p.random_state(seed), 0.2
        flow = gi.tangent_flow(p, y0, tau_end=h, method=name, step=h)
        bases = []
        scales = np.repeat([np.linalg.norm(y0[:3]), np.linalg.norm(y0[3:])], 3)[:, None]
        for y in (y0, flow.y):
            C = slopes_of(p, p.measure.manifold, y, 0.0, p.measure.conditions) * scales[:, 0]
            bases.append(np.linalg.qr(C.T, mode="complete")[0][:, 2:])
        Q, Q1 = bases
        X = Q1 @ (Q1.T @ (flow.slopes * scales.T / scales) @ Q)
        before, after = ((scales * A).T @ J @ (scales * A) for A in (Q, X))
        expected = np.linalg.norm(after - before) / np.linalg.norm(after)
        found = watched(p, y0, name, h, 1).final_error
        assert found == pytest.approx(expected, rel=1e-9, abs=2e-15)


def test_units() -> None:
    """Of length and momentum: the defect has none."""
    p, y0 = henon_heiles.problem(), np.array([0.1, 0.2, 0.3, 0.1])

    @gi.field
    def scaled(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        q1, q2 = y[0] / 64.0, y[1] / 64.0
        out[0] = 64.0 * 1024.0 * y[2]
        out[1] = 64.0 * 1024.0 * y[3]
        out[2] = (-q1 - 2.0 * q1 * q2) / 1024.0
        out[3] = (-q2 - q1 * q1 + q2 * q2) / 1024.0

    other = gi.Problem("scaled", p.pieces, field=scaled, symplectic_form=gi.SymplecticForm())
    one = watched(p, y0, "rk-4", 0.3, 20)
    two = watched(other, y0 * [64, 64, 1 / 1024, 1 / 1024], "rk-4", 0.3, 20)
    assert one.max_abs_error > 1e-7
    assert two.max_abs_error == pytest.approx(one.max_abs_error, rel=1e-9)


@pytest.mark.parametrize(
    "name",
    [
        "gauss-4",
        *(
            pytest.param(x, marks=pytest.mark.nightly)
            for x in ("rattle-2", "verlet-2", "lobatto-8")
        ),
    ],
)
def test_special_states(name: str) -> None:
    """At rest, at an equilibrium, backwards, huge and tiny momenta."""
    p, y0 = PROBLEMS["neumann-at-rest"][0], neumann.initial()
    for state in (
        np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        y0 * [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
        y0 * [1.0, 1.0, 1.0, 1e-9, 1e-9, 1e-9],
    ):
        for step in (0.05, -0.05):
            run = gi.solve(
                p, state, t_end=20 * step, method=name, step=0.05, observe=["symplectic"]
            )
            limit = 1e-7 if name == "gauss-4" else 4e-15
            assert run.drift["symplectic"].max_abs_error < limit


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
    y0 = henon_heiles.INITIAL
    run = gi.solve(henon_heiles.problem(), y0, t_end=1.0, observe=["all"])
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


def test_axes_do_not_put_bars_around_a_norm() -> None:
    run = gi.solve(
        henon_heiles.problem(), henon_heiles.INITIAL, t_end=5.0, step=0.1, method="rk-4",
        observe=["symplectic"],
    )  # fmt: skip
    assert run.plot_drift().axes[0].get_ylabel() == "largest ‖Φ*ω − ω‖/‖ω‖"
