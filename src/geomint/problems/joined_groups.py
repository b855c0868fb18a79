"""Products of any two groups, by the functions of both."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ..kernels.compiling.recorded import Recorded, helper
from ..kernels.groups.translations import endless
from ..kernels.numbers.arithmetic import maximum
from ..kernels.numbers.blocks import part
from .forms import Group

__all__ = ["joined"]

# layout = [length of the first layout, rows of its algebra, rows of its states, both layouts]
HEADER = 3


def joined(first: Group, second: Group) -> Group:
    """Return the product; both say their `rows`."""
    assert first.rows is not None
    assert second.rows is not None
    sizes = [len(first.layout), first.algebra_rows, first.rows]
    moves = {name: _both(first, second, name, 2) for name in ("act", "cayley")}
    maps = {name: _both(first, second, name, 1) for name in ("bracket", "dexpinv", "dcayinv")}
    return Group(
        f"{first.name} × {second.name}",
        first.algebra_rows + second.algebra_rows,
        np.array([*map(float, sizes), *first.layout, *second.layout]),
        work=max(first.work, second.work),
        extent=_extent(first.extent or endless, second.extent or endless),
        rows=first.rows + second.rows,
        **moves,  # type: ignore[arg-type]
        **maps,  # type: ignore[arg-type]
    )


def _both(first: Group, second: Group, name: str, size: int) -> Recorded | None:
    """Return both functions of that name as one, if both groups have it."""
    f, h = getattr(first, name), getattr(second, name)
    return None if f is None or h is None else _one_after_another(f, h, size)


@functools.cache
def _one_after_another(f: Recorded, h: Recorded, size: int) -> Recorded:
    """Return the function of f and h; the layout has the rows of f's `out` at `size`."""

    def product_map(layout: Any, x: Any, y: Any, out: Any, work: Any) -> None:
        k, m, r = int(layout[0]), int(layout[1]), int(layout[size])
        own, other = part(layout, HEADER, k), part(layout, HEADER + k, len(layout) - HEADER - k)
        f(own, part(x, 0, m), part(y, 0, r), part(out, 0, r), work)
        rest = part(out, r, len(out) - r)
        h(other, part(x, m, len(x) - m), part(y, r, len(y) - r), rest, work)

    return helper(product_map)


@functools.cache
def _extent(f: Recorded, h: Recorded) -> Recorded:
    """Return how far an element is from where the coordinates of either group end."""

    def product_extent(layout: Any, u: Any, work: Any) -> Any:
        k, m = int(layout[0]), int(layout[1])
        own, other = part(layout, HEADER, k), part(layout, HEADER + k, len(layout) - HEADER - k)
        return maximum(f(own, part(u, 0, m), work), h(other, part(u, m, len(u) - m), work))

    return helper(product_extent)
