"""Defects of numerical maps by another way: the plain Python kernels on numbers of many digits."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import mpmath
import numpy as np

import geomint as gi
from geomint.problems.testproblems import henon_heiles, pulsating_body
from tests.problems import double_pendulum, lotka_volterra, spherical_pendulum

PROBLEMS = {
    "lotka-volterra": (lotka_volterra.problem(), lotka_volterra.INITIAL),
    "henon-heiles": (henon_heiles.problem(), henon_heiles.INITIAL),
    "pulsating-body": (pulsating_body.problem(), pulsating_body.INITIAL),
    "spherical-pendulum": (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
    "double-pendulum": (double_pendulum.problem(), double_pendulum.INITIAL),
}
DIGITS = 32  # of which differences leave 20
Block: Any = type(gi.packed(namedtuple("One", "x")(1), x=0.0))


def exact(values: Any) -> Any:
    """A block of the same numbers with many digits."""
    return Block(np.array([mpmath.mpf(float(v)) for v in np.asarray(values)], dtype=object))


def zeros(size: int) -> Any:
    return exact(np.zeros(size))


class ExactMap:
    """One step of a method from (t, y), over h, by its kernel."""

    def __init__(self, problem: gi.Problem, name: str, y0: np.ndarray, h: float) -> None:
        self.stepper: Any = gi.Integrator(problem, y0, name, step=abs(h), compiled=False).stepper
        self.problem, self.h = problem, mpmath.mpf(h)

    def __call__(self, t: Any, y: np.ndarray) -> np.ndarray:
        """The increment Φ(y) − y."""
        own, rows = self.stepper.flow, self.problem.rows
        memory = zeros(own.memory)
        memory.data[:rows] = y
        status, *_ = own.kernel(
            tuple(f.recorded for f in own.functions),
            *map(exact, (self.problem.params, own.coefficients.data, own.fractions.data)),
            *(memory, zeros(own.work), rows, mpmath.mpf(t), self.h, 0, 1, 2, memory, zeros(0)),
        )
        assert status == 0
        return memory.data[:rows] + memory.data[rows : 2 * rows] - y


def columns(f: Any, y: np.ndarray) -> list[np.ndarray]:
    """Derivatives of f along the coordinates, by central differences."""
    d = mpmath.mpf(10) ** -10
    moves = d * np.array(mpmath.eye(len(y)).tolist(), dtype=object)
    return [(f(y + move) - f(y - move)) / (2 * d) for move in moves]


def units(problem: gi.Problem, y: np.ndarray) -> list[Any]:
    """For each row the norm of its piece, 1 where that is 0."""
    result: list[Any] = []
    for piece in problem.slices.values():
        result += [mpmath.norm(list(y[piece])) or mpmath.mpf(1)] * (piece.stop - piece.start)
    return result


def bases(problem: gi.Problem, t: Any, y: np.ndarray, unit: list[Any]) -> tuple[Any, Any]:
    """Orthonormal tangent vectors (columns) and the log density of their cell, in those units."""
    measure, n = problem.measure, problem.rows
    assert measure is not None
    m = measure.conditions
    params, work = exact(problem.params), zeros(problem.work)
    density = measure.log_density(params, mpmath.mpf(t), Block(y), work)
    if m == 0:
        return mpmath.eye(n), density

    def c(x: np.ndarray) -> np.ndarray:
        out = zeros(m)
        measure.manifold(params, mpmath.mpf(t), Block(x), out, work)
        return out.data

    gradients = columns(c, y)
    Q, R = mpmath.qr(mpmath.matrix([list(unit[i] * gradients[i]) for i in range(n)]))  # n × m
    volume = sum(mpmath.log(abs(R[i, i])) for i in range(m))
    return Q[:, m:], density - volume


def change(problem: gi.Problem, J: Any, begin: tuple[Any, ...], end: tuple[Any, ...]) -> float:
    """The logarithm of what a map of derivative J makes of volumes, from (t, y) to (t, y)."""
    unit = units(problem, begin[1])
    J = mpmath.diag([1 / u for u in unit]) * J * mpmath.diag(unit)
    (Q0, before), (Q1, after) = (bases(problem, *point, unit) for point in (begin, end))
    return float(mpmath.log(abs(mpmath.det(Q1.T * J * Q0))) + after - before)


def exact_defect(problem: gi.Problem, name: str, t: float, y: np.ndarray, h: float) -> float:
    """The defect of one step, by the definition."""
    with mpmath.workdps(DIGITS):
        step, start = ExactMap(problem, name, y, h), exact(y).data
        J = mpmath.matrix([list(column) for column in columns(lambda x: step(t, x), start)]).T
        J += mpmath.eye(problem.rows)
        ends = (t, start), (mpmath.mpf(t) + step.h, start + step(t, start))
        return change(problem, J, *ends)
