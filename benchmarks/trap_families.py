"""Motions that mislead a step chosen from one look at the first state: families with a draw each.

What moves is written here and nowhere else: `traps.py` integrates the same formulas by SciPy.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

import chaplygin as ch
import geomint as gi

__all__ = ["FAMILIES", "Motion"]

Rng = np.random.Generator


class Motion(NamedTuple):
    """A problem, where it begins and for how long; times at which a force jumps."""

    problem: gi.Problem
    y0: Any
    span: float
    t0: float = 0.0
    breaks: tuple[float, ...] = ()


FAMILIES: dict[str, Callable[[Rng], Motion]] = {}


def family(draw: Callable[[Rng], Motion]) -> Callable[[Rng], Motion]:
    FAMILIES[draw.__name__.replace("_", "-")] = draw
    return draw


def problem_of(field: Any, rows: int, params: Any, rng: Rng | None = None) -> gi.Problem:
    """Return a problem, its numbers in one piece or, by `rng`, in positions and velocities."""
    halves = rng is not None and rng.integers(2) == 0
    pieces = (("q", rows // 2), ("v", rows // 2)) if halves else (("y", rows),)
    return gi.Problem(field.function.__name__, pieces=pieces, params=params, field=field)


def ten_to(rng: Rng, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high))


# --- pendulums and other equilibria ---------------------------------------------------------------


@gi.field
def pendulum(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -params[0] * gi.sin(y[0]) - params[1] * y[1]


@family
def beside_rest(rng: Rng) -> Motion:
    y0 = [ten_to(rng, -9, -1) * rng.choice([-1, 1]), 0.0]
    return Motion(problem_of(pendulum, 2, [ten_to(rng, -2, 2), 0.0], rng), y0, rng.uniform(5, 60))


@family
def rest(rng: Rng) -> Motion:
    return Motion(problem_of(pendulum, 2, [ten_to(rng, -2, 2), 0.0], rng), [0.0, 0.0], 30.0)


@family
def through_rest(rng: Rng) -> Motion:
    y0 = [0.0, ten_to(rng, -9, 0.2)]
    return Motion(problem_of(pendulum, 2, [1.0, 0.0], rng), y0, rng.uniform(5, 60))


@family
def top_of_pendulum(rng: Rng) -> Motion:
    y0 = [math.pi - ten_to(rng, -9, -1), 0.0]
    return Motion(problem_of(pendulum, 2, [1.0, 0.0], rng), y0, rng.uniform(10, 40))


@family
def all_energies(rng: Rng) -> Motion:
    g = ten_to(rng, -1, 1)
    y0 = [rng.uniform(-3, 3), rng.uniform(-2.2, 2.2) * math.sqrt(g)]
    return Motion(problem_of(pendulum, 2, [g, 0.0], rng), y0, rng.uniform(5, 40))


@family
def damped(rng: Rng) -> Motion:
    y0 = [rng.uniform(-3, 3), rng.uniform(-2, 2)]
    return Motion(problem_of(pendulum, 2, [1.0, ten_to(rng, -2, 0.5)], rng), y0, 30.0)


@gi.field
def away(params, t, y, out, work):
    out[0] = y[1]
    out[1] = params[1] * params[1] * (params[0] - y[0])


@family
def far_from_origin(rng: Rng) -> Motion:
    far, w = ten_to(rng, 0, 5) * rng.choice([-1, 1]), ten_to(rng, -2, 2)
    y0 = [far + ten_to(rng, -2, 0), 0.0]
    return Motion(problem_of(away, 2, [far, w], rng), y0, rng.uniform(5, 60) / w)


@family
def other_units(rng: Rng) -> Motion:
    size, w = ten_to(rng, -9, 9), ten_to(rng, -9, 9)
    y0 = [size * rng.normal(), size * w * rng.normal()]
    return Motion(problem_of(away, 2, [0.0, w], rng), y0, rng.uniform(5, 60) / w)


@gi.field
def cubic(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -params[0] * y[0] - y[0] * y[0] * y[0]


@family
def soft_spring(rng: Rng) -> Motion:
    y0 = [ten_to(rng, -2, 0.5), 0.0]
    return Motion(problem_of(cubic, 2, [0.0], rng), y0, rng.uniform(5, 60) / y0[0])


@family
def double_well(rng: Rng) -> Motion:
    y0 = [rng.uniform(0.2, 1.3), ten_to(rng, -6, 0)]
    return Motion(problem_of(cubic, 2, [-1.0], rng), y0, rng.uniform(5, 40))


@family
def out_of_saddle(rng: Rng) -> Motion:
    y0 = [ten_to(rng, -7, -1), 0.0]
    return Motion(problem_of(cubic, 2, [-1.0], rng), y0, rng.uniform(5, 40))


@gi.field
def spherical(params, t, y, out, work):
    v2 = y[3] * y[3] + y[4] * y[4] + y[5] * y[5]
    by = params[0] * y[2] - v2
    for i in range(3):
        out[i] = 1.0 * y[3 + i]
        out[3 + i] = by * y[i]
    out[5] = out[5] - params[0]


@family
def spherical_pendulum(rng: Rng) -> Motion:
    space = gi.TangentSphere(3, ("q", "v"))
    problem = gi.Problem("spherical", space=space, params=[ten_to(rng, -1, 1.5)], field=spherical)
    y0 = problem.state(q=[0.0, 0.0, -1.0], v=[ten_to(rng, -9, 0.3), 0.0, 0.0])
    return Motion(problem, y0, rng.uniform(2, 15))


@family
def neumann_from_axis(rng: Rng) -> Motion:
    problem = ch.neumann_problem([1.0, 2.0, rng.uniform(3, 6)], rng.uniform(2, 10))
    v = ten_to(rng, -6, -0.3)
    y0 = problem.state(q=np.roll([1.0, 0, 0], rng.integers(3)), v=[0, 0, 0])
    y0[3:] = v * rng.normal(size=3) * (y0[:3] == 0.0)
    return Motion(problem, y0, rng.uniform(5, 30))


# --- bodies ---------------------------------------------------------------------------------------


@gi.field
def euler(params, t, y, out, work):
    w0 = params[0] * y[0]
    w1 = params[1] * y[1]
    w2 = params[2] * y[2]
    out[0] = y[1] * w2 - y[2] * w1
    out[1] = y[2] * w0 - y[0] * w2
    out[2] = y[0] * w1 - y[1] * w0


def body(rng: Rng, m: Any, span: float) -> Motion:
    inverse = 1.0 / np.sort(rng.uniform(0.5, 3.0, 3))
    return Motion(problem_of(euler, 3, inverse), m, span)


@family
def beside_middle_axis(rng: Rng) -> Motion:
    return body(rng, np.eye(3)[1] + ten_to(rng, -9, -1) * rng.normal(size=3), rng.uniform(20, 100))


@family
def steady_rotation(rng: Rng) -> Motion:
    axis = np.eye(3)[rng.choice([0, 2])]
    return body(rng, axis + ten_to(rng, -9, -1) * rng.normal(size=3), rng.uniform(20, 100))


@family
def rigid_body(rng: Rng) -> Motion:
    return body(rng, rng.normal(size=3) * ten_to(rng, -2, 2), rng.uniform(2, 20))


@family
def chaplygin_ball(rng: Rng) -> Motion:
    problem = ch.ChaplyginSphere(a=np.sort(rng.uniform(0.5, 2.0, 3)).tolist(), D=4.5).reduced()
    return Motion(problem, problem.random_state(int(rng.integers(1 << 30))), rng.uniform(5, 60))


@family
def ball_nearly_upright(rng: Rng) -> Motion:
    problem = ch.ChaplyginSphere(a=np.sort(rng.uniform(0.5, 2.0, 3)).tolist(), D=4.5).reduced()
    k = int(rng.integers(3))
    gamma = np.eye(3)[k] + ten_to(rng, -9, -1) * rng.normal(size=3)
    gamma /= np.linalg.norm(gamma)
    p = np.cross(gamma, ten_to(rng, -6, 0) * rng.normal(size=3))
    return Motion(problem, problem.state(gamma=gamma, p=p), rng.uniform(5, 60))


# --- orbits ---------------------------------------------------------------------------------------


@gi.field
def kepler(params, t, y, out, work):
    r2 = y[0] * y[0] + y[1] * y[1]
    by = -params[0] / (r2 * gi.sqrt(r2))
    out[0] = y[2]
    out[1] = y[3]
    out[2] = by * y[0]
    out[3] = by * y[1]


def orbit(rng: Rng, e: float, far: bool, turns: float) -> Motion:
    mu, sign = ten_to(rng, -2, 2), (1.0 if far else -1.0)
    r = 1.0 + sign * e
    y0 = [r, 0.0, 0.0, math.sqrt(mu * (1.0 - sign * e) / r)]
    span = turns * 2.0 * math.pi / math.sqrt(mu) * rng.choice([-1, 1])
    return Motion(problem_of(kepler, 4, [mu], rng), y0, span)


@family
def from_apocentre(rng: Rng) -> Motion:
    return orbit(rng, rng.uniform(0.3, 0.95), True, rng.uniform(0.3, 8))


@family
def from_pericentre(rng: Rng) -> Motion:
    return orbit(rng, rng.uniform(0, 0.95), False, rng.uniform(0.3, 8))


@family
def flyby(rng: Rng) -> Motion:
    far = rng.uniform(5, 30)
    y0 = [-far, ten_to(rng, -1, 0.5), 1.0, 0.0]
    return Motion(problem_of(kepler, 4, [1.0], rng), y0, rng.uniform(1.2, 2.5) * far)


@gi.field
def henon_heiles(params, t, y, out, work):
    out[0] = y[2]
    out[1] = y[3]
    out[2] = -y[0] - 2.0 * y[0] * y[1]
    out[3] = -y[1] - y[0] * y[0] + y[1] * y[1]


@family
def henon_heiles_low(rng: Rng) -> Motion:
    y0 = rng.normal(size=4) * 0.15
    return Motion(problem_of(henon_heiles, 4, [], rng), y0, rng.uniform(10, 100))


@family
def henon_heiles_chaotic(rng: Rng) -> Motion:
    y0 = rng.normal(size=4)
    y0 *= math.sqrt(0.15 / (0.5 * y0 @ y0))
    y0[:2] *= 0.7
    return Motion(problem_of(henon_heiles, 4, [], rng), y0, rng.uniform(20, 150))


@gi.field
def lorenz(params, t, y, out, work):
    out[0] = 10.0 * (y[1] - y[0])
    out[1] = y[0] * (28.0 - y[2]) - y[1]
    out[2] = y[0] * y[1] - 8.0 / 3.0 * y[2]


@family
def lorenz_short(rng: Rng) -> Motion:
    y0 = rng.normal(size=3) * 5.0 + [0.0, 0.0, 20.0]
    return Motion(problem_of(lorenz, 3, []), y0, rng.uniform(1, 12))


@gi.field
def gyration(params, t, y, out, work):
    b = params[0] * (1.0 + params[1] * y[0])
    out[0] = y[2]
    out[1] = y[3]
    out[2] = b * y[3]
    out[3] = -b * y[2]


@family
def fast_gyration(rng: Rng) -> Motion:
    b = ten_to(rng, 0, 2)
    y0 = rng.normal(size=4)
    return Motion(problem_of(gyration, 4, [b, 0.1], rng), y0, rng.uniform(5, 200) / b)


@gi.field
def oscillators(params, t, y, out, work):
    for i in range(4):
        out[i] = y[4 + i]
        out[4 + i] = -params[i] * params[i] * y[i]
    out[4] = out[4] - 0.05 * y[1]
    out[5] = out[5] - 0.05 * y[0]


@family
def slow_and_fast(rng: Rng) -> Motion:
    y0 = rng.normal(size=8) * 10.0 ** rng.uniform(-6, 0, 8)
    return Motion(problem_of(oscillators, 8, 10.0 ** rng.uniform(-0.5, 1.5, 4), rng), y0, 20.0)


# --- forces in time -------------------------------------------------------------------------------


@gi.field
def chirp(params, t, y, out, work):
    w = 1.0 + params[0] * t
    out[0] = y[1]
    out[1] = -w * w * y[0]


@family
def faster_and_faster(rng: Rng) -> Motion:
    a = ten_to(rng, -1, 0.5)
    return Motion(problem_of(chirp, 2, [a], rng), rng.normal(size=2), rng.uniform(5, 30))


@gi.field
def bump(params, t, y, out, work):
    z = (t - params[0]) / params[1]
    w = 1.0 + params[2] / (1.0 + z * z)
    out[0] = w * y[1]
    out[1] = -w * y[0]


@family
def fast_for_a_while(rng: Rng) -> Motion:
    span = rng.uniform(15, 100)
    given = [span * rng.uniform(0.2, 0.9), ten_to(rng, -0.7, 0.5), ten_to(rng, 0, 2)]
    return Motion(problem_of(bump, 2, given, rng), rng.normal(size=2), span)


@gi.field
def pushed(params, t, y, out, work):
    z = (t - params[0]) / params[1]
    w = 1.0 / (1.0 + z * z)
    w = w * w
    w = w * w
    out[0] = y[1]
    out[1] = -params[3] * y[0] + params[2] * w * w


@family
def pulse(rng: Rng) -> Motion:
    given = [rng.uniform(2, 14), ten_to(rng, -0.3, 0.5), ten_to(rng, -2, 1), 1.0]
    return Motion(problem_of(pushed, 2, given, rng), rng.normal(size=2), 15.0)


@family
def pulse_from_rest(rng: Rng) -> Motion:
    given = [rng.uniform(5, 14), ten_to(rng, -0.3, 0.5), ten_to(rng, -2, 1), rng.integers(2)]
    return Motion(problem_of(pushed, 2, given, rng), [0.0, 0.0], 15.0)


@family
def narrow_pulse(rng: Rng) -> Motion:
    given = [rng.uniform(2, 14), ten_to(rng, -3, -1.3), ten_to(rng, 0, 2), 1.0]
    return Motion(problem_of(pushed, 2, given, rng), rng.normal(size=2), 15.0)


@gi.field
def switched(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -y[0] + gi.select((t > params[0]) & (t < params[1]), params[2], 0.0)


@family
def switch(rng: Rng) -> Motion:
    on = rng.uniform(1, 12)
    off = on + ten_to(rng, -0.5, 0.5)
    problem = problem_of(switched, 2, [on, off, ten_to(rng, -4, 1)], rng)
    return Motion(problem, rng.normal(size=2), 15.0, breaks=(on, off))


@gi.field
def forced(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -y[0] + params[1] * gi.cos(params[0] * t)


@family
def fast_forcing(rng: Rng) -> Motion:
    problem = problem_of(forced, 2, [ten_to(rng, 0, 2), ten_to(rng, -1, 1)], rng)
    return Motion(problem, rng.normal(size=2) * rng.integers(2), 15.0, t0=rng.uniform(-5, 5))


@gi.field
def late(params, t, y, out, work):
    s = t / params[0]
    s = s * s * s * s
    s = s * s
    out[0] = y[1]
    out[1] = -y[0] + params[1] * s * s * gi.sin(8.0 * t)


@family
def force_that_comes_late(rng: Rng) -> Motion:
    span = rng.uniform(10, 60)
    return Motion(problem_of(late, 2, [span, ten_to(rng, -2, 2)], rng), rng.normal(size=2), span)


@gi.field
def mathieu(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -(params[0] + params[1] * gi.cos(2.0 * t)) * y[0]


@family
def parametric_resonance(rng: Rng) -> Motion:
    given = [rng.uniform(0.5, 5), rng.uniform(0, 2)]
    return Motion(problem_of(mathieu, 2, given, rng), rng.normal(size=2), rng.uniform(10, 50))


# --- growth, decay, contact -----------------------------------------------------------------------


@gi.field
def sir(params, t, y, out, work):
    out[0] = -params[0] * y[0] * y[1]
    out[1] = params[0] * y[0] * y[1] - params[1] * y[1]
    out[2] = params[1] * y[1]


@family
def epidemic(rng: Rng) -> Motion:
    ill = ten_to(rng, -6, -1)
    problem = problem_of(sir, 3, [rng.uniform(0.3, 3), rng.uniform(0.05, 0.25)])
    return Motion(problem, [1.0 - ill, ill, 0.0], rng.uniform(20, 100))


@gi.field
def predators(params, t, y, out, work):
    out[0] = y[0] * (1.0 - y[1])
    out[1] = params[0] * y[1] * (y[0] - 1.0)


@family
def lotka_volterra(rng: Rng) -> Motion:
    y0 = [1.0 + rng.choice([-1, 1]) * ten_to(rng, -6, -0.05), rng.uniform(0.2, 2)]
    return Motion(problem_of(predators, 2, [ten_to(rng, -1, 1)], rng), y0, rng.uniform(5, 60))


@gi.field
def relaxation(params, t, y, out, work):
    out[0] = y[1]
    out[1] = params[0] * (1.0 - y[0] * y[0]) * y[1] - y[0]


@family
def van_der_pol(rng: Rng) -> Motion:
    y0 = [ten_to(rng, -6, 0.3), 0.0]
    return Motion(problem_of(relaxation, 2, [ten_to(rng, -1, 1)], rng), y0, rng.uniform(10, 40))


@gi.field
def follower(params, t, y, out, work):
    out[0] = -params[0] * (y[0] - gi.cos(t)) - gi.sin(t)


@family
def stiff_decay(rng: Rng) -> Motion:
    rate = ten_to(rng, 0, 3)
    return Motion(problem_of(follower, 1, [rate]), [rng.uniform(-1, 1)], rng.uniform(1, 6))


@gi.field
def logistic(params, t, y, out, work):
    out[0] = params[0] * y[0] * (1.0 - y[0])


@family
def growth(rng: Rng) -> Motion:
    rate = ten_to(rng, -1, 1)
    return Motion(problem_of(logistic, 1, [rate]), [ten_to(rng, -9, -1)], rng.uniform(5, 40) / rate)


@gi.field
def square(params, t, y, out, work):
    out[0] = y[0] * y[0]


@family
def before_a_pole(rng: Rng) -> Motion:
    y = ten_to(rng, -3, 3)
    return Motion(problem_of(square, 1, []), [y], (1.0 - ten_to(rng, -3, -0.3)) / y)


@gi.field
def bouncing(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -1.0 + gi.select(y[0] < 0.0, -params[0] * y[0], 0.0)


@family
def stiff_contact(rng: Rng) -> Motion:
    y0 = [rng.uniform(0.5, 3), 0.0]
    return Motion(problem_of(bouncing, 2, [ten_to(rng, 1, 4)], rng), y0, rng.uniform(2, 12))
