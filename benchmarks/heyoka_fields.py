"""Fields as heyoka likes them best: written by hand in several ways, or traced from the source."""

from __future__ import annotations

from typing import Any

import geomint as gi
from geomint.kernels.numbers.traced import Algebra
from geomint.problems.formulas import traced_field

SPHERE_FORMS = ("rational", "polynomial-2", "homogeneous", "on-sphere", "on-sphere-polynomial")

System = list[tuple[Any, Any]]


def traced(problem: gi.Problem) -> System:
    """Return the formulas that the source of a problem's field is."""
    import heyoka as hy

    variables = [hy.expression(f"y{i}") for i in range(problem.rows)]
    algebra = Algebra(hy, hy.lt, hy.lte, hy.select)
    return [*zip(variables, traced_field(problem, algebra, hy.time, variables), strict=True)]


def sphere(form: str, a: Any, D: float) -> System:
    """Return the field of the Hamiltonised sphere, of any n, in one of its formulations.

    With and without the 1/(γ, γ) factors, polynomial or rational; the last two use (γ, γ) = 1 and
    (γ, p̃) = 0, and may leave the sphere.
    """
    import heyoka as hy

    n = len(a)
    g, p = ([hy.expression(f"{name}{i}") for i in range(n)] for name in "gp")
    ap = [float(a[i]) * p[i] for i in range(n)]
    u = hy.sum([g[i] * g[i] / float(a[i]) for i in range(n)])
    pp, gg = (hy.sum([x[i] * x[i] for i in range(n)]) for x in (p, g))
    gp = hy.sum([g[i] * p[i] for i in range(n)])
    gap, pap = (hy.sum([ap[i] * x[i] for i in range(n)]) for x in (g, p))
    r = {"rational": 1.0 / gg, "polynomial-2": 2.0 - gg, "on-sphere": 1.0 / gg}.get(form, 1.0)
    if form == "on-sphere-polynomial":
        r = 2.0 - gg
    mu = -gap * r if form.startswith("on-sphere") else (D * u * gp - gap) * r
    return [(g[i], (D * u - float(a[i])) * p[i] - mu * g[i]) for i in range(n)] + [
        (p[i], (pap * r - D * pp / float(a[i])) * g[i] + mu * p[i]) for i in range(n)
    ]


def ball(moments: Any, D: float) -> System:
    """Return the field of Chaplygin's ball in R³, (k, γ), of principal moments of inertia."""
    import heyoka as hy

    k, g = ([hy.expression(f"{name}{i}") for i in range(3)] for name in "kg")
    b = [1.0 / (i + D) for i in moments]
    w = hy.sum([moments[i] * b[i] * g[i] * g[i] for i in range(3)])
    m = D * hy.sum([g[i] * b[i] * k[i] for i in range(3)]) / w
    omega = [b[i] * (k[i] + m * g[i]) for i in range(3)]

    def turned(v: Any) -> list[Any]:
        return [
            v[1] * omega[2] - v[2] * omega[1],
            v[2] * omega[0] - v[0] * omega[2],
            v[0] * omega[1] - v[1] * omega[0],
        ]

    return [*zip(k, turned(k), strict=True), *zip(g, turned(g), strict=True)]


def n_body(constant: float, masses: Any) -> System:
    """Return the N-body problem as heyoka's own models write it: (q, v), body after body."""
    import heyoka as hy

    own = hy.model.nbody(len(masses), masses=list(masses), Gconst=constant)
    place = {str(name): rate for name, rate in own}
    names = [[f"{c}_{i}" for i in range(len(masses)) for c in "xyz"]]
    names.append([f"v{c}_{i}" for i in range(len(masses)) for c in "xyz"])
    return [(hy.expression(name), place[name]) for group in names for name in group]
