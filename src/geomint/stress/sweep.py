"""All cells: every case, in every representation, by every method that fits."""

import functools
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, NamedTuple, Protocol

from ..errors import GeomintError, nearest
from ..methods import Adaptive, Compose, Method, find_method, method_names
from ..plan.fitting import unfit
from ..run.many import run_many
from ..run.reported import Reported
from .case import Names, StressAxis, StressCase, stress_cases
from .guard import guarded
from .judge import Cell, Found, Trial, judge, strictly

SECONDS = 60.0  # of a cell,
# and of its compilations, which are not what is judged, and on a slow processor take longer than most
# runs. A process cannot be told how long they took: what hangs is found that much later.
COMPILING = 60.0
MEMORY = 12 << 30  # bytes of address space of a process
WORKERS = 2


class Item(NamedTuple):
    """One cell to compute: a case, one of its representations, a method's name."""

    case: StressCase
    representation: str
    method: str


@dataclass(frozen=True)
class Selection:
    """What to run; empty means all."""

    methods: Names = ()
    systems: Names = ()
    axes: Names = ()
    quick: bool = False


def selected(
    selection: Selection, cases: Sequence[StressCase]
) -> tuple[list[StressCase], list[Method]]:
    """Return the cases and the methods of a selection.

    Raises
    ------
    GeomintError
        For a name that is none.
    """
    found = [case for case in cases if case.quick or not selection.quick]
    for what, names, of in (
        ("axis", selection.axes, attrgetter("axis.name")),
        ("system", selection.systems, attrgetter("system")),
    ):
        known = set(map(of, cases))
        for name in names:
            if name not in known:
                raise GeomintError(f"--{what} {name!r}: no such {what}.{nearest(name, known)}")
        found = [case for case in found if not names or of(case) in names]
    if not found:
        raise GeomintError("no case has these --systems and --axis together, or none is --quick")
    methods = [find_method(name) for name in selection.methods or method_names()]
    quick = selection.quick and not selection.methods
    return found, _lowest_and_highest(methods) if quick else methods


def family_of(method: Method) -> str:
    """Return the module of the method's class, of its base where it has one: that of its kernel."""
    while isinstance(method, Adaptive | Compose):
        method = method.base
    return type(method).__module__


def _lowest_and_highest(methods: Iterable[Method]) -> list[Method]:
    """Return the methods of lowest and highest order of each family."""
    families: dict[tuple[str, bool], list[Method]] = {}
    for method in sorted(methods, key=attrgetter("order")):
        families.setdefault((family_of(method), method.adaptive), []).append(method)
    return list(dict.fromkeys(m for family in families.values() for m in (family[0], family[-1])))


def items_of(
    cases: Iterable[StressCase], methods: Iterable[Method], quick: bool = False
) -> Iterator[Item]:
    """Yield the cells to compute, problem by problem."""
    for case in cases:
        try:
            problems = strictly(case.build).problems
        except Exception:  # which is judged as well
            yield from (Item(case, "", method.name) for method in methods)
            continue
        wanted = case.quick if quick else case.representations or problems
        for name in filter(wanted.__contains__, problems):
            fit = (method for method in methods if not unfit(problems[name], method, {}))
            yield from (Item(case, name, method.name) for method in fit)


_trial = functools.lru_cache(maxsize=WORKERS)(Trial)


def run_item(item: Item) -> Cell:
    """Compute one cell."""
    trial = functools.partial(_trial, item.case, item.representation)
    return _cell(item, judge(trial, find_method(item.method)))


def sweep(
    items: Sequence[Item], *, seconds: float = SECONDS, workers: int = WORKERS
) -> Iterator[Cell]:
    """Compute cells in processes of their own and yield them as they come."""
    limits: dict[str, Any] = {"seconds": seconds + COMPILING, "memory": MEMORY}
    for item, ending, told in guarded(run_item, items, workers=workers, **limits):
        verdict = "hung" if ending == "hung" else "untyped"
        yield told if ending == "done" else _cell(item, {"verdict": verdict, "message": told})


def _cell(item: Item, found: Found) -> Cell:
    case = item.case
    system = "/".join(filter(None, (case.system, item.representation)))
    return Cell(system, case.axis.name, case.value, case.text, case.n, item.method, **found)


@dataclass
class Result(Reported):
    """What a sweep has found.

    Attributes
    ----------
    methods : list of str
        In the order of the registry.
    """

    cells: list[Cell]
    axes: list[StressAxis]
    methods: list[str]
    seconds: float
    interrupted: bool


class Listener(Protocol):
    """Hears of the cells of a sweep as they are done."""

    def begin(self, total: int) -> None:
        """Hear the number of cells."""

    def cell_done(self, cell: Cell) -> None:
        """Hear of a cell."""


def run_selection(
    selection: Selection,
    listener: Listener,
    cases: Sequence[StressCase] | None = None,
    *,
    seconds: float = SECONDS,
    workers: int = WORKERS,
) -> Result:
    """Compute the cells of a selection; after Ctrl-C return those that there are.

    Parameters
    ----------
    cases : sequence of StressCase, optional
        What is selected from, such as `geomint.stress.own_cases.own_cases`; by default the cases of
        all packages. They are sent to processes, with the functions that they are made of.
    """
    begun = time.perf_counter()
    chosen, methods = selected(selection, stress_cases() if cases is None else cases)
    items = list(items_of(chosen, methods, selection.quick))
    if not items:
        raise GeomintError("none of these --methods fits any of these cases")
    listener.begin(len(items))
    cells: list[Cell] = []

    def take(cell: Cell) -> None:
        cells.append(cell)
        listener.cell_done(cell)

    interrupted = not run_many(sweep(items, seconds=seconds, workers=workers), take)
    axes = list(dict.fromkeys(case.axis for case in chosen))
    names = [method.name for method in methods]
    return Result(cells, axes, names, time.perf_counter() - begun, interrupted)
