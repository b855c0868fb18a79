"""What every group that acts on states has."""

import numpy as np

from ..arguments import Array, whole
from ..kernels.numbers.blocks import Block
from ..problems.forms import Group
from ..problems.spaces.repair import length
from .judge import checks, hold, small, sure

__all__ = ["check_group", "moved"]

ROUNDING = 1e-12
H = 1e-3  # elements whose products are compared with their series


@checks(Group)
def check_group(group: Group, rows: int, elements: int = 3) -> None:
    """Raise `AssertionError` for the first property of a group that does not hold.

    0 moves nothing; multiples of an element are a flow; the bracket is a Lie bracket, that of the
    action; Cayley coordinates are exponential ones to second order; inverse differentials are those of
    `act` and `cayley`.

    Parameters
    ----------
    group : Group
    rows : int
        Length of the states.
    elements : int
        How many random elements are taken, from seeds 0, 1, …
    """
    sure(group.rows in (None, rows), f"{group.name} acts on {group.rows} rows, not on {rows}")
    for seed in range(whole("elements", elements, 1)):
        rng = np.random.default_rng(seed)
        x, y, z = (v / max(1.0, length(v)) for v in rng.normal(size=(3, group.algebra_rows)))
        state = rng.normal(size=rows)
        _check_flow(group, x, state)
        _check_bracket(group, x, y, z)
        _check_commutator(group, x, y, state)
        _check_coordinates(group, x, y, state)


def called(group: Group, name: str, x: Array, y: Array) -> Array:
    """Return what a function of the group writes, by plain Python."""
    out, work = np.full(len(y), np.nan), Block(np.zeros(group.work))
    getattr(group, name)(Block(group.layout), Block(x), Block(y), Block(out), work)
    sure(
        np.isfinite(out).all(),
        f"{name} of {group.name} leaves rows unwritten, or writes NaN: {out}",
    )
    return out


def moved(group: Group, xi: Array, y: Array, name: str = "act") -> Array:
    """Return exp(ξ)·y, or cay(ξ)·y."""
    return y + called(group, name, xi, y)


def _check_flow(group: Group, x: Array, state: Array) -> None:
    for name in {"act", "cayley"} & set(group.functions):
        nothing = moved(group, 0.0 * x, state, name)
        hold(nothing, state, f"{name} of {group.name} moves a state where ξ is 0")
    twice = moved(group, 0.3 * x, moved(group, 0.5 * x, state))
    text = f"exp(0.3 ξ) exp(0.5 ξ) of {group.name} is not exp(0.8 ξ)"
    small(twice - moved(group, 0.8 * x, state), ROUNDING * max(1.0, length(state)), text)


def _check_bracket(group: Group, x: Array, y: Array, z: Array) -> None:
    def bracket(a: Array, b: Array) -> Array:
        return called(group, "bracket", a, b)

    small(bracket(x, y) + bracket(y, x), ROUNDING, f"[x, y] + [y, x] of {group.name} is not 0")
    cycles = [bracket(a, bracket(b, c)) for a, b, c in ((x, y, z), (y, z, x), (z, x, y))]
    small(sum(cycles), ROUNDING, f"Jacobi's identity does not hold in {group.name}")


def _check_commutator(group: Group, x: Array, y: Array, state: Array) -> None:
    """exp(hx) exp(hy) exp(−hx) exp(−hy) = exp(h²[x, y]), to third order."""
    there = state
    for element in (-y, -x, y, x):
        there = moved(group, H * element, there)
    expected = moved(group, H * H * called(group, "bracket", x, y), state)
    text = f"the bracket of {group.name} is not that of its action, to order h³"
    small(there - expected, 20.0 * H**3 * length(state), text)


def _check_coordinates(group: Group, x: Array, v: Array, state: Array) -> None:
    for name, inverse in (("act", "dexpinv"), ("cayley", "dcayinv")):
        if name == "cayley" and name in group.functions:
            apart = moved(group, H * x, state) - moved(group, H * x, state, name)
            text = f"cay(hξ) of {group.name} is not exp(hξ) to order h³"
            small(apart, H**3 * length(state), text)
        if {name, inverse} <= set(group.functions):
            change = H * called(group, inverse, x, v)
            text = f"{inverse} of {group.name} is not the inverse differential of {name}"
            here = moved(group, x, state, name)
            slopes = [
                moved(group, x + sign * change, state, name) - moved(group, sign * H * v, here)
                for sign in (1.0, -1.0)
            ]
            small(slopes[0] - slopes[1], 20.0 * H**3 * length(state), text)
