"""Small systems of equations over blocks: a few constraints, matrices stored row after row."""

from ..compiling.recorded import helper
from ..numbers.arithmetic import maximum, plain, top

LEFT = 0.02  # of a constraint, beside those before it
NEAR = 0.8  # `dependence`
JUMP, RESTING, PULLED = 0.35, 0.52, 4.0


@helper
def solve_small(m: int, matrix, right):
    """Solve an m×m system in place, by elimination without exchanges.

    The matrices are G H_pp Gᵀ: definite wherever the kinetic energy is definite on the normals.
    """
    for k in range(m):
        for i in range(k + 1, m):
            factor = matrix[i * m + k] / matrix[k * m + k]
            for j in range(k + 1, m):
                matrix[i * m + j] -= factor * matrix[k * m + j]
            right[i] -= factor * right[k]
    for back in range(m):
        k = m - 1 - back
        total = right[k]
        for j in range(k + 1, m):
            total -= matrix[k * m + j] * right[j]
        right[k] = total / matrix[k * m + k]


@helper
def dependence(m: int, matrix):
    """Return how far constraints depend on each other, by what `solve_small` has made of G H_pp Gᵀ.

    The largest part of a normal that lies in those before it, of all lanes: a pivot is what is left.
    """
    most = 0.0 * plain(matrix[0])
    for k in range(1, m):
        taken = 0.0 * most
        for j in range(k):
            upper = plain(matrix[j * m + k])
            taken += upper * upper / plain(matrix[j * m + j])
        most = maximum(taken / (taken + plain(matrix[k * m + k])), most)
    return top(most)


@helper
def near_loss(m: int, matrix) -> bool:
    """Tell whether multipliers are so large that they change as fast as the state goes on."""
    return m > 1 and dependence(m, matrix) > NEAR


@helper
def lost_rank(m: int, matrix, n: int, p, kick, moved, force, h) -> bool:
    """Tell whether a step has passed a state where constraints depend on each other, and not rightly.

    Where next to nothing is left of a normal, several motions meet, and the step has taken another one
    if the largest kick of p, `moved`, is large: not from rest, and not by the force, whose steps are
    so too. Right passes of a four-bar kick by 0.2 of p at most, wrong ones by 0.4 at least. The kick is
    looked at first: all but a few steps cost no more.
    """
    before = top(plain(largest(n, p)))
    if not (moved > JUMP * before and dependence(m, matrix) > 1.0 - LEFT):
        return False
    after = 0.0 * plain(kick[0])
    for i in range(n):
        after = maximum(abs(plain(p[i]) + plain(kick[i])), after)
    size, pull = max(before, top(after)), abs(top(h)) * top(plain(largest(n, force)))
    return moved > JUMP * size and before >= RESTING * top(after) and size >= PULLED * pull


@helper
def contract(n: int, rows: int, left, right, out):
    """Write ``left rightᵀ`` of two matrices of `rows` rows and n columns."""
    for a in range(rows):
        for b in range(rows):
            total = left[a * n] * right[b * n]
            for i in range(1, n):
                total += left[a * n + i] * right[b * n + i]
            out[a * rows + b] = total


@helper
def largest(count: int, numbers):
    """Return the largest size of so many numbers; where one is not finite, it is not either."""
    found = 0.0 * numbers[0]
    for i in range(count):
        found = maximum(abs(numbers[i]), found) + 0.0 * numbers[i]
    return found


@helper
def along(n: int, m: int, i: int, rows, weights):
    """Return component i of ``rowsᵀ weights``."""
    total = rows[i] * weights[0]
    for a in range(1, m):
        total += rows[a * n + i] * weights[a]
    return total


@helper
def across(n: int, a: int, rows, vector):
    """Return component a of ``rows vector``."""
    total = rows[a * n] * vector[0]
    for i in range(1, n):
        total += rows[a * n + i] * vector[i]
    return total
