"""Motions that tests of runs share, each compiled once, and what is promised of default steps."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import signal
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles, sphere_metric
from tests.problems import lotka_volterra

Rate = Callable[..., Any]
PIECES = (("x", 1), ("v", 1))

# What is no matter of compiled code: plain Python has the same bits, as `tests.methods.test_bits` says.
solve = functools.partial(gi.solve, compiled=False)
Integrator = functools.partial(gi.Integrator, compiled=False)


def first(name: str, rate: Rate, *params: float, **more: Any) -> gi.Problem:
    """Return the motion x' = rate(params, t, y) beside a constant: of the size of `second`."""
    known = gi.helper(rate)

    @gi.field
    def field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0], out[1] = known(params, t, y), 0.0 * y[1]

    return gi.Problem(name, (("x", 1), ("c", 1)), params, field=field, **more)


def second(name: str, force: Rate, *params: float, pieces: Any = PIECES, **more: Any) -> gi.Problem:
    """Return the motion x'' = force(params, t, y), with y = (x, v)."""
    known = gi.helper(force)

    @gi.field
    def field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0], out[1] = 1.0 * y[1], known(params, t, y)

    return gi.Problem(name, pieces, params, field=field, **more)


_SWING = second("swing", lambda p, t, y: p[1] - p[0] * y[0] - p[2] * y[1])


def swing(
    stiffness: float = 1.0, push: float = 0.0, friction: float = 0.0, *more: float
) -> gi.Problem:
    """Return x'' = push − stiffness x − friction x'; further parameters are those of events."""
    return gi.Problem("swing", PIECES, [stiffness, push, friction, *more], field=_SWING.field)


def _pulsed_force(p: Any, t: Any, y: Any) -> Any:
    s = (t - p[0]) / p[1]
    pulse = 1.0 / (1.0 + s * s)
    pulse = pulse * pulse * pulse * pulse
    return p[3] * pulse - (1.0 + p[2] * pulse) * y[0]


_PULSED = second("pulsed", _pulsed_force, pieces=(("y", 2),))


def pulsed(at: float, width: float, stiffer: float, push: float = 0.0) -> gi.Problem:
    """Return an oscillator that is stiffer, or pushed, at a time, for a time."""
    return gi.Problem("pulsed", (("y", 2),), [at, width, stiffer, push], field=_PULSED.field)


