"""Sums that keep what rounding loses."""

from collections import namedtuple

from ..compiling.recorded import helper, inlined

State = namedtuple("State", "y carry")


@inlined
def compensated_state(rows: int) -> State:
    """Return the layout of a memory that is a state and the carries of its sums."""
    return State(rows, rows)


@helper
def add_compensated(state, carry, row: int, increment):
    """Add `increment` to ``state[row] + carry[row]``, an unevaluated sum (Knuth's TwoSum).

    The rounded sum goes to `state`, the rest to `carry`; both are blocks of any kind.
    """
    y = state[row]
    z = carry[row] + increment
    s = y + z
    shadow = s - y
    carry[row] = (y - (s - shadow)) + (z - shadow)
    state[row] = s
