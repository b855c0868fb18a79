"""Small problems with known structure, to verify methods with; one file each.

Every factory returns a `geomint.Problem` whose forms describe the same flow, and has a companion
constant ``INITIAL``, an admissible state at time 0.
"""

from .double_pendulum import double_spherical_pendulum
from .henon_heiles import henon_heiles
from .lotka_volterra import seasonal_lotka_volterra
from .pulsating_body import pulsating_body
from .so_n_flow import so_n_flow
from .sphere_metric import sphere_metric
from .spherical_pendulum import spherical_pendulum

__all__ = [
    "double_spherical_pendulum",
    "henon_heiles",
    "pulsating_body",
    "seasonal_lotka_volterra",
    "so_n_flow",
    "sphere_metric",
    "spherical_pendulum",
]
