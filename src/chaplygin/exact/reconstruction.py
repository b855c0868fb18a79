"""Attitude and contact point of the ball in R³ from (k⃗, γ⃗): reconstruction, n = 3.

gk⃗ and gγ⃗ = Γ are constant. Where k⃗ and γ⃗ are not parallel two vectors determine a rotation, so the
attitude is *algebraic* in the reduced motion, from any integrator or from the exact flow: with the
orthonormal frame F = (γ⃗, k⃗ − (k⃗, γ⃗)γ⃗, their product), normalised, g(t) = g(0) F(0) F(t)ᵀ.

So gωγ, the velocity of the contact point over ρ, is a function on the torus, and the contact point is
its integral: a mean drift and a quasi-periodic part, by the same quadrature as physical time (`clock`).
"""

import functools
from typing import Any

import numpy as np

import geomint as gi
from geomint.arguments import as_array

from ..inertia import positive_number
from ..manifold import PARALLEL, Array, triangle_of_vector, upright
from .classical import ExactBall
from .numbers import MadeOfNumbers


def attitude(k: Any, gamma: Any, g0: Any = None) -> Array:
    """Return the attitudes g(t) along a motion (k⃗(t), γ⃗(t)) of the ball in R³.

    Parameters
    ----------
    k, gamma : array_like, shape (..., 3)
        Along one motion; the first are those at time 0.
    g0 : array_like, shape (3, 3), optional
        g(0), the rotation from body to space; by default the smallest one that takes γ⃗ to E_3.

    Returns
    -------
    array, shape (..., 3, 3)

    Raises
    ------
    geomint.DomainError
        If k⃗ and γ⃗ are parallel: the ball turns steadily about the vertical, and they say not how far.
    """
    momenta, verticals = as_array("k", k), as_array("gamma", gamma)
    for name, given in (("k", momenta), ("gamma", verticals)):
        if given.shape[-1:] != (3,) or given.size == 0 or not np.isfinite(given).all():
            raise gi.DomainError(name, given, "finite vectors of R³")
    if momenta.shape != verticals.shape:
        raise gi.DomainError("k", momenta, f"as many vectors as of gamma, {verticals.shape}")
    frames = _frames(momenta, verticals)
    first = frames.reshape(-1, 3, 3)[0]
    start = upright(first[:, 0]) if g0 is None else gi.Rotations(3, "g0").point(g0).reshape(3, 3)
    return start @ first @ np.swapaxes(frames, -1, -2)


def _frames(k: Array, gamma: Array) -> Array:
    """Return F, its columns the frame, shape (..., 3, 3)."""
    height = np.linalg.norm(gamma, axis=-1, keepdims=True)
    if not np.all(height > 0.0):
        raise gi.DomainError("gamma", gamma, "vectors that are not zero")
    vertical = gamma / height
    across = k - np.sum(k * vertical, axis=-1, keepdims=True) * vertical
    across -= np.sum(across * vertical, axis=-1, keepdims=True) * vertical
    size = np.linalg.norm(across, axis=-1, keepdims=True)
    if np.any(size <= PARALLEL * np.linalg.norm(k, axis=-1, keepdims=True)):
        raise gi.DomainError("k", k, "momenta that are not parallel to gamma")
    across /= size
    return np.stack([vertical, across, np.cross(vertical, across)], axis=-1)


class ContactPath(MadeOfNumbers):
    """Attitude and contact point of the ball in R³ at any time, without stepping.

    Parameters
    ----------
    exact : ExactBall
        ``sphere.classical().exact(y0)``.
    rho : float
        The radius.
    g0 : array_like, shape (3, 3), optional
        The attitude at time 0; see `attitude`.
    r0 : array_like, shape (2,), optional
        The contact point at time 0; the origin.

    Raises
    ------
    geomint.DomainError
        For a radius that is not positive, a g0 that is no rotation or has not γ⃗ as its last row.
    """

    def __init__(self, exact: ExactBall, rho: Any, g0: Any = None, r0: Any = (0.0, 0.0)) -> None:
        if not isinstance(exact, ExactBall):
            raise gi.DomainError("exact", exact, "the exact motion of a ball in R³, classical()")
        self.exact, self.rho = exact, positive_number("rho", rho)
        self._r0 = gi.as_vector("r0", r0, 2)
        start = exact.at_tau(0.0)
        self._first = _frames(start[:3], start[3:])
        self._g0 = attitude(start[:3], start[3:], g0)
        if np.max(np.abs(self._g0[2] - start[3:])) > 1e-6:
            expected = "a rotation that takes gamma to E_3, whose last row it is"
            raise gi.DomainError("g0", self._g0, expected)

    def attitude(self, t: Any) -> Array:
        """Return g at physical times t, shape (..., 3, 3)."""
        return self._attitude(self.exact(t))

    def contact(self, t: Any) -> Array:
        """Return the contact point at physical times t, shape (..., 2)."""
        tau = self.exact.tau(t)
        parts = [quadrature(tau) for quadrature in self._quadratures]
        return self._r0 + np.stack(parts, axis=-1)

    def state(self, t: Any) -> Array:
        """Return states (k, γ, g, r) of ``sphere.contact(rho=…)`` at physical times t.

        What that problem observes, such as the reaction, can be evaluated on them (`geomint.value`).
        """
        vectors = self.exact(t)
        k, gamma = vectors[..., :3], vectors[..., 3:]
        g = self._attitude(vectors)
        flat = g.reshape(*g.shape[:-2], 9)
        return np.concatenate([triangle_of_vector(k), gamma, flat, self.contact(t)], axis=-1)

    @property
    def drift(self) -> Array:
        """The mean velocity of the contact point in physical time, shape (2,)."""
        means = np.array([c.mean for c in self._quadratures])
        return means / self.exact.clock.mean

    @functools.cached_property
    def _quadratures(self) -> list[Any]:
        exact = self.exact

        def component(i: int) -> Any:
            def rate(phi: Array) -> Array:
                y = exact.at_angles(phi)
                velocity = np.cross(exact.angular_velocity(y), y[..., 3:])
                moved = self._attitude(y) @ velocity[..., None]
                return self.rho * moved[..., i, 0] * exact.rate(y)

            return rate

        return [exact.quadrature(component(i)) for i in (0, 1)]

    def _attitude(self, y: Array) -> Array:
        frames = _frames(y[..., :3], y[..., 3:])
        return self._g0 @ self._first @ np.swapaxes(frames, -1, -2)
