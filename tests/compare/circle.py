"""Problems whose motions are known without any method."""

from __future__ import annotations

import numpy as np

import geomint as gi


@gi.field
def pendulum(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -gi.sin(y[0])


@gi.field
def turning(params, t, y, out, work):
    out[0] = -y[1]
    out[1] = y[0]


rate = gi.observable(lambda params, t, y, work: 2.0 + y[0])
PENDULUM = gi.Problem("pendulum", (("angle", 1), ("momentum", 1)), field=pendulum)
CIRCLE = gi.Problem("circle", (("x", 2),), field=turning)
IN_TAU = gi.Problem("circle", (("x", 2),), field=turning, clock=rate, time="tau")
EAST = np.array([1.0, 0.0])
REST = np.array([2.0, 0.0])
REST_AT_100 = np.array([1.98232565, 0.17964074])  # to 8 digits, from outside of this package


def on_circle(t):
    return np.array([np.cos(t), np.sin(t)], dtype=np.longdouble)


def with_time(tau):
    return np.append(on_circle(tau), 2.0 * tau + np.sin(tau))
