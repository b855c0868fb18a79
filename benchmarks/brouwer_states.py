"""The motions of Brouwer's law: random states of the sphere of `hamiltonized_n3`, and their twins."""

from __future__ import annotations

import numpy as np

import chaplygin as ch
import geomint as gi
from brouwer_fit import Array
from hamiltonized_n3 import A, D

CONDITION = 5.0
TWIN = 1.0 + 2.0**-48


def seeds(count: int) -> list[int]:
    """Return the first seeds of states that are not next to a separatrix."""
    problem, found, seed = sphere(), list[int](), 0
    while len(found) < count:
        if problem.exact(state(seed)).condition <= CONDITION:
            found.append(seed)
        seed += 1
    return found


def sphere(physical: bool = False) -> gi.Problem:
    """Return the sphere, reduced in t or Hamiltonised in τ."""
    own = ch.ChaplyginSphere(a=A, D=D)
    return own.reduced() if physical else own.hamiltonized()


def state(seed: int) -> Array:
    """Return a random state of the Hamiltonised flow with |p̃| = 1, so that one step fits all."""
    y = sphere().random_state(seed)
    y[3:] /= np.linalg.norm(y[3:])
    return y


def starts(chosen: list[int], physical: bool) -> Array:
    """Return all members, and after them the twins of the first half."""
    given = np.array([state(seed) for seed in chosen])
    twins = given[: len(given) // 2].copy()
    twins[:, 3:] *= TWIN
    every = np.concatenate([given, twins])
    if not physical:
        return every
    return np.array([ch.converted(y, sphere(), sphere(True)) for y in every])
