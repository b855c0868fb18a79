"""Every problem that `chaplygin` makes, by the name of its maker as the page on notation has it."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Iterator
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi

CLASSES = (ch.ChaplyginSphere, ch.RubberSphere, ch.Veselova, ch.VeselovaLR)
FUNCTIONS = (ch.ellipsoid_problem, ch.neumann_problem, ch.clebsch_problem)


def makers() -> set[str]:
    """Return the names of all makers, read off the classes themselves."""
    found = {function.__name__ for function in FUNCTIONS}
    for kind in CLASSES:
        for name, method in inspect.getmembers(kind, inspect.isfunction):
            if "Problem" in str(inspect.signature(method).return_annotation):
                found.add(f"{kind.__name__}.{name}")
    return {name for name in found if "._" not in name}


@functools.cache
def problems(n: int) -> dict[str, tuple[gi.Problem, ...]]:
    """Return what every maker makes in dimension n: different and equal parameters, r = 1 and 2."""
    found: dict[str, list[gi.Problem]] = {}
    for name, problem in _made(n):
        found.setdefault(name, []).append(problem)
    return {name: tuple(many) for name, many in found.items()}


def _made(n: int) -> Iterator[tuple[str, gi.Problem]]:
    unequal = np.linspace(0.8, 1.5, n)
    equal = np.array([0.8, *unequal[:-1]])
    for a in (unequal, equal):
        rows = n * (n - 1) // 2
        objects: list[Any] = [ch.ChaplyginSphere(a=a, D=4.0), ch.RubberSphere.from_a(0.3 * a, 4.0)]
        objects += [ch.Veselova(a=a), ch.VeselovaLR.from_a(a, 1), ch.VeselovaLR.from_a(a, 2)]
        for thing in objects:
            yield from _of(thing, {"k0": np.zeros(rows)})
        yield "ellipsoid_problem", ch.ellipsoid_problem(a)
        yield "neumann_problem", ch.neumann_problem(a, 1.0)
        yield "clebsch_problem", ch.clebsch_problem(a, 1.0, 1.0, 0.5)


def _of(thing: Any, spatial: dict[str, Any]) -> Iterator[tuple[str, gi.Problem]]:
    kind = type(thing).__name__
    for name in (maker.split(".")[1] for maker in makers() if maker.startswith(f"{kind}.")):
        given = inspect.signature(getattr(thing, name)).parameters
        needed = {"rho": 1.0} if "rho" in given else {}
        choices = [needed]
        if "attitude" in given:
            choices.append({"attitude": True, **spatial})
        elif "k0" in given:
            choices.append({**needed, **spatial})
        for choice in choices:
            try:
                yield f"{kind}.{name}", getattr(thing, name)(**choice)
            except gi.DomainError as error:
                if "dimension 3" not in str(error):
                    raise
