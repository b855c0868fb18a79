"""Products of tables with few columns, in whole lane values: eight columns at a time in registers."""

from ..compiling.recorded import helper
from ..numbers.arithmetic import fma
from ..numbers.blocks import as_lanes, part
from ..solve.gauss import eight_columns


@helper
def write_overlaps(n: int, A, B, out):
    """Write ``AᵀB`` of two tables of n rows: a row for each column of A."""
    across, groups = len(A) // (8 * n), len(B) // (8 * n)
    rows, results = as_lanes(B, 0, n * groups), as_lanes(out, 0, 8 * across * groups)
    zero = 0.0 * rows[0]
    for i in range(across):
        for g in range(groups):
            c0, c1, c2, c3, c4, c5, c6, c7 = zero, zero, zero, zero, zero, zero, zero, zero
            for r in range(n):
                b = rows[r * groups + g]
                a = part(A, 8 * (r * across + i), 8)
                c0 = fma(a[0], b, c0)
                c1 = fma(a[1], b, c1)
                c2 = fma(a[2], b, c2)
                c3 = fma(a[3], b, c3)
                c4 = fma(a[4], b, c4)
                c5 = fma(a[5], b, c5)
                c6 = fma(a[6], b, c6)
                c7 = fma(a[7], b, c7)
            at = 8 * i * groups + g
            results[at] = c0
            results[at + groups] = c1
            results[at + 2 * groups] = c2
            results[at + 3 * groups] = c3
            results[at + 4 * groups] = c4
            results[at + 5 * groups] = c5
            results[at + 6 * groups] = c6
            results[at + 7 * groups] = c7


@helper
def add_product(n: int, A, B, out):
    """Add ``A B`` to a table of n rows; B has a row for each column of A."""
    across, groups = len(A) // (8 * n), len(out) // (8 * n)
    rows, results = as_lanes(B, 0, 8 * across * groups), as_lanes(out, 0, n * groups)
    for i in range(across):
        for g in range(groups):
            b = eight_columns(rows, i, g, groups)
            for r in range(n):
                a = part(A, 8 * (r * across + i), 8)
                first = fma(a[0], b[0], results[r * groups + g])
                second = a[4] * b[4]
                first = fma(a[1], b[1], first)
                second = fma(a[5], b[5], second)
                first = fma(a[2], b[2], first)
                second = fma(a[6], b[6], second)
                first = fma(a[3], b[3], first)
                second = fma(a[7], b[7], second)
                results[r * groups + g] = first + second
