"""Attitude, contact point and reaction along any reduced motion of the ball, in any dimension.

A reduced motion (k(t), γ(t)) has the angular velocity ω(t), and the attitude is g with ġ = gω. What
the reduced state does not determine has to be transported: for zero momentum ω = γ∧γ̇, and the vectors
across γ are moved parallel along γ(t) on the sphere; momenta keep two directions, and leave SO(n−2) to
the transport, nothing at n = 3 (`chaplygin.exact.reconstruction`). After a time at which γ has come
back, what is left is the *geometric phase*; at n = 3 it is the area that γ has gone round.

From samples of the motion, by any integrator or by the exact flow: ω between them is a spline of
degree 7, one step of Magnus' method of order 6 leads from each sample to the next, and the contact
point ṙ = ρ gωγ is the integral of a spline. How far g⁻¹E_n is from γ measures the error.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

import geomint as gi
from geomint.arguments import as_array

from ..conversion import converted
from ..manifold import Array, skew_matrix

DEGREE = 7
NODES = np.array([0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)])  # of Gauss


@dataclass(frozen=True)
class RolledPath:
    r"""A motion with attitude and contact point.

    Parameters
    ----------
    t : array, shape (N,)
        Physical times.
    states : array, shape (N, rows)
        States (k, γ, g, r) of ``sphere.contact()``: what that problem observes, such as "reaction",
        can be evaluated on them with `geomint.value`.
    attitude : array, shape (N, n, n)
        g, from body to space.
    contact : array, shape (N, n−1)
        r.
    error : float
        Largest \|g⁻¹E_n − γ\|: too few samples make it large.
    """

    t: Array
    states: Array
    attitude: Array
    contact: Array
    error: float


def rolled_path(
    contact: gi.Problem, source: gi.Problem, t: Any, states: Any, g0: Any = None, r0: Any = None
) -> RolledPath:
    """Return attitude and contact point along a reduced motion.

    Parameters
    ----------
    contact : Problem
        ``sphere.contact(…)``: n, mass and radius.
    source : Problem
        Whose states are given: a representation of the same sphere.
    t : array_like, shape (N,)
        Physical times, ascending or descending; N ≥ 8, and so dense that the motion is smooth between.
    states : array_like, shape (N, rows)
        The states there: a solution's, or ``source.exact(y0)(t)``.
    g0 : array_like, shape (n, n), optional
        The attitude at the first time; by default the smallest rotation that takes γ to E_n.
    r0 : array_like, shape (n−1,), optional
        The contact point at the first time; the origin.

    Raises
    ------
    geomint.DomainError
        For fewer than 8 samples or times that are not in order; from conversions, and for a g0 that
        does not take γ to E_n.

    Examples
    --------
    >>> import numpy as np
    >>> import chaplygin as ch
    >>> sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.3, 1.5], D=4.0)
    >>> reduced, t = sphere.reduced(), np.linspace(0.0, 10.0, 400)
    >>> motion = reduced.exact(reduced.random_state(1))
    >>> path = ch.rolled_path(sphere.contact(rho=1.0), reduced, t, motion(t))
    >>> path.attitude.shape, path.contact.shape, path.error < 1e-9
    ((400, 4, 4), (400, 3), True)
    """
    names = [name for name, _ in contact.pieces]
    if names != ["k", "gamma", "g", "r"]:
        raise gi.DomainError(
            "contact", contact.name, "sphere.contact(…), with attitude and contact point"
        )
    times, given = as_array("t", t), as_array("states", states)
    if given.ndim != 2 or len(given) != np.size(times) or not np.isfinite(times).all():
        raise gi.DomainError("states", given.shape, "a state for every time, and finite times")
    steps = np.diff(times)
    if times.ndim != 1 or len(times) <= DEGREE or not (np.all(steps > 0) or np.all(steps < 0)):
        raise gi.DomainError("t", t, f"at least {DEGREE + 1} times in order")
    rows = np.array([converted(y, source, contact) for y in given])
    n, where = dict(contact.pieces)["gamma"], contact.slices
    first = contact.state(
        gamma=rows[0, where["gamma"]],
        k=skew_matrix(rows[0, where["k"]], n),
        **({} if g0 is None else {"g": g0}),
        **({} if r0 is None else {"r": r0}),
    )
    omega = _angular_velocities(contact, rows)
    attitude = _transported(times, omega, first[where["g"]].reshape(n, n))
    gamma = rows[:, where["gamma"]]
    error = float(np.max(np.abs(attitude[:, -1] - gamma)))
    velocity = (attitude @ omega @ gamma[..., None])[:, : n - 1, 0]
    integral = _spline(times, contact.parameters["rho"] * velocity).antiderivative()
    position = first[where["r"]] + integral(times) - integral(times[0])
    rows[:, where["g"]], rows[:, where["r"]] = attitude.reshape(len(times), -1), position
    return RolledPath(times, rows, attitude, position, error)


def geometric_phase(path: RolledPath, tolerance: float = 1e-6) -> Array:
    """Return the rotation of the vectors across γ by which g has changed when γ has come back.

    That is g(T)g(0)⁻¹ without its last row and column, a rotation of R^(n−1). For zero momentum it is
    the holonomy of the closed curve of γ on the sphere.

    Raises
    ------
    geomint.DomainError
        If the last γ is not the first one.
    """
    first, last = path.attitude[0], path.attitude[-1]
    apart = float(np.max(np.abs(first[-1] - last[-1])))
    if apart > tolerance:
        expected = f"a path along which gamma comes back; it ends {apart:.3g} away from its start"
        raise gi.DomainError("path", path.t[[0, -1]], expected)
    return (last @ first.T)[:-1, :-1]


def _angular_velocities(contact: gi.Problem, rows: Array) -> Array:
    """Return ω, shape (N, n, n): the field writes gω, which is ω where g = 1."""
    assert contact.field is not None
    n, where = dict(contact.pieces)["gamma"], contact.slices
    upright = rows.copy()
    upright[:, where["g"]] = np.eye(n).reshape(-1)
    rates = gi.pointwise(contact.field, contact.params, upright, contact.rows, contact.work)
    return rates[:, where["g"]].reshape(-1, n, n)


def _transported(times: Array, omega: Array, g0: Array) -> Array:
    """Return g with ġ = gω, by Magnus' method of order 6 on a spline of ω."""
    spline, steps = _spline(times, omega), np.diff(times)
    nodes = times[:-1, None] + steps[:, None] * NODES
    # ẋ = Ax for the transposed of g, A = −ω; Blanes, Casas, Oteo & Ros, *The Magnus expansion* (2009).
    a, b, c = -np.moveaxis(spline(nodes), 1, 0) * steps[:, None, None]
    linear, quadratic = np.sqrt(5.0 / 3.0) * (c - a), (10.0 / 3.0) * (c - 2.0 * b + a)
    first = _bracket(b, linear)
    second = -_bracket(b, 2.0 * quadratic + first) / 60.0
    correction = _bracket(-20.0 * b - quadratic + first, linear + second) / 240.0
    turns = _rotations(-(b + quadratic / 12.0 + correction))
    result = np.empty((len(times), *g0.shape))
    result[0] = g0
    for i, turn in enumerate(turns):
        result[i + 1] = result[i] @ turn
    left, _, right = np.linalg.svd(result)
    return left @ right


def _rotations(skew: Array) -> Array:
    """Return the exponentials of skew matrices, from the eigenvectors of iA, which is Hermitian."""
    angles, vectors = np.linalg.eigh(1j * skew)
    turned = vectors * np.exp(-1j * angles)[..., None, :]
    return (turned @ np.conj(np.moveaxis(vectors, -1, -2))).real


def _bracket(x: Array, y: Array) -> Array:
    return x @ y - y @ x


def _spline(times: Array, values: Array) -> Any:
    forward = slice(None) if times[-1] > times[0] else slice(None, None, -1)
    return make_interp_spline(times[forward], values[forward], k=DEGREE)
