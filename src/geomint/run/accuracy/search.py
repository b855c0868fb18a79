"""The step, or local tolerance, with which a run meets a tolerance: found by trials on a stretch.

A trial is what a stretch shows at one setting, and what the whole run would err by with it. From one
trial to the next the setting changes by the power of the error that the method's order says, or by
that which the last two trials showed. A run that then errs by more begins anew.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from .stretch import Stretch

MOST = 8  # trials
SEEN = 1e-13  # errors of a stretch that are clearly more than its roundings
NOISE = 1e-15  # what roundings may make of one that is 0
CHANGED = 30.0  # of the error, so far a setting may change in any case
CHANGE = 3.0  # of the setting from one trial to the next, at most; of low orders more
BACK = 0.4  # of a setting that failed
NEAR = 30.0  # times the goal, or a part of it
WORTH = 0.97  # of the work of a shorter step: less is saved by none
REACH = 1.3  # times the setting: so far the power of the error is trusted
STIFF = 3.0  # times the setting that serves, the least for which steps that cost more are tried
BEYOND = 1.5  # of a step that has been tried, at most, for longer implicit ones may fail,
CAUTION = 2.0 / 3.0  # and by so much of what the power says: there errors may grow faster


@dataclass(eq=False)
class Trial:
    """A setting that was tried: its error at the end, None where the stretch could not be run."""

    setting: float
    error: float | None
    stretch: Stretch | None = field(default=None, repr=False)


@dataclass
class Search:
    """A search for the setting whose error at the end is `goal`.

    Attributes
    ----------
    attempt : callable
        ``attempt(setting) -> Trial``.
    goal, power : float
        The error wanted, and how it depends on the setting: error ∝ setting^power.
    largest : float
        No setting is larger.
    implicit : bool
        Whether larger settings may fail to converge, or cost more.
    near : float
        How far an error may be from the goal that leads there without a further trial.
    """

    attempt: Callable[[float], Trial]
    goal: float
    power: float
    largest: float
    implicit: bool
    near: float = NEAR
    trials: list[Trial] = field(default_factory=list)

    def run(self, first: float) -> tuple[float, float]:
        """Return the setting found, and the error expected of it."""
        setting, failed = min(first, self.largest), math.inf
        before = None  # a setting and its error, far above rounding
        reach = max(self.near, REACH**self.power)
        power, most = self.power, max(CHANGE, CHANGED ** (1.0 / self.power))
        found, cost = (setting, math.inf), (math.inf, 0.0)
        for _ in range(MOST):
            trial = self.attempt(setting)
            self.trials.append(trial)
            if trial.error is None or trial.stretch is None:
                if before is not None:
                    break
                failed, setting = setting, BACK * setting
                found = setting, math.inf
                continue
            work = trial.stretch.work
            if self.implicit and setting > cost[0] and work > WORTH * cost[1]:
                break  # a longer step saves nothing
            cost, error = (setting, work), max(trial.error, 1e-30 * self.goal)
            seen = max(float(trial.stretch.errors[-1]), NOISE)
            factor = (self.goal / error) ** (1.0 / power)
            if seen < SEEN:  # by rounding, perhaps: what follows from more error is better
                factor = min(1.2 * (SEEN / seen) ** (1.0 / power), factor)
            elif before is not None and before[0] != setting:
                shown = math.log(error / before[1]) / math.log(setting / before[0])
                power = min(max(shown, 0.5 * self.power), 1.5 * self.power)
                factor = (self.goal / error) ** (1.0 / power)
            wanted = min(min(max(factor, 1.0 / most), most) * setting, self.largest)
            wanted = wanted if wanted < failed else math.sqrt(setting * failed)
            near = 0.2 <= error / self.goal <= reach or abs(wanted / setting - 1.0) < 0.03
            chosen = wanted
            if self.implicit and wanted > setting:
                chosen = setting * min((wanted / setting) ** CAUTION, BEYOND)
            found = chosen, error * (chosen / setting) ** power
            back = before is not None and setting < before[0]
            if near or (seen < SEEN and (back or setting >= self.largest)):
                break
            before = (setting, error) if seen >= SEEN else before
            setting = wanted
        return found

    def corrected(
        self, setting: float, expected: float, attempt: Callable[[float], Trial]
    ) -> tuple[float, float]:
        """Return the setting that one more trial leads to, such as one on a longer stretch."""
        trial = attempt(setting)
        self.trials.append(trial)
        if not trial.error:
            return setting, expected
        factor = min(max((self.goal / trial.error) ** (1.0 / self.power), 1.0 / CHANGE), CHANGE)
        changed = min(setting * factor, self.largest)
        return changed, trial.error * (changed / setting) ** self.power

    def stiff(self, setting: float, expected: float) -> bool:
        """Tell whether settings fail that are far too small for the goal."""
        failed = any(trial.stretch is None for trial in self.trials)
        far = expected * STIFF**self.power < self.goal or not math.isfinite(expected)
        return failed and far and STIFF * setting < self.largest

    @property
    def record(self) -> tuple[tuple[float, float | None], ...]:
        """The trials, as settings and errors at the end."""
        return tuple((t.setting, t.error) for t in self.trials)
