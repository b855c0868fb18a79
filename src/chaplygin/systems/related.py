"""Geodesics of the ellipsoid, and the systems of Neumann and Clebsch on the sphere."""

from ..related.clebsch import clebsch_problem, neumann_problem
from ..related.ellipsoid import ellipsoid_problem
from .parameters import Number, Numbers, Strict, default_of, keys_of, system_of

EllipsoidKeys = keys_of(ellipsoid_problem, __name__, "EllipsoidKeys", a=Numbers)
NeumannKeys = keys_of(neumann_problem, __name__, "NeumannKeys", a=Numbers)
STRENGTH = (Number, default_of(neumann_problem, "strength"))
ClebschKeys = keys_of(clebsch_problem, __name__, "ClebschKeys", a=Numbers, strength=STRENGTH)


class EllipsoidInitial(Strict):
    """A point, or the direction in which it lies, and the velocity p."""

    x: Numbers
    p: Numbers


class SphereInitial(Strict):
    """A point of the sphere and a tangent vector."""

    q: Numbers
    v: Numbers


ELLIPSOID = system_of(
    ellipsoid_problem,
    "geodesics",
    "ellipsoid",
    "geodesics of the ellipsoid (x, A⁻¹x) = 1 in R^n: a separable constrained Hamiltonian",
    EllipsoidKeys,
    EllipsoidInitial,
)
NEUMANN = system_of(
    neumann_problem,
    "neumann",
    "neumann",
    "Neumann's system on S^(n−1): a point in the potential ½σ(q, Aq), a natural system",
    NeumannKeys,
    SphereInitial,
)
CLEBSCH = system_of(
    clebsch_problem,
    "clebsch",
    "clebsch",
    "Clebsch's system on T*S^(n−1), which commutes with Neumann's",
    ClebschKeys,
    SphereInitial,
)
