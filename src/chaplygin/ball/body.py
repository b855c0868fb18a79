"""A ball of a laboratory: mass, radius and moments of inertia in kilograms, metres and seconds.

It is the classical ball (n = 3) in (k, γ, g, r), `contact`, with vectors of angular velocity and units.
ω⃗ in the body belongs to ω = g⁻¹ġ by the hat map, eq. (iso), and gω⃗ is that in space, whose third axis
points upwards: the centre moves with ρ gω⃗ × E_3.
"""

import dataclasses
import functools
from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi
from geomint import as_vector
from geomint.arguments import as_array

from ..inertia import positive_number
from ..manifold import Array, Named, triangle_of_vector
from ..rigid_body import check_inside
from .contact import contact_forms
from .fields import ball_parameters
from .path import carried_path
from .rolling_states import initial_attitude
from .sphere import ChaplyginSphere

UNITS = {
    "t": "s",
    "k": "kg m²/s",
    "gamma": "dimensionless",
    "g": "dimensionless",
    "r": "m",
    "energy": "J",
    "K": "kg² m⁴/s²",
    "momentum": "kg² m⁴/s²",
    "contact": "m",
    "reaction": "N",
    "power": "W",
    "speed": "m/s",
    "pivoting": "rad/s",
    "omega-body": "rad/s",
    "omega-space": "rad/s",
}
VELOCITIES = ("omega_space", "omega_body")
PLACES = ((2, -1.0), (1, 1.0), (0, -1.0))  # of a vector in the flat triangle, with signs


@dataclass(frozen=True, init=False, eq=False)
class Ball:
    """A balanced ball that rolls on a horizontal plane without slipping, in units of the SI.

    Parameters
    ----------
    mass : float
        In kg, > 0.
    radius : float
        In m, > 0.
    moments : array_like, shape (3,) or (3, 3)
        The principal moments of inertia about the centre, or the inertia tensor, in kg m², of a body
        inside of the ball: I_i ≤ I_j + I_k and 0.004 m r² ≤ I_1 + I_2 + I_3 ≤ 2 m r², where less than
        that is taken for another unit. `ChaplyginSphere` takes what no ball has.

    Raises
    ------
    geomint.DomainError
        For parameters outside of these domains, naming the value.

    Examples
    --------
    >>> import chaplygin as ch, geomint as gi
    >>> ball = ch.Ball(mass=0.4, radius=0.1, moments=[1.2e-3, 1.6e-3, 2.0e-3])
    >>> problem = ball.problem()
    >>> y0 = problem.state(gamma=[0.0, 0.0, 1.0], omega_space=[0.0, 5.0, 20.0])
    >>> [round(gi.value(problem, name, y0), 6) for name in ("speed", "omega-space-3")]
    [0.5, 20.0]
    >>> problem.units["speed"], problem.units["reaction"]
    ('m/s', 'N')
    """

    mass: float
    radius: float
    moments: Array

    def __init__(self, mass: Any, radius: Any, moments: Any) -> None:
        mass, radius = positive_number("mass", mass), positive_number("radius", radius)
        values = as_array("moments", moments, "three numbers or a matrix, in kg m²")
        values.flags.writeable = False
        if values.shape in ((3,), (3, 3)) and np.isfinite(values).all():
            check_inside(values, mass, radius)
        sphere = ChaplyginSphere.from_moments(values, mass, radius)
        vars(self).update(mass=mass, radius=radius, moments=values, _sphere=sphere)

    @property
    def sphere(self) -> ChaplyginSphere:
        """The same ball with its other representations, which have no units."""
        return vars(self)["_sphere"]

    def problem(self) -> gi.Problem:
        """Return the ball with attitude and contact point, in kg, m and s.

        State: that of `contact_problem`, ``k``, ``gamma``, ``g``, ``r``. Observables: those of it,
        ``omega-body-i`` and ``omega-space-i``, i = 1, 2, 3, the angular velocity in the body and in
        space, in rad/s; ``contact-i`` in m, ``reaction-i``, the horizontal part of the reaction of the
        plane, in N (its vertical part is the weight). ``problem.units`` has the unit of each.
        ``state(gamma=…, omega_space=…)``: angular velocities in rad/s, ``omega_space`` or
        ``omega_body``, as vectors; instead of them also what `contact_problem` takes.

        Raises
        ------
        geomint.DomainError
            From ``state``, as of `contact_problem`.
        """
        sphere = self.sphere
        contact = sphere.contact(self.mass, self.radius)
        omega, rows, _ = ball_parameters(sphere.inertia, sphere.D, None, self.mass, self.radius)
        assert contact.make_state is not None
        return dataclasses.replace(
            contact,
            name="ball",
            observables={**contact.observables, **angular_velocities(omega, rows)},
            make_state=with_velocities(contact.make_state),
            make_path=carried_path(contact.space or gi.Rotations(3), self.radius, "m"),
            parameters={"mass": self.mass, "radius": self.radius, "moments": self.moments},
            units=UNITS,
        )


def with_velocities(make_state: Any) -> Any:
    """Return a maker of states that takes vectors of angular velocity too."""

    def made(
        omega_space: Any = None,
        omega_body: Any = None,
        gamma: Any = None,
        g: Any = None,
        **others: Any,
    ) -> Array:
        given = dict(zip(VELOCITIES, (omega_space, omega_body), strict=True))
        named = [name for name in VELOCITIES if given[name] is not None]
        if not named:
            return make_state(gamma=gamma, g=g, **others)
        if len(named) > 1 or others.keys() & {"k", "omega", "p", "p_tilde"}:
            expected = "one of omega_space, omega_body, k, omega, p, p_tilde"
            raise gi.DomainError(named[0], given[named[0]], expected)
        _, attitude = initial_attitude(gamma, g, 3)
        vector = as_vector(named[0], given[named[0]], 3)
        if named == ["omega_space"]:
            vector = attitude.reshape(3, 3).T @ vector
        return make_state(gamma=gamma, g=g, omega=triangle_of_vector(vector), **others)

    return made


@functools.cache
def angular_velocities(omega: Any, rows: Any) -> Named:
    """Return the components of the angular velocity as observables of (k, γ, g, r), n = 3."""
    locate = contact_forms(omega, 3, rows)["locate"]

    def in_body(i: int) -> Any:
        place, sign = PLACES[i]

        def omega_body(params, t, y, work):
            _, _, w, _, _ = locate(params, y, work)
            return sign * w[place]

        return gi.observable(omega_body)

    def in_space(i: int) -> Any:
        def omega_space(params, t, y, work):
            _, g, w, _, _ = locate(params, y, work)
            return g[3 * i + 1] * w[1] - g[3 * i] * w[2] - g[3 * i + 2] * w[0]

        return gi.observable(omega_space)

    found = {f"omega-body-{i + 1}": in_body(i) for i in range(3)}
    return found | {f"omega-space-{i + 1}": in_space(i) for i in range(3)}
