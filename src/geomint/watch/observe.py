"""What is watched along a run: chosen by name, and reduced to windows on the fly."""

from collections.abc import Mapping
from types import FunctionType
from typing import Any

import numpy as np

from ..arguments import Array, Booleans, check_name
from ..errors import DomainError
from ..kernels.compiling.recorded import Recorded
from ..problems.problem import GROUPS, Problem
from .drift import Drift
from .functions import Function
from .quantities import expanded, watcher_of
from .registry import checked_watcher
from .watcher import Run, Seen, Watcher


def choose_watchers(problem: Problem, wanted: Any) -> dict[str, Watcher]:
    """Return the watchers that `wanted` asks for, by name.

    Parameters
    ----------
    wanted : iterable of str, or mapping of str to what is watched under that name
        Names: of the problem's diagnostics; ``"measure"`` (`geomint.watch.measure`), if the problem has
        one; ``"symplectic"`` (`geomint.watch.symplectic`), if it has a form that its flow keeps; of
        watchers that packages register; the groups ``"invariants"``, ``"constraints"``,
        ``"observables"`` and ``"all"``, which is what the problem has of its own. A mapping gives a
        function ``f(params, t, y, work)``, a `geomint.Watcher`, or the options of what has that name:
        ``{"all": {}, "measure": {"steps": 1000}}``.

    Raises
    ------
    DomainError
        For a name that the problem does not have, and for options that a watcher does not have.
    """
    expected = "names of quantities, or a mapping of functions, watchers or options"
    wanted = [wanted] if isinstance(wanted, str) else wanted
    try:
        names = list(wanted)
    except Exception:  # whatever a foreign object raises there
        raise DomainError("observe", wanted, expected) from None
    if not all(isinstance(name, str) for name in names):
        raise DomainError("observe", wanted, expected)
    given = wanted if isinstance(wanted, Mapping) else {key: {} for key in names}
    chosen = {}
    for key in names:
        what = given[key]
        if key in GROUPS and isinstance(what, Mapping):
            if what:
                raise DomainError(f"observe[{key!r}]", what, "{}: a group has no options")
            chosen.update({name: watcher_of(problem, name) for name in expanded(problem, [key])})
        else:
            chosen[key] = _chosen(problem, key, what)
    if names and not chosen and "all" not in names:
        raise DomainError("observe", names, f"something that {problem.name!r} has: it has none")
    return chosen


def _chosen(problem: Problem, name: str, what: Any) -> Watcher:
    """Return the watcher of one entry: a function, a watcher, or options of what has the name."""
    where = f"observe[{name!r}]"
    if isinstance(what, Mapping):
        watcher = watcher_of(problem, name)
        if not all(isinstance(option, str) for option in what):
            raise DomainError(where, what, "options by their names")
        return checked_watcher(where, watcher.with_options(**what)) if what else watcher
    check_name("observe", name)
    if isinstance(what, Recorded | FunctionType):
        return Function(what if isinstance(what, Recorded) else Recorded(what))
    if isinstance(what, Watcher) or (isinstance(what, type) and issubclass(what, Watcher)):
        watcher = checked_watcher(where, what)
        if obstacle := watcher.obstacle(problem):
            raise DomainError(where, what, f"another watcher: {obstacle}")
        return watcher
    expected = "a Python function f(params, t, y, work), written with def, or a geomint.Watcher"
    raise DomainError(where, what, expected)


class Observers:
    """Everything that is watched along one run."""

    def __init__(self, chosen: Mapping[str, Watcher], run: Run) -> None:
        self._names = list(chosen)
        groups: dict[type[Watcher], dict[str, Watcher]] = {}
        for name, watcher in chosen.items():
            groups.setdefault(type(watcher), {})[name] = watcher
        self._watches = [
            watch for kind, group in groups.items() for watch in kind.together(group, run)
        ]

    @property
    def needs_all_states(self) -> bool:
        """Whether the state after every step is needed, however seldom something is sampled."""
        return any(watch.sees_all for watch in self._watches)

    @property
    def entries(self) -> int:
        """How many functions `prepare` asks for, nearly."""
        return sum(watch.entries for watch in self._watches)

    def prepare(self) -> None:
        """Compile, or find in the cache, what is needed, and evaluate it where the run begins."""
        for watch in self._watches:
            watch.prepare()

    def add(
        self, times: Array, labels: Array, states: Array, sampled: Booleans, step: float = 0.0
    ) -> None:
        """Take the next states, one a row, of which some are sampled; see `Seen`."""
        seen = Seen(times, labels, states, sampled, step)
        for watch in self._watches:
            watch.add(seen)

    def add_end(self, time: float, label: float, state: Array) -> None:
        """Sample the last state of a run, however seldom something is sampled.

        What has been sampled there already is left alone: the end counts once.
        """
        end = Seen(np.array([time]), np.array([label]), state[None, :], np.array([True]))
        for watch in self._watches:
            watch.add_end(end)

    def drifts(self, steps: int) -> dict[str, Drift]:
        """Return the drift of every quantity over `steps` steps."""
        drifts = {drift.name: drift for watch in self._watches for drift in watch.drifts(steps)}
        return {name: drifts[name] for name in self._names}
