"""Hamiltonians that are separated in spheroconical coordinates: what flows on the same tori."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .branch_points import mp

__all__ = ["SeparatedEnergy"]


@dataclass(frozen=True)
class SeparatedEnergy:
    """A Hamiltonian that is separated in spheroconical coordinates: H = ½ (x F(0) + y (p̃, Ap̃)).

    (p̃, Ap̃) is the limit of λ²F. Sphere: x = D, y = −1; Veselova: x = 0, y = D².

    Parameters
    ----------
    at_zero, at_infinity : float or mpf
        x and y.
    """

    at_zero: Any
    at_infinity: Any

    def in_units(self, unit: float, unit_p: float) -> SeparatedEnergy:
        """Return the energy whose flow is the same in time where a and p̃ are measured in units."""
        a, p = mp.mpf(unit), mp.mpf(unit_p)
        return SeparatedEnergy(mp.mpf(self.at_zero) * p / a, mp.mpf(self.at_infinity) * p * a)

    def slopes(self, alpha: Any) -> list[Any]:
        """Return ∂H/∂c_j, j = 0 … q−2."""
        weights = [mp.mpf(0)] * (len(alpha) - 1)
        if weights:
            weights[0] += mp.mpf(self.at_zero) / (2 * mp.fprod(-x for x in alpha))
            weights[-1] += mp.mpf(self.at_infinity) / 2
        return weights

    def turning(self, alpha: Any, ell: Any) -> Any:
        """Return ∂H/∂ℓ of a pair."""
        return ell * (mp.mpf(self.at_zero) / alpha + mp.mpf(self.at_infinity) * alpha)
