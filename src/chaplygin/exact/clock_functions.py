"""Compiled: physical time from τ and back, and states at physical times.

The clock's section of the parameters (`clock`): T, the period of the waves over 2π, the fastest
frequency, how many waves are regular and resonant, the constant −Σ Re(A e^{im·φ(0)}), the largest
|m_k| in every direction; then for every wave m, r = m·ω and

* regular: A = 2f_m/(ir), which adds Re(A e^{im·φ}) to t;
* resonant, r all but 0: c = 2f_m and m·φ(0), which adds Re(c (e^{im·φ} − e^{im·φ(0)})/(ir)), evaluated
  so that r = 0 does no harm.
"""

from collections import namedtuple

import geomint as gi
from geomint import part, section

from ..operators import after
from .elimination import determinant
from .functions import phases, state_at
from .packing import torus_rows, torus_sizes

Clock = namedtuple("Clock", "mean period fastest regular resonant offset bounds waves")
Wave = namedtuple("Wave", "m rate re im first")
Product = namedtuple("Product", "size bound counts tables")
Column = namedtuple("Column", "weights waves")
HEAD = Product(size=1, bound=1, counts=0, tables=gi.REST)
NEWTON = 60
HALVINGS = 40
NOISE = 4e-16  # of the terms of the sum
FOUR_PI = 12.566370614359172


@gi.helper
def clock_rows(ovals):
    """Return the layout of the clock's section."""
    return Clock(1, 1, 1, 1, 1, 1, bounds=ovals, waves=gi.REST)


@gi.helper
def wave_rows(ovals):
    """Return the layout of the numbers of a wave."""
    return Wave(m=ovals, rate=1, re=1, im=1, first=1)


@gi.helper
def product_rows(size):
    """Return the layout of the parameters of `product_integral`: of points, and one table a column."""
    return Product(size=1, bound=1, counts=size, tables=gi.REST)


@gi.helper
def column_rows(size, bound, count):
    """Return the layout of a table: weights, and cosines and sines of multiples up to the bound."""
    return Column(weights=size * count, waves=2 * size * (bound + 1) * count)


@gi.helper
def clock_of(params):
    """Return the clock's section."""
    return section(params, torus_rows(params), "clock")


def clock_work(ovals: int, angles: int, bounds: int) -> int:
    """Rows of scratch that the functions of this module need; `bounds` is the sum of the |m_k|."""
    return 2 * (bounds + ovals) + 3 * angles + ovals * ovals + 6 * ovals + 3 * angles


@gi.helper
def fill_waves(params, phi, tables):
    """Write cos and sin of mφ_k/period, m = 0 … the largest, direction after direction."""
    ovals, _, _, _ = torus_sizes(params)
    clock, rows, at = clock_of(params), clock_rows(ovals), 0
    bounds = section(clock, rows, "bounds")
    for k in range(ovals):
        angle = phi[k] / section(clock, rows, "period")[0]
        cos1, sin1 = gi.cos(angle), gi.sin(angle)
        cos, sin = 1.0 + 0.0 * angle, 0.0 * angle
        for _ in range(int(bounds[k]) + 1):
            tables[at], tables[at + 1] = cos, sin
            cos, sin = cos * cos1 - sin * sin1, sin * cos1 + cos * sin1
            at += 2


@gi.helper
def wave(bounds, mode, tables):
    """Return cos and sin of m·φ for the wave whose m is `mode`."""
    cos, sin, at = 1.0, 0.0, 0
    for k in range(len(bounds)):
        m = int(mode[k])
        if m != 0:
            c, s = tables[at + 2 * abs(m)], tables[at + 2 * abs(m) + 1]
            if m < 0:
                s = -s
            cos, sin = cos * c - sin * s, sin * c + cos * s
        at += 2 * (int(bounds[k]) + 1)
    return cos, sin


@gi.helper
def clock_sums(params, tau, phi, tables):
    """Return t − Tτ and dt/dτ at τ, where the angles are φ."""
    ovals, _, _, _ = torus_sizes(params)
    clock, rows, parts = clock_of(params), clock_rows(ovals), wave_rows(ovals)
    size = parts.m + parts.rate + parts.re + parts.im + parts.first
    fill_waves(params, phi, tables)
    total, rate = section(clock, rows, "offset")[0], section(clock, rows, "mean")[0]
    waves, bounds = section(clock, rows, "waves"), section(clock, rows, "bounds")
    regular = int(section(clock, rows, "regular")[0])
    for number in range(regular + int(section(clock, rows, "resonant")[0])):
        own = part(waves, number * size, size)
        cos, sin = wave(bounds, section(own, parts, "m"), tables)
        r, re = section(own, parts, "rate")[0], section(own, parts, "re")[0]
        im = section(own, parts, "im")[0]
        if number < regular:
            total += re * cos - im * sin
            rate -= r * (re * sin + im * cos)
        else:
            first, whole = section(own, parts, "first")[0], r * tau
            rate += re * cos - im * sin
            if abs(whole) < 1.0:  # (e^{ib} − e^{ia})/(ir) = e^{i(a+b)/2} τ sin(rτ/2)/(rτ/2)
                half = 0.5 * whole
                span = tau if half == 0.0 else tau * gi.sin(half) / half
                total += span * (re * gi.cos(first + half) - im * gi.sin(first + half))
            else:
                x, y = cos - gi.cos(first), sin - gi.sin(first)
                total += (re * y + im * x) / r
    return total, rate


