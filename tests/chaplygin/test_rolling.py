"""The rolling ball with multipliers, (g, r, ω, v), and with reconstructed contact, (k, γ, g, r)."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from chaplygin.manifold import (
    skew_matrix,
    triangle_of_vector,
    vector_of_triangle,
    wedge,
)
from tests.chaplygin.rolling_support import RHO, ball, both, pieces, start
from tests.chaplygin.support import (
    acted,
    extended,
    field_of,
    generator_of,
    mp,
    quiet_state,
    random_diagonal,
    random_full,
    random_special,
    rate,
    rng_for,
    value_of,
)

EACH_N = pytest.mark.parametrize("n", range(2, 7))
EACH_INERTIA = pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])


def close(x, y, size=1.0):
    np.testing.assert_allclose(np.array(x, float), np.array(y, float), rtol=0, atol=4e-14 * size)


def reaction(problem, y):
    n = len(pieces(problem, y)["r"]) + 1
    return np.array([float(value_of(problem, f"reaction-{i}", y)) for i in range(1, n)])


def skew(flat, n):
    """Return the matrix of a flat triangle, also of extended numbers."""
    x = np.zeros((n, n), dtype=np.asarray(flat).dtype)
    x[np.triu_indices(n, 1)] = flat
    return x - x.T


def exact(matrix):
    """Return a matrix as one of extended numbers."""
    return extended(matrix.reshape(-1)).reshape(matrix.shape)


def lagrange_d_alembert(inertia, m, rho, g, omega):
    """Solve the Lagrange–d'Alembert equations, eq. (Hamilton), for (ω̇, V̇, Λ), V and Λ in R^n.

    In the coordinates x of g exp(x), around x = 0, where ω = ẋ − [x, ẋ]/2 + …, from nothing but
    the Lagrangian, eq. (ch-lagr), and the constraint, eq. (ch-constr). Their derivatives are
    differences in 40 digits.
    """
    n, size = len(g), len(omega)
    matrix = np.diag(inertia.diagonal) if inertia.diagonal is not None else inertia.matrix
    entries, w, h = exact(matrix), extended(omega), mp.mpf("1e-13")
    g, unit = exact(g), exact(np.eye(size))

    def velocity(x, dx):
        X, Y = skew(x, n), skew(dx, n)
        return Y - (X @ Y - Y @ X) / 2

    def kinetic(x, dx):
        flat = velocity(x, dx)[np.triu_indices(n, 1)]
        return flat @ (entries @ flat) / 2

    def travel(x, dx):
        """ρΩE_n."""
        X = skew(x, n)
        R = g @ (exact(np.eye(n)) + X + X @ X / 2)
        return rho * (R @ (velocity(x, dx) @ R[-1]))

    def slope(f, direction):
        return (f(direction * h) - f(-direction * h)) / (2 * h)

    zero = 0 * w
    force = [
        slope(lambda x: kinetic(x, w), e)
        - slope(lambda s, e=e: slope(lambda v: kinetic(s, w + v), e), w)  # along x = s
        for e in unit
    ]
    J = np.array([-slope(lambda v: travel(zero, w + v), e) for e in unit], float).T
    bias = np.array(slope(lambda x: travel(x, w), w), float)
    one, none = np.eye(n), np.zeros((size, n))
    equations = np.block(
        [[matrix, none, -J.T], [none.T, m * one, -one], [J, one, np.zeros((n, n))]]
    )
    right = np.concatenate([np.array(force, float), np.zeros(n), bias])
    return np.split(np.linalg.solve(equations, right), [size, size + n])


@EACH_N
@EACH_INERTIA
def test_field_and_reaction_are_lagrange_d_alembert(make, n):
    inertia, m, _ = ball(make, n)
    problems, states = both(make, n)
    given = start(n)
    dw, dv, force = lagrange_d_alembert(inertia, m, RHO, given["g"], given["omega"])
    size = 1e2 * max(1.0, np.max(np.abs(dw)), np.max(np.abs(force)))
    found = pieces(problems[0], field_of(problems[0], states[0]))
    close(found["omega"], dw, size)
    close(found["v"], dv[:-1], size)
    close([dv[-1], force[-1]], [0.0, 0.0], size)
    for problem, y in zip(problems, states, strict=True):
        close(reaction(problem, y), force[:-1], size)
    full = skew_matrix(given["omega"], n)
    close(found["g"].reshape(n, n), given["g"] @ full, 10)
    close(found["r"], (RHO * given["g"] @ full @ given["g"].T)[:-1, -1], 10)


@EACH_N
@EACH_INERTIA
def test_slip_is_constant_along_the_field(make, n):
    """The multipliers keep v − ρ gωγ, also where it is not zero; so the ball that rolls rolls on."""
    (problem, _), (y, _) = both(make, n)
    y = extended(y)
    y[problem.slices["v"]] += extended(rng_for(n, 3).normal(size=n - 1))
    assert value_of(problem, "rolling", y) > 0.1
    assert abs(rate(problem, "rolling", y, field_of(problem, y))) < 1e-20
    assert abs(rate(problem, "rolling", y, extended(rng_for(n, 4).normal(size=len(y))))) > 1e-4


@EACH_N
@EACH_INERTIA
def test_momentum_moves_as_that_of_the_ball(make, n):
    """ω ↦ k takes the field to k̇ = [k, ω], γ̇ = −ωγ: both forms against the reduced problem."""
    inertia, _, D = ball(make, n)
    (rolling, contact), (y, z) = both(make, n)
    reduced = ch.ball_problem(inertia, D, attitude=True)
    part, rates = pieces(rolling, y), pieces(rolling, field_of(rolling, y))
    physical = rolling.physical_state(y)
    b = quiet_state(reduced, g=part["g"], **physical)
    expected = pieces(reduced, field_of(reduced, b))
    gamma, dgamma = physical["gamma"], rates["g"][-n:]
    w, dw = skew_matrix(part["omega"], n), skew_matrix(rates["omega"], n)
    moved = wedge(dw @ gamma + w @ dgamma, gamma) + wedge(w @ gamma, dgamma)
    size = 100 * max(1.0, np.max(np.abs(expected["k"])))
    close(inertia.apply(rates["omega"]) + D * moved, expected["k"], size)
    close(dgamma, expected["gamma"], 100)
    close(rates["g"], expected["g"], 100)
    found = pieces(contact, field_of(contact, z))
    for name in ("k", "gamma", "g"):
        close(found[name], expected[name], size)
    close(found["r"], rates["r"], 100)


@EACH_N
@EACH_INERTIA
def test_diagnostics_agree_and_are_constant(make, n):
    """|Ad_g k − k_0| is evaluated with another k_0: it has no derivative at zero."""
    problems, states = both(make, n, k0=np.zeros(n * (n - 1) // 2))
    common = set(problems[0].diagnostics) & set(problems[1].diagnostics)
    assert {"energy", "K", "spatial-momentum", "reaction-1", "contact-1", "power"} <= common
    assert ("momentum" in common) == ("pivoting" in common) == (n > 2)
    assert ("trace-k4" in common) == (n > 3)
    for name in common:
        found, expected = (
            float(value_of(q, name, y)) for q, y in zip(problems, states, strict=True)
        )
        close(found, expected, 100 * max(1.0, abs(expected)))
    for problem, y in zip(problems, states, strict=True):
        velocity = field_of(problem, extended(y))
        for name in {*problem.invariants, "spatial-momentum"}:
            size = max(1.0, float(value_of(problem, name, y)))
            assert abs(rate(problem, name, y, velocity)) < 4e-14 * size, name
        for name in problem.constraints:
            if name != "spatial-momentum":
                assert abs(value_of(problem, name, y)) < 1e-14, name


@EACH_N
def test_constraints_measure_how_much_is_wrong(n):
    (rolling, contact), (y, z) = both(random_special, n)
    move = rng_for(n, 5).normal(size=n)
    z[contact.slices["gamma"]] += move
    assert value_of(contact, "vertical", z) == pytest.approx(np.sqrt(move @ move), rel=1e-13)
    y[rolling.slices["v"]] += move[1:]
    slip = np.sqrt(move[1:] @ move[1:])
    assert value_of(rolling, "rolling", y) == pytest.approx(slip, rel=1e-12)
    for problem, state in ((rolling, y), (contact, z)):
        state[problem.slices["g"]] *= 1.01
        assert value_of(problem, "orthogonality", state) == pytest.approx(0.0201 * np.sqrt(n))


@EACH_N
def test_energy_off_the_constraint_is_kinetic_energy(n):
    """½⟨Iω, ω⟩ + ½m(v, v), eq. (ch-lagr), whatever v is; ½⟨k, ω⟩ where the ball rolls."""
    inertia, m, _ = ball(random_full, n)
    (rolling, _), (y, _) = both(random_full, n)
    part = pieces(rolling, y)
    k = rolling.physical_state(y)["k"]
    assert value_of(rolling, "energy", y) == pytest.approx(0.5 * k @ part["omega"], rel=1e-13)
    part["v"][:] = rng_for(n, 1).normal(size=n - 1)
    turning = 0.5 * part["omega"] @ inertia.apply(part["omega"])
    expected = turning + 0.5 * m * part["v"] @ part["v"]
    assert value_of(rolling, "energy", y) == pytest.approx(expected, rel=1e-13)


@EACH_N
def test_observables_are_what_they_say(n):
    (rolling, contact), (y, z) = both(random_diagonal, n)
    part, rates = pieces(rolling, y), pieces(rolling, field_of(rolling, y))
    force, w = reaction(rolling, y), skew_matrix(part["omega"], n)
    gamma = part["g"][-n:]
    expected = {
        "reaction": np.sqrt(force @ force),
        "power": force @ part["v"],
        "speed": np.sqrt(part["v"] @ part["v"]),
        **{f"contact-{i + 1}": part["r"][i] for i in range(n - 1)},
    }
    if n > 2:
        rest = w - np.outer(w @ gamma, gamma) + np.outer(gamma, w @ gamma)
        expected["pivoting"] = np.sqrt(0.5 * np.sum(rest * rest))
    assert set(expected) | {f"reaction-{i}" for i in range(1, n)} == set(rolling.observables)
    for name, value in expected.items():
        close(value_of(rolling, name, y), value, 100)
        close(value_of(contact, name, z), value, 100)
    inertia, m, _ = ball(random_diagonal, n)
    close(m * part["v"] @ rates["v"], value_of(rolling, "power", y), 100)
    close(-part["omega"] @ inertia.apply(rates["omega"]), value_of(rolling, "power", y), 100)


@EACH_INERTIA
@pytest.mark.parametrize("seed", range(4))
def test_classical_vectors(make, seed):
    """n = 3 in space, by the hat map: M⃗˙ = −ρΓ⃗ × Λ⃗, mV⃗˙ = Λ⃗, V⃗ = ρ Ω⃗ × Γ⃗."""
    inertia, m, _ = ball(make, 3, seed)
    (rolling, _), (y, _) = both(make, 3, seed)
    part, rates = pieces(rolling, y), pieces(rolling, field_of(rolling, y))
    g, vertical = part["g"].reshape(3, 3), np.array([0.0, 0.0, 1.0])
    omega, domega = (vector_of_triangle(x["omega"]) for x in (part, rates))
    force = np.append(reaction(rolling, y), 0.0)
    close(np.append(part["v"], 0.0), RHO * np.cross(g @ omega, vertical), 10)
    close(m * np.append(rates["v"], 0.0), force, 100)
    momentum = vector_of_triangle(inertia.apply(part["omega"]))
    change = vector_of_triangle(inertia.apply(triangle_of_vector(domega)))
    in_space = g @ (change + np.cross(omega, momentum))
    close(in_space, np.cross(-RHO * vertical, force), 200 * max(1.0, np.max(np.abs(in_space))))
    spin = abs(omega @ (g.T @ vertical))
    assert value_of(rolling, "pivoting", y) == pytest.approx(spin, abs=1e-13)


@EACH_N
def test_action_is_the_field(n):
    problems, states = both(random_full, n, k0=rng_for(n, 8).normal(size=n * (n - 1) // 2))
    for problem, state in zip(problems, states, strict=True):
        y, h = extended(state), mp.mpf("1e-15")
        xi = generator_of(problem, y)
        above, below = (acted(problem, s * h * xi, y) for s in (1, -1))
        close((above - below) / (2 * h), field_of(problem, y), 100)
        moved = state + acted(problem, generator_of(problem, state), state)
        assert value_of(problem, "orthogonality", moved) < 1e-13
    moved -= 0.0  # of (k, γ, g, r): the momentum in space and the vertical stay as well
    for name in ("vertical", "spatial-momentum"):
        close(value_of(problem, name, moved), value_of(problem, name, state), 10)


def test_forms_arrive_at_the_same_state():
    """(g, r, ω, v), (k, γ, g, r) and the classical vectors, to 1e-11 after t = 20."""
    inertia, _, D = ball(random_diagonal, 3)
    (rolling, contact), (y, z) = both(random_diagonal, 3)
    vectors = ch.classical_problem(inertia, D)
    physical = rolling.physical_state(y)
    x = vectors.state(gamma=physical["gamma"], k=vector_of_triangle(physical["k"]))
    runs = [(rolling, y), (contact, z), (vectors, x)]
    ends = [gi.solve(q, s, t_end=20.0, method="gauss-8", step=0.1).y[-1] for q, s in runs]
    found, expected = pieces(rolling, ends[0]), pieces(contact, ends[1])
    for name in ("g", "r"):
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=1e-11)
    first, *others = [q.physical_state(s) for (q, _), s in zip(runs, ends, strict=True)]
    for state in others:
        for name in ("gamma", "k"):
            np.testing.assert_allclose(state[name], first[name], rtol=0, atol=1e-11)
    travelled = found["r"] - pieces(rolling, y)["r"]
    assert np.sqrt(travelled @ travelled) > 1.0


def largest(problem, y, method, step, *names):
    solution = gi.solve(problem, y, t_end=8.0, method=method, step=step, observe=list(names))
    return [solution.drift[name].max_abs_error for name in names]


@pytest.mark.parametrize(("method", "order"), [("gauss-1", 2), ("gauss-2", 4), ("rk-4", 4)])
def test_slip_is_lost_at_the_order_of_the_method(method, order):
    """It is cubic in (g, ω, v): Gauss keeps g gᵀ to round-off, but not the rolling constraint."""
    (rolling, _), (y, _) = both(random_diagonal, 3)
    steps = (0.08, 0.04)
    slips, defects = np.array(
        [largest(rolling, y, method, h, "rolling", "orthogonality") for h in steps]
    ).T
    assert slips[1] > 1e-12
    observed = np.log2(slips[0] / slips[1])
    assert order - 0.3 < observed < order + (1.2 if method == "rk-4" else 0.3)
    if method == "rk-4":
        assert defects[1] > 1e-12
    else:
        assert max(defects) < 1e-14


def test_eight_stages_keep_the_slip_to_round_off():
    (rolling, _), (y, _) = both(random_diagonal, 3)
    slip, defect, energy = largest(
        rolling, y, "gauss-8", 0.05, "rolling", "orthogonality", "energy"
    )
    assert max(slip, defect, energy) < 1e-14


def test_group_methods_keep_the_attitude_and_the_momentum_in_space():
    """cf-4 in both forms; in (g, r, ω, v) the momentum in space drifts, and the ball slips."""
    (rolling, _), (y, _) = both(random_diagonal, 3)
    g, k = y[:9].reshape(3, 3), skew_matrix(rolling.physical_state(y)["k"], 3)
    (rolling, contact), (y, z) = both(random_diagonal, 3, k0=g @ k @ g.T)
    names = ["orthogonality", "spatial-momentum"]
    assert max(largest(contact, z, "cf-4", 0.02, "vertical", "norm", "K", *names)) < 2e-14
    defect, momentum, slip = largest(rolling, y, "cf-4", 0.02, *names, "rolling")
    assert defect < 2e-14
    assert min(momentum, slip) > 1e-12


@EACH_N
def test_homogeneous_ball_rolls_straight_without_reaction(n):
    m, s = 1.7, 0.9
    sphere = ch.ChaplyginSphere.homogeneous(n, s, m * RHO * RHO)
    for problem in (sphere.rolling(m, RHO), sphere.contact(m, RHO)):
        y = problem.state(**start(n))
        assert np.max(np.abs(reaction(problem, y))) < 2e-14
        if "v" in problem.slices:
            rates = pieces(problem, field_of(problem, y))
            close([*rates["v"], *rates["omega"]], 0.0, 10)
            close(rates["r"], pieces(problem, y)["v"])


def test_homogeneous_ball_arrives_where_it_should():
    inertia = ch.GeneralInertia([0.9, 0.9, 0.9])
    problem = ch.rolling_problem(inertia, 1.7, RHO)
    y = problem.state(**start(3))
    end = gi.solve(problem, y, t_end=3.0, method="gauss-8", step=0.1).y[-1]
    first = pieces(problem, y)
    close(pieces(problem, end)["r"], first["r"] + 3.0 * first["v"], 10)


@EACH_INERTIA
@pytest.mark.parametrize("method", ["gauss-2", "cf-4"])
@pytest.mark.parametrize("which", [pytest.param(0, marks=pytest.mark.nightly), 1])
def test_compiled_is_plain_python(method, make, which):
    """Field in lanes, generator, and in one case each the diagnostics, bit for bit."""
    problems, states = both(make, 3, k0=np.ones(3))
    problem, y = problems[which], states[which]
    names = []
    if (method, make) == ("cf-4", random_diagonal):
        names = [["all"], ["vertical", "reaction-1", "speed"]][which]
    runs = [
        gi.solve(problem, y, t_end=0.05, method=method, step=0.01, observe=names, compiled=compiled)
        for compiled in (True, False)
    ]
    np.testing.assert_array_equal(runs[0].y, runs[1].y)
    for name in runs[0].drift:
        assert runs[0].drift[name].max_abs_error == runs[1].drift[name].max_abs_error, name
