"""The invariant measure, globally: an ensemble drawn from a density and pushed forward keeps it.

Two samples are compared by the energy distance of (γ₁², γ₂², γ₃²), with a p-value by permutations
(G. J. Székely, M. L. Rizzo, J. Stat. Plann. Inference 143 (2013) 1249). 1000 draws see the multiplier
of this sphere, and what heun-2 makes of energies, in 3 of 3 choices of seeds each (at 5 %).
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi

REDUCED = ch.ChaplyginSphere(a=[0.1, 1.0, 2.9], D=3.0).reduced()
UNIFORM = dataclasses.replace(
    REDUCED,
    measure=gi.Measure(manifold=REDUCED.measure.manifold, conditions=REDUCED.measure.conditions),
)
COUNT, PERMUTATIONS, KEPT, REJECTED = 1000, 99, 0.01, 0.05


def chance(one: np.ndarray, other: np.ndarray) -> float:
    """Return the part of permutations of both samples that are as far apart as these."""
    joined = np.concatenate([one[:, :3] ** 2, other[:, :3] ** 2])
    apart = np.sqrt(((joined[:, None] - joined[None]) ** 2).sum(axis=-1))
    n, m, total = len(one), len(other), apart.sum()

    def distance(first: np.ndarray) -> float:
        s = np.zeros(n + m)
        s[first] = 1.0
        along = apart @ s
        within, across = s @ along, (1.0 - s) @ along
        rest = total - within - 2.0 * across
        return float(2.0 * across / (n * m) - within / n**2 - rest / m**2)

    rng = np.random.default_rng(0)
    found = distance(np.arange(n))
    larger = sum(distance(rng.permutation(n + m)[:n]) >= found for _ in range(PERMUTATIONS))
    return (1 + larger) / (1 + PERMUTATIONS)


def pushed(problem: gi.Problem, seed: int, method: str) -> tuple[np.ndarray, np.ndarray]:
    """Return draws of a problem's measure moved for 1000 steps of the true flow, and other draws."""
    draws, others = (
        gi.draw_states(problem, COUNT, temperature=0.2, seed=s) for s in (seed, 100 + seed)
    )
    many = gi.solve_ensemble(REDUCED, draws, t_end=100.0, method=method, step=0.1)
    kept = np.isfinite(many.final).all(axis=1) & (np.abs(many.final) < 1e6).all(axis=1)
    return many.final[kept], others


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_method_that_keeps_it_is_not_told_from_the_measure(seed: int) -> None:
    assert chance(*pushed(REDUCED, seed, "gauss-8")) > KEPT


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_wrong_density_is(seed: int) -> None:
    assert chance(*pushed(UNIFORM, seed, "gauss-8")) <= REJECTED


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_method_that_heats_is(seed: int) -> None:
    assert chance(*pushed(REDUCED, seed, "heun-2")) <= REJECTED
