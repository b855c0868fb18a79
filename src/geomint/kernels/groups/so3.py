"""SO(3) acting on 3-vectors: the algebra is R³ with the cross product.

The hat map is ``x̂ v = x × v``; exp(x̂) turns by |x| about x, cay(x̂) by 2 arctan(|x|/2). Layout:
``[number of vectors]``.
"""

from ..compiling.recorded import helper
from ..numbers.arithmetic import NAN, fma, select, sqrt, top
from ..numbers.circular import cos, sin

# Below this |x|² the series are exact to rounding: their next terms are below 1e-17.
SMALL = 1.0
# dexp is singular at angles 2π, 4π, …; exponential coordinates are refused beyond this angle.
CHART = 6.0


@helper
def rotation_coefficients(s):
    """Return ``sin θ/θ`` and ``(1 − cos θ)/θ²`` for θ² = s, below `SMALL` by series.

    The second is ½ (sin(θ/2)/(θ/2))²: no cancellation at any angle. The series are split into even
    and odd powers and take fused multiply-adds, which shortens the chain of operations that wait
    for each other; they take a tenth of the time of the sines.
    """
    q = s * s
    a_even = fma(q, fma(q, 1 / 355687428096000.0, 1 / 6227020800.0), 1 / 362880.0)
    a_odd = fma(q, fma(q, 1 / 1307674368000.0, 1 / 39916800.0), 1 / 5040.0)
    b_even = fma(q, fma(q, 1 / 6402373705728000.0, 1 / 87178291200.0), 1 / 3628800.0)
    b_odd = fma(q, fma(q, 1 / 20922789888000.0, 1 / 479001600.0), 1 / 40320.0)
    a = fma(q, fma(q, a_even, 1 / 120.0), fma(-s, fma(q, a_odd, 1 / 6.0), 1.0))
    b = fma(q, fma(q, b_even, 1 / 720.0), fma(-s, fma(q, b_odd, 1 / 24.0), 0.5))
    if not top(s) < SMALL:
        small = s < SMALL
        theta = sqrt(select(small, 1.0 + 0.0 * s, s))
        half = 0.5 * theta
        ratio = sin(half) / half
        a = select(small, a, sin(theta) / theta)
        b = select(small, b, 0.5 * ratio * ratio)
    return a, b


@helper
def turn(a, b, xi, y, out):
    """Write ``a ξ×v + b ξ×(ξ×v)`` for each vector v of the state."""
    x0, x1, x2 = xi[0], xi[1], xi[2]
    for i in range(0, len(y), 3):
        v0, v1, v2 = y[i], y[i + 1], y[i + 2]
        c0 = x1 * v2 - x2 * v1
        c1 = x2 * v0 - x0 * v2
        c2 = x0 * v1 - x1 * v0
        out[i] = fma(a, c0, b * (x1 * c2 - x2 * c1))
        out[i + 1] = fma(a, c1, b * (x2 * c0 - x0 * c2))
        out[i + 2] = fma(a, c2, b * (x0 * c1 - x1 * c0))


@helper
def so3_act(layout, xi, y, out, work):
    """Write ``(exp(ξ̂) − 1) v`` for each vector v of the state."""
    a, b = rotation_coefficients(xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2])
    turn(a, b, xi, y, out)


@helper
def so3_cayley(layout, xi, y, out, work):
    """Write ``(cay(ξ̂) − 1) v = (ξ×v + ½ ξ×(ξ×v)) / (1 + |ξ|²/4)`` for each vector v."""
    a = 1.0 / (1.0 + 0.25 * (xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]))
    turn(a, 0.5 * a, xi, y, out)


@helper
def so3_bracket(layout, x, y, out, work):
    """Write x × y."""
    x0, x1, x2, y0, y1, y2 = x[0], x[1], x[2], y[0], y[1], y[2]
    out[0] = x1 * y2 - x2 * y1
    out[1] = x2 * y0 - x0 * y2
    out[2] = x0 * y1 - x1 * y0


@helper
def dexpinv_coefficient(s):
    """Return ``c = (1 − (θ/2) cot(θ/2)) / θ²`` for θ² = s; NaN beyond `CHART`.

    ``dexp_u⁻¹ v = v − ½ [u, v] + c [u, [u, v]]`` on SO(3), θ = |u|. Above `SMALL` the error of c θ²
    is a rounding of 1, so that of dexp_u⁻¹ v is a rounding of v until the pole at 2π magnifies it.
    """
    q = s * s
    even = fma(q, fma(q, 43867 / 5109094217170944000.0, 1 / 74724249600.0), 1 / 47900160.0)
    odd_end = 3617 / 10670622842880000.0
    odd = fma(q, fma(q, 174611 / 802857662698291200000.0, odd_end), 691 / 1307674368000.0)
    even = fma(q, fma(q, even, 1 / 30240.0), 1 / 12.0)
    c = fma(s, fma(q, fma(q, odd, 1 / 1209600.0), 1 / 720.0), even)
    if not top(s) < SMALL:
        small = s < SMALL
        safe = select(small, 1.0 + 0.0 * s, s)
        half = 0.5 * sqrt(safe)
        c_large = (1.0 - half * cos(half) / sin(half)) / safe
        c = select(small, c, select(s < CHART * CHART, c_large, NAN + 0.0 * s))
    return c


@helper
def so3_dexpinv(layout, u, v, out, work):
    """Write ``dexp_u⁻¹ v = v − ½ u×v + c u×(u×v)``; NaN where u turns by more than `CHART`."""
    c = dexpinv_coefficient(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    turn(-0.5, c, u, v, out)
    for i in range(3):
        out[i] = v[i] + out[i]


@helper
def so3_dcayinv(layout, u, v, out, work):
    """Write ``dcay_u⁻¹ v = v − ½ u×v + ¼ (u, v) u``."""
    u0, u1, u2, v0, v1, v2 = u[0], u[1], u[2], v[0], v[1], v[2]
    along = 0.25 * (u0 * v0 + u1 * v1 + u2 * v2)
    out[0] = v0 + (along * u0 - 0.5 * (u1 * v2 - u2 * v1))
    out[1] = v1 + (along * u1 - 0.5 * (u2 * v0 - u0 * v2))
    out[2] = v2 + (along * u2 - 0.5 * (u0 * v1 - u1 * v0))
