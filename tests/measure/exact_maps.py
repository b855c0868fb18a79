"""Defects of numerical maps by another way: the plain Python kernels on numbers of 50 digits."""

from __future__ import annotations

import mpmath
import numpy as np

import geomint as gi
from geomint.kernels.numbers.blocks import Block
from geomint.methods import Start
from geomint.problems.testproblems import henon_heiles, pulsating_body
from tests.problems import double_pendulum, lotka_volterra, spherical_pendulum

DIGITS = 50
PROBLEMS = {
    "lotka-volterra": (lotka_volterra.problem(), lotka_volterra.INITIAL),
    "henon-heiles": (henon_heiles.problem(), henon_heiles.INITIAL),
    "pulsating-body": (pulsating_body.problem(), pulsating_body.INITIAL),
    "spherical-pendulum": (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
    "double-pendulum": (double_pendulum.problem(), double_pendulum.INITIAL),
}


def exact(values) -> Block:
    """A block of the same numbers with 50 digits."""
    return Block(np.array([mpmath.mpf(float(v)) for v in np.asarray(values)], dtype=object))


def zeros(size: int) -> Block:
    return Block(np.array([mpmath.mpf(0)] * size, dtype=object))


class ExactMap:
    """One step of a method from (t, y), over h, by its kernel."""

    def __init__(self, problem: gi.Problem, name: str, h: float) -> None:
        y0 = np.full(problem.rows, 0.3)
        self.stepper = gi.find_method(name).start(Start(problem, y0, 0.0, h, compiled=False))
        self.problem, self.h = problem, mpmath.mpf(h)

    def __call__(self, t, y: np.ndarray) -> np.ndarray:
        """The increment Φ(y) − y."""
        rows = self.problem.rows
        memory = zeros(len(self.stepper.memory))
        memory.data[:rows] = y
        status, *_ = self.stepper.kernel(
            tuple(f.recorded for f in self.stepper.functions),
            exact(self.problem.params),
            exact(self.stepper.coefficients.data),
            exact(self.stepper.fractions.data),
            memory,
            zeros(len(self.stepper.work)),
            rows,
            mpmath.mpf(t),
            self.h,
            0,
            1,
            2,
            memory,
            zeros(0),
        )
        assert status == 0
        return memory.data[:rows] + memory.data[rows : 2 * rows] - y


def columns(f, y: np.ndarray) -> list[np.ndarray]:
    """Derivatives of f along the coordinates, by central differences."""
    d = mpmath.mpf(10) ** -16
    result = []
    for i in range(len(y)):
        above, below = y.copy(), y.copy()
        above[i] += d
        below[i] -= d
        result.append((f(above) - f(below)) / (2 * d))
    return result


def units(problem: gi.Problem, y: np.ndarray) -> list:
    """For each row the norm of its piece."""
    result = []
    for piece in problem.slices.values():
        result += [mpmath.norm(list(y[piece]))] * (piece.stop - piece.start)
    return result


def bases(problem: gi.Problem, t, y: np.ndarray, unit: list):
    """Orthonormal tangent vectors (columns) and the log density of their cell, in those units."""
    measure, n = problem.measure, problem.rows
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
    transposed = mpmath.matrix([list(unit[i] * gradients[i]) for i in range(n)])  # n × m
    Q, R = mpmath.qr(transposed)
    volume = sum(mpmath.log(abs(R[i, i])) for i in range(m))
    return Q[:, m:], density - volume


def exact_defect(problem: gi.Problem, name: str, t: float, y: np.ndarray, h: float) -> float:
    """The defect of one step, by the definition."""
    with mpmath.workdps(DIGITS):
        step, start = ExactMap(problem, name, h), exact(y).data
        J = mpmath.matrix([list(column) for column in columns(lambda x: step(t, x), start)]).T
        J += mpmath.eye(problem.rows)
        end = start + step(t, start)
        unit = units(problem, start)
        J = mpmath.diag([1 / u for u in unit]) * J * mpmath.diag(unit)
        Q0, before = bases(problem, t, start, unit)
        Q1, after = bases(problem, mpmath.mpf(t) + step.h, end, unit)
        return float(mpmath.log(abs(mpmath.det(Q1.T * J * Q0))) + after - before)
