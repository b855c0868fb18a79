"""What a run promises whose step is not given, and the step that it is begun anew with.

A step errs, in a characteristic time, by no more than `promised` of a piece where a method is named,
and the end by no more than `AT_END` where none is: default steps are made so that this holds of regular
motions, and local errors are measured. Where they are larger, as the motion is not what it looked like
at its beginning, the run begins anew with a shorter step.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..arguments import Array
from ..methods import Method, find_method, find_solver
from ..methods.adaptive import Adaptive
from ..problems.problem import Problem
from .accuracy.accuracy import Accuracy
from .accuracy.adaptive_stretch import at_tolerance
from .local_error import DOUBT, SURE, LocalError, Ranked, promised
from .solution import Solution

AT_END = 1e-9
ENOUGH = 3.0  # times: of the end, where sums are better known; of steps, where few err, and most
AIM = 0.3  # of what is promised
FAILED, SHORTER = 0.3, 0.6  # of a step that failed: of a default one, of one that was tried
SHORTEST, LONGEST = 0.1, 0.8  # of a step that is too long
FEW = 20  # steps: of so few two runs may err alike
LESS, MUCH_LESS = 0.3, 0.1  # of the error, of high orders: of a run of more steps, and of few
STRICTER = 0.03  # times rtol, at most so far at a time; a second run has one that is as much larger
VARIABLE_STEPS = {"field": "dop853-adaptive", "action": "rkmk-dop853-adaptive"}
VARIABLE = 0.03  # of what is wanted of the end: rtol of variable steps
UNEVEN = "steps of one length erred too much, so that these vary"
MOST_STEPS, FEW_STEPS = 2.0**20, 2.0**12  # that a run is begun anew with; in plain Python


def shortened(factor: float, power: int, longest: float = LONGEST) -> float:
    """Return by what a step is multiplied so that an error is, as far as one goes at a time."""
    return min(max(float(factor ** (1.0 / power)), SHORTEST), longest)


class Setting(NamedTuple):
    """A method with its step, or local tolerance, and what is wanted of it.

    Attributes
    ----------
    method, step
        As `geomint.solve` takes them.
    wanted : float or None
        What the end may err by; None where a method is named and no tolerance.
    each : bool
        Whether there is a promise for each step: where no tolerance is given.
    free : bool
        Whether variable steps of another method may be taken, as nobody has named one.
    turning : bool
        Whether steps whose iteration does not converge are taken by Newton's method, and not shorter.
    given : Method or None
        The method where errors grow: its iteration goes on to rounding.
    state
        Canonical, where that is known.
    accuracy : Accuracy or None
        What is expected, where a tolerance is given.
    iterations : float
        How many are expected then.
    states : array or None
        Of the motion, as far as trials have gone.
    problem : Problem or None
        In another time, where that is taken.
    own : Setting or None
        What is taken in its own time if the other does not serve.
    """

    method: Method
    step: float | None = None
    wanted: float | None = None
    each: bool = True
    free: bool = False
    turning: bool = False
    given: Method | None = None
    state: Array | None = None
    accuracy: Accuracy | None = None
    iterations: float = 0.0
    states: Array | None = None
    problem: Problem | None = None
    own: Setting | None = None

    @classmethod
    def default(cls, method: str | Method | None, problem: Any) -> Setting:
        """Return the default step of a method, or of none that is named."""
        chosen = find_solver(method, problem)
        if method is None:
            return cls(chosen, wanted=AT_END, each=False, free=True)
        return cls(chosen)

    @property
    def asked(self) -> dict[str, Any]:
        """What `solve` is to do."""
        return {
            "method": self.method,
            "step": self.step,
            "turning": self.turning,
            "admitted": self.state,
            "confirmed": self.wanted is not None,
        }

    @classmethod
    def of_former(cls, former: Solution) -> Setting | None:
        """Return what is wanted of a run that goes on; None where its step was given."""
        wanted = former.restart and former.restart.wanted
        return (
            None if wanted is None else cls(former.method, wanted=wanted or None, each=not wanted)
        )

    @property
    def promise(self) -> float:
        """What a run leaves behind, as `Restart.wanted`."""
        return 0.0 if self.wanted is None else self.wanted

    def kept(self, found: Solution, confirmed: bool = True) -> bool:
        """Tell whether a run errs by no more than is promised: each step, or all, where few decide.

        Else the end does, as a second run tells, where it is `confirmed` by one.
        """
        ranked = found.ranked
        if confirmed and not self.each and isinstance(ranked, Ranked) and not ranked.concentrated:
            return True
        error = rough_error(found)
        if error is not None and self._part(found, error) > SURE:
            error = found.local_error
        return error is None or self._part(found, error) <= 1.0

    def _part(self, found: Solution, error: LocalError) -> float:
        """Return what part errors are of those with which a run is as it is."""
        at_end = 0.0 if self.wanted is None else error.total / (ENOUGH * self.wanted)
        few = isinstance(found.ranked, Ranked) and found.ranked.concentrated
        most = (ENOUGH if few else DOUBT) * promised(found.method)
        return max(at_end, error.largest / most) if self.each else at_end

    def looser(self) -> dict[str, Any]:
        """Return what is asked of a second run of variable steps, which errs more."""
        assert isinstance(self.method, Adaptive)
        return {**self.asked, "method": at_tolerance(self.method, self.method.rtol / STRICTER)}

    def shorter(self, found: Solution, most: float, expected: float = math.inf) -> Setting | None:
        """Return what is tried after a run that errs too much, or failed: in `most` steps at most.

        `expected` is what the end errs by if it does so as the order says.
        """
        error, p, end, local = None, found.method.order, found.end_error, found.local_error
        if found.success:
            error = end.error if end else local.total if local else 0.0
            error = min(error, math.sqrt(error * expected))
        if isinstance(found.method, Adaptive):
            return self._stricter(found.method, error)
        step, method = self.step or abs(found.step), self.method
        factor = SHORTER if self.accuracy else FAILED
        if error is not None and local:
            less = LESS if found.steps > FEW else MUCH_LESS
            longest = max(LONGEST, float(less ** (1.0 / p)))
            factor, step = longest, min(step, local.step)
            if self.each:
                part = AIM * promised(found.method) / max(local.largest, 1e-300)
                factor = min(factor, shortened(part, p + 1, longest))
            if self.wanted is not None:
                factor = min(factor, shortened(self.wanted / max(error, 1e-300), p, longest))
            method = self.given if end and self.given else method
        if found.steps > factor * most or not factor * step > 0.0:
            return None
        accuracy, turning = self._tried(step, error), self.turning or self.accuracy is not None
        if accuracy is not None:
            accuracy = accuracy._replace(expected=accuracy.expected * factor**p)
        return self._replace(method=method, step=factor * step, accuracy=accuracy, turning=turning)

    def _stricter(self, method: Adaptive, error: float | None) -> Setting | None:
        """Return local tolerances with which the end errs by what is wanted."""
        if error is None or self.wanted is None:
            return None
        power = method.order / (method.base.estimate_order or method.order)
        part = (AIM * self.wanted / max(error, 1e-300)) ** power
        stricter = at_tolerance(method, method.rtol * max(part, STRICTER))
        if stricter == method:
            return None
        return self._replace(method=stricter, accuracy=self._tried(method.rtol, error))

    def variable(self, found: Solution) -> Setting | None:
        """Return variable steps where few decide, if another method may be taken."""
        ranked, forms = found.ranked, found.problem.forms
        name = next((VARIABLE_STEPS[form] for form in VARIABLE_STEPS if form in forms), None)
        if not (self.free and self.wanted and name and isinstance(ranked, Ranked)):
            return None
        if not ranked.concentrated:
            return None
        rtol, state = VARIABLE * self.wanted, ranked.places[0][1]
        adaptive = find_method(name)
        assert isinstance(adaptive, Adaptive)
        method = at_tolerance(adaptive, rtol)
        accuracy = self.accuracy and self.accuracy._replace(reason=UNEVEN)
        return self._replace(
            method=method, step=None, state=state, free=False, each=False, accuracy=accuracy
        )

    def _tried(self, setting: float, error: float | None) -> Accuracy | None:
        """Return what is expected, with one more trial."""
        known = self.accuracy
        return known and known._replace(trials=(*known.trials, (setting, error)))


def rough_error(found: Solution) -> LocalError | None:
    """Return what steps err by, measured at one place where it has not been measured yet."""
    return found.ranked.rough if isinstance(found.ranked, Ranked) else found.ranked


def advice(solution: Solution, part: float) -> str:
    """Return what to do so that a run errs by such a part of what it errs by; 0: nothing helps."""
    ranked = solution.ranked
    if isinstance(ranked, Ranked) and ranked.concentrated:
        return "if a force switches there, name the time: breaks=[…]"
    if not part > 0.0:
        return "no shorter step does better: give an earlier end"
    if isinstance(solution.method, Adaptive):
        return "give a smaller tolerance"
    step = abs(solution.step) * min(part ** (1.0 / solution.method.order), 0.5)
    return f"give a shorter step: step={step:.2g}"
