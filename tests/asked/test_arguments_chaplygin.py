"""Every argument of every public function of chaplygin does something."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.systems import find_system, system_names
from tests.asked.asked_support import arguments_of, called, methods_of

A, OTHER_A = np.array([0.8, 1.1, 1.5]), np.array([0.8, 1.1, 1.4])
SPECIAL, OTHER = ch.SpecialInertia(A, 4.0), ch.SpecialInertia(OTHER_A, 4.0)
GENERAL, OTHER_GENERAL = ch.GeneralInertia([1.0, 1.5, 2.0]), ch.GeneralInertia([1.0, 1.4, 2.0])
MOMENTS, OTHER_MOMENTS = [1.0, 1.5, 2.0], [1.0, 1.4, 2.0]
K0, OTHER_K0 = [1.0, 0.5, 0.2], [0.5, 1.0, 0.2]
GAMMA, OTHER_GAMMA = np.array([0.48, 0.6, 0.64]), np.array([0.6, 0.48, 0.64])
Y, OTHER_Y = np.array([1.0, 0.5, 0.2, 0.48, 0.6, 0.64]), np.array([0.5, 1.0, 0.2, 0.48, 0.6, 0.64])
TURN = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
BALL, OTHER_BALL = ch.ChaplyginSphere(A, 4.0), ch.ChaplyginSphere(OTHER_A, 4.0)
BODY, OTHER_BODY = ch.Veselova(A), ch.Veselova(OTHER_A)
FLOWS = [sphere.hamiltonized() for sphere in (BALL, OTHER_BALL)]
START = FLOWS[0].random_state(2)
CLASSICAL = BALL.classical()
CHART = ch.Spheroconical(A)
POINT, OTHER_POINT = (CHART.point(g, np.cross(g, [1.0, 2.0, 3.0])) for g in (GAMMA, OTHER_GAMMA))
TIMES = np.linspace(0.0, 1.0, 12)
CONTACT = BALL.contact(rho=1.0)
REDUCED = BALL.reduced()


class Later:
    """A value that is made when a test asks for it: to collect the tests compiles nothing."""

    def __init__(self, make: Callable[[], Any]) -> None:
        self.value = functools.cache(make)


def now(x: Any) -> Any:
    return x.value() if isinstance(x, Later) else x


def motion(problem: gi.Problem, seed: int) -> Later:
    return Later(lambda: problem.exact(problem.random_state(seed)))


def at_tau(flow: Later, tau: Any) -> Later:
    return Later(lambda: now(flow).at_tau(tau))


def inward(flow: Later, tau: Any) -> Later:
    return Later(lambda: now(flow).inward(now(flow).at_tau(tau)))


MOTION, OTHER_MOTION = (motion(CLASSICAL, seed) for seed in (1, 2))
FLOW, OTHER_FLOW = (motion(FLOWS[0], seed) for seed in (1, 2))
MOVE, OTHER_MOVE = (Later(lambda seed=seed: now(motion(REDUCED, seed))(TIMES)) for seed in (1, 2))
NEAR = Later(lambda: ch.rolled_path(CONTACT, REDUCED, TIMES, now(MOVE)))


def bent(angle: float) -> ch.RolledPath:
    """Return a path whose last attitude has come back, and has turned about the vertical."""
    path = now(NEAR)
    c, s = math.cos(angle), math.sin(angle)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ path.attitude[0]
    return dataclasses.replace(path, attitude=np.array([path.attitude[0], turned]))


def not_back() -> ch.RolledPath:
    return dataclasses.replace(now(NEAR), attitude=now(NEAR).attitude[[0, -1]])


# function: (arguments, another value of each)
CALLS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "action_variables": ({"exact": FLOW}, {"exact": OTHER_FLOW}),
    "almost_poisson_tensor": (
        {"inertia": SPECIAL, "D": 4.0, "y": Y},
        {"inertia": OTHER, "D": 3.0, "y": OTHER_Y},
    ),
    "attitude": (
        {"k": K0, "gamma": GAMMA, "g0": None},
        {"k": OTHER_K0, "gamma": OTHER_GAMMA, "g0": TURN},
    ),
    "ball_problem": (
        {"inertia": SPECIAL, "D": 4.0, "attitude": True, "k0": K0},
        {"inertia": OTHER, "D": 3.0, "attitude": False, "k0": OTHER_K0},
    ),
    "chaplygin_change": ({"sphere": BALL, "y": Y}, {"sphere": OTHER_BALL, "y": OTHER_Y}),
    "classical_problem": (
        {"inertia": SPECIAL, "D": 4.0, "attitude": True, "k0": K0},
        {"inertia": OTHER, "D": 3.0, "attitude": False, "k0": OTHER_K0},
    ),
    "clebsch_problem": (
        {"a": A, "strength": 1.0, "x": 1.0, "y": 0.5},
        {"a": OTHER_A, "strength": 2.0, "x": 2.0, "y": 1.0},
    ),
    "contact_problem": (
        {"inertia": GENERAL, "m": 1.0, "rho": 2.0, "k0": K0},
        {"inertia": OTHER_GENERAL, "m": 2.0, "rho": 1.0, "k0": OTHER_K0},
    ),
    "converted": (
        {"y": START, "source": FLOWS[0], "target": REDUCED},
        {"y": FLOWS[0].random_state(3), "source": FLOWS[1], "target": CLASSICAL},
    ),
    "cotangent_problem": (
        {"inertia": SPECIAL, "D": 4.0, "k0": K0},
        {"inertia": OTHER, "D": 3.0, "k0": OTHER_K0},
    ),
    "critical_energies": ({"a": A, "D": 4.0, "K": 1.0}, {"a": OTHER_A, "D": 5.0, "K": 2.0}),
    "discriminant": (
        {"a": A, "D": 4.0, "K": 1.0, "H": 0.1},
        {"a": OTHER_A, "D": 5.0, "K": 2.0, "H": 0.2},
    ),
    "ellipsoid_problem": ({"a": A}, {"a": OTHER_A}),
    "fedorov_ball": (
        {"moments": [2.0, 3.0, 4.0], "D": 1.0},
        {"moments": [2.0, 3.0, 5.0], "D": 2.0},
    ),
    "fedorov_body": ({"sphere": BALL}, {"sphere": OTHER_BALL}),
    "fedorov_constants": (
        {"f1": 0.1, "f3": 0.5, "f4": 2.0, "D": 1.0},
        {"f1": 0.2, "f3": 2.0, "f4": 3.0, "D": 2.0},
    ),
    "fedorov_state": ({"y": Y}, {"y": OTHER_Y}),
    "frequency_map": (
        {"problem": FLOWS[0], "states": [START]},
        {"problem": FLOWS[1], "states": [FLOWS[0].random_state(3)]},
    ),
    "gauss_map": ({"a": A, "D": 1.0}, {"a": OTHER_A, "D": 2.0}),
    "geometric_phase": (
        {"path": Later(lambda: bent(0.3)), "tolerance": 1e-6},
        {"path": Later(lambda: bent(0.4))},
    ),
    "geometric_phase of a path that is not closed": (
        {"path": Later(not_back), "tolerance": 1e-6},
        {"tolerance": 10.0},
    ),
    "hamiltonization": ({"system": BALL}, {"system": BODY}),
    "hamiltonized_problem": ({"inertia": SPECIAL}, {"inertia": OTHER}),
    "lr_problem": ({"inertia": GENERAL, "r": 1}, {"inertia": OTHER_GENERAL, "r": 2}),
    "multiplier_defects": (
        {"inertia": SPECIAL, "D": 4.0, "gamma": GAMMA, "k": K0},
        {"inertia": OTHER, "D": 3.0, "gamma": OTHER_GAMMA, "k": OTHER_K0},
    ),
    "neumann_problem": ({"a": A, "strength": 1.0}, {"a": OTHER_A, "strength": 2.0}),
    "poisson_problem": ({"inertia": SPECIAL, "D": 4.0}, {"inertia": OTHER, "D": 3.0}),
    "poisson_tensor": (
        {"inertia": SPECIAL, "D": 4.0, "y": Y},
        {"inertia": OTHER, "D": 3.0, "y": OTHER_Y},
    ),
    "reduced_problem": ({"inertia": SPECIAL, "D": 4.0}, {"inertia": OTHER, "D": 3.0}),
    "resonances": (
        {"omega": [1.0, 5.0, math.pi], "order": 3, "tolerance": 1e-9},
        {"omega": [1.0, 3.0, math.pi], "order": 9, "tolerance": 0.1},
    ),
    "rolled_path": (
        {"contact": CONTACT, "source": REDUCED, "t": TIMES, "states": MOVE, "g0": None, "r0": None},
        {
            "contact": BALL.contact(rho=2.0),
            "source": OTHER_BALL.hamiltonized(),
            "t": 2.0 * TIMES,
            "states": OTHER_MOVE,
            "g0": Later(lambda: TURN @ now(NEAR).attitude[0]),
            "r0": [1.0, 2.0],
        },
    ),
    "rolling_problem": (
        {"inertia": GENERAL, "m": 1.0, "rho": 2.0, "k0": K0},
        {"inertia": OTHER_GENERAL, "m": 2.0, "rho": 1.0, "k0": OTHER_K0},
    ),
    "rubber_rolling_problem": (
        {"inertia": GENERAL, "total": ch.GeneralInertia([5.0, 5.5, 6.0]), "m": 1.0, "rho": 2.0},
        {
            "inertia": OTHER_GENERAL,
            "total": ch.GeneralInertia([5.0, 5.4, 6.0]),
            "m": 2.0,
            "rho": 1.0,
        },
    ),
    "stiefel_problem": ({"inertia": GENERAL, "r": 1}, {"inertia": OTHER_GENERAL, "r": 2}),
    "to_clebsch": (
        {"sphere": BALL, "y": START},
        {"sphere": OTHER_BALL, "y": FLOWS[0].random_state(3)},
    ),
    "to_neumann": ({"body": BODY, "y": START}, {"body": OTHER_BODY, "y": FLOWS[0].random_state(3)}),
    "veselova_classical_problem": (
        {"a": A, "D": 1.0, "f1": 0.0},
        {"a": OTHER_A, "D": 2.0, "f1": 0.5},
    ),
    "veselova_hamiltonized_problem": ({"a": A, "D": 1.0}, {"a": OTHER_A, "D": 2.0}),
    "veselova_multiplier_problem": (
        {"a": A, "D": 1.0, "f1": 0.0},
        {"a": OTHER_A, "D": 2.0, "f1": 0.5},
    ),
    "veselova_reduced_problem": ({"a": A, "D": 1.0}, {"a": OTHER_A, "D": 2.0}),
    # classes
    "Ball": (
        {"mass": 1.0, "radius": 2.0, "moments": MOMENTS},
        {"mass": 2.0, "radius": 1.0, "moments": OTHER_MOMENTS},
    ),
    "ChaplyginSphere": ({"a": A, "D": 4.0}, {"a": OTHER_A, "D": 5.0}),
    "ChaplyginSphere of any inertia": (
        {"inertia": GENERAL, "D": 4.0},
        {"inertia": OTHER_GENERAL, "D": 5.0},
    ),
    "ContactPath": (
        {"exact": MOTION, "rho": 1.0, "g0": None, "r0": (0.0, 0.0)},
        {"exact": OTHER_MOTION, "rho": 2.0, "g0": TURN, "r0": (1.0, 2.0)},
    ),
    "GeneralInertia": ({"values": MOMENTS}, {"values": OTHER_MOMENTS}),
    "RubberSphere": ({"inertia": GENERAL, "D": 4.0}, {"inertia": OTHER_GENERAL, "D": 5.0}),
    "SpecialInertia": ({"a": A, "D": 4.0}, {"a": OTHER_A, "D": 5.0}),
    "Spheroconical": ({"a": A}, {"a": OTHER_A}),
    "Veselova": ({"a": A, "D": 1.0}, {"a": OTHER_A, "D": 2.0}),
    "VeselovaLR": ({"inertia": GENERAL, "r": 1}, {"inertia": OTHER_GENERAL, "r": 2}),
}
LOOK: dict[str, Callable[..., Any]] = {
    "attitude": lambda **given: ch.attitude(**given),
    "chaplygin_change": lambda **given: change_of(ch.chaplygin_change(**given)),
    "gauss_map": lambda **given: change_of(ch.gauss_map(**given)),
    "hamiltonization": lambda **given: change_of(ch.hamiltonization(**given)),
    "to_clebsch": lambda **given: change_of(ch.to_clebsch(**given)),
    "to_neumann": lambda **given: change_of(ch.to_neumann(**given)),
    "fedorov_ball": lambda **given: ch.fedorov_ball(**given).classical(),
    "fedorov_body": lambda **given: ch.fedorov_body(**given).reduced(),
    "Ball": lambda **given: ch.Ball(**given).problem(),
    "ChaplyginSphere": lambda **given: ch.ChaplyginSphere(**given).ball(),
    "ContactPath": lambda **given: path_of(ch.ContactPath(**given)),
    "GeneralInertia": lambda **given: ch.GeneralInertia(**given).matrix,
    "RubberSphere": lambda **given: ch.RubberSphere(**given).reduced(),
    "SpecialInertia": lambda **given: ch.SpecialInertia(**given).diagonal,
    "Spheroconical": lambda **given: ch.Spheroconical(**given).coordinates(GAMMA),
    "Veselova": lambda **given: ch.Veselova(**given).hamiltonized(),
    "VeselovaLR": lambda **given: ch.VeselovaLR(**given).lr(),
    "lr_problem": lambda **given: free_of_w(ch.lr_problem(**given)),
}


def change_of(change: ch.Correspondence) -> Any:
    y = change.source.random_state(4)
    return [change.name, change.source, change.target, change.forward(y), change.rate_at(y)]


def path_of(path: ch.ContactPath) -> Any:
    return [path.attitude(0.5), path.contact(0.5), path.state(0.5)]


def free_of_w(problem: Any) -> Any:
    return [problem.name, problem.params, list(problem.diagnostics), problem.pieces]


def pairs(mass: bool = True, **values: tuple[Any, Any]) -> tuple[dict, dict]:
    """Return arguments and others, with m and ρ or with D."""
    one, other = ({name: pair[i] for name, pair in values.items()} for i in (0, 1))
    scale = {"m": (1.0, 2.0), "rho": (2.0, 1.0)} if mass else {"D": (4.0, 5.0)}
    return one | {k: v[0] for k, v in scale.items()}, other | {k: v[1] for k, v in scale.items()}


def one_of_phi(phi: Any) -> Any:
    return np.cos(np.asarray(phi)[..., 0])


def other_of_phi(phi: Any) -> Any:
    return np.sin(2.0 * np.asarray(phi)[..., 0])


CHANGE = ch.hamiltonization(BALL)
REDUCED_Y = REDUCED.random_state(4)
PATH = Later(lambda: ch.ContactPath(now(MOTION), 1.0))
P = np.cross(GAMMA, [1.0, 2.0, 3.0])

# Methods of the classes: (object, method, arguments, another value of each)
METHODS: list[tuple[Any, str, dict[str, Any], dict[str, Any]]] = [
    *[
        (BALL, name, {"attitude": True, "k0": K0}, {"attitude": False, "k0": OTHER_K0})
        for name in ("ball", "classical")
    ],
    (BALL, "contact", {"rho": 1.0, "k0": K0}, {"rho": 2.0, "k0": OTHER_K0}),
    (BALL, "contact", {"m": 1.0}, {"m": 2.0}),
    (BALL, "rolling", {"rho": 1.0, "k0": K0}, {"rho": 2.0, "k0": OTHER_K0}),
    (BALL, "rolling", {"m": 1.0}, {"m": 2.0}),
    (BALL, "on_group", {"k0": K0}, {"k0": OTHER_K0}),
    (ch.ChaplyginSphere, "from_moments", *pairs(moments=(MOMENTS, OTHER_MOMENTS))),
    (ch.ChaplyginSphere, "from_tensor", *pairs(J=([0.6, 0.8, 1.0], [0.6, 0.8, 1.1]))),
    (
        ch.ChaplyginSphere,
        "homogeneous",
        {"n": 3, "s": 2.0, "D": 4.0},
        {"n": 4, "s": 3.0, "D": 5.0},
    ),
    (CHANGE, "defect", {"y": START}, {"y": FLOWS[0].random_state(5)}),
    (CHANGE, "rate_at", {"y": REDUCED_Y}, {"y": REDUCED.random_state(5)}),
    (PATH, "attitude", {"t": 0.5}, {"t": 0.6}),
    (PATH, "contact", {"t": 0.5}, {"t": 0.6}),
    (PATH, "state", {"t": 0.5}, {"t": 0.6}),
    *[
        (flow, name, {argument: one}, {argument: other})
        for flow in (FLOW, MOTION)
        for name, argument, one, other in (
            ("at_angles", "phi", [0.1, 0.2], [0.2, 0.2]),
            ("at_tau", "tau", 0.1, 0.2),
            ("tau", "t", 0.1, 0.2),
            ("time", "tau", 0.1, 0.2),
            ("phase_error", "tau", 1.0, 1e6),
            ("time_error", "tau", 1.0, 1e6),
        )
    ],
    *[
        (flow, name, {argument: one}, {argument: other})
        for flow in (FLOW, MOTION)
        for name, argument, one, other in (
            ("angles", "y", at_tau(flow, 0.1), at_tau(flow, 0.2)),
            ("theta", "y", at_tau(flow, 0.1), at_tau(flow, 0.2)),
            ("inward", "y", at_tau(flow, 0.1), at_tau(flow, 0.2)),
            ("outward", "y", inward(flow, 0.1), inward(flow, 0.2)),
            ("lam", "theta", [0.1, 0.2], [0.2, 0.2]),
            ("rate", "states", inward(flow, [0.1]), inward(flow, [0.2])),
            ("quadrature", "rate", one_of_phi, other_of_phi),
        )
    ],
    (MOTION, "angular_velocity", {"y": at_tau(MOTION, 0.1)}, {"y": at_tau(MOTION, 0.2)}),
    *[
        (inertia, "apply", {"omega": np.array(K0)}, {"omega": np.array(OTHER_K0)})
        for inertia in (GENERAL, SPECIAL)
    ],
    (ch.GeneralInertia, "from_mass_tensor", {"J": [0.6, 0.8, 1.0]}, {"J": [0.6, 0.8, 1.1]}),
    (
        ch.GeneralInertia,
        "from_tensor",
        {"tensor": np.diag(MOMENTS)},
        {"tensor": np.diag([1, 2, 2])},
    ),
    (GENERAL, "special", {"D": 4.0}, {"D": 5.0}),
    (ch.SpecialInertia, "from_moments", *pairs(False, moments=(MOMENTS, OTHER_MOMENTS))),
    (
        ch.SpecialInertia,
        "homogeneous",
        {"n": 3, "s": 2.0, "D": 4.0},
        {"n": 4, "s": 3.0, "D": 5.0},
    ),
    (ch.RubberSphere(GENERAL, 4.0), "rolling", {"m": 1.0, "rho": 2.0}, {}),
    (
        ch.RubberSphere,
        "from_a",
        {"a": [0.3, 0.4, 0.45], "D": 4.0},
        {"a": [0.3, 0.4, 0.4], "D": 3.0},
    ),
    (ch.RubberSphere, "from_moments", *pairs(False, moments=(MOMENTS, OTHER_MOMENTS))),
    (CHART, "coordinates", {"gamma": GAMMA}, {"gamma": OTHER_GAMMA}),
    (
        CHART,
        "gamma",
        {"gaps": POINT.gaps, "signs": POINT.signs},
        {"gaps": OTHER_POINT.gaps, "signs": -POINT.signs},
    ),
    *[
        (CHART, name, {"gamma": GAMMA, "p_tilde": P}, {"gamma": OTHER_GAMMA, "p_tilde": 2.0 * P})
        for name in ("point", "polynomial")
    ],
    (CHART, "separated", {"point": POINT}, {"point": OTHER_POINT}),
    (CHART, "state", {"point": POINT}, {"point": OTHER_POINT}),
    (ch.Veselova, "from_moments", *pairs(False, moments=(MOMENTS, OTHER_MOMENTS))),
    (BODY, "classical", {"f1": 0.0}, {"f1": 0.5}),
    (BODY, "multiplier", {"f1": 0.0}, {"f1": 0.5}),
    (ch.VeselovaLR, "from_a", {"a": A, "r": 1}, {"a": OTHER_A, "r": 2}),
]
PARTNERS = {  # (class, method): arguments that are told apart from others only together with these
    ("RubberSphere", "rolling"): {"m", "rho"},
}


def visible(x: Any) -> Any:
    """Return what can be seen of what a method makes."""
    if isinstance(x, ch.ChaplyginSphere):
        return x.ball()
    if isinstance(x, ch.RubberSphere):
        return [x.reduced(), x.D]
    if isinstance(x, ch.Veselova):
        return x.reduced()
    if isinstance(x, ch.VeselovaLR):
        return [x.inertia, free_of_w(x.lr())]
    if isinstance(x, ch.SpecialInertia | ch.GeneralInertia):
        return [x.n, getattr(x, "matrix", None), getattr(x, "a", None), getattr(x, "D", None)]
    return x if not callable(x) else x(np.array([0.3, 0.4]))


def public() -> dict[str, Any]:
    return {name: getattr(ch, name) for name in ch.__all__}


RECORDS = {"Correspondence", "ExactBall", "ExactFlow", "FrequencyMap", "MultiplierDefects"}
RECORDS |= {"RolledPath", "SpheroconicalPoint"}  # made by functions of the table


def keys_of(module: str) -> set[str]:
    """Return the keys of the systems that a module declares: those are looked at by themselves."""
    systems = [s for s in map(find_system, system_names()) if s.parameters.__module__ == module]
    return {key for system in systems for key in system.parameters.model_fields}


def test_every_argument_is_in_the_table() -> None:
    for name, function in public().items():
        if name in RECORDS:
            continue
        known = {a for key in CALLS if key.split(" ")[0] == name for a in CALLS[key][1]}
        known = known or keys_of(function.__module__)
        assert known == arguments_of(function), name


def test_every_method_is_in_the_table() -> None:
    for name, kind in public().items():
        if inspect.isclass(kind):
            mine = [entry for entry in METHODS if owner(now(entry[0])) is kind]
            assert {entry[1] for entry in mine} == methods_of(kind), name
            for method in methods_of(kind):
                known = {a for entry in mine if entry[1] == method for a in entry[3]}
                known |= PARTNERS.get((name, method), set())
                assert known == arguments_of(getattr(kind, method)) - {"self"}, (name, method)


def owner(thing: Any) -> type:
    return thing if inspect.isclass(thing) else type(thing)


@pytest.mark.parametrize(
    ("name", "argument"), [(name, a) for name, (_, others) in CALLS.items() for a in others]
)
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_an_argument_does_something(name: str, argument: str) -> None:
    given, others = CALLS[name]
    function = name.split(" ")[0]
    look = LOOK.get(function) or getattr(ch, function)
    one, other = (
        called(look, {key: now(x) for key, x in {**given, **more}.items()})
        for more in ({}, {argument: others[argument]})
    )
    assert one != other
    assert not failed(one) or name.endswith("not closed")


@pytest.mark.parametrize(
    ("thing", "method", "given", "argument", "value"),
    [(t, m, g, a, value) for t, m, g, others in METHODS for a, value in others.items()],
    ids=lambda x: x if isinstance(x, str) else "",
)
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_an_argument_of_a_method_does_something(
    thing: Any, method: str, given: dict, argument: str, value: Any
) -> None:
    def look(**arguments: Any) -> Any:
        taken = {key: now(x) for key, x in arguments.items()}
        return visible(getattr(now(thing), method)(**taken))

    one, other = (called(look, {**given, **more}) for more in ({}, {argument: value}))
    assert one != other
    assert not failed(one)


def failed(result: Any) -> bool:
    return isinstance(result, list) and result[:1] == ["error"]


def test_mass_and_radius_of_a_rubber_ball() -> None:
    """Together they are D, and apart they are not free."""
    ball = ch.RubberSphere(GENERAL, 4.0)
    radii = [ball.rolling(m, rho).parameters["rho"] for m, rho in ((1.0, 2.0), (4.0, 1.0))]
    assert radii == [2.0, 1.0]
    with pytest.raises(gi.DomainError, match="D = 4"):
        ball.rolling(1.0, 1.0)


@pytest.mark.parametrize("make", [ch.ball_problem, ch.classical_problem])
def test_a_momentum_in_space_without_an_attitude_is_refused(make) -> None:
    with pytest.raises(gi.DomainError, match=r"k0 = .*attitude=True"):
        make(SPECIAL, 4.0, k0=K0)