@gi.helper
def solve_tau(params, t, phi, work):
    """Write the angles at physical time t; return τ and what is left, as an angle."""
    ovals, angles, _, _ = torus_sizes(params)
    turns, rows = section(params, torus_rows(params), "turns"), clock_rows(ovals)
    mean, fastest = (
        section(clock_of(params), rows, "mean")[0],
        section(clock_of(params), rows, "fastest")[0],
    )
    base, tables = part(work, 0, angles), after(work, angles)
    start = t / mean
    rest = gi.fma(-mean, start, t)  # t − T start, without a rounding of its own
    phases(params, start, base)
    for j in range(angles):
        phi[j] = base[j]
    total, rate = clock_sums(params, start, phi, tables)
    delta, defect = 0.0, total - rest
    for _ in range(NEWTON):
        if abs(defect) <= NOISE * (abs(total) + abs(rest) + abs(mean * delta)):
            break
        step, previous = -defect / rate, abs(defect)
        for _ in range(HALVINGS):  # t is monotone: a step too long is cut, never turned
            for j in range(angles):
                phi[j] = base[j] + FOUR_PI * turns[j] * (delta + step)
            total, rate = clock_sums(params, start + (delta + step), phi, tables)
            defect = mean * (delta + step) + total - rest
            if abs(defect) < previous:
                break
            if abs(step) * fastest < NOISE:
                break
            step *= 0.5
        delta += step
        if abs(step) * fastest < NOISE:
            break
    return start + delta, abs(defect / rate) * fastest


@gi.field
def time_at(params, t, x, out, work):
    """(τ) ↦ t."""
    ovals, angles, _, _ = torus_sizes(params)
    mean = section(clock_of(params), clock_rows(ovals), "mean")[0]
    phi = part(work, 0, angles)
    phases(params, x[0], phi)
    total, _ = clock_sums(params, x[0], phi, after(work, angles))
    out[0] = gi.fma(mean, x[0], total)


@gi.field
def tau_at(params, t, x, out, work):
    """(t) ↦ τ, what is left of the iteration."""
    _, angles, _, _ = torus_sizes(params)
    out[0], out[1] = solve_tau(params, x[0], part(work, 0, angles), after(work, angles))


@gi.field
def at_time(params, t, x, out, work):
    """(t) ↦ state, what is left of the iterations."""
    _, angles, _, n = torus_sizes(params)
    phi, rest = part(work, 0, angles), after(work, angles)
    _, left = solve_tau(params, x[0], phi, rest)
    out[2 * n] = max(left, state_at(params, phi, out, rest))


@gi.field
def product_integral(params, t, x, out, work):
    """(m) ↦ det_jk Σ_i weight_kij cos(m·φ(θ_i)); the tables of `clock`."""
    size, bound = int(section(params, HEAD, "size")[0]), int(section(params, HEAD, "bound")[0])
    counts = section(params, product_rows(size), "counts")
    tables, at = section(params, product_rows(size), "tables"), 0
    matrix, rest = part(work, 0, size * size), after(work, size * size)
    for k in range(size):
        count = int(counts[k])
        rows = column_rows(size, bound, count)
        own = part(tables, at, rows.weights + rows.waves)
        waves, at = section(own, rows, "waves"), at + len(own)
        cos, sin = part(rest, 0, count), part(rest, count, count)
        for i in range(count):
            cos[i], sin[i] = 1.0, 0.0
        for j in range(size):
            m = int(x[j])
            if m == 0:
                continue
            table = 2 * count * (j * (bound + 1) + abs(m))
            c, s = part(waves, table, count), part(waves, table + count, count)
            sign = 1.0 if m > 0 else -1.0
            for i in range(count):
                cos[i], sin[i] = (
                    cos[i] * c[i] - sign * sin[i] * s[i],
                    sin[i] * c[i] + sign * cos[i] * s[i],
                )
        for j in range(size):
            total, carry, weights = 0.0, 0.0, part(section(own, rows, "weights"), j * count, count)
            for i in range(count):  # compensated: T is one of them
                term = weights[i] * cos[i] - carry
                longer = total + term
                carry = (longer - total) - term
                total = longer
            matrix[j * size + k] = total
    out[0] = determinant(size, matrix)
