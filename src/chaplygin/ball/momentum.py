"""The ball in (k, γ) on so(n)*×S^(n−1): any n ≥ 2, any momentum, any inertia operator.

k̇ = [k, ω], eq. (ch-red), γ̇ = −ωγ, eq. (PE), and with the attitude ġ = gω, eq. (ch-red2); ω from k
and γ as in `angular_velocity`. All of k is constant in space: (Ad_g k)˙ = 0. As an action of
SO(n), ẏ = ξ·y with ξ = −ω: k ↦ E k Eᵀ, γ ↦ Eγ, g ↦ g Eᵀ.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint import part, sqrt

from ..inertia import GeneralInertia, SpecialInertia, parameters_of
from ..manifold import Array, admit_frame, admit_unit, frame, skew_components
from ..measures import on_sphere
from ..states import initial_momentum
from .angular_velocity import apply_to_gamma, omega_for
from .fields import ball_forms, ball_work, unpack

__all__ = ["ball_problem"]


@gi.observable
def ball_k(params: Any, t: Any, y: Any, work: Any) -> Any:
    """K = ⟨k, k⟩, eq. (IK)."""
    n = int(params[0])
    total = y[0] * y[0]
    for i in range(1, n * (n - 1) // 2):
        total += y[i] * y[i]
    return total


@gi.observable
def ball_momentum(params: Any, t: Any, y: Any, work: Any) -> Any:
    """|pr_so(n−1) Ad_g k|² = |k − (kγ)∧γ|², constant by eq. (cl); (k⃗, γ⃗)² at n = 3."""
    n = int(params[0])
    size = n * (n - 1) // 2
    gamma, v = part(y, size, n), part(work, 0, n)
    apply_to_gamma(n, part(y, 0, size), gamma, v)
    total = 0.0 * y[0]
    at = 0
    for i in range(n):
        for j in range(i + 1, n):
            entry = y[at] - (v[i] * gamma[j] - gamma[i] * v[j])
            total += entry * entry
            at += 1
    return total


@gi.observable
def ball_trace_k4(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Tr k⁴ = |k²|², an invariant of the spectrum of k; tr k² is −2K."""
    n = int(params[0])
    k = part(work, 0, n * n)
    unpack(n, part(y, 0, n * (n - 1) // 2), k)
    total = 0.0 * y[0]
    for i in range(n):
        for j in range(n):
            entry = k[i * n] * k[j * n]
            for c in range(1, n):
                entry += k[i * n + c] * k[j * n + c]
            total += entry * entry
    return total


@gi.observable
def ball_norm(params: Any, t: Any, y: Any, work: Any) -> Any:
    """(γ, γ) − 1."""
    n = int(params[0])
    size = n * (n - 1) // 2
    total = y[size] * y[size]
    for i in range(size + 1, size + n):
        total += y[i] * y[i]
    return total - 1.0


@gi.observable
def ball_orthogonality(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Frobenius norm of g gᵀ − 1."""
    n = int(params[0])
    first = n * (n + 1) // 2
    total = 0.0 * y[0]
    for i in range(n):
        for j in range(n):
            entry = 0.0 * y[0]
            if i == j:
                entry = entry - 1.0
            for c in range(n):
                entry += y[first + i * n + c] * y[first + j * n + c]
            total += entry * entry
    return sqrt(total)


@gi.observable
def ball_spatial_momentum(params: Any, t: Any, y: Any, work: Any) -> Any:
    """|Ad_g k − k_0| in the norm of ⟨X, X⟩; params ends with the triangle of k_0."""
    n = int(params[0])
    size = n * (n - 1) // 2
    k, gk = part(work, 0, n * n), part(work, n * n, n * n)
    g = part(y, size + n, n * n)
    unpack(n, part(y, 0, size), k)
    for i in range(n):
        for j in range(n):
            entry = g[i * n] * k[j]
            for c in range(1, n):
                entry += g[i * n + c] * k[c * n + j]
            gk[i * n + j] = entry
    total = 0.0 * y[0]
    at = len(params) - size
    for i in range(n):
        for j in range(i + 1, n):
            entry = 0.0 * y[0] - params[at]
            for c in range(n):
                entry += gk[i * n + c] * g[j * n + c]
            total += entry * entry
            at += 1
    return sqrt(total)


def ball_problem(
    inertia: SpecialInertia | GeneralInertia, D: float, attitude: bool = False, k0: Any = None
) -> gi.Problem:
    """Return the ball in (k, γ), or in (k, γ, g) with the attitude.

    State: ``k`` (n(n−1)/2,), the flat triangle, ``gamma`` (n,) and with `attitude` ``g`` (n·n,),
    the rotation from body to space, row after row. Time t. Forms: ODE and action of SO(n).
    ``state(gamma=…, k=…)`` with k a skew matrix or flat; instead of k also omega, or p or p_tilde
    for k = γ∧p; g = 1 unless given.

    Parameters
    ----------
    inertia, D
        See `ChaplyginSphere`.
    attitude : bool
        Carry g.
    k0 : array_like, flat or (n, n), optional
        The spatial momentum Ad_g k (k itself where g = 1): gives "spatial-momentum" |Ad_g k − k_0|.

    Raises
    ------
    geomint.DomainError
        From ``state`` and ``canonical``: a k, γ or g that describes no state; see `manifold`.
    """
    n = inertia.n
    size = n * (n - 1) // 2
    omega, params = omega_for(inertia, D)
    forms = ball_forms(omega, n)
    invariants = {"energy": forms.energy, "K": ball_k}
    if n > 2:
        invariants["momentum"] = ball_momentum
    if n > 3:
        invariants["trace-k4"] = ball_trace_k4
    constraints = {"norm": ball_norm}
    if attitude:
        constraints["orthogonality"] = ball_orthogonality
        if k0 is not None:
            params = np.concatenate([params, skew_components("k0", k0, n)])
            constraints["spatial-momentum"] = ball_spatial_momentum

    def make_state(gamma: Any = None, g: Any = None, **components: Any) -> Array:
        if g is not None and not attitude:
            raise gi.DomainError("g", g, "no attitude: this problem has attitude=False")
        vertical, k = initial_momentum(inertia, D, gamma, **components)
        return np.concatenate([k, vertical, *([frame(g, n)] if attitude else [])])

    def admit(y: Array) -> Array:
        last = [admit_frame(y[size + n :], n)] if attitude else []
        return np.concatenate([y[:size], admit_unit(y[size : size + n]), *last])

    pieces = ("adjoint", "vector", "frame") if attitude else ("adjoint", "vector")
    return gi.Problem(
        name="chaplygin-ball",
        pieces=(("k", size), ("gamma", n), *((("g", n * n),) if attitude else ())),
        params=params,
        field=forms.field,
        action=gi.GroupAction(forms.generator, gi.so_n(n, *pieces)),
        work=ball_work(omega, n),
        invariants=invariants,
        constraints=constraints,
        measure=on_sphere(forms.log_density, size, n, attitude),
        make_state=make_state,
        admit=admit,
        physical=lambda y: {"gamma": np.array(y[size : size + n]), "k": np.array(y[:size])},
        parameters=parameters_of(inertia, D),
    )
