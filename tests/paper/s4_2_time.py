"""Section 4.2, Time reparametrization: the multiplier, Theorem 5, the Dirac bracket."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .algebra import Array, inner, wedge
from .calculus import gradient, nested_gradient
from .claim import Section, Sides, half
from .equations import (
    extended_energy,
    flow_in_tau,
    ham_flow,
    hamiltonian,
    hamiltonian_tau,
    log_mu,
    ro,
    split,
    to_tau,
    u_of,
)
from .momenta import true_rates
from .points import Point
from .two_forms import canonical, dirac_bracket, dirac_brackets, dirac_field, tangent_basis

__all__ = ["claim"]

claim = Section("4.2 Time reparametrization")


def printed_ham0(point: Point, y: Array) -> Any:
    """Return H of eq. (ham0)."""
    gamma, p = split(y)
    D, a = point.D, point.a
    inside = wedge(gamma / a, p) - wedge(gamma, a * p) / D
    return inner(wedge(gamma, p), inside) / (2.0 * D * u_of(point, gamma))


@claim("ham0", "H = ⟨γ∧p, A⁻¹γ∧p − γ∧Ap/D⟩/(2D(γ, A⁻¹γ))", "938–943")
def ham0(point: Point) -> Sides:
    return printed_ham0(point, point.state), extended_energy(point, point.special, point.state)


@claim("hamiltonian", "on (phi): H = (D(γ, A⁻¹γ)(p, p) − (p, Ap))/(2D²(γ, A⁻¹γ))", "944–949")
def hamiltonian_on_manifold(point: Point) -> Sides:
    value = hamiltonian(point, point.state)
    return [value] * 2, [
        printed_ham0(point, point.state),
        extended_energy(point, point.special, point.state),
    ]


@claim("text:multiplier-guess", "μ = 𝒩^(n−2) with 𝒩 proportional to 1/√(γ, A⁻¹γ)", "951–955")
def multiplier_guess(point: Point) -> Sides:
    u = u_of(point, point.gamma)
    return (1.0 / np.sqrt(u)) ** (point.n - 2), np.exp(log_mu(point, point.state))


@claim(
    "main",
    "Theorem 5: with dτ = 𝒩dt and p̃ = 𝒩p, (ro1), (ro2) is the Hamiltonian flow of (hamiltonian*)",
    "957–975",
)
def main(point: Point) -> Sides:
    y = point.state
    left = flow_in_tau(point, y, np.concatenate(true_rates(point, point.special)))
    return left, dirac_field(partial(hamiltonian_tau, point), to_tau(point, y))


@claim(
    "text:geodesic", "the Hamiltonian (hamiltonian*) is a metric: positive on T*S^(n−1)", "968–973"
)
def geodesic(point: Point) -> Sides:
    """Check that the eigenvalues of the quadratic form on p̃ ⟂ γ are positive."""
    D, u = point.D, u_of(point, point.gamma)
    basis = tangent_basis(np.concatenate([point.gamma, 0.0 * point.p]))[:, point.n :]
    form = basis @ (D * u * np.eye(point.n) - np.diag(point.a)) @ basis.T
    values = np.linalg.eigvalsh(form)
    return float(np.sum(values > 1e-12)), float(point.n - 1)


def reparametrized(point: Point) -> Sides:
    """Compare (ro1), (ro2) in τ with the flow of (hamiltonian*)."""
    y = point.state
    left = flow_in_tau(point, y, ro(point, y))
    return left, dirac_field(partial(hamiltonian_tau, point), to_tau(point, y))


claim(
    "CM",
    "dτ = 𝒩dt, 𝒩 = 1/(D√(A⁻¹γ, γ)), is a reducing multiplier: γ′ as (hamiltonian*) has it",
    "959–962",
)(half(reparametrized, 0))
claim("mapping", "p̃ = p/(D√(γ, A⁻¹γ)): p̃′ as (hamiltonian*) has it", "963–967")(
    half(reparametrized, 1)
)


@claim(
    "hamiltonian*",
    "H(γ, p̃) = ½(D(γ, A⁻¹γ)(p̃, p̃) − (p̃, Ap̃)) is (hamiltonian) under (mapping)",
    "970–973, 1001–1002",
    everywhere=True,
)
def hamiltonian_star(point: Point) -> Sides:
    return hamiltonian_tau(point, to_tau(point, point.state)), hamiltonian(point, point.state)


claim.unchecked("psi", "ψ_1 = (γ, γ) = 1, ψ_2 = (γ, p̃) = 0", "977–982", "definition")


def test_functions(point: Point) -> list[Any]:
    """Return three functions of y without any meaning."""
    rows = point.normal("f", 3, 2 * point.n)
    return [lambda y, row=row: np.sin(row @ y) + (row @ (y * y)) for row in rows]


@claim("text:dirac", "{·,·}_d as printed is the bracket of dp̃∧dγ on T*S^(n−1)", "984–999")
def dirac_is_canonical(point: Point) -> Sides:
    """Its fields are those of dp∧dγ: ω(·, X_f) = df."""
    y, (f, *_) = point.state, test_functions(point)
    basis = tangent_basis(y)
    X = dirac_field(f, y)
    return [canonical(y, Y, X) for Y in basis], basis @ gradient(f, y)


@claim(
    "text:casimirs",
    "ψ_1 and ψ_2 are Casimir functions of {·,·}_d on R̂²ⁿ",
    "996–999",
    everywhere=True,
)
def casimirs(point: Point) -> Sides:
    n, y, (f, *_) = point.n, point.state, test_functions(point)
    first, size = dirac_bracket(f, lambda z: z[:n] @ z[:n], y)
    second, other = dirac_bracket(f, lambda z: z[:n] @ z[n:], y)
    return [first, second], [0.0, 0.0], min(size, other)


@claim(
    "text:jacobi",
    "{·,·}_d satisfies the Jacobi identity on R̂²ⁿ",
    "996–999",
    n=range(2, 5),
    everywhere=True,
)
def jacobi(point: Point) -> Sides:
    """Sum the cyclic {f, {g, h}_d}_d of linear functions, {y_i, y_j}_d = Π_ij."""
    y, n = point.state, point.n

    def tensor(z: Array) -> Array:
        gamma, p = z[:n], z[n:]
        g2 = gamma @ gamma
        free = np.eye(n) - np.outer(gamma, gamma) / g2
        lower = (np.outer(p, gamma) - np.outer(gamma, p)) / g2
        return np.block([[np.zeros((n, n)), free], [-free, lower]])

    printed = dirac_brackets(lambda z: z, y)[0]
    slope = nested_gradient(tensor, y)  # ∂_l Π_jk on the last axis
    terms = np.einsum("il,jkl->ijk", printed, slope)
    total = terms + np.einsum("ijk->jki", terms) + np.einsum("ijk->kij", terms)
    left = [*np.ravel(printed), *np.ravel(total)]
    return left, [*np.ravel(tensor(y)), *np.zeros(total.size)]


@claim(
    "hamiltonian-flow",
    "γ_i′ = {γ_i, H}_d, p̃_i′ = {p̃_i, H}_d is the geodesic flow: (ham_q), (ham_p)",
    "1003–1010",
    everywhere=True,
)
def hamiltonian_flow(point: Point) -> Sides:
    y = point.state
    return dirac_field(partial(hamiltonian_tau, point), y), ham_flow(point, y)
