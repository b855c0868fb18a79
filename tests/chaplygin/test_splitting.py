"""The splitting of the Hamiltonised sphere: exact flows of its parts, singular cases, long runs."""

import dataclasses
import math

import numpy as np
import pytest
from numba.core import types

import chaplygin as ch
import geomint as gi
from chaplygin.ball.hamiltonized_splitting import dilation_coefficients, splitting_rows
from chaplygin.integrable import special_rows
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.compiling.recorded import Recorded
from geomint.kernels.numbers.blocks import Block, as_lanes, scalar_block
from tests.chaplygin.support import (
    CASES,
    DIMENSIONS,
    extended,
    mp,
    quiet_state,
    random_special,
    random_tangent,
)

EPSILON = 2.0**-52
each_n = pytest.mark.parametrize("n", DIMENSIONS)


def case(n, seed=0):
    """A problem and a random admissible state."""
    gamma, p = random_tangent(n, seed)
    problem = ch.hamiltonized_problem(random_special(n, seed))
    return problem, quiet_state(problem, gamma=gamma, p_tilde=p)


def flow(problem, k, h, y):
    """φ_k(y) − y over h, in float64 or, for object arrays, in mpmath numbers."""
    long = y.dtype == object
    zeros = extended(np.zeros(len(y))) if long else np.zeros(len(y))
    out = Block(zeros)
    params = Block(extended(problem.params) if long else problem.params)
    t, h = (mp.mpf(0), mp.mpf(h)) if long else (np.float64(0.0), np.float64(h))
    problem.splitting.flow(k, params, t, h, Block(y), out, Block(zeros[:0]))
    return out.data


def hamiltonian(problem, k, y):
    """The Hamiltonian of part k by its definition, from the problem's own params."""
    n = len(y) // 2
    rows = splitting_rows(n)
    own = gi.section(Block(problem.params), special_rows(n, sum(rows)), "splitting")
    g, p = y[:n], y[n:]
    part, rho, mu = (gi.section(own, rows, name)[k] for name in ("part", "rho", "mu"))
    if int(part) == n:
        return gi.section(own, rows, "kappa")[0] * (p @ p) / 2
    axis = part
    rest = [j for j in range(n) if j != int(axis)]
    squares = sum(
        (g[i] * p[j] - g[j] * p[i]) ** 2 for at, i in enumerate(rest) for j in rest[at + 1 :]
    )
    return (rho * squares - mu * p[int(axis)] ** 2) / 2


def hamiltonian_field(problem, k, y):
    """Hamilton's equations of part k on T*S^(n−1), by differences with 40 digits."""
    n, h = len(y) // 2, mp.mpf("1e-15")
    y = extended(y)
    slopes = []
    for i in range(2 * n):
        e = extended(np.eye(2 * n)[i])
        above, below = (hamiltonian(problem, k, y + s * h * e) for s in (1, -1))
        slopes.append((above - below) / (2 * h))
    g, p = y[:n], y[n:]
    eta, xi = np.array(slopes[:n], dtype=object), np.array(slopes[n:], dtype=object)
    mu, lam = g @ xi, g @ eta - p @ xi
    return np.concatenate([xi - mu * g, -eta + lam * g + mu * p]).astype(float)


def on_manifold(y):
    """The state moved to the manifold, to 40 digits."""
    n = len(y) // 2
    g, p = extended(y[:n]), extended(y[n:])
    g = g / mp.sqrt(g @ g)
    return np.concatenate([g, p - (g @ p) * g])


# --- the parts ------------------------------------------------------------------------------------


@each_n
@pytest.mark.parametrize("seed", range(3))
def test_parts_sum_to_the_hamiltonian(n, seed):
    problem, y = case(n, seed)
    assert problem.splitting.parts == n
    total = sum(hamiltonian(problem, k, y) for k in range(n))
    energy = gi.value(problem, problem.invariants["energy"], y)
    size = sum(abs(hamiltonian(problem, k, y)) for k in range(n))
    assert abs(total - energy) <= 1e-14 * size
    assert size > 0.01


@each_n
def test_parts_sum_to_the_field(n):
    problem, y = case(n)
    only = dataclasses.replace(problem, field=None, hamiltonian=None)
    np.testing.assert_allclose(gi.derivative(only, y), gi.derivative(problem, y), atol=1e-4)


@each_n
def test_flows_begin_as_hamiltons_equations(n):
    """With 40 digits, a central difference in time."""
    problem, y = case(n)
    y = on_manifold(y)
    for k in range(n):
        h = mp.mpf("1e-9")
        rate = (flow(problem, k, h, y) - flow(problem, k, -h, y)) / (2 * h)
        expected = hamiltonian_field(problem, k, y)
        np.testing.assert_allclose(rate.astype(float), expected, rtol=0, atol=1e-14)
        assert np.max(np.abs(expected)) > 1e-3


