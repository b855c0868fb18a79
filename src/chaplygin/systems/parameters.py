"""What the keys of scene files are made of."""

import inspect
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, create_model

import geomint as gi

from ..manifold import Named

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Numbers = list[Number]
Matrix = list[Numbers]
Moments = Annotated[Numbers | Matrix | None, Field(title="I")]
Dimension = Annotated[int, Field(strict=True, ge=2)]


class Strict(BaseModel):
    """Unknown keys are errors, and so are numbers written as strings."""

    model_config = ConfigDict(extra="forbid", strict=True)

    def given(self, *others: str) -> Named:
        """Return what was given, the others aside."""
        return {name: value for name, value in self if name not in others and value is not None}

    def the_one_of(self, *names: str) -> tuple[str, Any]:
        """Return the only one of these that was given and its value, or raise `geomint.DomainError`."""
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            raise gi.DomainError("parameters", given, f"exactly one of {list(names)}")
        return given[0], getattr(self, given[0])


class Weight(Strict):
    """D, or the mass m and the radius rho, mρ² = D."""

    D: Number | None = None
    m: Number | None = None
    rho: Number | None = Field(default=None, title="ρ")

    def mass_and_radius(self) -> tuple[float, float]:
        """Return m and ρ; where D is given, ρ = 1."""
        D, m, rho = self.D, self.m, self.rho
        if D is not None and m is None and rho is None:
            return D, 1.0
        if D is not None or m is None or rho is None:
            raise gi.DomainError("parameters", {"D": D, "m": m, "rho": rho}, "D, or m and rho")
        return m, rho


class Direction(Strict):
    """A direction that is fixed in space, and a momentum or a velocity."""

    gamma: Numbers
    p: Numbers | None = None
    p_tilde: Numbers | None = None
    k: Numbers | Matrix | None = None

    def components(self) -> Named:
        """Return what was given, γ aside."""
        return self.given("gamma")


class Initial(Direction):
    """A vertical direction and one of p, p_tilde, k, omega."""

    omega: Numbers | Matrix | None = None


class Placed(Strict):
    """gamma or the attitude g (or both), one of p, k, omega, and the contact point r."""

    gamma: Numbers | None = None
    g: Matrix | None = None
    r: Numbers | None = None
    p: Numbers | None = None
    k: Numbers | Matrix | None = None
    omega: Numbers | Matrix | None = None


def default_of(function: Callable[..., Any], name: str) -> Any:
    """Return the default of an argument, which is that of the key; ``...`` where there is none."""
    argument = inspect.signature(function).parameters[name]
    return ... if argument.default is argument.empty else argument.default


def keys_of(function: Callable[..., Any], home: str, name: str, **kinds: Any) -> type[Strict]:
    """Return the keys of a section that are the arguments of a function, as the class `home`.`name`.

    `kinds` are those of arguments that are no numbers, with a default where it is not the function's.
    """
    names = inspect.signature(function).parameters
    found = {key: kinds.get(key, Number) for key in names}
    fields: Any = {
        key: kind if isinstance(kind, tuple) else (kind, default_of(function, key))
        for key, kind in found.items()
    }
    return create_model(name, __base__=Strict, __module__=home, **fields)


def system_of(
    problem: Callable[..., gi.Problem],
    form: str,
    name: str,
    summary: str,
    parameters: type[Strict],
    initial: type[Strict],
) -> gi.System:
    """Return the system of one problem: keys are arguments of its factory and pieces of its state."""

    def build(parameters: Strict, initial: Strict) -> gi.Model:
        found = problem(**dict(parameters))
        return gi.Model({form: found}, {form: found.state(**dict(initial))})

    return gi.System(name, summary, parameters, initial, build)
