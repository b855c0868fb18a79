"""dop853 with other last digits: roundings of coefficients that leave the order conditions exact.

Coefficients that are rounded one by one to the nearest floats miss Σ b_i c_i = ½ by 5e-16, and the
conditions of order 3 by as much. That is the same in every step, and integrals drift by it. Here 23 of
the 58 coefficients are moved by one or two units in the last place, found by a random search for
combinations that make Σ b_i exactly 1 and the conditions up to order 3 hold to 4e-19.
"""

from __future__ import annotations

import math
from fractions import Fraction

from geomint.tableaux import RUNGE_KUTTA, Tableau

# Units in the last place by which coefficients are moved: a_ij by (i, j), b_j by j, both from 0 on.
A_MOVES = {
    (1, 0): -2, (2, 1): 1, (3, 0): -1, (4, 0): -1, (4, 2): -1, (4, 3): -2, (5, 0): 1, (5, 4): 1,
    (7, 6): -1, (8, 4): 2, (9, 5): 1, (9, 8): -1, (10, 0): -1, (10, 3): -1, (10, 4): -2,
    (11, 0): 1, (11, 3): 1, (11, 7): 1, (11, 9): 1,
}  # fmt: skip
B_MOVES = {0: -2, 5: -1, 7: 1, 8: -1}


def moved(coefficient: Fraction, units: int) -> Fraction:
    """Return the float next to a coefficient, moved by units in its last place."""
    nearest = float(coefficient)
    return Fraction(nearest) + units * Fraction(math.ulp(nearest))


def chosen_digits() -> Tableau:
    """Return dop853 with the coefficients above, all of them floats."""
    table = RUNGE_KUTTA["dop853"]
    stages = range(table.used_stages)
    A = tuple(tuple(moved(table.A[i][j], A_MOVES.get((i, j), 0)) for j in stages) for i in stages)
    b = tuple(moved(table.b[j], B_MOVES.get(j, 0)) for j in stages)
    c = tuple(sum(a, Fraction(0)) for a in A)
    return Tableau(name="dop853-digits", order=table.order, A=A, b=b, c=c)


def summary() -> dict[str, float]:
    """Return how many coefficients are moved, and the largest defects before and after."""
    table = RUNGE_KUTTA["dop853"]
    s = table.used_stages
    given = [*(x for a in table.A[:s] for x in a), *table.b]
    return {
        "moved": len(A_MOVES) + len(B_MOVES),
        "coefficients": sum(map(bool, given)),
        "nearest": max(map(abs, defects(table))),
        "chosen": max(map(abs, defects(chosen_digits()))),
    }


def defects(table: Tableau) -> list[float]:
    """Return by how much the order conditions up to 3 are missed by the floats of a tableau.

    Σ b_i − 1, Σ b_i c_i − 1/2, Σ b_i c_i² − 1/3, Σ b_i a_ij c_j − 1/6, with c_i the sums of the rows.
    """
    s = range(table.used_stages)
    A = [[Fraction(float(table.A_float[i, j])) for j in s] for i in s]
    b = [Fraction(float(x)) for x in table.b_float[: len(s)]]
    c = [sum(a, Fraction(0)) for a in A]
    second = [sum((A[i][j] * c[j] for j in s), Fraction(0)) for i in s]
    sums = (
        (Fraction(1), [Fraction(1)] * len(s)),
        (Fraction(1, 2), c),
        (Fraction(1, 3), [x * x for x in c]),
        (Fraction(1, 6), second),
    )
    return [float(sum((x * y for x, y in zip(b, of, strict=True)), -right)) for right, of in sums]
