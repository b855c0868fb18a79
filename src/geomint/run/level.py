"""The set of states where quantities have given values, such as the energy, and ways onto it."""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..arguments import Array, Booleans, finite, whole
from ..errors import DomainError, Gathered, GeomintError, nearest
from ..problems.at_states import writer
from ..problems.evaluate import value
from ..problems.problem import Problem
from ..problems.spaces.conditions import both, written
from .way_back import WayBack, way_back

ROUNDING = 1e-14  # of the sizes of terms: below that their sum says nothing
NEAR_ENOUGH = 1e-11  # of the size of a quantity
ATTEMPTS = 8  # at every state, before there are none
MOST_ITERATIONS = 60
DIFFERENCE = 1e-6  # of the state's size
FEW = 24  # states that are not worth compiling for


class Level:
    r"""{c(y) = 0, F(y) = f}: the conditions of the manifold, and quantities with given values.

    Parameters
    ----------
    problem : Problem
    values : mapping of str to float
        The quantities F and their values f.
    compiled : bool
        Whether it is worth compiling: for many states.

    Attributes
    ----------
    conditions : int
        How many there are in all.
    sizes : array, shape (conditions,)
        What they are measured in: \|f\|, or 1.
    """

    def __init__(
        self, problem: Problem, values: Mapping[str, float], compiled: bool = True
    ) -> None:
        self.problem, self.values = problem, dict(values)
        names = list(values)
        functions = [problem.diagnostics[name] for name in names]
        measure, wanted = problem.measure, [values[name] for name in names]
        if measure is None:
            names = [name for name in problem.constraints if name not in values]
            functions = [*(problem.constraints[name] for name in names), *functions]
            wanted, manifold, own = [0.0] * len(names) + wanted, None, 0
        else:
            manifold, own = measure.manifold, measure.conditions
            wanted = [0.0] * own + wanted
        self._wanted = np.array(wanted)
        self.sizes = np.where(self._wanted != 0.0, np.abs(self._wanted), 1.0)
        self.conditions = len(wanted)
        self._write: Callable[[Array, Array], Array] | None = None
        self._way_back: WayBack | None = None
        if functions or manifold is not None:
            given = written(*functions) if functions else manifold
            if functions and manifold is not None:
                given = both(manifold, own, given, len(functions))
            assert given is not None
            self._write = writer(problem, [given], self.conditions, compiled)
            self._way_back = way_back(problem, given, self._wanted, self.sizes, compiled)

    def off(self, states: Array) -> Array:
        """Return how far conditions are from holding, in their sizes, shape (states, conditions)."""
        if self._write is None:
            return np.zeros((len(states), 0))
        (found,) = self._write(np.zeros(len(states)), states)
        with np.errstate(over="ignore", invalid="ignore"):  # ∞ is off too
            return (found - self._wanted) / self.sizes

    def back(self, ahead: Array, ways: Array, a: Array, on: float) -> tuple[Array, Booleans]:
        """Return ``a`` with ``ahead − a ways`` on the level, from what is given, and which are found.

        Parameters
        ----------
        ahead, ways, a : array, shape (states, rows), (states, conditions, rows), (states, conditions)
        on : float
            By less than that no condition is off, in its size.
        """
        if self._way_back is None:
            return a, np.ones(len(a), dtype=bool)
        return self._way_back(ahead, ways, a, on)

    def gradients(self, states: Array, ways: Array) -> Array:
        """Return the derivatives of `off` along ways, one a row: shape (states, conditions, ways).

        By differences over 1e-6 of the ways, good to some 1e-10.
        """
        return self._differences(states, DIFFERENCE * ways[None]) / (2.0 * DIFFERENCE)

    def _differences(self, states: Array, moves: Array) -> Array:
        """Return ``off(states + moves) − off(states − moves)``: shape (states, conditions, moves)."""
        near = states[:, None, None, :] + np.array([1.0, -1.0])[:, None, None] * moves[:, None]
        shape = (len(states), 2, moves.shape[1], self.conditions)
        values = self.off(near.reshape(-1, states.shape[1])).reshape(shape)
        return (values[:, 0] - values[:, 1]).transpose(0, 2, 1)

    def nearest(self, states: Array) -> tuple[Array, Booleans]:
        """Return states on the level near others, and which of them are: Newton's, least changes."""
        z = states.copy()
        found = np.zeros(len(z), dtype=bool)
        going = np.arange(len(z))
        for _ in range(MOST_ITERATIONS):
            here = self.off(z[going])
            good = np.isfinite(here).all(axis=1)
            on = good & (np.abs(here).max(axis=1, initial=0.0) < NEAR_ENOUGH)
            found[going[on]] = True
            left = good & ~on
            going, here = going[left], here[left]
            if not len(going):
                break
            sizes = np.maximum(np.abs(z[going]).max(axis=1, keepdims=True), 1e-300)
            slopes = self._slopes(z[going], sizes)
            change = (np.linalg.pinv(slopes, 1e-9) @ here[:, :, None])[:, :, 0]
            longest = np.abs(change).max(axis=1, keepdims=True) / (0.5 * sizes)
            z[going] -= change / np.maximum(1.0, longest)
        return z, found

    def _slopes(self, states: Array, sizes: Array) -> Array:
        """Return derivatives by differences over parts of each state's own size; 0 for no numbers."""
        near = np.eye(states.shape[1])[None, :, :] * (DIFFERENCE * sizes)[:, :, None]
        slopes = self._differences(states, near)
        slopes = slopes / (2.0 * DIFFERENCE * sizes)[:, :, None]
        return np.where(np.isfinite(slopes), slopes, 0.0)


