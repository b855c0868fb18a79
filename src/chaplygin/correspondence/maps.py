"""Maps that take motions of one system to those of another one, up to a change of time.

*Chaplygin's multiplier*: from time t and (γ, p) to time τ and (γ, p̃), eqs. (CM), (mapping).

*The Gauss map*: geodesics of the ellipsoid and motions of the Veselova problem.

*Chaplygin's change of variables*: the ball in R³ at any area constant, and one at area zero.

A motion with c = (k⃗, γ⃗), h = ½(k⃗, ω⃗) and F = (k⃗, k⃗) is also that of a ball with another D and
other moments, without area constant: with δ = D₁/D − 1,

    (2hD₁ − F) δ = c²,   I₁ + D₁ = I + D,
    γ⃗₁ = (δk⃗ + cγ⃗)/|…|,   k⃗₁ ∈ span{k⃗, γ⃗},   k⃗₁ ⟂ γ⃗₁.

Of the two roots D₁ the one in (0, D] is taken: I₁ ≥ I, and where c = 0, D₁ = D. k⃗ and γ⃗ have constant
products, so both maps are linear with constant coefficients along a motion. Both pairs turn with the
same ω⃗, up to its length: with k⃗ = αk⃗₁ + βγ⃗₁ and γ⃗ = ζk⃗₁ + εγ⃗₁,

    dt₁/dt = α + ζ D(ω⃗, γ⃗),

which is no constant. The scale of k⃗₁ is free, and taken so that |k⃗₁| = |k⃗|.

*Neumann and Clebsch*: the Hamiltonised Veselova problem is Neumann's system, the Hamiltonised sphere
Clebsch's.

Both in any dimension. In spheroconical coordinates the flows in τ live on −4λPμ² = R(λ), those of the
Neumann family on 4P μ² = −N(λ): where N(0) = 0, N = λR, the differentials λ^j dλ/√(−λPR) of the
angles are the same, and so are the rates of the commuting flows r_j and N_j. So, with q = γ and the
constant σ = (p̃, Ap̃),

    v = Ap̃ − (γ, Ap̃)γ,   p̃ = A⁻¹v − ((γ, A⁻¹v)/U) A⁻¹γ

takes the level (p̃, Ap̃) = σ of T*S^(n−1) to the level N_0 = 0 of Neumann's family with that σ, the
Veselova flow to Neumann's in the time D²τ, and the flow of the sphere, which is
½(−1)ⁿDr_0/Πa − ½r_(n−2), to Clebsch's with weights x = −1, y = D in the time τ itself. For Veselova
this is Knörrer's theorem on the Gauss map of geodesics.

*Fedorov's correspondence of tori*, n = 3: Veselova's problem and the ball at any f₁ and F₁.

Theorem 6 of the paper, with the constants that really correspond. With 𝓘 = 1 + DI⁻¹ and w⃗ = −Iω⃗, eq.
(tr1), the momenta of (3.2) and (Chap) are opposite, K⃗ = −k⃗, with the same γ⃗, and

    F₁ = −f₁,   F₂ = f₂ = 1,   F₃ = (f₄/2 − f₃)/D,   F₄ = f₄.

Tori go to tori and, with the same γ⃗, both are turned by their own angular velocity: the two *flows* on
them are different, so that this is no `Correspondence`.
"""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi
from geomint import section, sqrt

from ..ball.classical import DIAGONAL, classical_parameters, diagonal_omega
from ..ball.sphere import ChaplyginSphere
from ..exact.classical import principal_moments, without_area
from ..inertia import SpecialInertia, positive_vector
from ..initial_states import multiplier
from ..integrable import factors, physical_scale
from ..manifold import Array, Map
from ..related.clebsch import clebsch_problem, neumann_problem
from ..related.ellipsoid import ellipsoid_problem, normal_squared
from ..veselova.body import Veselova, veselova_factors

SPACING = 2.0**-10  # of the differences of order 8: their error is below 1e-13 for smooth maps
# Weights of f(x + kh) − f(x − kh), k = 1 … 4, in the derivative of order 8.
WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)


