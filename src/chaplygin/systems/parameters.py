"""What the keys of scene files are made of."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

__all__ = ["Dimension", "Direction", "Initial", "Matrix", "Number", "Numbers", "Strict"]

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Numbers = list[Number]
Matrix = list[Numbers]
Dimension = Annotated[int, Field(strict=True, ge=2)]


class Strict(BaseModel):
    """Unknown keys are errors, and so are numbers written as strings."""

    model_config = ConfigDict(extra="forbid")


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
