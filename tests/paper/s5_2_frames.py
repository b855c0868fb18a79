"""Section 5.2, the Veselova problem on SO(n) and its reduction to the Stiefel variety V(n, r)."""

from __future__ import annotations

import numpy as np

from .algebra import Array, apply, bracket, coordinates, inner, null_space, rank, wedge
from .claim import Section, Sides
from .points import Point
from .stiefel import (
    admissible,
    constraint_forms,
    momentum_matrix,
    phi_r,
    rank_of,
    span,
    stiefel,
    stiefel_rates,
    veselova_motion,
)

__all__ = ["claim"]

claim = Section("5.2 Veselova problem on SO(n)", n=range(3, 7))


@claim("text:LR-lagrangian", "L = ½⟨𝓘w, w⟩ = −¼ tr(𝓘w w)", "1228–1232")
def lr_lagrangian(point: Point) -> Sides:
    w = point.omega
    moment = apply(point.general, w)
    return 0.5 * coordinates(moment) @ coordinates(w), -0.25 * np.trace(moment @ w)


@claim(
    "VC",
    "𝒟_r, 𝔡 = span{E_i∧E_j, i ≤ r}, is ⟨w, e_i∧e_j⟩ = 0, n − r + 1 ≤ i < j ≤ n",
    "1232–1241",
    misprint="r + 1 ≤ i < j ≤ n",
)
def vc(point: Point, corrected: bool) -> Sides:
    """Return the projections onto what the constraints leave, and onto 𝔡."""
    size = point.n * (point.n - 1) // 2

    def projection(rows: list[Array]) -> Array:
        flat = np.array([coordinates(X) for X in rows]).reshape(-1, size)
        return np.asarray(flat.T @ flat)

    body = [point.g.T @ X @ point.g for X in constraint_forms(point, printed=not corrected)]
    space = [point.g @ X @ point.g.T for X in body]
    return np.eye(size) - projection(space), projection(span(point))


@claim("text:w", "w(t) = g⁻¹·g(t) ∈ so(n)", "1243", misprint="w(t) = g⁻¹·ġ(t)")
def angular_velocity(point: Point, corrected: bool) -> Sides:
    g_dot = point.g @ point.omega
    w = point.g.T @ (g_dot if corrected else point.g)
    return w, -w.T


@claim(
    "text:frame",
    "e_i = g⁻¹E_i is an orthonormal frame, Ad_{g⁻¹}(E_i∧E_j) = e_i∧e_j",
    "1238–1249",
)
def frame(point: Point) -> Sides:
    E, e = np.eye(point.n), point.g.T
    left = [point.g.T @ wedge(E[0], E[1]) @ point.g, e.T @ e]
    return left, [wedge(e[:, 0], e[:, 1]), E]


@claim("PoissonV", "ė_i = −w e_i", "1251–1254")
def poisson(point: Point) -> Sides:
    w = admissible(point)
    return (point.g @ w).T, -w @ point.g.T


@claim(
    "VFK",
    "d/dt(𝓘w) = [𝓘w, w] + Σ λ_pq e_p∧e_q, n − r + 1 ≤ p < q ≤ n",
    "1256–1261",
    misprint="r + 1 ≤ p < q ≤ n",
    finding="VC",
)
def vfk(point: Point, corrected: bool) -> Sides:
    """Return what is left of the motion after the best λ_pq."""
    w, rate = veselova_motion(point)
    torque = apply(point.general, rate) - bracket(apply(point.general, w), w)
    forms = [point.g.T @ X @ point.g for X in constraint_forms(point, printed=not corrected)]
    return torque, sum((inner(torque, X) * X for X in forms), 0.0 * torque)


@claim(
    "text:n3",
    "n = 3, r = 2 is the Veselova problem (w⃗, γ⃗) = 0",
    "1263–1266",
    n=(3,),
    misprint="n = 3, r = 1, with γ⃗ = e_1",
    finding="VC",
)
def classical_case(point: Point, corrected: bool) -> Sides:
    """Return dim 𝔡 and (w⃗, e_1) for w in it; w⃗ = (w_32, w_13, w_21)."""
    r = 1 if corrected else 2
    E = np.eye(3)
    rows = [wedge(E[i], E[j]) for i in range(r) for j in range(3) if i < j]
    Omega = sum(c * X for c, X in zip(point.normal("c", len(rows)), rows, strict=True))
    return [len(rows), Omega[2, 1]], [2, 0.0]


