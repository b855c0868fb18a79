"""Numbers without conditions: R^n, moved by translations, or a vector, turned by SO(n)."""

from dataclasses import dataclass

from ...arguments import switch
from .pieces import Pieces
from .space import Space

__all__ = ["Euclidean"]


@dataclass(frozen=True)
class Euclidean(Space):
    """R^n.

    Parameters
    ----------
    n : int
    name : str
        Of the piece of the state.
    turned : bool
        Whether SO(n) turns the vector; else translations move it.
    """

    n: int
    name: str = "x"
    turned: bool = False
    least = 1

    def __post_init__(self) -> None:
        object.__setattr__(self, "turned", switch("turned", self.turned))
        super().__post_init__()

    @property
    def pieces(self) -> Pieces:
        """One piece."""
        return ((self.name, self.n),)

    @property
    def codes(self) -> tuple[str, ...]:
        """A vector, if it is turned."""
        return ("vector",) if self.turned else ()
