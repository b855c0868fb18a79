"""All cells: every case, in every representation, by every method that fits."""

import functools
import itertools
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from ..errors import GeomintError, nearest
from ..methods import Adaptive, Compose, Method, find_method, method_names
from ..plan.fitting import unfit
from ..problems.systems import Model
from ..run.many import run_many
from .case import Names, StressAxis, StressCase, stress_cases
from .guard import Outcome, guarded
from .judge import Cell, Found, Trial, judge, strictly, verdict_of
from .known_end import KnownEnd, known_end

SECONDS = 60.0  # of a cell, compilations apart
MEMORY = 12 << 30  # bytes of address space of a process
WORKERS = 2


@dataclass(frozen=True)
class Item:
    """One cell to compute: a case by its number, one of its representations, a method's name."""

    case: int
    representation: str
    method: str


@dataclass(frozen=True)
class Selection:
    """What to run; empty means all."""

    methods: Names = ()
    systems: Names = ()
    axes: Names = ()
    quick: bool = False


@functools.cache
def _cases() -> tuple[StressCase, ...]:
    return tuple(stress_cases())


def selected(selection: Selection) -> tuple[list[int], list[Method]]:
    """Return the numbers of the cases and the methods of a selection.

    Raises
    ------
    GeomintError
        For a name that is none.
    """
    axes = list(dict.fromkeys(case.axis.name for case in _cases()))
    systems = list(dict.fromkeys(case.system for case in _cases()))
    for chosen, known, what in (
        (selection.axes, axes, "axis"),
        (selection.systems, systems, "system"),
    ):
        for name in chosen:
            if name not in known:
                raise GeomintError(f"--{what} {name!r}: no such {what}.{nearest(name, known)}")
    numbers = [
        i
        for i, case in enumerate(_cases())
        if (not selection.axes or case.axis.name in selection.axes)
        and (not selection.systems or case.system in selection.systems)
        and (case.quick or not selection.quick)
    ]
    if not numbers:
        raise GeomintError("no case has these --systems and --axis together, or none is --quick")
    names = selection.methods or tuple(method_names())
    methods = [find_method(name) for name in names]
    if selection.quick and not selection.methods:
        methods = _lowest_and_highest(methods)
    return numbers, methods


def family_of(method: Method) -> str:
    """Return the module of the method's class, of its base where it has one: that of its kernel."""
    while isinstance(method, Adaptive | Compose):
        method = method.base
    return type(method).__module__


def _lowest_and_highest(methods: Iterable[Method]) -> list[Method]:
    """Return the methods of lowest and highest order of each family."""
    families: dict[tuple[str, bool], list[Method]] = {}
    for method in methods:
        families.setdefault((family_of(method), method.adaptive), []).append(method)
    ends = [sorted(family, key=lambda m: m.order) for family in families.values()]
    return list(dict.fromkeys(m for family in ends for m in (family[0], family[-1])))


def items_of(
    numbers: Sequence[int], methods: Sequence[Method], quick: bool = False
) -> tuple[list[list[Item]], list[Cell]]:
    """Return the cells to compute, a group for each problem, and those that are judged already.

    These are the cases whose problem cannot be built: with a typed error they are refused. In a
    quick run, which is mostly compilation, problems of the same forms are one group, and every other
    group begins with the last methods: processes side by side do not compile the same.
    """
    groups: dict[tuple[Any, ...], list[Item]] = {}
    judged = []
    for number in numbers:
        case = _cases()[number]
        try:
            model = strictly(case.build)
        except Exception as error:
            verdict = "refused" if isinstance(error, GeomintError) else "untyped"
            found = verdict_of(verdict, error)
            judged += [_cell(case, "", m.name, found) for m in methods]
            continue
        for name, problem in model.problems.items():
            chosen = case.quick if quick else case.representations
            if chosen is None or name in chosen:
                key = problem.forms if quick else (number, name)
                items = [Item(number, name, m.name) for m in methods if not unfit(problem, m, {})]
                group = groups.setdefault(key, [])
                turned = quick and list(groups).index(key) % 2 == 1
                group.extend(reversed(items) if turned else items)
    return [group for group in groups.values() if group], judged


def _cell(case: StressCase, representation: str, method: str, found: Found) -> Cell:
    system = f"{case.system}/{representation}" if representation else case.system
    return Cell(system, case.axis.name, case.value, case.text, case.n, method, **found)


@functools.lru_cache(maxsize=1)
def _trial(number: int, representation: str) -> Trial:
    case = _cases()[number]
    model = strictly(case.build)
    problem, y0 = model.problems[representation], model.states[representation]
    reference, physical = _reference(case, model, representation)
    return Trial(
        problem,
        y0,
        reference=reference,
        physical=physical,
        **{name: getattr(case, name) for name in ("span", "fraction", "step", "steps", "steady")},
    )


def _reference(
    case: StressCase, model: Model, representation: str
) -> tuple[Callable[[float], KnownEnd] | None, bool]:
    """Return what the reference solution comes from, if not from the problem itself."""
    units = case.rescaled
    if units is not None:
        other = strictly(units.build)
        problem, y0 = other.problems[representation], other.states[representation]

        def in_units(end: float) -> KnownEnd:
            return known_end(problem, y0, end / units.time).scaled(units.pieces)

        return in_units, False
    name = case.reference
    if name is None or model.problems[name].time != model.problems[representation].time:
        return None, False
    source, start = model.problems[name], model.states[name]
    return (lambda end: known_end(source, start, end, physical=True)), True


def run_item(item: Item) -> Cell:
    """Compute one cell."""
    case = _cases()[item.case]
    try:
        found = judge(_trial(item.case, item.representation), find_method(item.method))
    except Exception as error:
        found = verdict_of("untyped", error)
    return _cell(case, item.representation, item.method, found)


def cell_of(outcome: Outcome) -> Cell:
    """Return the cell of an item, also of one that hung or whose process died."""
    if outcome.ending == "done":
        return outcome.value
    item = outcome.item
    verdict = "hung" if outcome.ending == "hung" else "untyped"
    found = {"verdict": verdict, "message": outcome.message, "seconds": outcome.seconds}
    return _cell(_cases()[item.case], item.representation, item.method, found)


def sweep(
    groups: Sequence[Sequence[Item]], *, seconds: float = SECONDS, workers: int = WORKERS
) -> Iterator[Cell]:
    """Compute cells in processes of their own and yield them as they come."""
    for outcome in guarded(run_item, groups, seconds=seconds, workers=workers, memory=MEMORY):
        yield cell_of(outcome)


@dataclass
class Result:
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
    selection: Selection, listener: Listener, *, seconds: float = SECONDS, workers: int = WORKERS
) -> Result:
    """Compute the cells of a selection; after Ctrl-C return those that there are."""
    begun = time.perf_counter()
    numbers, methods = selected(selection)
    groups, judged = items_of(numbers, methods, selection.quick)
    if not groups and not judged:
        raise GeomintError("none of these --methods fits any of these cases")
    listener.begin(len(judged) + sum(len(group) for group in groups))
    cells = []

    def take(cell: Cell) -> None:
        cells.append(cell)
        listener.cell_done(cell)

    computed = sweep(groups, seconds=seconds, workers=workers)
    interrupted = not run_many(itertools.chain(judged, computed), take)
    axes = list(dict.fromkeys(_cases()[number].axis for number in numbers))
    names = [method.name for method in methods]
    return Result(cells, axes, names, time.perf_counter() - begun, interrupted)