@pytest.mark.parametrize("n", [2, 3, 5])
@pytest.mark.parametrize("size", [0.1, 3.0, 40.0])
def test_flows_are_flows(n, size):
    """φ(s + t) = φ(s) φ(t): with the equations at 0, the parts are solved exactly."""
    problem, y = case(n, 1)
    y = on_manifold(y)
    for k in range(n):
        h = size / float(np.max(np.abs(hamiltonian_field(problem, k, y))))
        steps = 64 if size > 1 else 1
        z = y
        for _ in range(steps):
            z = z + flow(problem, k, mp.mpf(h) / (2 * steps), z)
        half = y + flow(problem, k, mp.mpf(h) / 2, y)
        np.testing.assert_allclose(
            half.astype(float), z.astype(float), rtol=1e-15, atol=1e-11 * size
        )
        whole = half + flow(problem, k, mp.mpf(h) / 2, half)
        direct = y + flow(problem, k, h, y)
        scale = float(max(abs(direct)))
        np.testing.assert_allclose(
            direct.astype(float), whole.astype(float), rtol=0, atol=1e-13 * size * scale
        )
        assert float(max(abs(whole - y))) > 0.02


def special_states(n):
    """States where a formula could fail: poles, equators, meridians, no momentum."""
    e, f = np.eye(n)[0], np.eye(n)[1]
    slanted = np.full(n, 1 / math.sqrt(n))
    near = np.cos(1e-9) * e + np.sin(1e-9) * f
    across = np.sin(1e-9) * e - np.cos(1e-9) * f
    tangent = e - slanted * (e @ slanted)
    return {
        "pole": np.concatenate([e, f]),
        "opposite pole": np.concatenate([-e, -2 * f]),
        "equator, along the axis": np.concatenate([f, e]),
        "near a pole": np.concatenate([near, across]),
        "meridian": np.concatenate([slanted, tangent]),
        "no momentum": np.concatenate([slanted, np.zeros(n)]),
        "tiny momentum": np.concatenate([slanted, 1e-170 * tangent]),
    }


@each_n
@pytest.mark.parametrize("name", special_states(3))
def test_singular_cases(n, name):
    """In float64 the flows are those of 40 digits, finite, and on the manifold to rounding."""
    problem, _ = case(n)
    y = special_states(n)[name]
    for k in range(n):
        for h in (1e-12, 0.02, 0.7, -0.3):
            found = y + flow(problem, k, h, y)
            exact = y + flow(problem, k, h, on_manifold(y)).astype(float)
            scale = np.repeat([1.0, max(np.max(np.abs(exact[n:])), 1e-300)], n)
            np.testing.assert_allclose(found / scale, exact / scale, rtol=0, atol=2e-14)
            g, p = found[:n], found[n:]
            assert abs(g @ g - 1) < 8 * EPSILON * (1 + abs(h) * np.max(np.abs(y[n:])))
            assert abs(g @ p) <= 32 * EPSILON * max(np.max(np.abs(p)), 1e-300)


def test_dilation_coefficients():
    """sinh and cosh − 1, small and large, to relative accuracy."""
    for s in (0.0, 1e-200, -1e-9, 0.1, 0.4999999, 0.5, -0.7, 5.0, 60.0, -300.0):
        sinh, excess = dilation_coefficients(np.float64(s))
        exact = mp.sinh(mp.mpf(s)), 2 * mp.sinh(mp.mpf(s) / 2) ** 2
        for found, truth in zip((sinh, excess), exact, strict=True):
            assert abs(found - truth) <= EPSILON * (3 + 2 * abs(s)) * abs(truth) + 1e-320


@pytest.mark.parametrize("kind", [SCALAR, LANE], ids=str)
def test_flows_compile_to_the_same_bits(kind):
    """For numbers and lanes, lanes in which only some dilations are large included."""
    problem = next(c for c in CASES if c.label == "hamiltonized-special-n3").problem
    y = next(c for c in CASES if c.label == "hamiltonized-special-n3").y
    function, parts = problem.splitting.flow, problem.splitting.parts

    def call(params, y, out, work):
        rows = len(y)
        for k in range(parts):
            zero = 0.0 * y[0]
            function(k, params, zero, 0.4 + zero, y, gi.part(out, k * rows, rows), work)

    def block(values):
        if kind is SCALAR:
            made = scalar_block(len(values))
            made.data[:] = values
        else:
            made = as_lanes(scalar_block(8 * len(values)), 0, len(values))
            made.data[:] = np.outer(values, np.ones(8))
            made.data[3:] *= 2.0 ** np.arange(8) if np.any(values) else 1.0
        return made

    recorded = Recorded(call)
    signature = types.void(SCALAR.block, kind.block, kind.block, kind.block)
    params = scalar_block(len(problem.params))
    params.data[:] = problem.params
    results = []
    for run in (recorded, compile_function(recorded, signature)):
        out = block(np.zeros(6 * parts))
        run(params, block(y), out, block(np.zeros(0)) if kind is SCALAR else block(np.zeros(1)))
        results.append(np.array(out.data))
    assert np.isfinite(results[0]).all()
    np.testing.assert_array_equal(results[0], results[1])


