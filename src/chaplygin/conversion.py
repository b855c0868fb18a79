"""States of one representation as states of another: the chain of reductions, both ways."""

from typing import Any

import geomint as gi

from .manifold import Array, skew_matrix

CARRIED = ("g", "r")  # what reductions forget


def converted(y: Any, source: gi.Problem, target: gi.Problem) -> Array:
    """Return the state of `target` that describes the same motion as the state y of `source`.

    Attitude and contact point go along where both problems have them. Where only the target has
    them, they are the smallest rotation that takes γ to E_n, and the origin.

    Parameters
    ----------
    y : array_like
        A flat state of `source`.
    source, target : Problem
        Representations of one system: of a ball, a rubber ball, or a body of Veselova's.

    Raises
    ------
    geomint.DomainError
        If `target` has no such state: the message of the target says what is missing, such as zero
        SO(n−1)-momentum on T*S^(n−1).

    Examples
    --------
    >>> import chaplygin as ch
    >>> sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
    >>> y = sphere.reduced().state(gamma=[0.6, 0.0, 0.8], p=[0.8, 1.0, -0.6])
    >>> ch.converted(y, sphere.reduced(), sphere.classical())[3:]
    array([0.6, 0. , 0.8])
    """
    state = source.canonical(y)
    common = dict(source.physical_state(state))
    if "gamma" in common:  # as a matrix k means the same for vectors and for triangles
        common["k"] = skew_matrix(common["k"], len(common["gamma"]))
    both = dict(source.pieces).keys() & dict(target.pieces).keys()
    for name in CARRIED:
        if name in both:
            common[name] = state[source.slices[name]]
    if "g" in dict(target.pieces) and "X" in common:
        del common["X"]  # the first rows of g
    return target.state(**common)
