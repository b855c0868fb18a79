"""Where a ball in R³ is along a motion: attitude and contact point of any representation, for pictures.

ġ = gω and ṙ = ρ gωγ, eq. (ch-constr), with ω⃗ of k⃗ and γ⃗ as in `classical`. What the state does not
have is integrated along the samples, which are as dense as pictures need them: the contact point by the
trapezoidal rule with corrected ends, the attitude as in `reconstruction`. Where a representation has
neither mass nor radius, lengths are in radii.
"""

from collections.abc import Callable

import numpy as np

import geomint as gi

from ..inertia import Inertia, inertia_tensor
from ..manifold import Array, Arrays, upright, vector_of_triangle

KNOWN = 0.02  # of a radius, or of the length of the path: what a picture may be wrong by

Path = Callable[[Array, Array], gi.BodyPath]


def carried_path(space: gi.Space, rho: float, unit: str = "dimensionless") -> Path:
    """Return the path of states that have the attitude g and the contact point r, in any dimension."""
    frame, place = space.slices["g"], space.slices["r"]
    n = place.stop - place.start + 1

    def path(t: Array, states: Array) -> gi.BodyPath:
        return gi.BodyPath(states[:, frame].reshape(-1, n, n), states[:, place], rho, unit)

    return path


def integrated_path(
    inertia: Inertia, D: float, physical: Callable[[Array], Arrays], frame: slice | None = None
) -> Path | None:
    """Return the path of states that lack the contact point, n = 3; None in other dimensions.

    Parameters
    ----------
    inertia, D
        See `ChaplyginSphere`.
    physical : callable
        That of the problem: a state ↦ γ and the flat triangle of k.
    frame : slice, optional
        Where the state has the attitude. It is integrated as well if there is none, from the smallest
        rotation that takes γ to E_3.
    """
    if inertia.n != 3:
        return None
    inverse = np.asarray(np.linalg.inv(inertia_tensor(inertia) + D * np.eye(3)), dtype=np.float64)

    def path(t: Array, states: Array) -> gi.BodyPath:
        found = [physical(y) for y in states]
        gamma = np.array([one["gamma"] for one in found])
        k = vector_of_triangle(np.array([one["k"] for one in found]))
        omega = _omega(inverse, D, k, gamma)
        g = _turned(t, omega, gamma) if frame is None else states[:, frame].reshape(-1, 3, 3)
        velocity = np.einsum("kij,kj->ki", g, np.cross(omega, gamma))[:, :2]
        return gi.BodyPath(g, _integral(t, velocity), 1.0, "radii")

    return path


def _omega(inverse: Array, D: float, k: Array, gamma: Array) -> Array:
    """Return ω⃗ = B(k⃗ + m γ⃗), m = D (γ⃗, Bk⃗)/(γ⃗, (1 − DB)γ⃗), B = (I + D)⁻¹."""
    bk, bg = k @ inverse, gamma @ inverse
    weight = np.einsum("ki,ki->k", gamma, gamma - D * bg)
    m = D * np.einsum("ki,ki->k", gamma, bk) / weight
    return bk + m[:, None] * bg


def _turned(t: Array, omega: Array, gamma: Array) -> Array:
    """Return the attitude: rows that turn with γ, by Magnus' method of order 4 on the samples."""
    from scipy.spatial.transform import Rotation

    steps = np.diff(t)[:, None]
    mean = 0.5 * steps * (omega[1:] + omega[:-1])
    rates = np.gradient(omega, t, axis=0)
    mean += steps**2 / 12.0 * (rates[:-1] - rates[1:] + np.cross(omega[:-1], omega[1:]))
    g = np.empty((len(t), 3, 3))
    g[0] = upright(gamma[0])
    for i, turn in enumerate(Rotation.from_rotvec(mean).as_matrix()):
        g[i + 1] = g[i] @ turn
    return g


def _integral(t: Array, velocity: Array) -> Array:
    """Return ∫ v dt from the first sample on, or raise where samples are too far apart for it."""
    coarse = _trapezia(t[::2], velocity[::2])[-1] if len(t) > 4 else np.full(2, np.inf)
    result = _trapezia(t, velocity)
    last = result[(len(t) - 1) // 2 * 2] if len(t) > 4 else np.zeros(2)
    travelled = float(np.sum(np.abs(np.diff(result, axis=0))))
    if not np.max(np.abs(coarse - last)) <= KNOWN * max(1.0, travelled):
        expected = "states so dense that the contact point can be integrated: dense=True in solve"
        raise gi.DomainError("states", len(t), expected)
    return result


def _trapezia(t: Array, velocity: Array) -> Array:
    steps, rates = np.diff(t)[:, None], np.gradient(velocity, t, axis=0)
    parts = 0.5 * steps * (velocity[1:] + velocity[:-1]) + steps**2 / 12.0 * (
        rates[:-1] - rates[1:]
    )
    return np.concatenate([np.zeros((1, 2)), np.cumsum(parts, axis=0)])