@dataclass(frozen=True)
class Correspondence:
    """A map Φ that takes motions of one problem to motions of another, in its time.

    If y(t) is a motion of the source, z = Φ(y(t)) is one of the target in the time s(t),
    ds/dt = rate(y); t and s are the problems' own times.

    Parameters
    ----------
    name : str
    source, target : Problem
    forward, backward : callable
        Φ and its inverse on the states that correspond, flat states.
    rate : recorded ``f(params, t, y, work) -> number``
        ds/dt, of the parameters and states of `source`.
    """

    name: str
    source: gi.Problem
    target: gi.Problem
    forward: Map
    backward: Map
    rate: Any

    def clocked(self) -> gi.Problem:
        """Return the source with s as one more piece of its state, called ``s``.

        Integrate it, and ``forward(state[:-1])`` is the target's state at the time ``state[-1]``.
        """
        return gi.with_quadrature(self.source, "s", self.rate)

    def rate_at(self, y: Any) -> float:
        """Return ds/dt at a state of the source."""
        return gi.value(self.source, self.rate, self.source.canonical(y))

    def defect(self, y: Any) -> float:
        """Return how far the field of the source, carried over, is from that of the target.

        The largest entry of DΦ(y) ẏ − rate(y) z′(Φ(y)), relative to the largest of z′; DΦ ẏ by
        differences of order 8, so that 1e-11 is zero.
        """
        state = self.source.canonical(y)
        velocity = gi.derivative(self.source, state)
        h = SPACING * float(np.max(np.abs(state))) / max(float(np.max(np.abs(velocity))), 1e-300)
        carried = sum(
            w * (self.forward(state + k * h * velocity) - self.forward(state - k * h * velocity))
            for k, w in enumerate(WEIGHTS, 1)
        )
        expected = gi.derivative(self.target, self.forward(state))
        difference = carried / h - self.rate_at(state) * expected
        return float(np.max(np.abs(difference)) / np.max(np.abs(self.rate_at(state) * expected)))


