"""Stress cases: motions at the edge of what methods can do, given by any package.

A package registers under ``[project.entry-points."geomint.stress"]`` a function that returns a list
of `StressCase`. Every method that fits is run on every representation of every case.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import EntryPoint

from ..errors import DomainError, loaded, offered
from ..problems.systems import Model

Names = tuple[str, ...]


@dataclass(frozen=True)
class StressAxis:
    """A direction in which methods are driven until they stop working.

    Parameters
    ----------
    name : str
        For ``--axis``: lower case with hyphens.
    title : str
        What is stressed.
    quantity : str
        What the values of the axis are.
    """

    name: str
    title: str
    quantity: str


@dataclass(frozen=True)
class StressCase:
    """One motion, at one value of one axis, in all its representations.

    Parameters
    ----------
    system : str
        Which family of motions; cases of one axis and system differ in `value` alone.
    axis : StressAxis
    value : float
        Where on the axis.
    n : int
        Dimension; 0 where there is none.
    build : callable
        Returns the `Model`. What it raises is judged as well. It is sent to other processes: a
        function of a module, or `functools.partial` of one.
    label : str
        The value for readers; by default its three leading digits.
    representations : tuple of str, optional
        Only these of the model.
    span : float
        Length of a run, in characteristic times of the representation.
    step : float, optional
        In the problem's own time. Default: each method's own.
    steps : int
        How many, where `step` is given; `span` is then not used.
    steady : bool
        Whether the generators of the action forms are constant along this motion.
    reference : str, optional
        The representation whose reference solution serves all others, compared in physical
        quantities: where their own would take too long.
    quick : tuple of str
        The representations that are part of the quick run.
    """

    system: str
    axis: StressAxis
    value: float
    n: int
    build: Callable[[], Model] = field(repr=False, compare=False)
    label: str = ""
    representations: Names | None = None
    span: float = 2.0
    step: float | None = None
    steps: int = 1
    steady: bool = False
    reference: str | None = None
    quick: Names = ()

    @property
    def text(self) -> str:
        """The value for readers."""
        return self.label or f"{self.value:.3g}"


def stress_cases() -> list[StressCase]:
    """Return the cases of all packages, axis by axis."""

    def cases_of(point: EntryPoint) -> dict[str, StressCase]:
        cases = list(loaded(point)())
        if not all(isinstance(case, StressCase) for case in cases):
            raise DomainError("cases", cases, "geomint.StressCase objects")
        return {f"{c.axis.name} {c.system} {c.text} {c.n} {c.representations}": c for c in cases}

    expected = "a function that returns geomint.StressCase objects"
    found = list(offered("geomint.stress", parts=cases_of, expected=expected).values())
    axes = list(dict.fromkeys(case.axis.name for case in found))
    return sorted(found, key=lambda case: axes.index(case.axis.name))
