"""When an implicit step is solved: the one stop rule of Gauss methods and RATTLE.

An iteration ``x ↦ Φ(x)`` measures its change by pieces (γ, or p), ``δ = max |Φ(x) − x| / size``, where
the size of a piece is the largest of its numbers before the step and of the increments that the
step has given them so far. So an unknown that passes through zero, a momentum of 1e-150, and one that
begins at rest are all solved for to relative accuracy. It ends

- with δ = 0: Φ(x) = x, bit for bit, whatever the sizes;
- where δ no longer falls and is a few roundings (`rounding_left`), or where constraints nearly depend
  on each other, so that roundings are larger, less than `NEWTON_ROUNDING`;
- of Gauss methods, at the cap, where δ has not fallen since half of the iterations (`kept_up`): where
  the function subtracts what is nearly the same, as a stiff spring does, roundings are those of its
  terms;
- with a tolerance: where δ times the larger of its last two contractions, which is what a further
  iteration would change, is less than it. Two contractions, because one piece may wait for another
  to move before it does.

Sizes are taken anew in every iteration until δ is less than `COARSE`: from rest a piece has no size
before its increments have one. A piece without a size has that of `SMALLEST`, so that its first move
is a large δ and never the end.
"""

from ..compiling.recorded import helper, inlined
from ..numbers.arithmetic import epsilon, like, maximum, plain, select
from .status import NOT_CONVERGED, NOT_FINITE

BEGINNING = 1e300  # the change before the first, and what no change may reach
SMALLEST = 1e-200  # sizes below count as this: their inverse is a number, and so are changes
COARSE = 2.0**-10  # below, sizes are known to a part in a thousand and stay
FINE = 1e-6  # above, two contractions do not predict a third
ROUNDINGS = 16.0
EARLY = 8  # iterations after which changes as large as what changes tell of divergence
DIVERGING = 0.5
# Newton's method either falls quadratically or has met the rounding of its residual. A change larger
# than this that no longer falls is neither.
NEWTON_ROUNDING = 2.0**-40


@inlined
def inverse_size(size):
    """Return 1 / size, that of `SMALLEST` for what is smaller."""
    return 1.0 / maximum(size, like(SMALLEST, size))


@inlined
def larger(x, moves, n: int):
    """Return the size of a piece: the largest of its numbers and of their increments, no slopes."""
    size = 0.0 * plain(x[0])
    for i in range(n):
        size = maximum(maximum(abs(plain(x[i])), abs(plain(moves[i]))), size)
    return size


@inlined
def finite(change) -> bool:
    """Tell whether a change, the largest of all, is a number of sensible size."""
    return change < BEGINNING


@inlined
def failure(iteration: int) -> int:
    """Return the status of an iteration that is not finite: the function's fault, or divergence."""
    return NOT_FINITE if iteration == 0 else NOT_CONVERGED


@inlined
def rounding_left(change, number):
    """Tell whether a change is not more than a few roundings of numbers of the kind of `number`."""
    return change <= ROUNDINGS * epsilon(number)


@inlined
def kept_up(change, halfway) -> bool:
    """Tell whether rounding has kept a change up since it was `halfway` to the last iteration.

    What contracts, however slowly, falls by more than the eighth in so many iterations.
    """
    return (change <= NEWTON_ROUNDING) & (8.0 * change >= halfway)


@inlined
def no_contraction(iteration: int, patience: int, change) -> bool:
    """Tell whether an iteration that has not ended so far is not worth going on with.

    Changes are relative to sizes that grow with what diverges: they stay near 1, or above. Where it
    does not diverge, it is asked for three digits (`COARSE`) after a third of the iterations
    (`patience`; negative: never).
    """
    diverging = (iteration == EARLY) & (patience > EARLY) & (change > DIVERGING)
    return diverging | ((iteration == patience) & (change > COARSE))


@helper
def solved(change, last, before, tolerance, rounding, final: bool):
    """Tell, in every lane, whether the iteration has ended.

    Parameters
    ----------
    change, last, before : number
        δ of this iteration, of the one before it, and of the one before that; `BEGINNING` where there
        was none.
    tolerance : number
        0 for none.
    rounding : bool
        Whether δ can be rounding: `rounding_left`, or a wider bound where rounding is amplified.
    final : bool
        Whether this is the last iteration that the cap allows: then rounding is enough.
    """
    stagnated = (change >= select(final, 0.0 * last, last)) & rounding
    # δ max(δ/δ′, δ′/δ″) < tolerance, without divisions
    predicted = (change * change <= tolerance * last) & (change * last <= tolerance * before)
    settled = (change <= FINE) & predicted & (before < BEGINNING)
    return (change == 0.0) | stagnated | settled


@helper
def solved_by_newton(change, last, tolerance):
    """Tell, in every lane, whether Newton's method has ended.

    With a change less than the tolerance or than rounding, after which what is left is of the size of
    its square; or with one that is kept up by rounding.
    """
    small = change <= maximum(like(epsilon(change), change), like(tolerance, change))
    return small | ((change >= last) & (change <= NEWTON_ROUNDING))