def kept_values(problem: Problem, keep: Any, state: Array | None) -> dict[str, float]:
    """Return the values that quantities are to have: as given, or as they are at a state.

    Raises
    ------
    DomainError
        For names that the problem does not have, and numbers that are not finite.
    """
    known = problem.diagnostics
    expected = "names of quantities, or a mapping of them to values"
    try:
        names = [keep] if isinstance(keep, str) else list(keep)
        unknown = [name for name in names if name not in known]
    except TypeError:
        raise DomainError("keep", keep, expected) from None
    for name in unknown:
        hint = nearest(str(name), known)
        raise DomainError("keep", name, f"quantities of {problem.name!r}.{hint}")
    if isinstance(keep, Mapping):
        return {name: finite(f"keep[{name!r}]", keep[name]) for name in names}
    if not names:
        return {}
    if state is None:
        raise DomainError("keep", keep, "values, in a mapping, or a state that has them: at=…")
    return {name: _told(problem, name, value(problem, name, state), state) for name in names}


def _told(problem: Problem, name: str, found: float, state: Array) -> float:
    """Return a value at a state, 0 for what is no more than the rounding of its terms.

    These are as large as Σ |∂F/∂yᵢ yᵢ|. A level of 1e-17 would be met to 1e-28 else, thus nowhere.
    """
    if found == 0.0:
        return found
    level = Level(problem, {name: found}, compiled=False)
    terms = np.abs(level.gradients(state[None, :], np.diag(state))[0, -1]).sum()  # in units of it
    return 0.0 if ROUNDING * terms > 1.0 else found


def on_level(
    level: Level, count: int, rng: np.random.Generator, near: Array | None = None
) -> Array:
    """Return random states of the problem, put onto the level, one a row.

    Raises
    ------
    DomainError
        If there are none within reach.
    """
    problem, found = level.problem, np.zeros((0, level.problem.rows))
    for _ in range(ATTEMPTS):
        missing = count - len(found)
        if not missing:
            break
        somewhere = np.array([_somewhere(problem, near, rng) for _ in range(missing)])
        moved, good = level.nearest(somewhere)
        found = np.concatenate([found, settled_states(problem, moved[good])])
    if len(found) < count:
        expected = (
            f"quantities with which other states of {problem.name!r} can be found: it has "
            f"{problem.rows} numbers, constraints: {', '.join(problem.constraints) or 'none'}; "
            "a representation of the system with fewer may have some (scene.model.problems)"
        )
        raise DomainError("keep", level.values, expected)
    return found


def states_on_level(
    problem: Problem, y0: Any, count: int, keep: Sequence[str] = ("energy",), seed: int = 0
) -> Array:
    """Return random states where quantities have the values that they have at y0.

    A random state of the problem is moved as little as will do by Newton's method. What is kept is kept
    to 1e-11 of its size, the constraints and what is 0 to 1e-11. `geomint.draw_states` gives states by
    the invariant measure.

    Parameters
    ----------
    y0 : array_like
    count : int
        How many.
    keep : names of quantities
    seed : int

    Returns
    -------
    array, shape (count, rows)

    Raises
    ------
    DomainError
        For names that the problem does not have, or if no such states are found.
    """
    state, count = problem.canonical(y0), whole("count", count, 0)
    level = Level(problem, kept_values(problem, keep, state), compiled=count > FEW)
    return on_level(level, count, np.random.default_rng(whole("seed", seed, 0)), state)


def _somewhere(problem: Problem, state: Array | None, rng: np.random.Generator) -> Array:
    if problem.make_random is not None:
        return problem.random_state(rng)
    state = np.zeros(problem.rows) if state is None else state
    size = np.sqrt(np.mean(state * state)) or 1.0
    z, v = state, size * rng.normal(size=len(state))
    return z + v if problem.space is None else problem.space.retract(z, problem.space.tangent(z, v))


def settled_states(problem: Problem, states: Array) -> Array:
    """Return states as the problem has them, without those that it takes for none."""
    settled = []
    with Gathered(quiet=True):
        for z in states:
            with contextlib.suppress(GeomintError):
                settled.append(problem.canonical(z))
    return np.array(settled).reshape(-1, problem.rows)
