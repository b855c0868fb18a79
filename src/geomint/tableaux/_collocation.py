"""What collocation methods are computed with, in 60 digits, and how their numbers are rounded."""

from decimal import ROUND_HALF_EVEN, Context, Decimal, localcontext
from math import isfinite, prod

from ._exact import Array, read_only

DIGITS = Context(prec=60, rounding=ROUND_HALF_EVEN)
HALF = Decimal("0.5")


def legendre(x: Decimal, degree: int) -> list[Decimal]:
    """Return P_0(x), ..., P_degree(x) by the three-term recurrence."""
    P = [Decimal(1), x]
    for k in range(1, degree):
        P.append(((2 * k + 1) * x * P[k] - k * P[k - 1]) / (k + 1))
    return P


def extrapolation(c: tuple[Decimal, ...], b: tuple[Decimal, ...], ratio: float) -> Array:
    """Return the matrix from the increments of stages to those of the next step: P of `GaussTableau`.

    Of collocation methods with any nodes c and weights b; `ratio`: ρ.
    """
    if not isfinite(ratio):
        raise ValueError(f"the ratio of two steps must be finite, got {ratio}")
    with localcontext(DIGITS):
        rho = Decimal(ratio)
        scaled = [
            b_j * prod(c_j - c_k for k, c_k in enumerate(c) if k != j)
            for j, (b_j, c_j) in enumerate(zip(b, c, strict=True))
        ]
        matrix = []
        for b_i, c_i in zip(b, c, strict=True):
            factors = [1 + rho * c_i - c_k for c_k in c]
            products = (prod(factors[:j]) * prod(factors[j + 1 :]) for j in range(len(c)))
            matrix.append([float(rho * b_i * p / w) for p, w in zip(products, scaled, strict=True)])
    return read_only(matrix)


def halves(x: Decimal) -> tuple[float, float]:
    """Return the float64 nearest to x and the rounded remainder."""
    hi = float(x)
    return hi, float(x - Decimal(hi))


def halves_about_half(e: Decimal) -> tuple[float, float]:
    """Split ``1/2 + e`` so that the parts for e and -e add up to 1 and 0 exactly."""
    hi, lo = halves(HALF + abs(e))
    return (hi, lo) if e >= 0 else (1.0 - hi, -lo)