@gi.observable
def tau_per_t(params, t, y, work):
    """dτ/dt = 1/(D√U)."""
    return 1.0 / physical_scale(len(y) // 2, params, y)


def hamiltonization(system: ChaplyginSphere | Veselova) -> Correspondence:
    """Return the correspondence of the reduced system and its Hamiltonised flow.

    Φ(γ, p) = (γ, p/(D√U)), dτ = dt/(D√U), U = (γ, A⁻¹γ): Theorem 4 of the paper, and the same for the
    Veselova problem.

    Raises
    ------
    geomint.DomainError
        For a sphere whose operator is not the special one.
    """
    target = system.hamiltonized()
    a = np.array(target.parameters["a"])
    n, D = system.n, system.D

    def forward(y: Array) -> Array:
        return np.concatenate([y[:n], y[n:] / multiplier(a, D, y[:n])])

    def backward(z: Array) -> Array:
        return np.concatenate([z[:n], z[n:] * multiplier(a, D, z[:n])])

    return Correspondence("hamiltonization", system.reduced(), target, forward, backward, tau_per_t)


@gi.observable
def veselova_time(params, t, y, work):
    """dt/ds = |A⁻¹x|⁻³ = U^(3/2), U = (γ, Aγ)."""
    total = normal_squared(params, y)
    return 1.0 / (total * sqrt(total))


def gauss_map(a: Any, D: Any = 1.0) -> Correspondence:
    """Return the correspondence of an ellipsoid's geodesics and the Veselova problem with 1/a_i.

    Φ(x, ẋ) = (γ, p), γ = A⁻¹x/|A⁻¹x|, p = ẋ, with dt = U^(3/2) ds, U = (γ, Aγ): the remark after
    eq. (ham:ves), where |Aγ| is misprinted for |Ax| and the time change is left out.

    Parameters
    ----------
    a : array_like, shape (n,)
        Squares of the semi-axes of (x, A⁻¹x) = 1.
    D : float
        Of the Veselova problem: the unit of its τ.
    """
    source = ellipsoid_problem(a)
    squares = np.array(source.parameters["a"])
    n = len(squares)
    target = Veselova(1.0 / squares, D).reduced()

    def forward(y: Array) -> Array:
        normal = y[:n] / squares
        return np.concatenate([normal / np.sqrt(normal @ normal), y[n:]])

    def backward(z: Array) -> Array:
        x = squares * z[:n]
        return np.concatenate([x / np.sqrt(z[:n] @ x), z[n:]])

    return Correspondence("gauss-map", source, target, forward, backward, veselova_time)


@gi.observable
def new_time(params, t, y, work):
    """dt₁/dt = α + ζ D(ω⃗, γ⃗); α and ζ are its own of the parameters."""
    w0, w1, w2 = diagonal_omega(params, y)
    own, D = section(params, DIAGONAL, "own"), section(params, DIAGONAL, "D")
    return own[0] + own[1] * D[0] * (w0 * y[3] + w1 * y[4] + w2 * y[5])


def chaplygin_change(sphere: ChaplyginSphere, y: Any) -> Correspondence:
    """Return the correspondence of a motion of the ball in R³ and one with area constant zero.

    Parameters
    ----------
    sphere : ChaplyginSphere
        n = 3, in its principal axes.
    y : array_like
        A state (k⃗, γ⃗) of ``sphere.classical()``; only states with the same energy, (k⃗, k⃗) and
        (k⃗, γ⃗) correspond.

    Raises
    ------
    geomint.DomainError
        If n is not 3 or the inertia tensor is not diagonal; if k⃗ and γ⃗ are parallel, which is a
        steady turn about the vertical.
    """
    problem = sphere.classical()
    moments = principal_moments(sphere.inertia)
    change = without_area(moments, sphere.D, problem.canonical(y))
    matrix, inverse = change.forward, change.backward
    other = ChaplyginSphere(inertia=change.inertia)
    _, params = classical_parameters(np.diag(moments), sphere.D, inverse[:, 0])
    source = dataclasses.replace(problem, params=params.data)

    def forward(point: Array) -> Array:
        return (matrix @ point.reshape(2, 3)).reshape(-1)

    def backward(point: Array) -> Array:
        return (inverse @ point.reshape(2, 3)).reshape(-1)

    return Correspondence(
        "chaplygin-change", source, other.classical(), forward, backward, new_time
    )


@gi.observable
def own_time(params, t, y, work):
    """1: the times are the same."""
    return 1.0 + 0.0 * y[0]


@gi.observable
def squared_time(params, t, y, work):
    """D²."""
    D, _, _ = factors(params, len(y) // 2)
    return D[0] * D[0] + 0.0 * y[0]


def to_neumann(body: Veselova, y: Any) -> Correspondence:
    """Return the correspondence of the Hamiltonised Veselova problem and Neumann's system.

    Parameters
    ----------
    body : Veselova
    y : array_like
        A state (γ, p̃); its (p̃, Ap̃) becomes the strength σ, and only states with the same correspond.
    """
    source = body.hamiltonized()
    forward, backward, sigma = _maps(source, y)
    target = neumann_problem(body.a, sigma)
    return Correspondence("neumann", source, target, forward, backward, squared_time)


def to_clebsch(sphere: ChaplyginSphere, y: Any) -> Correspondence:
    """Return the correspondence of the Hamiltonised sphere and Clebsch's system.

    Parameters
    ----------
    sphere : ChaplyginSphere
        With the special operator.
    y : array_like
        A state (γ, p̃); its (p̃, Ap̃) becomes the strength σ, and only states with the same correspond.

    Raises
    ------
    geomint.DomainError
        For a sphere whose operator is not the special one.
    """
    source = sphere.hamiltonized()
    forward, backward, sigma = _maps(source, y)
    target = clebsch_problem(source.parameters["a"], sigma, -1.0, sphere.D)
    return Correspondence("clebsch", source, target, forward, backward, own_time)


def _maps(source: gi.Problem, y: Any) -> tuple[Any, Any, float]:
    """Return Φ, its inverse and σ at that state."""
    a = np.array(source.parameters["a"])
    n = len(a)

    def forward(state: Array) -> Array:
        gamma, ap = state[:n], a * state[n:]
        return np.concatenate([gamma, ap - (gamma @ ap) * gamma])

    def backward(state: Array) -> Array:
        gamma, bv = state[:n], state[n:] / a
        b = gamma / a
        return np.concatenate([gamma, bv - (gamma @ bv) / (gamma @ b) * b])

    p = source.canonical(y)[n:]
    return forward, backward, float(p @ (a * p))


def fedorov_body(sphere: ChaplyginSphere) -> Veselova:
    """Return the body with the moments 𝓘 = 1 + D/I of a ball in principal axes, n = 3."""
    if sphere.n != 3 or sphere.inertia.diagonal is None:
        expected = "a ball in R³ in principal axes"
        raise gi.DomainError("inertia", sphere.inertia.diagonal, expected)
    return Veselova(veselova_factors(1.0 + sphere.D / sphere.inertia.diagonal[::-1]), sphere.D)


def fedorov_ball(moments: Array, D: float) -> ChaplyginSphere:
    """Return the ball with the moments I = D/(𝓘 − 1) of a body with all 𝓘_i > 1.

    Raises
    ------
    geomint.DomainError
        If some 𝓘_i ≤ 1: such a body has no ball.
    """
    values = gi.as_vector("moments", positive_vector("moments", moments), 3)
    if not (values > 1.0).all():
        raise gi.DomainError("moments", moments, "principal moments that are all greater than 1")
    return ChaplyginSphere(inertia=SpecialInertia.from_moments(D / (values - 1.0), D))


def fedorov_state(y: Array) -> Array:
    """Return (K⃗, γ⃗) of (k⃗, γ⃗), or back: the momentum changes its sign."""
    return np.concatenate([-y[:3], y[3:]])


def fedorov_constants(f1: float, f3: float, f4: float, D: float) -> tuple[float, float, float]:
    """Return (F₁, F₃, F₄) of the ball's torus from (f₁, f₃, f₄) of the body's, f₂ = F₂ = 1."""
    return -f1, (0.5 * f4 - f3) / D, f4
