"""What an ensemble is given: problems, states, and the arguments of `geomint.solve` for each."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...arguments import MOST_NUMBERS, Array, Booleans, Integers, as_array
from ...errors import DomainError, Gathered, GeomintError, GeomintWarning, StateWarning, tell
from ...methods import Exact, Method
from ...problems.declaration import unshared
from ...problems.problem import Problem


@dataclass(frozen=True, eq=False)
class Members:
    """Problems and the states that they begin at.

    Attributes
    ----------
    problems : tuple of Problem
        One for each member, or one for all.
    states : array, shape (members, rows)
    admitted : array of bool, shape (members,)
        Whether a state is one of its problem: of others the member's own run tells why not.
    told : dict of int to tuple of GeomintWarning
        What was changed in states.
    """

    problems: tuple[Problem, ...]
    states: Array
    admitted: Booleans
    told: dict[int, tuple[GeomintWarning, ...]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.states)

    def problem(self, k: int) -> Problem:
        """Return the problem of a member."""
        return self.problems[0 if len(self.problems) == 1 else k]

    def differing(self) -> dict[str, Array]:
        """Return the parameters that differ between members and are single numbers."""
        found = {}
        for name in self.problems[0].parameters if len(self.problems) > 1 else ():
            values = [problem.parameters.get(name) for problem in self.problems]
            if all(isinstance(v, int | float) for v in values) and len(set(values)) > 1:
                found[name] = np.array(values, dtype=np.float64)
        return found

    def of(self, which: Integers) -> Members:
        """Return some members, with problems of their own: nothing is shared that a run changes."""
        told = {i: self.told[k] for i, k in enumerate(which.tolist()) if k in self.told}
        own = [0] if len(self.problems) == 1 else which
        problems = tuple(unshared(self.problems[k]) for k in own)
        return Members(problems, self.states[which], self.admitted[which], told)


@dataclass(frozen=True)
class Asked:
    """How every member is integrated, and what is wanted of it.

    Attributes
    ----------
    method : Method
    shared : dict
        Arguments of `geomint.solve` that are the same for all.
    members : int
        How many there are in all.
    wanted : dict
        What is wanted beside states after steps: states at times, events, quantities.
    readings : dict of str to Reading
        What is read off every member.
    keep_states : bool
        Whether states along the runs are kept after that.
    streamed : bool
        Whether what becomes of a block goes to the disk at once.
    """

    method: Method
    shared: dict[str, Any]
    members: int
    wanted: dict[str, Any] = field(default_factory=dict)
    readings: dict[str, Any] = field(default_factory=dict)
    keep_states: bool = True
    streamed: bool = False

    @property
    def steps_alone(self) -> bool:
        """Whether all that is wanted are states after steps of given lengths."""
        fixed = not (self.method.adaptive or isinstance(self.method, Exact))
        return fixed and not self.wanted

    @property
    def ends(self) -> dict[str, Any]:
        """Where members begin and end, and their step."""
        return {name: self.shared[name] for name in ("t_end", "tau_end", "step", "t0")}

    @property
    def times(self) -> Any:
        """The times at which states are wanted, of either kind; None where they are not."""
        return self.wanted.get("t_eval", self.wanted.get("tau_eval"))

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of `geomint.solve`; what remembers runs is a copy."""
        given = {**self.shared, **{name: _copied(value) for name, value in self.wanted.items()}}
        return {**given, "method": self.method, "progress": False}


def _copied(value: Any) -> Any:
    """Return a copy, or what cannot be copied itself, of which `solve` tells what is wrong."""
    try:
        return copy.copy(value)
    except Exception:  # whatever a foreign object raises there
        return value


def canonical_members(problems: Any, states: Any) -> Members:
    """Return members; if none has an admissible state, raise `DomainError` that names the first.

    Warnings of states that are projected are summed up in one.
    """
    chosen = _problems(problems)
    rows = chosen[0].rows
    expected = f"states of {rows} numbers in their order, one a row"
    given = as_array("states", states, expected)
    given = given[None, :] if given.ndim == 1 else given
    if given.ndim != 2 or given.shape[1] != rows or not len(given):
        raise DomainError("states", states, expected)
    count = max(len(given), len(chosen))
    if len(given) not in (1, count) or len(chosen) not in (1, count):
        expected = f"{len(chosen)} of them, one for each problem, or one for all"
        raise DomainError("states", states, expected)
    if count * rows > MOST_NUMBERS:
        raise DomainError("states", states, f"at most {MOST_NUMBERS // rows} of them")
    found = np.broadcast_to(given, (count, rows)).copy()
    told = {}
    admitted, refused = np.ones(count, dtype=bool), None
    for k in _unsettled(chosen, found):
        with Gathered(quiet=True) as changes:
            try:
                found[k] = chosen[k if len(chosen) > 1 else 0].canonical(found[k])
            except GeomintError as error:
                admitted[k], refused = False, refused or (k, error)
        if changes:
            told[k] = tuple(changes)
    if refused and not admitted.any():
        k, why = refused
        raise DomainError(f"states[{k}]", found[k], f"a state of the problem: {why}") from why
    if told:
        k, (first, *_) = next(iter(told.items()))
        text = f"{len(told)} of {count} states were changed; states[{k}]: {first}"
        tell(StateWarning(text, first.quantity, first.size))
    return Members(chosen, found, admitted, told)


def _unsettled(problems: tuple[Problem, ...], states: Array) -> list[int]:
    """Return the numbers of states that a problem has to look at: not those that it surely takes."""
    problem = problems[0]
    settled = np.zeros(len(states), dtype=bool)
    if all(p.admit is None for p in problems):
        settled[:] = np.isfinite(states).all(axis=1)
    elif problem.space is not None and all(p.admit == problem.space.admit for p in problems):
        settled = problem.space.settled(states)
    return [int(k) for k in np.flatnonzero(~settled)]


def _problems(problems: Any) -> tuple[Problem, ...]:
    if isinstance(problems, Problem):
        return (problems,)
    expected = "a geomint.Problem, or several with the same pieces in the same time"
    if not isinstance(problems, Sequence) or not problems:
        raise DomainError("problems", problems, expected)
    for problem in problems:
        if not isinstance(problem, Problem):
            raise DomainError("problems", problem, expected)
        if problem.pieces != problems[0].pieces or problem.time != problems[0].time:
            raise DomainError("problems", problem, expected)
    return tuple(problems)