@claim("text:invariance", "L and 𝒟_r are invariant under the left action of SO(n−r)", "1268–1271")
def invariance(point: Point) -> Sides:
    n, r = point.n, rank_of(point)
    h = np.eye(n)
    h[r:, r:] = np.linalg.qr(point.normal("h", n - r, n - r))[0]
    Omega = point.g @ admissible(point) @ point.g.T
    turned = h @ Omega @ h.T
    left = [inner(turned, X) for X in constraint_forms(point)]
    w = (h @ point.g).T @ turned @ (h @ point.g)
    energies = [inner(apply(point.general, x), x) for x in (w, admissible(point))]
    return [*left, energies[0]], [*np.zeros(len(left)), energies[1]]


@claim(
    "bundle",
    "𝒟_r is a principal connection of SO(n−r) → SO(n) → V(n, r): so(n) = 𝔡 ⊕ so(n−r)",
    "1271–1281",
)
def connection(point: Point) -> Sides:
    n, r = point.n, rank_of(point)
    rows = [coordinates(X) for X in span(point)]
    fibre = [coordinates(X) for X in constraint_forms(point)]
    ranks = [rank(rows), rank([*rows, *fibre])]
    return ranks, [n * r - r * (r + 1) // 2, n * (n - 1) // 2]


@claim("cond_X", "TV(n, r): XᵀX = 1, XᵀẊ + ẊᵀX = 0", "1282–1290")
def cond_x(point: Point) -> Sides:
    X, X_dot, _ = stiefel(point)
    r = rank_of(point)
    symmetric = X.T @ X_dot + X_dot.T @ X
    return [X.T @ X, symmetric], [np.eye(r), np.zeros((r, r))], np.abs(X_dot)


@claim(
    "text:Phi_r",
    "Φ_r(X, Ẋ) = w, both forms: XẊᵀ − ẊXᵀ + ½X[XᵀẊ − ẊᵀX]Xᵀ and the sum of wedges",
    "1292–1305",
)
def momentum(point: Point) -> Sides:
    X, X_dot, w = stiefel(point)
    r = rank_of(point)
    total = sum(wedge(X[:, a], X_dot[:, a]) for a in range(r))
    for a in range(r):
        for b in range(a + 1, r):
            factor = 0.5 * (X[:, a] @ X_dot[:, b] - X_dot[:, a] @ X[:, b])
            total = total + factor * wedge(X[:, a], X[:, b])
    return [phi_r(X, X_dot), total], [w, w]


@claim("text:L_red", "L_red = −¼ tr(𝓘Φ_r Φ_r) is the energy", "1292–1297")
def reduced_lagrangian(point: Point) -> Sides:
    X, X_dot, w = stiefel(point)
    phi = phi_r(X, X_dot)
    left = -0.25 * np.trace(apply(point.general, phi) @ phi)
    return left, 0.5 * inner(apply(point.general, w), w)


@claim("dotX->P", "P = ∂L_red/∂Ẋ; L_red is degenerate in the redundant velocities", "1307–1315")
def degenerate(point: Point) -> Sides:
    X, _, _ = stiefel(point)
    n, r = X.shape
    rows = [np.ravel(momentum_matrix(point, X, e.reshape(n, r))) for e in np.eye(n * r)]
    return rank(rows), n * r - r * (r + 1) // 2


@claim(
    "condX",
    "T*V(n, r): XᵀX = 1, XᵀP + PᵀX = 0, and Ẋ is uniquely determined by (X, P)",
    "1315–1325",
)
def cond_p(point: Point) -> Sides:
    X, X_dot, _ = stiefel(point)
    n, r = X.shape
    P = momentum_matrix(point, X, X_dot)
    rows = [
        (X.T @ e.reshape(n, r) + e.reshape(n, r).T @ X)[np.triu_indices(r)] for e in np.eye(n * r)
    ]
    tangents = null_space(np.array(rows).T)
    images = [np.ravel(momentum_matrix(point, X, v.reshape(n, r))) for v in tangents]
    symmetric = X.T @ P + P.T @ X
    left = [*np.ravel(symmetric), rank(images)]
    return left, [*np.zeros(r * r), len(tangents)], np.max(np.abs(P))


claim(
    "rest_St",
    "Theorem 7: the reduction of (VC), (PoissonV), (VFK) to T*V(n, r) is (dot_P)",
    "1327–1338",
    cites=("VC", "VFK"),
)(stiefel_rates)
claim("dot_P", "Ẋ = −Φ_r X, Ṗ = −Φ_r P", "1330–1335")(stiefel_rates)


@claim("remark:FeJo", "Φ* = 𝓘ω|_{𝒟_r} = XPᵀ − PXᵀ", "1340–1347")
def momentum_correction(point: Point) -> Sides:
    X, X_dot, w = stiefel(point)
    P = momentum_matrix(point, X, X_dot)
    moment = point.g @ apply(point.general, w) @ point.g.T
    inside = sum(inner(moment, Y) * Y for Y in span(point))
    return X @ P.T - P @ X.T, point.g.T @ inside @ point.g
