"""Hamiltonians that are separated in spheroconical coordinates: what flows on the same tori."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class SeparatedEnergy:
    """A Hamiltonian that is separated in spheroconical coordinates: H = 2^e · ½ (x F(0) + y (p̃, Ap̃)).

    (p̃, Ap̃) is the limit of λ²F. Sphere: x = D, y = −1; Veselova: x = 0, y = D².

    Parameters
    ----------
    at_zero, at_infinity : float
        x and y.
    exponent : int
        e: numbers of any size, of which products are finite.
    """

    at_zero: float
    at_infinity: float
    exponent: int = 0

    def in_units(self, unit: float, unit_p: float) -> SeparatedEnergy:
        """Return the energy whose flow is the same in time where a and p̃ are measured in units.

        Units are powers of two.
        """
        (x, i), (y, j) = math.frexp(self.at_zero), math.frexp(self.at_infinity)
        a, p = math.frexp(unit)[1] - 1, math.frexp(unit_p)[1] - 1
        i, j = i + p - a, j + p + a
        e = max(i if x else j, j if y else i)
        return SeparatedEnergy(
            math.ldexp(x, max(i - e, -2000)), math.ldexp(y, max(j - e, -2000)), self.exponent + e
        )

    def turning(self, alpha: float) -> float:
        """Return ∂H/∂ℓ of a pair, over ℓ."""
        return math.ldexp(self.at_zero / alpha + self.at_infinity * alpha, self.exponent)
