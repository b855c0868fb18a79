"""Random states of the system of Hénon and Heiles."""

from __future__ import annotations

import numpy as np


def states(energy: float, count: int, seed: int) -> list[np.ndarray]:
    """Return random states (q, p) with q₁ = 0 of that energy."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        q, p = rng.uniform(-0.5, 1.0), rng.uniform(-0.6, 0.6)
        rest = 2.0 * energy - p * p - q * q + 2.0 * q**3 / 3.0
        if rest > 0.0:
            found.append(np.array([0.0, q, np.sqrt(rest), p]))
    return found
