"""The Chaplygin sphere in n dimensions: problem definitions for geomint.

Equation numbers and labels refer to B. Jovanović, *Hamiltonization and integrability of the
Chaplygin sphere in R^n*. Conventions, used by every module:

* body frame; k̇ = [k, ω], ġ = gω, γ̇ = −ωγ, and γ is a unit vector;
* so(n) is identified with its dual by ⟨X, Y⟩ = −½ tr XY, and x∧y = xyᵀ − yxᵀ;
* a skew matrix X is stored as its flat upper triangle X_12, X_13, …, X_1n, X_23, …, X_(n−1)n;
* at n = 3 the hat map (iso) is X v = x⃗ × v: the triangle of x⃗ is (−x_3, x_2, −x_1);
* everything is dimensionless; D = mρ².

Importing chaplygin imports neither numba nor pydantic: both come when they are needed.
"""

from __future__ import annotations

import importlib
from typing import Any

_PUBLIC = {
    "ChaplyginSphere": "sphere",
    "GeneralInertia": "inertia",
    "SpecialInertia": "inertia",
    "ball_problem": "ball",
    "classical_problem": "classical",
    "hamiltonized_problem": "hamiltonized",
    "reduced_problem": "reduced",
}

__all__ = [
    "ChaplyginSphere",
    "GeneralInertia",
    "SpecialInertia",
    "ball_problem",
    "classical_problem",
    "hamiltonized_problem",
    "reduced_problem",
]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_PUBLIC[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_PUBLIC})
