"""Flows on T*S^(n−1) = {|q| = 1, (q, p) = 0}: great circles and kicks along the sphere.

Both give increments, so that they can be added with compensation, and work in any dimension.
"""

import math

from ..compiling.recorded import helper
from ..numbers.arithmetic import fma, select, top
from .so3 import rotation_coefficients

# Up to this θ² = s the polynomials are exact to rounding: their next terms are s⁷/15! and s⁷/16!.
SMALL = 0.25
A1, A2, A3, A4, A5, A6 = (1 / math.factorial(2 * k + 1) * (-1) ** k for k in range(1, 7))
B1, B2, B3, B4, B5, B6 = (1 / math.factorial(2 * k + 2) * (-1) ** k for k in range(1, 7))


@helper
def short_series(x, c0, c1, c2, c3, c4, c5, c6):
    """Return ``Σ_k c_k x^k`` for small x, by a tree: half as long as Horner's chain."""
    x2 = x * x
    low = fma(x2, fma(x, c3, c2), fma(x, c1, c0))
    return fma(x2 * x2, fma(x2, c6, fma(x, c5, c4)), low)


@helper
def turn_coefficients(s):
    """Return ``sin θ/θ`` and ``(1 − cos θ)/θ²`` for θ² = s, without cancellation at any angle.

    Up to `SMALL` by polynomials in s, for the sine function would take as long as all the rest of a
    step. For −SMALL ≤ s < 0 these are ``sinh x/x`` and ``(cosh x − 1)/x²``, x² = −s.
    """
    x = select(s < SMALL, s, 0.0 * s)
    a = short_series(x, 1.0, A1, A2, A3, A4, A5, A6)
    b = short_series(x, 0.5, B1, B2, B3, B4, B5, B6)
    if not top(s) < SMALL:
        a_large, b_large = rotation_coefficients(s)
        a = select(s < SMALL, a, a_large)
        b = select(s < SMALL, b, b_large)
    return a, b


@helper
def great_circle(h, y, out):
    """Write the increment of the flow of ½(p, p) on T*S^(n−1) over h, y = (q, p).

    ::

        q ↦ cos θ q + (sin θ/|p|) p,    p ↦ cos θ p − sin θ |p| q,    θ = h |p|

    The increments are ``−v q + w p`` and ``−v p − w (p, p) q`` with v = 1 − cos θ and w = sin θ/|p|,
    without cancellation at small angles. Two things keep roundings from adding up:

    - what they have left of δ = 1 − (q, q) and of τ = (q, p) is taken away: the flow is that of
      (q + ½δq, p − τq), to first order;
    - on a free orbit θ never changes, and so would not the roundings of v and w: the energy would
      drift. Their error r in ``cos²θ + w² (p, p) = 1`` is found by fused multiply-adds, and the new q
      and p are divided by 1 + ½r.
    """
    n = len(y) // 2
    q, p = y[0], y[n]
    defect, pp, qp = fma(-q, q, 1.0), p * p, q * p
    for i in range(1, n):
        q, p = y[i], y[n + i]
        defect = fma(-q, q, defect)
        pp += p * p
        qp += q * p
    a, b = turn_coefficients((h * h) * pp)
    v = b * ((h * h) * pp)
    w = a * h
    cosine = 1.0 - v
    ww, vv = w * w, v * v
    sine2 = ww * pp
    rest = fma(ww, pp, -sine2) + (fma(w, w, -ww) * pp + fma(v, v, -vv))
    excess = 0.5 * (((sine2 - 2.0 * v) + vv) + rest)
    back = w * pp
    half = 0.5 * defect - excess
    to_q = half * cosine - w * qp
    to_p = fma(w, pp, -back) + (half * back + cosine * qp)
    for i in range(n):
        q, p = y[i], y[n + i]
        out[i] = (to_q * q - (excess * w) * p) + (w * p - v * q)
        out[n + i] = -(to_p * q + (excess * cosine) * p) - (v * p + back * q)


@helper
def kick_along_sphere(h, y, out):
    """Write the increment ``p −= h (f − (q, f) q)``; f = ∂V/∂q is taken from the last rows of `out`."""
    n = len(y) // 2
    normal = y[0] * out[n]
    for i in range(1, n):
        normal += y[i] * out[n + i]
    for i in range(n):
        out[n + i] = h * (normal * y[i] - out[n + i])
        out[i] = 0.0 * h
