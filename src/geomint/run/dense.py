"""Dense output: states of a run at any times of it, afterwards."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import MOST_NUMBERS, Array, as_array
from ..errors import DomainError
from ..kernels.compiling.sameness import Compared
from ..methods import Method
from ..methods.partial import Nodes, PartialSteps
from ..problems.problem import Problem
from .timeline import met_by_rounding


@dataclass(frozen=True, eq=False)
class Kept(Compared):
    """What dense output is made of, kept by a run.

    Attributes
    ----------
    times, states : array
        Where it began and after every step: the problem's own time, and the state, with the clock's
        row where physical time was integrated. Of a run without steps: where the motion was begun, and
        both ends of the run.
    step : float
        Its length, with its sign; of an adaptive method the first.
    compiled : bool
        Whether the run was compiled, and what is asked for will be.
    """

    times: Array
    states: Array
    step: float
    compiled: bool


class Output:
    """The states of a run at any time within it: ``sol.sol(t)``, or ``sol.sol(tau=…)``.

    Parameters
    ----------
    problem : Problem
    times, states : array
        Some of the run, the first and the last among them: the problem's own times, and states, with
        the clock's row where physical time is known.
    """

    def __init__(self, problem: Problem, times: Array, states: Array) -> None:
        self.problem, self.times, self.states = problem, times, states

    def __repr__(self) -> str:
        own = self.problem.time
        return f"<dense output, {own} = {self.times[0]:.9g} … {self.times[-1]:.9g}>"

    @property
    def clock(self) -> bool:
        """Whether physical time was integrated beside the state."""
        return bool(self.states.shape[1] > self.problem.rows)

    def __call__(self, t: Any = None, *, tau: Any = None) -> Array:
        """Return the state at a physical time, or at one of the problem's own; of many, one a row.

        Times may be in any order and repeated. Several threads may ask at once.

        Raises
        ------
        DomainError
            For times outside of the run by more than four roundings; for physical times that were not
            integrated.
        StepError
            If a step does not succeed.
        """
        if (t is None) == (tau is None):
            raise DomainError("t, tau", (t, tau), "exactly one of them")
        name, given = ("t", t) if tau is None else ("tau", tau)
        by_clock = name == "t" and self.problem.time == "tau"
        if by_clock and not self.clock:
            raise DomainError("t", t, "tau=…: physical time was not integrated, see clock=True")
        wanted = as_array(name, given, "times")
        times = np.atleast_1d(wanted).ravel()
        if times.size * self.states.shape[1] > MOST_NUMBERS:
            raise DomainError(name, given, f"at most {MOST_NUMBERS // self.states.shape[1]} times")
        known = self.states[:, -1] if by_clock else self.times
        met = met_by_rounding(times, float(known[0]), float(known[-1]))
        if met is None:
            low, high = sorted((known[0], known[-1]))
            raise DomainError(name, given, f"times within the run, {low:.17g} … {high:.17g}")
        states = self._found(met, by_clock)
        return states.reshape(*wanted.shape, self.problem.rows)

    def own_times(self, t: Array) -> Array:
        """Return the problem's own times at physical ones within the run, where these are known."""
        raise NotImplementedError

    def _found(self, times: Array, by_clock: bool) -> Array:
        """Return the states at times of the clock, or the problem's own, shape (m,) ↦ (m, rows)."""
        raise NotImplementedError


class DenseOutput(Output):
    """States of a run with steps.

    A state is that of a real step of the method from the step before, as with `t_eval`: as accurate
    as the run, on the manifold, of the method's own order; after a whole step the run's, bit for bit.
    """

    def __init__(self, problem: Problem, method: Method, kept: Kept) -> None:
        super().__init__(problem, kept.times, kept.states)
        self._made = problem, method, kept
        self._sign = np.sign(kept.step)
        y0, t0 = kept.states[0][: problem.rows], float(kept.times[0])
        flow = method.on(problem, y0, t0, self.clock, kept.compiled)
        self._partial = PartialSteps(flow.begin(y0, t0, kept.step))

    def __reduce__(self) -> Any:
        return DenseOutput, self._made

    def own_times(self, t: Array) -> Array:
        """Return those of the real steps that lead there."""
        return self._steps(t, True)[0]

    def _found(self, times: Array, by_clock: bool) -> Array:
        return self._steps(times, by_clock)[1]

    def _steps(self, times: Array, by_clock: bool) -> tuple[Array, Array]:
        """Return the problem's own times, and the states."""
        nodes = Nodes(self.times, self.states, np.arange(len(self.times)))
        order = np.argsort(times, kind="stable")
        at = nodes.before(times[order], self._sign, by_clock)
        taken = self._partial.to_clock if by_clock else self._partial.to_times
        found = taken(nodes, at, times[order])
        if found.error is not None:
            raise found.error
        own, states = np.empty(len(times)), np.empty((len(times), self.problem.rows))
        own[order], states[order] = found.times, found.states[:, : self.problem.rows]
        return own, states
