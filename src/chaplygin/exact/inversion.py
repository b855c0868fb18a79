"""Compiled: from the linear angles φ to θ, and the sine series between them.

The parameters are those of `packing`.
"""

import numpy as np

import geomint as gi
from geomint import part, section

from .elimination import solve_in_place
from .packing import torus_rows, torus_sizes

NEWTON, MOST_STRETCHES = 12, 400
TOO_FAR = 1e3  # a step longer than that, or NaN, leads nowhere
QUADRATIC = 1e-10  # after a step below this nothing is left
WHOLE = 2.0**52  # numbers beyond are whole


@gi.helper
def whole_nearest(x):
    """Return the whole number next to x, of two the even one: adding 2⁵² drops the digits."""
    if abs(x) >= WHOLE:
        return x
    return (x + WHOLE) - WHOLE if x >= 0.0 else (x - WHOLE) + WHOLE


@gi.helper
def shift_sums(params, theta, shift, slopes):
    """Write Σ_k shift_k(θ_k) for all angles, and the matrix ∂φ/∂θ."""
    ovals, angles, _, _ = torus_sizes(params)
    rows, at = torus_rows(params), 0
    terms, series = section(params, rows, "terms"), section(params, rows, "series")
    for j in range(angles):
        shift[j] = 0.0
    for k in range(ovals):
        for j in range(ovals):
            slopes[j * ovals + k] = 1.0 if j == k else 0.0
        cos1, sin1 = gi.cos(theta[k]), gi.sin(theta[k])
        cos, sin = cos1, sin1
        for m in range(int(terms[k])):
            for j in range(angles):
                shift[j] += series[at] * sin
                if j < ovals:
                    slopes[j * ovals + k] += (m + 1) * series[at] * cos
                at += 1
            cos, sin = cos * cos1 - sin * sin1, sin * cos1 + cos * sin1


@gi.helper
def newton_steps(params, phi, theta, shift, work):
    """Improve θ by Newton's method; write the shifts there and return the size of the last step."""
    ovals, angles, _, _ = torus_sizes(params)
    slopes, step = part(work, 0, ovals * ovals), part(work, ovals * ovals, ovals)
    largest = 0.0
    for _ in range(NEWTON):
        shift_sums(params, theta, shift, slopes)
        for k in range(ovals):
            step[k] = theta[k] - phi[k] + shift[k]
        solve_in_place(ovals, slopes, step)
        largest = 0.0
        for k in range(ovals):
            largest = max(largest, abs(step[k]))
            theta[k] -= step[k]
        if largest <= QUADRATIC or not largest < TOO_FAR:
            break
    if angles > ovals and largest <= QUADRATIC:  # they want the shifts where θ is now
        shift_sums(params, theta, shift, slopes)
    return largest


@gi.helper
def solve_theta(params, phi, theta, shift, work):
    """Write θ at φ, which winds as φ does, and the shifts there; return the last step's size.

    Newton's method from θ = φ. Next to separatrices the map is far from linear, and that may fail;
    then φ is approached on a straight line, with steps as long as Newton's method allows, from the
    next point whose coordinates are multiples of π: there θ = φ.
    """
    ovals, _, _, _ = torus_sizes(params)
    target = part(work, ovals * ovals + ovals, ovals)
    known = part(work, ovals * ovals + 2 * ovals, ovals)
    for k in range(ovals):
        theta[k] = phi[k]
    largest = newton_steps(params, phi, theta, shift, work)
    if largest <= QUADRATIC:
        return largest
    for k in range(ovals):
        known[k] = np.pi * whole_nearest(phi[k] / np.pi)
        theta[k] = known[k]
    done, ahead = 0.0, 0.125
    for _ in range(MOST_STRETCHES):
        reach = min(1.0, done + ahead)
        for k in range(ovals):
            start = np.pi * whole_nearest(phi[k] / np.pi)
            target[k] = start + reach * (phi[k] - start)
        largest = newton_steps(params, target, theta, shift, work)
        if largest <= QUADRATIC:
            if reach == 1.0:
                break
            done, ahead = reach, 2.0 * ahead
            for k in range(ovals):
                known[k] = theta[k]
        else:
            ahead *= 0.25
            for k in range(ovals):
                theta[k] = known[k]
    return largest
