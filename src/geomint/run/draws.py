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

from typing import Any

import numpy as np

from ..arguments import Array, positive, whole
from ..errors import DomainError, StateWarning, tell
from ..problems.at_states import evaluator
from ..problems.problem import Problem
from .chains import Chains, Target
from .level import Level, kept_values, on_level, settled_states

CHAINS = 64  # at least: by their spread the length of all is chosen


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
        Independent up to e⁻¹⁰ of their correlation with where their chains began: at random states put
        onto the level, or at `at` where the problem has none. A level of several parts has draws in the
        proportions of where chains begin: of `at` alone those of its part. All draws depend on the
        count, as steps are sized by all.

    Raises
    ------
    DomainError
        For a problem without a measure, quantities that it does not have or that are constraints,
        values that no state has or that depend on each other, an energy that is kept and has a
        temperature, and if neither a level nor a temperature makes the measure finite.

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
    chains = Chains(target, _starts(target.level, max(count, CHAINS), rng, near), rng)
    chains.adapt()
    slowest = chains.run()
    if slowest is not None:
        name = next(n for n, r in problem.slices.items() if r.start <= slowest < r.stop)
        text = (
            f"draws depend on where chains began: {name!r} of {problem.name!r} may have no bounds on "
            "this level, or chains move too slowly there"
        )
        tell(StateWarning(text, name))
    states = settled_states(problem, chains.here.states[:count])
    if len(states) < count:
        expected = (
            f"a level on which {problem.name!r} admits all states, not {len(states)} of {count}"
        )
        raise DomainError("keep", target.level.values, expected)
    return states


def _starts(level: Level, count: int, rng: np.random.Generator, near: Array | None) -> Array:
    """Return where chains begin: at random states, or all at the one that is given."""
    if level.problem.make_random is not None or near is None:
        return on_level(level, count, rng, near)
    (state,), (found,) = level.nearest(near[None, :])
    if not found:
        expected = "values that states near `at` have"
        raise DomainError("keep", level.values, expected)
    return np.repeat(state[None, :], count, axis=0)


def _target(problem: Problem, at: Any, keep: Any, temperature: Any) -> Target:
    if not isinstance(problem, Problem):
        raise DomainError("problem", problem, "a geomint.Problem")
    measure = problem.measure
    if measure is None:
        raise DomainError("problem", problem, f"one with a measure; {problem.name!r} states none")
    state = None if at is None else problem.canonical(at)
    names = ([] if temperature is not None else ["energy"]) if keep is None else keep
    values = kept_values(problem, names, state)
    for name in values:
        if name in problem.constraints:
            expected = f"no constraint: of {problem.name!r} every state meets it"
            raise DomainError("keep", name, expected)
    if not values and temperature is None:
        expected = "a quantity, such as the energy, or a temperature: all states together may have"
        raise DomainError("keep", keep, f"{expected} an infinite measure")
    density = evaluator(problem, measure.log_density)
    if temperature is None:
        return Target(Level(problem, values), lambda y: density(np.zeros(len(y)), y))
    theta = positive("temperature", temperature)
    if "energy" in values:
        raise DomainError("temperature", temperature, "None where the energy is kept")
    if "energy" not in problem.diagnostics:
        expected = f"None: {problem.name!r} has no quantity named energy"
        raise DomainError("temperature", temperature, expected)
    energy = evaluator(problem, problem.diagnostics["energy"])

    def weighted(y: Array) -> Array:
        times = np.zeros(len(y))
        return density(times, y) - energy(times, y) / theta

    return Target(Level(problem, values), weighted)
