"""Matrix groups acting on states, ready for `geomint.GroupAction`.

Products of any two have the functions of both, one after another.
"""

import functools
from collections import namedtuple

import numpy as np

from ..arguments import whole
from ..errors import DomainError, nearest
from ..kernels.compiling.recorded import Recorded, helper, inlined
from ..kernels.groups.so3 import so3_act, so3_bracket, so3_cayley, so3_dcayinv, so3_dexpinv
from ..kernels.groups.so_n import ADJOINT, FRAME, SHIFTED, VECTOR, so_n_act, so_n_bracket, so_n_work
from ..kernels.groups.so_n_coordinates import so_3_dexpinv, so_n_cayley, so_n_dcayinv, so_n_extent
from ..kernels.groups.translations import commute, endless, shift, unchanged
from ..kernels.numbers.arithmetic import maximum
from ..kernels.numbers.blocks import REST, packed, part, section, sections
from .forms import Group

# Numbers of the first group's layout, rows of its algebra and of its states; the layouts of both.
Joined = namedtuple("Joined", "numbers algebra_rows rows first second")


@inlined
def joined_layout(numbers):
    """Return the layout of a product's layout."""
    return Joined(1, 1, 1, numbers, REST)


@inlined
def parts_of(layout):
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

    def product_map(layout, x, y, out, work):
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

    def product_extent(layout, u, work):
        both = parts_of(layout)
        m = int(both.algebra_rows[0])
        rest = part(u, m, len(u) - m)
        return maximum(f(both.first, part(u, 0, m), work), h(both.second, rest, work))

    return helper(product_extent)


_SO3 = (so3_act, so3_bracket, so3_cayley, so3_dcayinv, so3_dexpinv)
_SO_N = (so_n_act, so_n_bracket, so_n_cayley, so_n_dcayinv, so_3_dexpinv, so_n_extent)
_CODES = {"vector": VECTOR, "adjoint": ADJOINT, "frame": FRAME}


def so3(vectors: int) -> Group:
    """SO(3) turning each of several 3-vectors; the algebra is R³ with the cross product."""
    vectors = whole("vectors", vectors, 1)
    return Group(
        "SO(3)",
        3,
        np.array([float(vectors)]),
        so3_act,
        so3_bracket,
        0,
        cayley=so3_cayley,
        dexpinv=so3_dexpinv,
        dcayinv=so3_dcayinv,
        inline=True,
        rows=3 * vectors,
    )


def so_n(n: int, *pieces: str) -> Group:
    """SO(n) acting on a state made of pieces.

    Parameters
    ----------
    n : int
        At least 2.
    *pieces : str
        In the order of the state: ``"vector"`` (v ↦ E v), ``"adjoint"`` (X ↦ E X Eᵀ, X skew, as the
        flat upper triangle), ``"frame"`` (g ↦ g Eᵀ, an n×n matrix row after row).
    """
    n = whole("n", n, 2)
    for piece in pieces:
        if not (isinstance(piece, str) and piece in _CODES):
            hint = nearest(piece, _CODES) if isinstance(piece, str) else ""
            raise DomainError("pieces", piece, f"one of {list(_CODES)}.{hint}")
    return _so_n(n, [_CODES[piece] for piece in pieces], 0)


def _so_n(n: int, codes: list[int], m: int) -> Group:
    """SO(n), or SO(n) × R^m where the last of the codes is `SHIFTED`: one kernel."""
    layout, algebra = np.array([float(n), *codes]), n * (n - 1) // 2 + m
    rows = {VECTOR: n, ADJOINT: n * (n - 1) // 2, FRAME: n * n, SHIFTED: m}
    return Group(
        f"SO({n}) × R^{m}" if m else f"SO({n})",
        algebra,
        layout,
        so_n_act,
        so_n_bracket,
        so_n_work(n) + algebra,
        cayley=so_n_cayley,
        dexpinv=so_3_dexpinv if n == 3 else None,
        dcayinv=so_n_dcayinv,
        extent=so_n_extent if n > 2 else None,  # in SO(2) the series ends at once, and is exact
        rows=sum(rows[code] for code in codes),
    )


def translations(m: int) -> Group:
    """R^m acting on m rows: r ↦ r + ξ."""
    m = whole("m", m, 1)
    layout = np.array([float(m)])
    return Group(f"R^{m}", m, layout, shift, commute, 0, shift, unchanged, unchanged, rows=m)


def product(first: Group, second: Group) -> Group:
    """Return G × H, acting on the rows of G and then on those of H.

    Elements of its algebra are those of G and then of H. Of SO(n) and R^m there is a kernel; else the
    functions of both are joined, and what only one of them has, no product has.

    Raises
    ------
    DomainError
        If one of them does not say its `rows`.
    """
    for group in (first, second):
        if group.rows is None:
            raise DomainError("rows", ..., f"the length of the states that {group.name} acts on")
    codes = [int(code) for code in first.layout[1:]]
    if first.act is so_n_act and second.act is shift and SHIFTED not in codes:
        return _so_n(int(first.layout[0]), [*codes, SHIFTED], second.algebra_rows)
    return joined(first, second)


def own_sizes(group: Group) -> tuple[int, int, int] | None:
    """Return the rows of algebra elements, states and scratch that the functions of a group take.

    By its layout, for a group of this module's own kernels; None for others.
    """
    functions = group.functions.values()
    codes = [int(code) for code in group.layout[1:]]
    if all(f in _SO3 for f in functions):
        own = so3(int(group.layout[0]))
    elif all(f in _SO_N for f in functions):
        n = int(group.layout[0])
        shifted = group.algebra_rows - n * (n - 1) // 2
        own = _so_n(n, codes, shifted if SHIFTED in codes else 0)
    else:
        return None
    assert own.rows is not None
    return own.algebra_rows, own.rows, own.work
