"""Random rolling balls of radius `RHO`, in both forms, for the tests of this folder."""

import chaplygin as ch
from tests.chaplygin.support import quiet_state, random_rotation, rng_for

RHO = 0.7


def ball(make, n, seed=0):
    """Return inertia, m and D of a random ball of radius RHO."""
    inertia = make(n, seed)
    D = getattr(inertia, "D", 1.3)
    return inertia, D / RHO**2, D


def start(n, seed=0):
    """Return a random attitude, position and angular velocity."""
    rng = rng_for(n, seed + 70)
    size = n * (n - 1) // 2
    return {
        "g": random_rotation(n, seed), "r": rng.normal(size=n - 1), "omega": rng.normal(size=size)
    }  # fmt: skip


def both(make, n, seed=0, k0=None):
    """Return both problems and the same random state for each."""
    inertia, m, _ = ball(make, n, seed)
    problems = ch.rolling_problem(inertia, m, RHO, k0), ch.contact_problem(inertia, m, RHO, k0)
    return problems, [quiet_state(problem, **start(n, seed)) for problem in problems]


def pieces(problem, y):
    return {name: y[where] for name, where in problem.slices.items()}
