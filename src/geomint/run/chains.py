r"""Markov chains on a level, all at once: normal steps in the tangent space, and back along normals.

E. Zappa, M. Holmes-Cerfon, J. Goodman, *Monte Carlo on manifolds*, Comm. Pure Appl. Math. 71
(2018) 2609; steps that would cross to another part of a level are refused, there and back.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..arguments import Array, Booleans
from ..errors import DomainError
from ..problems.problem import Problem
from .level import Level

PILOT, PILOTS = 50, 4  # moves while the frame and the size of steps are adapted, and how often
ACCEPTANCE = 0.35
LENGTHS, CHOSEN = (1.0, 0.25, 0.0625), (0.8, 0.1, 0.1)  # of steps, for where a level bends sharply
BENT = 0.1  # of a step: by that much it may end elsewhere than its first half foretells
TURNED = 0.0  # the least product of cosines between the normals at both ends of a step
FLAT = 0.01  # of the square of a number's size: the least spread that a frame has
ON, ROUGHLY = 1e-12, 1e-4  # of sizes: on the level; so for a look ahead
SAME = 1e-7  # of the frame: the same point
RECALLED = 0.05  # of correlations after `PILOT` moves: less is not told from none
FORGET = 7.0  # e-folds of the slowest correlation with the beginning
TRIED, LONGEST = 1000, 6000  # moves: before longer chains are given up; of the longest


class Target(NamedTuple):
    """What is drawn from: a level, and the logarithm of the density beside it."""

    level: Level
    log_density: Callable[[Array], Array]


class _Points(NamedTuple):
    """Points of the level: states, orthonormal normals, logarithms of the density.

    In the frame of the chains.
    """

    states: Array
    normals: Array
    log_density: Array

    def where(self, chosen: Booleans, other: _Points) -> _Points:
        """Return other points where they are chosen."""
        pairs = zip(self, other, strict=True)
        shaped = (chosen.reshape(-1, *[1] * (x.ndim - 1)) for x in self)
        return _Points(*(np.where(c, y, x) for c, (x, y) in zip(shaped, pairs, strict=True)))


class Chains:
    """Markov chains on a level, all at once."""

    def __init__(self, target: Target, starts: Array, rng: np.random.Generator) -> None:
        self._target, self._rng = target, rng
        self._size = 0.5 / np.sqrt(max(starts.shape[1] - target.level.conditions, 1))
        self._measured(starts)
        if not np.isfinite(self.here.log_density).all():
            expected = "quantities that do not depend on each other, where the density is above 0"
            raise DomainError("keep", target.level.values, expected)

    def _measured(self, states: Array) -> None:
        """Take the frame of steps from where chains are."""
        self._frame = _frame(self._target.level.problem, states)
        self._inverse = np.linalg.inv(self._frame)
        self.here = self._points(states)

    def adapt(self) -> None:
        """Find a frame, and steps of which about half are taken."""
        for _ in range(PILOTS):
            for k in range(PILOT):
                taken, lengths = self._move()
                part = taken[lengths == LENGTHS[0]].mean()  # short ones mostly are
                self._size *= np.exp((part - ACCEPTANCE) * 2.0 / np.sqrt(1.0 + k))
            self._measured(self.here.states)

    def run(self) -> int | None:
        """Move until the beginning is forgotten, or return the number that is slowest to be.

        How fast that goes is told by how far a move goes beside how far chains are spread: of what has
        the least of it, of all combinations of numbers and of the density's logarithm (of a
        temperature energies are the slowest).
        """
        done, needed, slowest = 0, float(PILOT), 0
        moved = []
        while done < needed:
            if done >= TRIED and needed > LONGEST:
                break
            before = self._seen()
            for _ in range(PILOT):
                self._move()
            done += PILOT
            change = self._seen() - before
            with np.errstate(over="ignore", invalid="ignore"):
                moved.append(change.T @ change / len(change))
            late = np.mean(moved[len(moved) // 2 :], axis=0)  # without the way from the beginning
            part, slowest = _slowest(self._seen(), late)
            rate = -np.log(max(1.0 - part, RECALLED)) / PILOT
            needed = max(FORGET / max(rate, 1e-300), float(PILOT))
        return slowest if done < needed else None

    def _seen(self) -> Array:
        """Return what is to be forgotten: numbers, their squares, the density's logarithm."""
        density = np.where(np.isfinite(self.here.log_density), self.here.log_density, 0.0)
        numbers = self.here.states @ self._inverse.T
        return np.column_stack([numbers, numbers**2, density])

    def _points(self, states: Array) -> _Points:
        level = self._target.level
        density = self._target.log_density(states)
        rows = level.gradients(states, self._frame.T)
        rows = np.where(np.isfinite(rows), rows, 0.0)
        normals, factors = np.linalg.qr(rows.transpose(0, 2, 1))
        pivots = np.diagonal(factors, axis1=1, axis2=2)
        normals = normals * np.where(pivots < 0.0, -1.0, 1.0)[:, None, :]  # as gradients point
        pivots = np.abs(pivots)
        with np.errstate(divide="ignore", invalid="ignore"):
            density = density - np.log(pivots).sum(axis=1)
        dependent = (pivots < 1e-9 * pivots.max(axis=1, keepdims=True, initial=0.0)).any(axis=1)
        density = np.where(np.isfinite(density) & ~dependent, density, -np.inf)
        return _Points(states, normals, density)

    def _move(self) -> tuple[Booleans, Array]:
        """Move all chains once; return which have taken their steps, and of which lengths these are."""
        old = self.here
        lengths = self._rng.choice(LENGTHS, len(old.states), p=CHOSEN)
        sizes = self._size * lengths
        v = _tangent(old, sizes[:, None] * self._rng.normal(size=old.states.shape))
        states, found = self._back(old, v)
        new = self._points(np.where(found[:, None], states, old.states))
        w = _tangent(new, (old.states - new.states) @ self._inverse.T)
        begun, back = self._back(new, w)
        back &= np.abs((begun - old.states) @ self._inverse.T).max(axis=1) < SAME
        # Parts of a level on both sides of a saddle have opposite normals: there is no step across.
        back &= np.linalg.det(old.normals.transpose(0, 2, 1) @ new.normals) > TURNED
        # The chances of v and of the step back.
        chances = 0.5 * (np.sum(v * v, axis=1) - np.sum(w * w, axis=1)) / sizes**2
        with np.errstate(invalid="ignore"):
            log_ratio = new.log_density - old.log_density + chances
        taken = found & back & (np.log(self._rng.random(len(v))) < log_ratio)
        self.here = old.where(taken, new)
        return taken, lengths

    def _back(self, points: _Points, v: Array) -> tuple[Array, Booleans]:
        """Return the points of the level along the normals from ``points + v``, where there are any.

        The first half of a step has to foretell, by a parabola, where the whole ends: else normals may
        meet another part of the level.
        """
        level, moves = self._target.level, v @ self._frame.T
        ways = points.normals.transpose(0, 2, 1) @ self._frame.T  # a normal a row
        nothing = np.zeros(ways.shape[:2])
        half, near = level.back(points.states + 0.5 * moves, ways, nothing, ROUGHLY)
        begun = np.where(near[:, None], 4.0 * half, 0.0)
        whole, found = level.back(points.states + moves, ways, begun, ON)
        off = np.linalg.norm(whole - 4.0 * half, axis=1)
        found &= near & (off < BENT * np.linalg.norm(v, axis=1))
        ends = v - (points.normals @ whole[:, :, None])[:, :, 0]
        return points.states + np.where(found[:, None], ends, 0.0) @ self._frame.T, found


