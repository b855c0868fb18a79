"""What the keys of scene files are made of."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

import geomint as gi

__all__ = [
    "Dimension",
    "Direction",
    "Initial",
    "Matrix",
    "Number",
    "Numbers",
    "Strict",
    "Weight",
    "the_one_of",
]

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Numbers = list[Number]
Matrix = list[Numbers]
Dimension = Annotated[int, Field(strict=True, ge=2)]


class Strict(BaseModel):
    """Unknown keys are errors, and so are numbers written as strings."""

    model_config = ConfigDict(extra="forbid", strict=True)


class Weight(Strict):
    """D, or the mass m and the radius rho, mρ² = D."""

    D: Number | None = None
    m: Number | None = None
    rho: Number | None = None

    def mass_and_radius(self) -> tuple[float, float]:
        """Return m and ρ; where D is given, ρ = 1."""
        D, m, rho = self.D, self.m, self.rho
        if D is not None and m is None and rho is None:
            return D, 1.0
        if D is not None or m is None or rho is None:
            raise gi.DomainError("parameters", {"D": D, "m": m, "rho": rho}, "D, or m and rho")
        return m, rho


def the_one_of(operators: dict[str, Any]) -> str:
    """Return the name of the only operator that is not None, or raise `geomint.DomainError`."""
    given = [name for name, value in operators.items() if value is not None]
    if len(given) != 1:
        raise gi.DomainError("parameters", given, f"exactly one of {list(operators)}")
    return given[0]


class Direction(Strict):
    """A direction that is fixed in space, and a momentum or a velocity."""

    gamma: Numbers
    p: Numbers | None = None
    p_tilde: Numbers | None = None
    k: Numbers | Matrix | None = None

    def components(self) -> dict[str, Any]:
        """Return what was given, γ aside."""
        return {name: value for name, value in self if name != "gamma" and value is not None}


class Initial(Direction):
    """A vertical direction and one of p, p_tilde, k, omega."""

    omega: Numbers | Matrix | None = None
