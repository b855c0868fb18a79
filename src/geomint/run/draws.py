r"""Random states by the invariant measure of a problem.

On the level N = {c(y) = 0, F(y) = f} the flow keeps μ δ(c) δ(F − f) dy. By the co-area formula that is
the area of N times ``μ / sqrt(det G Gᵀ)`` with G = D(c, F). With a temperature θ the density has a
factor exp(−H/θ), of which the flow keeps the level sets.

Draws are the ends of Markov chains, one for each, all at once (E. Zappa, M. Holmes-Cerfon, J. Goodman,
*Monte Carlo on manifolds*, Comm. Pure Appl. Math. 71 (2018) 2609): a normal step in the tangent space,
back onto N along the normals of where it began, by Newton's method; taken with Metropolis' probability,
and only if the step back is found in the same way, without which the chain would not be reversible.
Gradients come from differences: what they are off by, some 1e-10, moves the density by as much.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..arguments import Array, positive, whole
from ..errors import DomainError, GeomintWarning
from ..problems.problem import Problem
from .at_states import evaluator
from .level import Level, kept_values, on_level, settled_states

__all__ = ["draw_states"]

CHAINS = 64  # at least: by their spread the length of all is chosen
PILOT = 50  # moves while the size of steps is adapted
ACCEPTANCE = 0.45
ROUNDS = 8  # of Newton's method
TINY = 1e-7  # of the units: differences for Newton's method
ON, SAME = 1e-12, 1e-7  # of the units: on the level; the point that the step began at
FORGET = 12.0  # e-folds of the slowest number's correlation with the beginning
TRIED, LONGEST = 1000, 20_000  # moves: before longer chains are given up; of the longest


def draw_states(
    problem: Problem,
    count: int,
    *,
    at: Any = None,
    keep: Any = None,
    temperature: Any = None,
    seed: Any = 0,
) -> Array:
    r"""Return random states distributed by the invariant measure of a problem.

    Parameters
    ----------
    problem : Problem
        With a `Measure`.
    count : int
    at : array_like, shape (rows,), optional
        A state: quantities that are kept have its values.
    keep : names of quantities, or mapping of them to values
        What all draws have in common, such as ``["energy", "K"]`` of `at`, ``{"energy": 0.5}``.
        Default: the energy of `at`; nothing with a temperature.
    temperature : float, optional
        θ, in units of the energy: the weight exp(−energy/θ), with which the measure of all states
        becomes finite.
    seed : int
        The same seed and count give the same states.

    Returns
    -------
    array, shape (count, rows)
        Independent up to e⁻¹² of their correlation with where their chains began: at random states
        put onto the level. A level of several parts has them in the proportions of these.

    Raises
    ------
    DomainError
        For a problem without a measure, quantities that it does not have, values that no state has
        or that depend on each other, and if neither a level nor a temperature makes the measure
        finite.

    Warns
    -----
    GeomintWarning
        If the chains were ended before they had forgotten where they began, such as where a level has
        no bounds: the contact point of a rolling ball may be anywhere.

    Examples
    --------
    >>> import geomint as gi
    >>> scene = gi.load_scene("hamiltonized-n3")
    >>> states = gi.draw_states(scene.problem, 100, at=scene.state, keep=["energy"])
    >>> states.shape
    (100, 6)
    """
    target = _target(problem, at, keep, temperature)
    count, rng = whole("count", count, 1), np.random.default_rng(whole("seed", seed, 0))
    near = None if at is None else problem.canonical(at)
    starts = on_level(target.level, max(count, CHAINS), rng, near)
    chains = _Chains(target, starts, rng)
    chains.adapt()
    chains.run()
    return settled_states(problem, chains.here.states)[:count]


class _Target(NamedTuple):
    """What is drawn from: a level, and the logarithm of the density beside it."""

    level: Level
    log_density: Callable[[Array], Array]


def _target(problem: Problem, at: Any, keep: Any, temperature: Any) -> _Target:
    if not isinstance(problem, Problem):
        raise DomainError("problem", problem, "a geomint.Problem")
    measure = problem.measure
    if measure is None:
        raise DomainError("problem", problem, f"one with a measure; {problem.name!r} states none")
    state = None if at is None else problem.canonical(at)
    names = ([] if temperature is not None else ["energy"]) if keep is None else keep
    values = kept_values(problem, names, state)
    if not values and temperature is None:
        expected = "a quantity, such as the energy, or a temperature: all states together may have"
        raise DomainError("keep", keep, f"{expected} an infinite measure")
    density = evaluator(problem, measure.log_density)
    if temperature is None:
        return _Target(Level(problem, values), lambda y: density(np.zeros(len(y)), y))
    theta = positive("temperature", temperature)
    if "energy" not in problem.diagnostics:
        expected = f"None: {problem.name!r} has no quantity named energy"
        raise DomainError("temperature", temperature, expected)
    energy = evaluator(problem, problem.diagnostics["energy"])

    def weighted(y: Array) -> Array:
        times = np.zeros(len(y))
        return np.asarray(density(times, y) - energy(times, y) / theta)

    return _Target(Level(problem, values), weighted)


class _Points(NamedTuple):
    """Points of the level: states, orthonormal normals, factors of the gradients, log of the density.

    In units of the numbers.
    """

    states: Array
    normals: Array
    factors: Array
    log_density: Array

    def where(self, chosen: npt.NDArray[np.bool_], other: _Points) -> _Points:
        """Return other points where they are chosen."""
        pairs = zip(self, other, strict=True)
        shaped = (chosen.reshape(-1, *[1] * (x.ndim - 1)) for x in self)
        return _Points(*(np.where(c, y, x) for c, (x, y) in zip(shaped, pairs, strict=True)))


class _Chains:
    """Markov chains on a level, all at once."""

    def __init__(self, target: _Target, starts: Array, rng: np.random.Generator) -> None:
        self._target, self._rng = target, rng
        self._units = _units(target.level.problem, starts)
        self._size = 0.5 / np.sqrt(max(starts.shape[1] - target.level.conditions, 1))
        self.here = self._points(starts)
        if not np.isfinite(self.here.log_density).all():
            expected = "quantities that do not depend on each other, where the density is above 0"
            raise DomainError("keep", target.level.values, expected)

    def adapt(self) -> None:
        """Find steps of which about half are taken."""
        for k in range(PILOT):
            taken = self._move()
            self._size *= np.exp((taken.mean() - ACCEPTANCE) * 2.0 / np.sqrt(1.0 + k))

    def run(self) -> None:
        """Move until the beginning is forgotten, by how far a move goes in each number's spread.

        In that of the logarithm of the density too: energies of a temperature are the slowest.
        """
        done, needed, slowest = 0, float(PILOT), 0
        moved = np.zeros(self.here.states.shape[1] + 1)
        while done < needed:
            if done >= TRIED and needed > LONGEST:
                break
            before = self.here
            self._move()
            moved += np.mean((self._seen(self.here) - self._seen(before)) ** 2, axis=0)
            done += 1
            if done % PILOT == 0:
                spread = self._seen(self.here).var(axis=0)
                steady = spread <= 1e-12
                rates = moved / done / (2.0 * np.where(steady, 1.0, spread))
                rates[steady] = 1.0
                slowest = int(np.argmin(rates[:-1]))
                needed = max(FORGET / max(float(rates.min()), 1e-300), float(PILOT))
        if done < needed:
            _warn(self._target.level.problem, slowest)

    def _seen(self, points: _Points) -> Array:
        """Return what is to be forgotten: states in units, and the density's logarithm."""
        density = np.where(np.isfinite(points.log_density), points.log_density, 0.0)
        return np.column_stack([points.states / self._units, density])

    def _points(self, states: Array) -> _Points:
        level, units = self._target.level, self._units
        density = self._target.log_density(states)
        rows = level.gradients(states, units)
        rows = np.where(np.isfinite(rows), rows, 0.0)
        normals, factors = np.linalg.qr(rows.transpose(0, 2, 1))
        pivots = np.abs(np.diagonal(factors, axis1=1, axis2=2))
        with np.errstate(divide="ignore", invalid="ignore"):
            density = density - np.log(pivots).sum(axis=1)
        dependent = (pivots < 1e-9 * pivots.max(axis=1, keepdims=True, initial=0.0)).any(axis=1)
        density = np.where(np.isfinite(density) & ~dependent, density, -np.inf)
        return _Points(states, normals, factors, density)

    def _move(self) -> npt.NDArray[np.bool_]:
        """Move all chains once; return which have taken their steps."""
        old, units = self.here, self._units
        v = _tangent(old, self._size * self._rng.normal(size=old.states.shape))
        states, found = self._back(old, v)
        new = self._points(np.where(found[:, None], states, old.states))
        w = _tangent(new, (old.states - new.states) / units)
        begun, back = self._back(new, w)
        back &= (np.abs(begun - old.states) / units).max(axis=1) < SAME
        # The chances of v and of the step back.
        chances = 0.5 * (np.sum(v * v, axis=1) - np.sum(w * w, axis=1)) / self._size**2
        with np.errstate(invalid="ignore"):
            log_ratio = new.log_density - old.log_density + chances
        taken = found & back & (np.log(self._rng.random(len(v))) < log_ratio)
        self.here = old.where(taken, new)
        return np.asarray(taken)

    def _back(self, points: _Points, v: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Return the points of the level along the normals from ``points + v``, where there are any.

        By Newton's method for the coefficients of the normals, with one-sided differences along these.
        """
        level, units = self._target.level, self._units
        states = points.states + units * v
        if not level.conditions:
            return states, np.ones(len(v), dtype=bool)
        found, going = np.zeros(len(v), dtype=bool), np.arange(len(v))
        ways = units * points.normals.transpose(0, 2, 1)  # a normal a row
        for _ in range(ROUNDS):
            along, here = ways[going], states[going]
            near = np.concatenate([here[:, None], here[:, None] + TINY * along], axis=1)
            off = level.off(near.reshape(-1, len(units))).reshape(*near.shape[:2], -1)
            size = np.abs(off[:, 0]).max(axis=1)
            found[going[size < ON]] = True
            slopes = (off[:, 1:] - off[:, :1]) / TINY
            left = (size >= ON) & (size < 1e6) & np.isfinite(slopes).all(axis=(1, 2))
            if not left.any():
                break
            going = going[left]
            changes = _solved(slopes[left].transpose(0, 2, 1), off[left, 0, :, None])
            states[going] -= np.einsum("ijk,ij->ik", along[left], changes[:, :, 0])
        return states, found


def _warn(problem: Problem, row: int) -> None:
    name = next(n for n, rows in problem.slices.items() if rows.start <= row < rows.stop)
    words = (
        f"draws depend on where chains began: {name!r} of {problem.name!r} may have no bounds on this "
        "level, or chains move too slowly there"
    )
    warnings.warn(words, GeomintWarning, stacklevel=5)


def _tangent(points: _Points, v: Array) -> Array:
    """Return the tangent part of vectors."""
    normals = points.normals
    along = normals @ (normals.transpose(0, 2, 1) @ v[:, :, None])
    return np.asarray(v - along[:, :, 0])


def _solved(matrices: Array, right: Array) -> Array:
    """Return solutions of linear equations; the shortest where there are many or none."""
    try:
        return np.asarray(np.linalg.solve(matrices, right))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.pinv(matrices) @ right)


def _units(problem: Problem, states: Array) -> Array:
    """Return the root mean square of each number, a thousandth of its piece's at least."""
    own = np.mean(states**2, axis=0)
    units = np.ones(problem.rows)
    for rows in problem.slices.values():
        units[rows] = np.sqrt(np.maximum(own[rows], 1e-6 * own[rows].mean()))
    return np.where(units > 0.0, units, 1.0)
