"""Newton's method where rounding is large: very stiff springs, against the equations in 40 digits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import geomint as gi
from geomint.tableaux import gauss_legendre
from tests.methods.stage_increments import increments
from tests.problems import spring_pendulum

Array = Any
LONG = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")
AT_REST = np.array([1.0, 0.0, 0.0, 0.3])  # the spring, not the pendulum
# ω and steps with h ω from 3 to 2·10⁴: with a bound on rounding that did not know them none was taken.
STIFF = [(1e2, 0.03), (1e3, 0.05), (1e4, 0.003), (1e4, 0.05), (1e5, 0.01), (1e5, 0.05), (1e6, 0.02)]
CASES = [(*case, stages) for case in STIFF for stages in (1, 2, 5)] + [
    (1e4, 0.05, 8),
    (1e6, 0.02, 11),
]
FAST = [(1e2, 0.03, 2), (1e4, 0.05, 1), (1e6, 0.02, 2)]
LENGTHS = (2.0**-900, 2.0**-30, 2.0**30, 2.0**900)


def slope_of(omega: float, y: Array) -> tuple[Array, Array]:
    """Return the field of the spring pendulum and its Jacobian, in mpmath numbers."""
    q, p, k = y[:2], y[2:], mpf(omega) ** 2
    r = mp.sqrt(q[0] ** 2 + q[1] ** 2)
    pull = k * (1 - 1 / r)
    J = np.full((4, 4), mpf(0))
    J[0, 2] = J[1, 3] = mpf(1)
    for i in range(2):
        for j in range(2):
            J[2 + i, j] = -k * q[i] * q[j] / r**3 - (pull if i == j else 0)
    return np.array([p[0], p[1], -pull * q[0], -pull * q[1] - 1]), J


def eliminated(matrix: Array, right: Array) -> Array:
    """Return the solution of a linear system, by elimination in place."""
    n = len(matrix)
    for k in range(n):
        at = k + int(np.argmax(np.abs(matrix[k:, k])))
        matrix[[k, at]], right[[k, at]] = matrix[[at, k]], right[[at, k]]
        for i in (i for i in range(n) if i != k and matrix[i, k] != 0):
            factor = matrix[i, k] / matrix[k, k]
            matrix[i, k:] = matrix[i, k:] - factor * matrix[k, k:]
            right[i] = right[i] - factor * right[k]
    return right / np.diag(matrix)[:, None]


def step(omega: float, stages: int, y: Array, h: float, near: Array) -> tuple[Array, Array]:
    """Return one step and its derivative, from increments near which the equations are solved."""
    mp.dps = 40
    table, n = gauss_legendre(stages), 4 * stages
    b, mu = [mpf(float(x)) for x in table.b], [[mpf(float(x)) for x in row] for row in table.mu]
    start, H = np.array([mpf(float(x)) for x in y]), mpf(h)
    L = np.array([[mpf(float(x)) for x in row] for row in near])
    for _ in range(6):
        matrix, lack = np.full((n, n), mpf(0)) + np.eye(n), np.full((n, 5), mpf(0))
        for i in range(stages):
            f, J = slope_of(omega, start + sum(mu[i][j] * L[j] for j in range(stages)))
            own = slice(4 * i, 4 * i + 4)
            lack[own, 0], lack[own, 1:] = L[i] - H * b[i] * f, H * b[i] * J
            for j in range(stages):
                matrix[own, 4 * j : 4 * j + 4] -= H * b[i] * mu[i][j] * J
        found = eliminated(matrix, lack).reshape(stages, 4, 5)
        L = L - found[:, :, 0]
        if np.abs(found[:, :, 0]).max() < mpf(10) ** -30:
            return start + L.sum(axis=0), np.eye(4) + found[:, :, 1:].sum(axis=0)
    raise AssertionError("no solution there")


@LONG
@pytest.mark.parametrize(
    ("omega", "h", "stages"),
    [pytest.param(*c, marks=[pytest.mark.nightly] * (c not in FAST)) for c in CASES],
)
def test_steps_and_their_derivatives(omega: float, h: float, stages: int) -> None:
    """Of lengths some roundings are lost, of speeds those over the step; of derivatives (h ω)²."""
    of, method = spring_pendulum.problem(omega), gi.Gauss(stages)
    motion = gi.Integrator(of, AT_REST, method, step=h, compiled=False)
    motion.step()
    exact, slopes = step(omega, stages, AT_REST, h, increments(motion.stepper, stages))
    rounding = 2.0**-52 * np.array([1.0, 1.0, 1.0 / h, 1.0 / h])
    assert np.abs((exact - motion.state).astype(float) / rounding).max() < 4096.0
    found = gi.tangent_flow(of, AT_REST, t_end=h, step=h, method=method)
    wanted = slopes.astype(float)
    off = 2.0**-52 * (64.0 + (h * omega) ** 2) * np.abs(wanted).max()
    np.testing.assert_allclose(found.slopes, wanted, rtol=0.0, atol=off)
    np.testing.assert_allclose(found.y, motion.state, rtol=0.0, atol=64.0 * rounding.max())
    longer = gi.tangent_flow(
        of, AT_REST, t_end=h, step=h, method=method, directions=np.diag(LENGTHS)
    )
    np.testing.assert_array_equal(longer.slopes / LENGTHS, found.slopes)


@gi.field
def chain(params, t, y, out, work):
    """Masses on a line, stiff springs between them, each bound to its place by a cubic one."""
    n = len(y) // 2
    for i in range(n):
        out[i] = 1.0 * y[n + i]
        pull = -y[i] * y[i] * y[i]
        if i > 0:
            pull = pull + params[0] * (y[i - 1] - y[i])
        if i + 1 < n:
            pull = pull + params[0] * (y[i + 1] - y[i])
        out[n + i] = pull


@LONG
def test_more_unknowns_than_a_matrix_holds() -> None:
    """One Jacobian for all stages serves, and derivatives are symplectic: ω(Du, Dv) = ω(u, v)."""
    n = 65
    of = gi.Problem(name="chain", pieces=(("q", n), ("p", n)), field=chain, params=[1e6])
    rng = np.random.default_rng(0)
    y, D = 0.01 * rng.normal(size=2 * n), rng.normal(size=(2 * n, 2))
    found = gi.tangent_flow(of, y, t_end=0.1, step=0.02, method="gauss-8", directions=D)
    with pytest.raises(gi.ConvergenceError):
        gi.solve(of, y, t_end=0.1, step=0.02, method=gi.Gauss(8, iteration="fixed-point"))

    def area(u: Array, v: Array) -> float:
        return float(u[:n] @ v[n:] - u[n:] @ v[:n])

    size = np.prod(np.linalg.norm(found.slopes, axis=0))
    assert abs(area(*found.slopes.T) - area(*D.T)) < 1e-13 * size
    ends = [gi.solve(of, y + d * D[:, 0], t_end=0.1, step=0.02).y[-1] for d in (1e-5, -1e-5)]
    differences = (ends[0] - ends[1]) / 2e-5
    size = np.abs(differences).max()
    np.testing.assert_allclose(found.slopes[:, 0], differences, rtol=0.0, atol=1e-7 * size)
