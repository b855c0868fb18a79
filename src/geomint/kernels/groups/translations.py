"""R^m moving m rows by translation: the algebra is R^m, and nothing is turned."""

from ..compiling.recorded import helper


@helper
def shift(layout, xi, y, out, work):
    """Write ξ = (y + ξ) − y."""
    for i in range(len(xi)):
        out[i] = 1.0 * xi[i]


@helper
def commute(layout, x, y, out, work):
    """Write 0."""
    for i in range(len(x)):
        out[i] = 0.0 * x[i]


@helper
def unchanged(layout, u, v, out, work):
    """Write v."""
    for i in range(len(v)):
        out[i] = 1.0 * v[i]


@helper
def endless(layout, u, work):
    """Return 0: the coordinates end nowhere."""
    return 0.0 * u[0]
