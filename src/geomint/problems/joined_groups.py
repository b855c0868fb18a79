"""Products of any two groups, by the functions of both."""

import functools
from collections import namedtuple
from typing import Any

from ..kernels.compiling.recorded import Recorded, helper, inlined
from ..kernels.groups.translations import endless
from ..kernels.numbers.arithmetic import maximum
from ..kernels.numbers.blocks import REST, packed, part, section, sections
from .forms import Group

__all__ = ["joined"]

# Numbers of the first group's layout, rows of its algebra and of its states; the layouts of both.
Joined = namedtuple("Joined", "numbers algebra_rows rows first second")


@inlined
def joined_layout(numbers: int) -> Joined:
    """Return the layout of a product's layout."""
    return Joined(1, 1, 1, numbers, REST)


@inlined
def parts_of(layout: Any) -> Any:
    """Return the parts of a product's layout by name."""
    return sections(layout, joined_layout(int(section(layout, joined_layout(0), "numbers")[0])))


def joined(first: Group, second: Group) -> Group:
    """Return the product; both say their `rows`."""
    assert first.rows is not None
    assert second.rows is not None
    moves = {name: _both(first, second, name, True) for name in ("act", "cayley")}
    maps = {name: _both(first, second, name, False) for name in ("bracket", "dexpinv", "dcayinv")}
    return Group(
        f"{first.name} × {second.name}",
        first.algebra_rows + second.algebra_rows,
        packed(
            joined_layout(len(first.layout)),
            numbers=len(first.layout),
            algebra_rows=first.algebra_rows,
            rows=first.rows,
            first=first.layout,
            second=second.layout,
        ).data,
        work=max(first.work, second.work),
        extent=_extent(first.extent or endless, second.extent or endless),
        rows=first.rows + second.rows,
        **moves,  # type: ignore[arg-type]
        **maps,  # type: ignore[arg-type]
    )


def _both(first: Group, second: Group, name: str, moves: bool) -> Recorded | None:
    """Return both functions of that name as one, if both groups have it."""
    f, h = getattr(first, name), getattr(second, name)
    return None if f is None or h is None else _one_after_another(f, h, moves)


@functools.cache
def _one_after_another(f: Recorded, h: Recorded, moves: bool) -> Recorded:
    """Return the function of f and h, which write moves of states, or elements of the algebra."""

    def product_map(layout: Any, x: Any, y: Any, out: Any, work: Any) -> None:
        both = parts_of(layout)
        m = int(both.algebra_rows[0])
        r = int(both.rows[0]) if moves else m
        f(both.first, part(x, 0, m), part(y, 0, r), part(out, 0, r), work)
        rest = part(out, r, len(out) - r)
        h(both.second, part(x, m, len(x) - m), part(y, r, len(y) - r), rest, work)

    return helper(product_map)


@functools.cache
def _extent(f: Recorded, h: Recorded) -> Recorded:
    """Return how far an element is from where the coordinates of either group end."""

    def product_extent(layout: Any, u: Any, work: Any) -> Any:
        both = parts_of(layout)
        m = int(both.algebra_rows[0])
        rest = part(u, m, len(u) - m)
        return maximum(f(both.first, part(u, 0, m), work), h(both.second, rest, work))

    return helper(product_extent)