def _slowest(seen: Array, moved: Array) -> tuple[float, int]:
    """Return the least of uᵀ M u / 2 uᵀ C u over u, and the number that has most of it.

    M = `moved` is the mean square of a move, C the spread of what is `seen`. Numbers that are too large
    to tell are forgotten at no rate.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        covariance = np.cov(seen.T)
    if not (np.isfinite(covariance).all() and np.isfinite(moved).all()):
        return 0.0, int(np.abs(seen[:, : (seen.shape[1] - 1) // 2]).max(axis=0).argmax())
    spreads, ways = np.linalg.eigh(covariance)
    varies = spreads > 1e-12
    if not varies.any():
        return 1.0, 0
    frame = ways[:, varies] / np.sqrt(spreads[varies])
    rates, combined = np.linalg.eigh(frame.T @ moved @ frame)
    most = np.abs(ways[:, varies] @ (np.sqrt(spreads[varies]) * combined[:, 0]))
    return 0.5 * float(rates[0]), int(most[:-1].argmax()) % (len(most) // 2)


def _tangent(points: _Points, v: Array) -> Array:
    """Return the tangent part of vectors."""
    normals = points.normals
    along = normals @ (normals.transpose(0, 2, 1) @ v[:, :, None])
    return v - along[:, :, 0]


def _frame(problem: Problem, states: Array) -> Array:
    """Return F, states being like F z with z of size 1 in all ways: what steps are sized by.

    By the spread of states about their mean; of no way less than a tenth of what each number has by its
    size, so that a cloud that is still small keeps no step inside.
    """
    own = np.mean(states**2, axis=0)
    for rows in problem.slices.values():
        own[rows] = np.maximum(own[rows], 1e-6 * own[rows].mean())
    own = np.where(own > 0.0, own, 1.0)
    scales = np.sqrt(own)
    spread = np.cov((states / scales).T).reshape(len(own), len(own))
    return scales[:, None] * np.linalg.cholesky(spread + FLAT * np.eye(len(own)))