@gi.field
def kepler(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    r2 = y[0] * y[0] + y[1] * y[1]
    r3 = r2 * gi.sqrt(r2)
    out[0], out[1] = 1.0 * y[2], 1.0 * y[3]
    out[2], out[3] = -params[0] * y[0] / r3, -params[0] * y[1] / r3


@gi.field
def _epidemic(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = -0.5 * y[0] * y[1]
    out[1] = 0.5 * y[0] * y[1] - 0.1 * y[1]
    out[2] = 0.1 * y[1]


@gi.field
def _rigid(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = -y[1] * y[2] / 3.0
    out[1] = y[2] * y[0]
    out[2] = -y[0] * y[1]


@gi.field
def _hanging(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A spherical pendulum."""
    force = 9.81 * y[2] - (y[3] * y[3] + y[4] * y[4] + y[5] * y[5])
    for i in range(3):
        out[i] = 1.0 * y[3 + i]
        out[3 + i] = force * y[i]
    out[5] = out[5] - 9.81


@gi.field
def _turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    s = (t - params[0]) / params[1]
    push = 1.0 / (1.0 + s * s)
    out[0] = params[2] * push * push * push * push
    out[1] = 0.3 * y[0]
    out[2] = 1.0 + 0.2 * y[1]


def turned(at: float, width: float, push: float) -> gi.Problem:
    """Return a body with angular velocities, that is pushed at a time, for a time."""
    action = gi.GroupAction(_turning, gi.so3(1))
    return gi.Problem("turned", (("v", 3),), params=[at, width, push], action=action)


@gi.observable
def pace(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 1.5 + 0.3 * y[0] * gi.sin(t)


TIMED = dataclasses.replace(lotka_volterra.problem(), time="tau", clock=pace, measure=None)
KEPLER = gi.Problem("kepler", (("y", 4),), [1.0], field=kepler)
PENDULUM = gi.Problem("hanging", space=gi.TangentSphere(3, ("q", "v")), field=_hanging)
APOCENTRE = [1.8, 0.0, 0.0, 1.0 / 3.0]
METRIC = sphere_metric.problem()
SPHERE = ch.ChaplyginSphere(a=(0.8, 1.1, 1.5), D=4.0).hamiltonized()
BALL = ch.ChaplyginSphere.from_moments((1.0, 2.0, 3.0), 1.0, 1.0).classical()

# Where the first state does not show the motion: problem, state, end.
TRAPS: dict[str, tuple[gi.Problem, Any, float]] = {
    "far away": (swing(1.0, 100.0), [101.0, 0.0], 100.0),
    "very far": (swing(1.0, 1e4), [1e4 + 1.0, 0.0], 100.0),
    "epidemic": (gi.Problem("epidemic", (("y", 3),), field=_epidemic), [0.999, 1e-3, 0.0], 100.0),
    "apocentre": (KEPLER, APOCENTRE, 64.0),
    "middle axis": (gi.Problem("rigid", (("y", 3),), field=_rigid), [1e-5, 1.0, 1e-5], 100.0),
    "lowest point": (PENDULUM, [0.0, 0.0, -1.0, 0.01, 0.0, 0.0], 10.0),
    "lowest point, slow": (PENDULUM, [0.0, 0.0, -1.0, 1e-5, 0.0, 0.0], 10.0),
    "lowest point, fast": (PENDULUM, [0.0, 0.0, -1.0, 5.0, 0.0, 0.0], 10.0),
    "axis": (ch.neumann_problem([1.0, 2.0, 4.0], 10.0), [1.0, 0.0, 0.0, 0.0, 0.01, 0.005], 20.0),
    "faster later": (pulsed(70.0, 6.0, 440.0), [1.0, 0.0], 100.0),
}
REGULAR: dict[str, tuple[gi.Problem, Any, float]] = {
    "sphere": (SPHERE, SPHERE.random_state(3), 60.0),
    "ball": (BALL, BALL.random_state(3), 60.0),
    "lotka-volterra": (lotka_volterra.problem(), np.asarray(lotka_volterra.INITIAL), 60.0),
    "henon-heiles": (henon_heiles.problem(), np.asarray(henon_heiles.INITIAL), 60.0),
    "metric": (METRIC, np.asarray(sphere_metric.initial(METRIC)), 60.0),
}


SPACE = gi.TangentSphere(3, ("q", "p"))
SWINGING, TURNING = [0.6, 0.0, -0.8, 0.4, 0.9, 0.3], [0.7, -0.4, 1.1, 0.48, 0.6, -0.64]


@functools.cache
def _pushed_forms(push: Rate) -> Any:
    """Return all forms of a pendulum on the sphere, its energy, and the velocities of a body."""
    now = gi.helper(push)

    @gi.field
    def gravity(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
        out[0] = 0.0 * q[0] + 1.5 * now(params, t)
        out[1] = 0.0 * q[1] - 0.5 * now(params, t)
        out[2] = 0.0 * q[2] + 1.0

    @gi.field
    def gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
        gravity(params, t, q, dq, work)
        for i in range(3):
            dp[i] = 1.0 * p[i]

    @gi.field
    def field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        x, z = 1.5 * now(params, t), -0.5 * now(params, t)
        p2 = y[3] * y[3] + y[4] * y[4] + y[5] * y[5]
        pull = (p2 - x * y[0] - z * y[1] - y[2]) / (y[0] * y[0] + y[1] * y[1] + y[2] * y[2])
        for i in range(3):
            out[i] = 1.0 * y[3 + i]
            out[3 + i] = -pull * y[i]
        out[3], out[4], out[5] = out[3] - x, out[4] - z, out[5] - 1.0

    @gi.observable
    def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
        height = y[2] + now(params, t) * (1.5 * y[0] - 0.5 * y[1])
        return 0.5 * (y[3] * y[3] + y[4] * y[4] + y[5] * y[5]) + height

    @gi.field
    def velocities(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        for i in range(3):
            out[i] = -y[i] / (1.0 + 0.6 * i) - now(params, t) * y[3 + (i + 1) % 3]

    return gravity, gradients, field, energy, velocities


def pushed(kind: str, push: Rate, *params: float, kept: bool = False, **more: Any) -> gi.Problem:
    """Return a pendulum, one on the sphere with all forms, or a body, with push(params, t).

    `kept`: whether the energy is an invariant of the one on the sphere.
    """
    gravity, gradients, field, energy, velocities = _pushed_forms(push)
    if kind == "body":
        action = gi.GroupAction(velocities, gi.so3(2))
        return gi.Problem("body", (("m", 3), ("gamma", 3)), params, action=action)
    if kind == "pendulum":
        return gi.Problem("pendulum", (("q", 3), ("p", 3)), params, field=field)
    more |= {"hamiltonian": SPACE.hamiltonian(gradients, separable=True), "field": field}
    more |= {"splitting": gi.natural_on_sphere(gravity)}
    more |= {"invariants" if kept else "observables": {"energy": energy}}
    return gi.Problem("sphere", space=SPACE, params=params, **more)


def promised(method: gi.Method) -> float:
    """Return what each step errs by whose length is not given, as `docs/how-accurate.md` says."""
    table = ((7, 1e-9), (4, 1e-7), (2, 1e-3), (1, 1e-2))
    return method.step_fraction * next(e for order, e in table if method.order >= order)


@contextlib.contextmanager
def after_a_while(happens: Callable[..., Any]) -> Iterator[None]:
    """Call something after a tenth of a second of processor time, as Ctrl-C is heeded."""
    before = [signal.signal(signal.SIGINT, signal.default_int_handler)]
    before.append(signal.signal(signal.SIGVTALRM, happens))
    signal.setitimer(signal.ITIMER_VIRTUAL, 0.1)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        for number, handler in zip((signal.SIGINT, signal.SIGVTALRM), before, strict=True):
            signal.signal(number, handler)
