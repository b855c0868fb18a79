"""The splitting of the Hamiltonised sphere: exact flows of its parts, singular cases, long runs."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from tests.chaplygin.support import (
    dimensions,
    extended,
    like,
    mp,
    quiet_state,
    random_special,
    random_tangent,
    rng_for,
    seeds,
)
from tests.rows import examples

EPSILON = 2.0**-52


def case(n, seed=0):
    """A problem and a random admissible state."""
    gamma, p = random_tangent(n, seed)
    problem = ch.hamiltonized_problem(random_special(n, seed))
    return problem, quiet_state(problem, gamma=gamma, p_tilde=p)


def flow(problem, k, h, y):
    """φ_k(y) − y over h, in float64 or, for object arrays, in mpmath numbers."""
    out, work = like(y, np.zeros(len(y))), like(y, [])
    time, h = (mp.mpf(0), mp.mpf(h)) if y.dtype == object else (np.float64(0.0), np.float64(h))
    problem.splitting.flow(k, like(y, problem.params), time, h, y.copy().view(type(out)), out, work)
    return out.view(np.ndarray)


def on_manifold(y):
    """The state moved to the manifold, to 40 digits."""
    n = len(y) // 2
    g, p = extended(y[:n]), extended(y[n:])
    g = g / mp.sqrt(g @ g)
    return np.concatenate([g, p - (g @ p) * g])


# --- the parts, whose sum is the field: `test_problems.py` ----------------------------------------


@given(dimensions, st.sampled_from([0.1, 3.0, 40.0]), seeds)
@examples(6)
def test_flows_are_flows(n, size, seed):
    """φ(s + t) = φ(s) φ(t), in steps that are so small that all of their series converge at once."""
    problem, y = case(n, seed)
    y = on_manifold(y)
    for k in range(n):
        rate = flow(problem, k, 1e-12, y) / mp.mpf(1e-12)
        h = size / float(max(abs(rate)))
        steps, z = 64 if size > 1 else 1, y
        for _ in range(steps):
            z = z + flow(problem, k, mp.mpf(h) / (2 * steps), z)
        half = y + flow(problem, k, mp.mpf(h) / 2, y)
        scale = float(max(abs(half)))
        np.testing.assert_allclose(
            half.astype(float), z.astype(float), rtol=1e-15, atol=1e-11 * size * scale
        )
        whole, direct = half + flow(problem, k, mp.mpf(h) / 2, half), y + flow(problem, k, h, y)
        scale = float(max(abs(direct)))
        np.testing.assert_allclose(
            direct.astype(float), whole.astype(float), rtol=0, atol=1e-13 * size * scale
        )
        assert float(max(abs(whole - y))) > 0.02


@given(dimensions, seeds)
@examples(6)
def test_flows_are_symplectic(n, seed):
    """Of vectors that move along, u_γ v_p − u_p v_γ stays; with the sum of the parts, each is right."""
    problem, y = case(n, seed)
    y, rng, h = on_manifold(y), rng_for(n, seed), mp.mpf("1e-12")
    ends = []
    for vector in rng.normal(size=(2, 2 * n)):
        off = [on_manifold(y + s * h * extended(vector)) for s in (1, -1)]
        ends.append([off, (off[0] - off[1]) / (2 * h)])

    def form(u, v):
        return float(u[:n] @ v[n:] - u[n:] @ v[:n])

    expected = form(ends[0][1], ends[1][1])
    for k in range(n):
        moved = [[z + flow(problem, k, 0.7, z) for z in off] for off, _ in ends]
        u, v = ((plus - minus) / (2 * h) for plus, minus in moved)
        assert form(u, v) == pytest.approx(expected, rel=1e-12, abs=1e-12)
        assert abs(form(u, ends[1][1]) - expected) > 1e-6  # what does not move along


def special_states(n):
    """States where a formula could fail: poles, equators, meridians, no momentum."""
    e, f = np.eye(n)[0], np.eye(n)[1]
    slanted = np.full(n, 1 / np.sqrt(n))
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


@pytest.mark.parametrize("name", special_states(3))
@given(n=dimensions, h=st.floats(-12.0, 1.0).map(lambda power: 10.0**power), back=st.booleans())
@examples(4)
def test_singular_cases(name, n, h, back):
    """In float64 the flows are those of 40 digits, finite, and on the manifold to rounding."""
    problem, y = case(n)[0], special_states(n)[name]
    for k in range(n):
        step = -h if back else h
        found = y + flow(problem, k, step, y)
        exact = y + flow(problem, k, step, on_manifold(y)).astype(float)
        size = max(np.max(np.abs(exact[n:])), 1e-300)
        allowed = 2e-14 * (1 + 2 * h * size)
        scale = np.repeat([1.0, size], n)
        np.testing.assert_allclose(found / scale, exact / scale, rtol=0, atol=allowed)
        g, p = found[:n], found[n:]
        assert abs(g @ g - 1) < 8 * EPSILON * (1 + h * np.max(np.abs(y[n:])))
        assert abs(g @ p) <= 32 * EPSILON * max(np.max(np.abs(p)), 1e-300)


# --- the method -----------------------------------------------------------------------------------


SPHERE = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
OBSERVED = ["energy", "K", "norm", "tangency"]
Y0 = SPHERE.state(gamma=[0.6, 0.48, 0.64], p_tilde=[0.3, -0.2, -0.13125])


@pytest.mark.parametrize(
    ("name", "counts"), [("verlet-2", (64, 128, 256)), ("verlet-4", (16, 23, 32))]
)
def test_orders(name, counts):
    """Two-sided, the state and physical time beside it, against the exact flow."""
    exact = SPHERE.exact(Y0)
    truth, order = np.append(exact.at_tau(2.0), exact.time(2.0)), int(name[-1])
    errors = []
    for steps in counts:
        sol = gi.solve(SPHERE, Y0, tau_end=2.0, step=2.0 / steps, method=name, compiled=False)
        errors.append(abs(np.append(sol.y[-1], sol.t[-1]) - truth))
    for part in (slice(0, -1), slice(-1, None)):
        sizes = [np.max(e[part]) for e in errors]
        assert 1e-13 < sizes[-1] < 1e-3
        found = np.diff(np.log(sizes)) / -np.diff(np.log(counts))
        assert found == pytest.approx([order] * 2, abs=0.2)


@pytest.mark.parametrize(
    ("name", "h"), [("verlet-2", 0.02), pytest.param("verlet-8", 0.3, marks=pytest.mark.nightly)]
)
def test_long_runs(name, h):
    """Constraints to round-off, the energy bounded; K is bounded too, but not kept."""
    sol = gi.solve(SPHERE, Y0, tau_end=h * 20000, step=h, method=name, observe=OBSERVED)
    for quantity in ("norm", "tangency"):
        assert sol.drift[quantity].max_abs_error <= 8 * EPSILON, sol.drift[quantity]
    for quantity, size in (("energy", 1e-4), ("K", 1e-3)):
        drift = sol.drift[quantity]
        assert drift.drift_class in ("bounded", "sqrt", "roundoff"), drift
        assert drift.max_abs_error < size
    if name != "verlet-8":
        assert sol.drift["K"].max_abs_error > 1e-9


@pytest.mark.parametrize("scale", [1e-150, 1e140])
def test_any_scale_of_momenta(scale):
    """A geodesic flow: the same path for momenta of any size, in steps of the inverse size."""
    factors, run = np.repeat([1.0, scale], 3), {"method": "verlet-2", "compiled": False}
    once = gi.solve(SPHERE, Y0, tau_end=0.5, step=0.05, **run).y[-1]
    again = gi.solve(SPHERE, Y0 * factors, tau_end=0.5 / scale, step=0.05 / scale, **run).y[-1]
    np.testing.assert_allclose(again / factors, once, rtol=0, atol=1e-13)


@pytest.mark.filterwarnings("ignore:.*steps of .* are so long:geomint.GeomintWarning")
def test_compiled_steps_have_the_bits_of_plain_python():
    """For small dilations and large ones."""
    run = {"tau_end": 1.2, "step": 0.4, "method": "verlet-2", "observe": OBSERVED}
    for factor in (0.5, 5.0):
        y0 = np.append(Y0[:3], factor * Y0[3:])
        ends = [gi.solve(SPHERE, y0, **run, compiled=c).y[-1] for c in (True, False)]
        np.testing.assert_array_equal(*ends)


@pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")
def test_a_step_far_too_large():
    """The flows exist for any time: a bad answer on the manifold, or a typed error."""
    run = {"step": 2.0, "method": "verlet-2", "observe": "constraints"}
    sol = gi.solve(SPHERE, Y0, tau_end=2.0, **run, compiled=False)
    assert all(drift.max_abs_error < 1e-13 for drift in sol.drift.values())
    with pytest.raises(gi.NonFiniteError, match="too large"):
        gi.solve(SPHERE, Y0, tau_end=1e8, step=1e7, method="verlet-2", compiled=False)