# --- the method -----------------------------------------------------------------------------------


def sphere(n):
    a = [0.8, 1.1, 1.5] if n == 3 else np.linspace(0.8, 1.5, n)
    problem = ch.ChaplyginSphere(a=a, D=4.0).hamiltonized()
    gamma, p = random_tangent(n, 4)
    return problem, problem.state(gamma=gamma, p_tilde=0.5 * p / np.linalg.norm(p))


@pytest.mark.parametrize("n", [2, 3, 5])
@pytest.mark.parametrize(
    ("name", "counts"), [("verlet-2", (64, 128, 256)), ("verlet-4", (16, 23, 32))]
)
def test_orders(n, name, counts):
    """Two-sided, the state and physical time beside it."""
    problem, y0 = sphere(n)
    order = int(name[-1])
    kwargs = {"tau_end": 2.0, "save_every": 10**6}

    def end(method, steps):
        sol = gi.solve(problem, y0, step=2.0 / steps, method=method, **kwargs)
        return np.append(sol.y[-1], sol.t[-1])

    exact = end("gauss-8", 64)
    errors = [abs(end(name, steps) - exact) for steps in counts]
    for part in (slice(0, -1), slice(-1, None)):
        sizes = [np.max(e[part]) for e in errors]
        assert 1e-13 < sizes[-1] < 1e-3
        found = np.diff(np.log(sizes)) / -np.diff(np.log(counts))
        assert found == pytest.approx([order] * 2, abs=0.2)


@pytest.mark.parametrize("n", [3, 5])
@pytest.mark.parametrize(("name", "h"), [("verlet-2", 0.02), ("verlet-4", 0.1), ("verlet-8", 0.3)])
def test_long_runs(n, name, h):
    """Constraints to round-off, the energy bounded; K is bounded too, but not kept."""
    problem, y0 = sphere(n)
    names = ["energy", "K", "norm", "tangency"]
    sol = gi.solve(problem, y0, tau_end=h * 20000, step=h, method=name, observe=names)
    for quantity in ("norm", "tangency"):
        assert sol.drift[quantity].max_abs_error <= 8 * EPSILON, sol.drift[quantity]
    for quantity, size in (("energy", 1e-4), ("K", 1e-3)):
        drift = sol.drift[quantity]
        assert drift.drift_class in ("bounded", "sqrt", "roundoff"), drift
        assert drift.max_abs_error < size
    if name != "verlet-8":
        assert sol.drift["K"].max_abs_error > 1e-9


@pytest.mark.nightly
def test_a_million_steps():
    """No slope of the energy or of the constraints."""
    problem, y0 = sphere(3)
    names = ["energy", "norm", "tangency"]
    sol = gi.solve(problem, y0, tau_end=2e4, step=0.02, method="verlet-2", observe=names)
    assert sol.steps == 10**6
    for drift in sol.drift.values():
        assert abs(drift.slope) <= 5 * drift.slope_stderr, drift
    assert sol.drift["energy"].drift_class == "bounded"


@pytest.mark.parametrize("scale", [1e-150, 1e-8, 1e8, 1e140])
def test_any_scale_of_momenta(scale):
    """A geodesic flow: the same path for momenta of any size, in steps of the inverse size."""
    problem, y0 = sphere(3)
    factors = np.repeat([1.0, scale], 3)
    once = gi.solve(problem, y0, tau_end=5.0, step=0.05, method="verlet-4").y[-1]
    again = gi.solve(
        problem, y0 * factors, tau_end=5.0 / scale, step=0.05 / scale, method="verlet-4"
    ).y[-1]
    np.testing.assert_allclose(again / factors, once, rtol=0, atol=1e-13)


@pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")
def test_a_step_far_too_large():
    """The flows exist for any time: a bad answer on the manifold, or a typed error."""
    problem, y0 = sphere(3)
    sol = gi.solve(problem, y0, tau_end=2.0, step=2.0, method="verlet-2", observe="constraints")
    assert all(drift.max_abs_error < 1e-13 for drift in sol.drift.values())
    with pytest.raises(gi.NonFiniteError, match="too large"):
        gi.solve(problem, y0, tau_end=1e7, step=1e6, method="verlet-2")
