"""Motions for the tests of the exact flow: every pattern of equal a_i, special states."""

import numpy as np
import pytest

import chaplygin as ch
from tests.chaplygin.support import rng_for

# Which a_i are equal: multiplicities of different values, in a mixed order.
PATTERNS = {
    "2": (1, 1),
    "3": (1, 1, 1),
    "4": (1, 1, 1, 1),
    "5": (1,) * 5,
    "6": (1,) * 6,
    "7": (1,) * 7,
    "lagrange": (2, 1),
    "two-pairs": (2, 2),
    "pair-of-four": (2, 1, 1),
    "triple-and-pair": (3, 2, 1),
    "two-triples": (3, 3),
    "pair-of-five": (1, 2, 1, 1),
    "circle-2": (2,),
    "circle-4": (4,),
}
# In the fast row those of few dimensions, which are of all kinds.
LATE = ("6", "7", "two-triples", "pair-of-five")
patterns = pytest.mark.parametrize(
    "pattern", [pytest.param(x, marks=[pytest.mark.nightly] * (x in LATE)) for x in PATTERNS]
)
# Of a derivative by a central difference of order 8.
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
TAU_AND_T = ("sphere-tau", "sphere-t", "body-tau", "body-t")


def parameters(pattern, seed=0):
    """Return (a, D of the sphere, D of the body)."""
    multiplicities = PATTERNS[pattern]
    n = sum(multiplicities)
    rng = rng_for(n, seed + 31 * len(multiplicities))
    while True:  # apart, so that what is tested is not the condition
        values = rng.uniform(0.6, 1.6, len(multiplicities))
        if len(values) == 1 or np.min(np.diff(np.sort(values))) > 0.25 / len(values):
            break
    a = rng.permutation(np.repeat(values, multiplicities))
    largest = np.sort(a)[-1] * np.sort(a)[-2]
    return a, largest * rng.uniform(1.1, 3.0), rng.uniform(0.5, 3.0)


def problem_of(pattern, kind, seed=0):
    a, sphere, body = parameters(pattern, seed)
    system = ch.ChaplyginSphere(a, sphere) if kind.startswith("sphere") else ch.Veselova(a, body)
    return system.hamiltonized() if kind.endswith("tau") else system.reduced()


def flow_of(problem, gamma, momentum):
    """Return a state from any γ and momentum, projected."""
    gamma = np.array(gamma, dtype=float) / np.linalg.norm(gamma)
    momentum = np.array(momentum, dtype=float)
    momentum -= (gamma @ momentum) * gamma
    return problem.canonical(np.concatenate([gamma, momentum]))


def special_states(problem, seed=0):
    """Return states within coordinate planes, and with groups that move along lines."""
    n = problem.rows // 2
    a = np.array(problem.parameters["a"])
    y = problem.random_state(seed)
    gamma, p = y[:n].copy(), y[n:].copy()
    found = {}
    for i in range(n):
        if n > 2:
            inside = np.arange(n) != i
            found[f"plane-{i}"] = flow_of(problem, gamma * inside, p * inside)
    for value in np.unique(a):
        group = a == value
        if np.count_nonzero(group) > 1 and not group.all():
            along = gamma[group] / np.linalg.norm(gamma[group])
            line = p.copy()
            line[group] = 0.7 * along
            # The projection keeps p_G parallel to γ_G.
            found[f"line-{np.argmax(group)}"] = flow_of(problem, gamma, line)
            moved, still = gamma.copy(), p.copy()
            moved[group] = 0.0
            found[f"origin-{np.argmax(group)}"] = flow_of(problem, moved, still)
    return found


def turn_of(exact):
    """Return the time in which the fastest angle advances by one."""
    return 1.0 / np.max(np.abs(exact.frequencies))


def turned(x):
    """Angles modulo 2π, in [−π, π]."""
    return x - 2 * np.pi * np.rint(x / (2 * np.pi))
