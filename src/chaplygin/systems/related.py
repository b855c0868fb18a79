"""Geodesics of the ellipsoid, and the systems of Neumann and Clebsch on the sphere."""

from __future__ import annotations

from ..related.clebsch import clebsch_problem, neumann_problem
from ..related.ellipsoid import ellipsoid_problem
from .parameters import system_of

__all__ = ["CLEBSCH", "ELLIPSOID", "NEUMANN"]

ELLIPSOID = system_of(
    ellipsoid_problem,
    "ellipsoid",
    "geodesics of the ellipsoid (x, A⁻¹x) = 1 in R^n: a separable constrained Hamiltonian",
    "geodesics",
    *("x", "p"),
)
NEUMANN = system_of(
    neumann_problem,
    "neumann",
    "Neumann's system on S^(n−1): a point in the potential ½σ(q, Aq), a natural system",
    "neumann",
    *("q", "v"),
)
CLEBSCH = system_of(
    clebsch_problem,
    "clebsch",
    "Clebsch's system on T*S^(n−1), which commutes with Neumann's",
    "clebsch",
    *("q", "v"),
)
