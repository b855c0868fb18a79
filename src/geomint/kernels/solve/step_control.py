"""Step size control: how large an error estimate is, and what step it asks for next.

The factor by which a step changes needs three digits, but the same three everywhere: so logarithm and
exponential are made here of ``+ − × ÷``, and the sequence of steps does not depend on a C library.
Everything is float64: a run has one step at a time.
"""

from ..compiling.recorded import helper
from ..numbers.arithmetic import maximum, sqrt

LOG_2 = 0.6931471805599453
ROOT_2 = 1.4142135623730951
LOG_SAFETY = -0.10536051565782628  # log 0.9
LOG_SMALLEST = -1.6094379124341003  # log 0.2
LOG_LARGEST = 2.302585092994046  # log 10
FAILED = 0.2  # after a step without an estimate
# Exponents of the PI controller, times the order of the estimate: K. Gustafsson, ACM Trans. Math.
# Softw. 17 (1991) 533. Against those of the code DOPRI5 (0.85, 0.2) they reject far fewer steps, and
# need up to 24 % fewer evaluations for the same error (1 % more in the worst of twelve runs).
PRESENT, FORMER = 0.7, 0.4


@helper
def logarithm(x):
    """Return log x to 1e-9, for x cut to [1e-12, 1e12]."""
    x = 1e-12 if x < 1e-12 else (1e12 if x > 1e12 else x)
    power = 0.0
    while x > ROOT_2:
        x *= 0.5
        power += 1.0
    while x < 1.0 / ROOT_2:
        x *= 2.0
        power -= 1.0
    z = (x - 1.0) / (x + 1.0)
    s = z * z
    return power * LOG_2 + 2.0 * z * (
        1.0 + s * (1.0 / 3.0 + s * (1.0 / 5.0 + s * (1.0 / 7.0 + s / 9.0)))
    )


@helper
def exponential(x):
    """Return exp x to 1e-8, for x cut to what a factor may be."""
    x = LOG_SMALLEST if x < LOG_SMALLEST else (LOG_LARGEST if x > LOG_LARGEST else x)
    x /= 16.0
    result = 1.0 + x * (1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0 * (1.0 + x / 5.0))))
    for _ in range(4):
        result *= result
    return result


@helper
def next_factor(order, error, former):
    """Return the factor for the step after one with this error, in units of what is allowed.

    `former` is the logarithm of the error before.
    """
    return exponential(LOG_SAFETY + (FORMER * former - PRESENT * logarithm(error)) / order)


@helper
def retry_factor(order, error):
    """Return the factor for another try after an error above 1 (or NaN); less than 1."""
    if not error < 1e12:
        return FAILED
    return exponential(LOG_SAFETY - logarithm(error) / order)


@helper
def error_size(rtol, atol, pieces, y, increment, error, low, estimates: int):
    """Return the error in units of what is allowed: 1 at the tolerance; NaN if a number is NaN.

    What is allowed in a piece of the state is ``atol + rtol max |y_i|``, over the rows i of the piece
    before and after the step; the largest ratio over all pieces counts. With a second estimate
    `low` of lower order the ratios e and e_low make ``e² / (e² + 0.01 e_low²)^½``.

    Parameters
    ----------
    pieces : block
        The number of the piece that each row belongs to; rows of a piece are neighbours.
    """
    e, e_low = 0.0, 0.0
    r = 0
    while r < len(pieces):
        piece = pieces[r]
        size, wrong, wrong_low = 0.0, 0.0, 0.0
        while r < len(pieces) and pieces[r] == piece:
            size = maximum(maximum(abs(y[r]), abs(y[r] + increment[r])), size)
            wrong = maximum(abs(error[r]), wrong)
            if estimates == 2:
                wrong_low = maximum(abs(low[r]), wrong_low)
            r += 1
        allowed = atol + rtol * size
        if wrong != 0.0:  # a piece that is 0 and stays 0 allows nothing and errs by nothing
            e = maximum(wrong / allowed, e)
        if wrong_low != 0.0:
            e_low = maximum(wrong_low / allowed, e_low)
    if estimates == 2 and e > 0.0:
        ratio = e_low / e
        return e / sqrt(1.0 + 0.01 * ratio * ratio)
    return e
