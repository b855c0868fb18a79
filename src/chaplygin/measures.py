"""Manifolds of states, as the conditions c(y) = 0 of `geomint.Measure`.

The measures are μ δ(c) dy. With c = (|γ|² − 1, (γ, p)) that is μσ up to a factor, σ the symplectic
volume of T*S^(n−1); with |γ|² − 1 it is the area of the sphere, and with the entries of g gᵀ − 1 the
Haar measure of SO(n), each up to a factor.
"""

from __future__ import annotations

import functools
from typing import Any

import geomint as gi
from geomint import part

__all__ = [
    "constant_density",
    "haar_conditions",
    "norm",
    "on_rotations",
    "on_sphere",
    "on_tangent_bundle",
    "sphere_constraint",
    "tangency",
]


@gi.observable
def norm(params: Any, t: Any, y: Any, work: Any) -> Any:
    """(γ, γ) − 1 of a state (γ, p)."""
    total = y[0] * y[0]
    for i in range(1, len(y) // 2):
        total += y[i] * y[i]
    return total - 1.0


@gi.observable
def tangency(params: Any, t: Any, y: Any, work: Any) -> Any:
    """(γ, p) of a state (γ, p)."""
    n = len(y) // 2
    total = y[0] * y[n]
    for i in range(1, n):
        total += y[i] * y[n + i]
    return total


@gi.field
def tangent_conditions(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """(γ, γ) − 1 and (γ, p) of a state (γ, p)."""
    out[0] = norm(params, t, y, work)
    out[1] = tangency(params, t, y, work)


@gi.field
def sphere_constraint(params: Any, q: Any, g: Any, G: Any, work: Any) -> None:
    """½((q, q) − 1) and its Jacobian q."""
    total = q[0] * q[0]
    for i in range(1, len(q)):
        total += q[i] * q[i]
    g[0] = 0.5 * (total - 1.0)
    for i in range(len(q)):
        G[i] = 1.0 * q[i]


@gi.observable
def constant_density(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Return log 1."""
    return 0.0 * y[0]


def on_tangent_bundle(log_density: Any) -> gi.Measure:
    """Return the measure on T*S^(n−1), states (γ, p), with that density by its symplectic volume."""
    return gi.Measure(log_density, tangent_conditions, 2)


def on_sphere(log_density: Any, first: int, n: int, attitude: bool) -> gi.Measure:
    """Return the measure on states with γ in the rows `first` …, and g after it with `attitude`."""
    count = 1 + (n * (n + 1) // 2 if attitude else 0)
    return gi.Measure(log_density, sphere_conditions(first, n, attitude), count)


def on_rotations(log_density: Any, first: int, n: int) -> gi.Measure:
    """Return the measure on states with a rotation g in the rows `first` …, flat in the others."""
    return gi.Measure(log_density, haar_conditions(first, n), n * (n + 1) // 2)


@functools.cache
def haar_conditions(first: int, n: int) -> Any:
    """Return the function that writes g gᵀ − 1 on and above the diagonal, g from row `first` on."""

    def rotation_conditions(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        at = 0
        for i in range(first, first + n * n, n):
            for j in range(i, first + n * n, n):
                total = y[i] * y[j]
                for c in range(1, n):
                    total += y[i + c] * y[j + c]
                if i == j:
                    total = total - 1.0
                out[at] = total
                at += 1

    return gi.field(rotation_conditions)


@functools.cache
def sphere_conditions(first: int, n: int, attitude: bool) -> Any:
    """Return the function that writes (γ, γ) − 1, and g gᵀ − 1 on and above the diagonal."""
    rotation = haar_conditions(first + n, n)

    def conditions(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        total = y[first] * y[first]
        for c in range(first + 1, first + n):
            total += y[c] * y[c]
        out[0] = total - 1.0
        if attitude:
            rotation(params, t, y, part(out, 1, len(out) - 1), work)

    return gi.field(conditions)
