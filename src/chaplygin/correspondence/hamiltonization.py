"""Chaplygin's multiplier: from time t and (γ, p) to time τ and (γ, p̃), eqs. (CM), (mapping)."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

from ..ball.sphere import ChaplyginSphere
from ..initial_states import multiplier
from ..integrable import physical_scale
from ..manifold import Array
from ..veselova.body import Veselova
from .correspondence import Correspondence

__all__ = ["hamiltonization"]


@gi.observable
def tau_per_t(params: Any, t: Any, y: Any, work: Any) -> Any:
    """dτ/dt = 1/(D√U)."""
    return 1.0 / physical_scale(len(y) // 2, params, y)


def hamiltonization(system: ChaplyginSphere | Veselova) -> Correspondence:
    """Return the correspondence of the reduced system and its Hamiltonised flow.

    Φ(γ, p) = (γ, p/(D√U)), dτ = dt/(D√U), U = (γ, A⁻¹γ): Theorem 4 of the paper, and the same for the
    Veselova problem.

    Raises
    ------
    geomint.DomainError
        For a sphere whose operator is not the special one.
    """
    target = system.hamiltonized()
    a = np.array(target.parameters["a"])
    n, D = system.n, system.D

    def forward(y: Array) -> Array:
        return np.concatenate([y[:n], y[n:] / multiplier(a, D, y[:n])])

    def backward(z: Array) -> Array:
        return np.concatenate([z[:n], z[n:] * multiplier(a, D, z[:n])])

    return Correspondence("hamiltonization", system.reduced(), target, forward, backward, tau_per_t)
