"""The step, or local tolerance, with which a run meets a tolerance: found by trials on a stretch.

A trial is what a stretch shows at one setting, and what the whole run would err by with it. From one
trial to the next the setting changes by the power of the error that the method's order says, or by
that which the last two trials showed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from .stretch import Stretch

__all__ = ["Search", "Trial"]

MOST = 8  # trials
SEEN = 1e-13  # errors of a stretch that are clearly more than its roundings
NOISE = 1e-15  # what roundings may make of one that is 0
CHANGED = 30.0  # of the error, so far a setting may change in any case
CHANGE = 3.0  # of the setting from one trial to the next, at most; of low orders more
BACK = 0.4  # of a setting that failed
FAR = 0.03  # of the goal: an error below that is tried to be met, whether it saves work or not
WORTH = 0.97  # of the work: longer steps that save less are not worth their error
LIKELY = 2.0  # times a step that serves: where one so long fails, those between are not trusted
STIFF = 3.0  # times the setting that serves, the least for which steps that cost more are tried
BEYOND = 1.5  # of the longest step that has been tried, at most, for longer implicit ones may fail,
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
        The factor in error over which the power is trusted without a further trial.
    worth : float
        What a trial costs, as a part of the run: one of a longer step that saves less is not made.
    """

    attempt: Callable[[float], Trial]
    goal: float
    power: float
    largest: float
    implicit: bool
    near: float = 30.0
    worth: float = 0.0
    trials: list[Trial] = field(default_factory=list)
    _good: list[tuple[Trial, float, float]] = field(default_factory=list)

    @property
    def change(self) -> float:
        """The factor by which a setting changes at most: of low orders more."""
        return float(max(CHANGE, CHANGED ** (1.0 / self.power)))

    def run(self, first: float) -> tuple[float, float]:
        """Return the setting found, and the error expected of it."""
        setting, failed = min(first, self.largest), math.inf
        for _ in range(MOST):
            trial = self._took(self.attempt(setting))
            if trial.error is None or trial.stretch is None:
                failed = min(failed, setting)
                most = max((t.setting for t, _, _ in self._good), default=BACK**2 * setting)
                setting = math.sqrt(most * failed)
                if self._good and self._saves(most, setting) < self.worth:
                    break  # what serves is there, and what is longer may fail again
                continue
            if self._not_worth():
                break
            setting, near = self._next(failed)
            far = trial.error < FAR * self.goal  # so that it is no estimate of what that errs by
            if near or (self._saves(trial.setting, setting) < self.worth and not far):
                break
        good = self._good
        if not good:
            return setting, math.inf
        if self._not_worth():
            return good[-2][0].setting, good[-2][1]
        trial, error, _ = min(good, key=lambda each: abs(math.log(each[1] / self.goal)))
        chosen = self._changed(trial, error, failed)
        longest = max(t.setting for t, _, _ in good)
        if self.implicit and chosen > longest and failed < LIKELY * longest:
            chosen = longest
        elif self.implicit and chosen > longest:
            caution = CAUTION * min(self._power() / self.power, 1.0)
            chosen = longest * min((chosen / longest) ** caution, BEYOND)
        else:
            chosen = min(chosen, trial.setting * self.near ** (1.0 / self.power))
        return chosen, error * (chosen / trial.setting) ** self._power()

    def corrected(
        self, setting: float, expected: float, attempt: Callable[[float], Trial]
    ) -> tuple[float, float]:
        """Return the setting that one more trial leads to, such as one on a longer stretch."""
        trial = self._took(attempt(setting))
        if not trial.error:
            return setting, expected
        factor = (self.goal / trial.error) ** (1.0 / self.power)
        changed = min(setting * min(max(factor, 1.0 / self.change), self.change), self.largest)
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

    def _took(self, trial: Trial) -> Trial:
        """Keep a trial, and if it says something, the error at the end and that of the stretch."""
        self.trials.append(trial)
        if trial.error is not None and trial.stretch is not None:
            seen = max(float(trial.stretch.errors[-1]), NOISE)
            self._good.append((trial, max(trial.error, 1e-300), seen))
        return trial

    def _not_worth(self) -> bool:
        """Tell whether the last trial, with longer steps than one before, saved no work to speak of."""
        good = [t.stretch for t, _, _ in self._good if t.stretch is not None]
        if not self.implicit or len(good) < 2 or good[-1].step <= good[-2].step:
            return False
        return good[-1].work > WORTH * good[-2].work

    def _saves(self, setting: float, longer: float) -> float:
        """Return the part of the run that a longer setting saves; infinite for a shorter one."""
        return 1.0 - setting / longer if longer > setting else math.inf

    def _power(self) -> float:
        """Return the power that the last two trials showed, if they were far above rounding."""
        seen = [(t.setting, e) for t, e, s in self._good if s > SEEN]
        if len(seen) < 2 or seen[-1][0] == seen[-2][0]:
            return self.power
        (a, before), (b, now) = seen[-2:]
        shown = math.log(now / before) / math.log(b / a)
        return min(max(shown, 0.5 * self.power), 1.5 * self.power)

    def _next(self, failed: float) -> tuple[float, bool]:
        """Return what to try next, and whether that is known well enough without a trial."""
        trial, error, seen = self._good[-1]
        if seen < SEEN:  # by rounding, perhaps; what follows from a trial with more error is better
            if any(s >= SEEN for _, _, s in self._good) or trial.setting >= self.largest:
                return trial.setting, True
            factor = min(1.2 * (SEEN / seen) ** (1.0 / self.power), self.change)
            return self._within(trial.setting, factor, failed), False
        wanted, ratio = self._changed(trial, error, failed), error / self.goal
        # So far below the goal that the last step, which is not much longer than those tried, is too.
        low = max(BEYOND**-self.power, FAR) if self.implicit else 1.0 / self.near
        near = low <= ratio <= self.near or abs(wanted / trial.setting - 1.0) < 0.03
        return wanted, near or seen < SEEN * ratio

    def _changed(self, trial: Trial, error: float, failed: float) -> float:
        """Return the setting that leads from a trial to the goal, as far as one goes at a time."""
        factor = (self.goal / error) ** (1.0 / self._power())
        return self._within(trial.setting, min(max(factor, 1.0 / self.change), self.change), failed)

    def _within(self, setting: float, factor: float, failed: float) -> float:
        wanted = min(factor * setting, self.largest)
        return wanted if wanted < failed else math.sqrt(setting * failed)
