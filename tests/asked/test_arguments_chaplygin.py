"""Every argument of every public function and class of chaplygin does something."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
from tests.asked.asked_support import arguments_of, check

A, D, MOMENTS, K = np.array([0.8, 1.1, 1.5]), 4.0, np.array([1.0, 1.5, 2.0]), [1.0, 0.5, 0.2]
GAMMAS = np.array([0.48, 0.6, 0.64]), np.array([0.6, 0.48, 0.64])
TURN = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
TIMES = np.linspace(0.0, 1.0, 12)
BALL, OTHER_BALL, BODY = ch.ChaplyginSphere(A, D), ch.ChaplyginSphere(1.05 * A, D), ch.Veselova(A)
FLOW, REDUCED, CLASSICAL = BALL.hamiltonized(), BALL.reduced(), BALL.classical()
CONTACT, GENERAL = BALL.contact(rho=1.0), ch.GeneralInertia(MOMENTS)
VALUES: dict[str, Any] = {
    "a": A, "m": 1.0, "rho": 2.0, "strength": 1.0, "x": 1.0, "K": 1.0, "H": 0.1, "f1": 0.1, "f3": 0.5,
    "f4": 2.0, "moments": MOMENTS, "mass": 1.0, "radius": 2.0, "values": MOMENTS, "D": D, "k": K,
    "fedorov_ball D": 1.0, "fedorov_ball moments": 2.0 * MOMENTS, "r": 1,
    "sphere": (BALL, OTHER_BALL), "system": (BALL, BODY), "body": (BODY, ch.Veselova(1.05 * A)),
    "gamma": GAMMAS, "y": tuple(np.r_[K, gamma] for gamma in GAMMAS), "clebsch_problem y": 0.5,
    "source": (FLOW, OTHER_BALL.hamiltonized()), "target": (REDUCED, CLASSICAL), "k0": (None, K),
    "problem": (FLOW, OTHER_BALL.hamiltonized()), "contact": (CONTACT, BALL.contact(rho=2.0)),
    "inertia": (BALL.inertia, OTHER_BALL.inertia), "g0": (None, TURN), "r0": ((0.0, 0.0), (1.0, 2.0)),
    "total": (ch.GeneralInertia(6.0 * MOMENTS), ch.GeneralInertia(7.0 * MOMENTS)),
    "resonances omega": ([1.0, 5.0, math.pi], [1.0, 3.0, math.pi]), "order": (3, 9),
    "resonances tolerance": (1e-9, 0.1), "rolled_path source": (REDUCED, OTHER_BALL.hamiltonized()),
    "geometric_phase tolerance": (1e-6, 10.0), "t": (TIMES, 2.0 * TIMES),
    **{f"{name} inertia": (GENERAL, ch.GeneralInertia(1.05 * MOMENTS))
       for name in ("lr_problem", "VeselovaLR", "RubberSphere")},
}  # fmt: skip


@functools.cache
def moving() -> dict[str, Any]:
    """Return pairs of motions, of states on them, and of paths."""
    moves, motions, flows = (
        [problem.exact(problem.random_state(seed)) for seed in (1, 2)]
        for problem in (REDUCED, CLASSICAL, FLOW)
    )
    states, starts = [move(TIMES) for move in moves], [FLOW.random_state(seed) for seed in (2, 3)]
    path = ch.rolled_path(CONTACT, REDUCED, TIMES, states[0])
    first = path.attitude[0]
    backs = [np.array([first, turn @ first]) for turn in (TURN, TURN @ TURN)]
    pairs: dict[str, Any] = {
        "states": states, "exact": motions, "action_variables exact": flows,
        "frequency_map states": [[y] for y in starts], "rolled_path g0": [None, TURN @ first],
        "path": [dataclasses.replace(path, attitude=attitude) for attitude in backs],
        **{f"{name} y": starts for name in ("converted", "to_clebsch", "to_neumann")},
    }  # fmt: skip
    not_back = dataclasses.replace(path, attitude=path.attitude[[0, -1]])
    return {"not back": not_back} | {name: tuple(pair) for name, pair in pairs.items()}


def beside() -> dict[str, dict[str, Any]]:
    """Return what an argument needs beside it, or in place of another one."""
    attitude, not_back = {"attitude": True}, {"path": moving()["not back"]}
    return {
        "ball_problem k0": attitude, "classical_problem k0": attitude, "ChaplyginSphere a": {"D": D},
        "ChaplyginSphere D": {"a": A}, "ChaplyginSphere inertia": {"D": D},
        "RubberSphere inertia": {"D": D}, "geometric_phase tolerance": not_back,
    }  # fmt: skip


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
            return x.coordinates(GAMMAS[0])
        case ch.Correspondence():
            y = x.source.random_state(4)
            return [x.name, x.source, x.target, x.forward(y), x.rate_at(y)]
        case ch.SpecialInertia() | ch.GeneralInertia():
            return [x.diagonal, getattr(x, "D", None)]
    return x


MADE = {
    "Correspondence", "ExactBall", "ExactFlow", "FrequencyMap", "MultiplierDefects", "RolledPath",
}  # fmt: skip
MADE |= {"SpheroconicalPoint"}  # by functions that are asked


@pytest.mark.parametrize("name", sorted(set(ch.__all__) - MADE))
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_every_argument_does_something(name: str) -> None:
    make = getattr(ch, name)
    look = lambda **given: visible(make(**given))  # noqa: E731
    check(name, look, arguments_of(make), {**VALUES, **moving()}, beside())
