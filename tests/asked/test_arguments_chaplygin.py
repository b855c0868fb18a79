"""Every argument of every public function, class and method of chaplygin does something."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.asked.asked_support import Tables, arguments_of, seen

A, D, MOMENTS, K0 = np.array([0.8, 1.1, 1.5]), 4.0, np.array([1.0, 1.5, 2.0]), [1.0, 0.5, 0.2]
GAMMA, OTHER_GAMMA = np.array([0.48, 0.6, 0.64]), np.array([0.6, 0.48, 0.64])
TURN = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
TIMES = np.linspace(0.0, 1.0, 12)
BALL, OTHER_BALL = ch.ChaplyginSphere(A, D), ch.ChaplyginSphere([0.8, 1.1, 1.4], D)
BODY, CHART, GENERAL = ch.Veselova(A), ch.Spheroconical(A), ch.GeneralInertia(MOMENTS)
FLOW, REDUCED, CLASSICAL = BALL.hamiltonized(), BALL.reduced(), BALL.classical()

# One value of the arguments of a name: another one is near to it.
NEAR: dict[str, Any] = {
    "a": A, "m": 1.0, "rho": 2.0, "strength": 1.0, "x": 1.0, "K": 1.0, "H": 0.1, "f1": 0.1,
    "f3": 0.5, "f4": 2.0, "moments": MOMENTS, "mass": 1.0, "radius": 2.0, "values": MOMENTS,
    "k": K0, "omega": np.array(K0), "tau": 0.1, "t": 0.1, "phi": [0.1, 0.2], "theta": [0.1, 0.2],
    "p_tilde": np.cross(GAMMA, [1.0, 2.0, 3.0]), "tensor": np.diag(MOMENTS), "n": 3, "s": 2.0,
    "J": [0.6, 0.8, 1.0], "RubberSphere.from_a a": [0.3, 0.4, 0.45],
    "fedorov_ball D": 1.0, "fedorov_ball moments": np.array([2.0, 3.0, 4.0]),
}  # fmt: skip


def about_vertical(path: ch.RolledPath, angle: float) -> ch.RolledPath:
    """Return a path whose last attitude has come back, and has turned about the vertical."""
    c, s = math.cos(angle), math.sin(angle)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ path.attitude[0]
    return dataclasses.replace(path, attitude=np.array([path.attitude[0], turned]))


@functools.cache
def objects() -> dict[str, Any]:
    """Return an object of every class that has methods with arguments."""
    flows = {"ExactFlow": FLOW, "ExactBall": CLASSICAL}
    exact = {name: problem.exact(problem.random_state(1)) for name, problem in flows.items()}
    return exact | {
        "ChaplyginSphere": BALL, "Correspondence": ch.hamiltonization(BALL), "Veselova": BODY,
        "ContactPath": ch.ContactPath(exact["ExactBall"], 1.0), "GeneralInertia": GENERAL,
        "SpecialInertia": BALL.inertia, "RubberSphere": ch.RubberSphere(GENERAL, D),
        "Spheroconical": CHART, "VeselovaLR": ch.VeselovaLR(GENERAL),
    }  # fmt: skip


def of_exact() -> dict[str, Any]:
    """Return states on exact motions, and in their own coordinates."""
    found: dict[str, Any] = {}
    for name in ("ExactFlow", "ExactBall"):
        flow = objects()[name]
        outside = [flow.at_tau(tau) for tau in (0.1, 0.2)]
        inside = [flow.inward(y) for y in outside]
        found |= {f"{name} y": outside, f"{name}.outward y": inside}
        found |= {f"{name} states": [y[None] for y in inside]}
        found |= {f"{name}.{error} tau": [1.0, 1e6] for error in ("phase_error", "time_error")}
    return found


@functools.cache
def tables() -> Tables:
    moves = [REDUCED.exact(REDUCED.random_state(seed))(TIMES) for seed in (1, 2)]
    motions = [CLASSICAL.exact(CLASSICAL.random_state(seed)) for seed in (1, 2)]
    flows = [FLOW.exact(FLOW.random_state(seed)) for seed in (1, 2)]
    starts = [FLOW.random_state(seed) for seed in (2, 3)]
    contact, generals = BALL.contact(rho=1.0), [GENERAL, ch.GeneralInertia([1.0, 1.4, 2.0])]
    path = ch.rolled_path(contact, REDUCED, TIMES, moves[0])
    points = [CHART.point(g, np.cross(g, [1.0, 2.0, 3.0])) for g in (GAMMA, OTHER_GAMMA)]
    pairs: dict[str, Any] = {
        "inertia": [BALL.inertia, OTHER_BALL.inertia], "gamma": [GAMMA, OTHER_GAMMA],
        "y": [np.r_[K0, GAMMA], np.r_[K0, OTHER_GAMMA]], "sphere": [BALL, OTHER_BALL],
        "system": [BALL, BODY], "body": [BODY, ch.Veselova([0.8, 1.1, 1.4])],
        "source": [FLOW, OTHER_BALL.hamiltonized()], "target": [REDUCED, CLASSICAL],
        "problem": [FLOW, OTHER_BALL.hamiltonized()], "point": points, "states": moves,
        "gaps": [p.gaps for p in points], "signs": [points[0].signs, -points[0].signs],
        "rate": [lambda phi: np.cos(phi[..., 0]), lambda phi: np.sin(2.0 * phi[..., 0])],
        "contact": [contact, BALL.contact(rho=2.0)], "exact": motions,
        "total": [ch.GeneralInertia([5.0, 5.5, 6.0]), ch.GeneralInertia([5.0, 5.4, 6.0])],
        "clebsch_problem y": [0.5, 1.0], "action_variables exact": flows,
        "frequency_map states": [[y] for y in starts], "rolled_path t": [TIMES, 2.0 * TIMES],
        "rolled_path source": [REDUCED, OTHER_BALL.hamiltonized()],
        "rolled_path g0": [None, TURN @ path.attitude[0]], "k0": [None, K0], "g0": [None, TURN],
        "r0": [(0.0, 0.0), (1.0, 2.0)], "geometric_phase tolerance": [1e-6, 10.0],
        "geometric_phase path": [about_vertical(path, angle) for angle in (0.3, 0.4)],
        "resonances omega": [[1.0, 5.0, math.pi], [1.0, 3.0, math.pi]], "resonances order": [3, 9],
        "resonances tolerance": [1e-9, 0.1], "Correspondence.defect y": starts,
        "Correspondence.rate_at y": [REDUCED.random_state(seed) for seed in (4, 5)], "D": [4.0, 5.0],
        **{f"{name} y": starts for name in ("converted", "to_clebsch", "to_neumann")},
        **{f"{name} inertia": generals for name in ("lr_problem", "VeselovaLR", "RubberSphere")},
    }  # fmt: skip
    path_not_back = dataclasses.replace(path, attitude=path.attitude[[0, -1]])
    attitude, general = {"attitude": True}, {"inertia": GENERAL, "a": None}
    beside = {
        **{f"{name} k0": attitude for name in ("ball_problem", "classical_problem")},
        **{f"ChaplyginSphere.{name} k0": attitude for name in ("ball", "classical")},
        "ChaplyginSphere a": {"D": D}, "ChaplyginSphere D": {"a": A},
        **{f"ChaplyginSphere.{name} k0": {"rho": 1.0} for name in ("contact", "rolling")},
        "ChaplyginSphere inertia": {**general, "D": D}, "RubberSphere inertia": {"D": D},
        "geometric_phase tolerance": {"path": path_not_back},
    }  # fmt: skip
    return Tables(pairs | of_exact(), NEAR, beside)


def visible(x: Any) -> Any:
    """Return what can be seen of what a call makes."""
    match x:
        case ch.ChaplyginSphere():
            return x.ball()
        case ch.RubberSphere() | ch.Veselova():
            return [getattr(x, "D", None), x.reduced()]
        case ch.VeselovaLR():
            return [x.inertia, x.lr()]
        case ch.Ball():
            return x.problem()
        case ch.ContactPath():
            return [x.attitude(0.5), x.contact(0.5), x.state(0.5)]
        case ch.Spheroconical():
            return x.coordinates(GAMMA)
        case ch.Correspondence():
            y = x.source.random_state(4)
            return [x.name, x.source, x.target, x.forward(y), x.rate_at(y)]
        case ch.SpecialInertia() | ch.GeneralInertia():
            return [x.n, x.diagonal, getattr(x, "a", None), getattr(x, "D", None)]
    return x(np.array([0.3, 0.4])) if callable(x) else x


def asked() -> dict[str, Any]:
    """Return all that takes arguments, by name: of methods those of the objects."""
    found = {name: getattr(ch, name) for name in ch.__all__}
    for name, kind in list(found.items()):
        for method, f in inspect.getmembers(kind, callable) if inspect.isclass(kind) else ():
            if not method.startswith("_") and arguments_of(f):
                found[f"{name}.{method}"] = f
    made = {
        "Correspondence",
        "FrequencyMap",
        "MultiplierDefects",
        "RolledPath",
        "SpheroconicalPoint",
    }
    return {name: f for name, f in found.items() if name not in made | {"ExactBall", "ExactFlow"}}


@pytest.mark.parametrize("name", asked())
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_every_argument_does_something(name: str) -> None:
    owner, _, method = name.partition(".")
    function = getattr(objects()[owner], method) if method else asked()[name]
    tables().check(name, lambda **given: seen(visible(function(**given))), arguments_of(function))


def test_mass_and_radius_of_a_rubber_ball() -> None:
    """Together they are D, and apart they are not free."""
    ball = ch.RubberSphere(GENERAL, D)
    radii = [ball.rolling(m, rho).parameters["rho"] for m, rho in ((1.0, 2.0), (4.0, 1.0))]
    assert radii == [2.0, 1.0]
    with pytest.raises(gi.DomainError, match="D = 4"):
        ball.rolling(1.0, 1.0)


@pytest.mark.parametrize("make", [ch.ball_problem, ch.classical_problem])
def test_a_momentum_in_space_without_an_attitude_is_refused(make) -> None:
    with pytest.raises(gi.DomainError, match=r"k0 = .*attitude=True"):
        make(BALL.inertia, D, k0=K0)
