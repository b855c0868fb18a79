"""The sampler: a random ball with a random state, all that a claim may ask for."""

from __future__ import annotations

import dataclasses
import zlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .algebra import Array, coordinates, project, skew

__all__ = ["Point", "around_vertical", "horizontal_rotation", "lagrange_case", "sample"]


@dataclass(frozen=True, eq=False)
class Point:
    """A ball in Rⁿ and a state: what is random depends on (seed, n, index) only.

    Attributes
    ----------
    n : int
    seed : tuple of int
        Of this point; see `normal`.
    a : ndarray, shape (n,)
        Parameters of the special operator, different from each other and increasing, a_i > 0 with
        a_i a_j < D for i ≠ j; a_n² may exceed D.
    m, rho : float
        Mass and radius; D = mρ².
    g : ndarray, shape (n, n)
        A rotation, body to space.
    gamma, p : ndarray, shape (n,)
        γ = g⁻¹Γ with Γ = E_n, and p ⟂ γ. At points `off` the manifold |γ| ≠ 1 and (γ, p) ≠ 0.
    """

    n: int
    seed: tuple[int, ...]
    a: Array
    m: float
    rho: float
    g: Array
    gamma: Array
    p: Array

    def normal(self, key: str, *shape: int) -> Array:
        """Return normal random numbers, the same ones for the same key."""
        return np.random.default_rng([*self.seed, zlib.crc32(key.encode())]).normal(size=shape)

    def uniform(self, key: str, low: float, high: float, *shape: int) -> Array:
        """Return uniform random numbers, the same ones for the same key."""
        rng = np.random.default_rng([*self.seed, zlib.crc32(key.encode())])
        return np.asarray(rng.uniform(low, high, size=shape))

    def skew(self, key: str) -> Array:
        """Return a random skew matrix."""
        return skew(self.normal(key, self.n * (self.n - 1) // 2), self.n)

    def with_(self, **changes: object) -> Point:
        """Return a point with other parameters or another state."""
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]

    @property
    def off(self) -> Point:
        """The same ball at a state off T*S^(n−1)."""
        size, along = self.uniform("off", 0.5, 1.5, 2)
        size = size if abs(size - 1.0) > 0.2 else 1.3
        return self.with_(gamma=size * self.gamma, p=self.p + along * self.gamma)

    @property
    def D(self) -> float:  # noqa: N802 - the paper's symbol
        """D = mρ²."""
        return self.m * self.rho**2

    @property
    def Gamma(self) -> Array:  # noqa: N802 - the paper's symbol
        """The vertical in space, E_n."""
        return np.asarray(np.eye(self.n)[-1])

    @property
    def state(self) -> Array:
        """(γ, p) as one vector."""
        return np.concatenate([self.gamma, self.p])

    @property
    def pairs(self) -> tuple[Array, Array]:
        """The indices i < j of the basis E_i∧E_j."""
        return np.triu_indices(self.n, 1)

    @cached_property
    def special(self) -> Array:
        """The operator (operator), a diagonal matrix."""
        i, j = self.pairs
        product = self.a[i] * self.a[j]
        return np.diag(product * self.D / (self.D - product))

    @cached_property
    def special_veselova(self) -> Array:
        """The operator (inertia_tensor) of the Veselova problem, a diagonal matrix."""
        i, j = self.pairs
        return np.diag(1.0 / (self.a[i] * self.a[j]))

    @cached_property
    def general(self) -> Array:
        """A symmetric positive definite operator on so(n) without any structure."""
        size = self.n * (self.n - 1) // 2
        square = self.normal("general", size, size)
        return square @ square.T / size + 0.4 * np.eye(size)

    @cached_property
    def omega(self) -> Array:
        """An angular velocity of any momentum."""
        return self.skew("omega")

    @property
    def Omega(self) -> Array:  # noqa: N802 - the paper's symbol
        """That angular velocity in space, gωg⁻¹."""
        return np.asarray(self.g @ self.omega @ self.g.T)

    def metric(self, inertia: Array, gamma: Array) -> Array:
        """Return κ_red = I + D pr as a matrix on so(n)."""
        rows = [coordinates(project(skew(e, self.n), gamma)) for e in np.eye(len(inertia))]
        return inertia + self.D * np.array(rows).T

    def omega_of(self, inertia: Array, k: Array, gamma: Array) -> Array:
        """Return the ω with Iω + D(ωγ)∧γ = k."""
        return skew(np.linalg.solve(self.metric(inertia, gamma), coordinates(k)), self.n)


def sample(n: int, index: int, seed: int = 0) -> Point:
    """Return the random point of that number in dimension n."""
    rng = np.random.default_rng([seed, n, index])
    a = np.cumsum(rng.uniform(0.2, 0.5, n)) + rng.uniform(0.2, 0.5)
    rho = rng.uniform(0.6, 1.4)
    D = a[-1] * a[-2] * rng.uniform(1.1, 2.0)
    q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    q[0] *= np.linalg.det(q)
    gamma = q[-1] / np.linalg.norm(q[-1])
    p = rng.normal(size=n)
    for _ in range(2):
        p = p - (gamma @ p) * gamma
    return Point(n, (seed, n, index), a, D / rho**2, rho, q, gamma, p)


def around_vertical(point: Point, key: str) -> Array:
    """Return a random element of so(n−1): it kills Γ."""
    xi = point.skew(key)
    return xi - project(xi, point.Gamma)


def horizontal_rotation(point: Point) -> Array:
    """Return a random rotation that keeps Γ."""
    half = 0.5 * around_vertical(point, "turn")
    one = np.eye(point.n)
    return np.asarray(np.linalg.solve(one - half, one + half))


def lagrange_case(point: Point) -> Point:
    """Return the point with a_1 = … = a_(n−1) ≠ a_n, eq. (sing), a_1² < D."""
    first, last = (float(x) for x in point.uniform("lagrange", 0.4, 1.6, 2))
    last = last if abs(last - first) > 0.1 else first + 0.3
    D = float(point.uniform("lagrangeD", 1.05, 3.0)) * first * max(first, last)
    a = np.array([first] * (point.n - 1) + [last])
    return point.with_(a=a, m=D / point.rho**2)
