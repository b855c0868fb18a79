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

import lazy_loader

# The public names are listed in __init__.pyi and imported when they are first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
