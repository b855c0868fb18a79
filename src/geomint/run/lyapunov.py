"""Lyapunov exponents of a run: how fast neighbouring motions part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..arguments import Array, whole
from ..errors import DomainError
from ..kernels.numbers.blocks import scalar_block
from ..kernels.solve.status import OK
from ..kernels.tangent.directions import begin_at
from ..kernels.tangent.exponents import growth_sweep
from ..methods import Method
from ..methods.carried import Carried
from ..methods.stepper import Advance, Stepper
from ..problems.problem import Problem
from ..problems.shown import Shown
from ..problems.time_scale import characteristic_time
from .carried_directions import columns
from .tangent_flow import started

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Lyapunov", "lyapunov"]

APART = 0.1  # of a characteristic time: directions are made orthonormal as often
EARLY, BLOCKS = 200, 64  # samples at even intervals of log t; parts of a run for its errors


@dataclass(frozen=True, eq=False, repr=False)
class Lyapunov(Shown):
    """Exponents of a run, and how they have converged.

    Attributes
    ----------
    exponents : array, shape (k,)
        In the order of their directions, the largest first as a rule; per unit of the problem's own
        time.
    errors : array, shape (k,)
        One standard error: that of the means over parts of the run, and what the second half of the
        run has changed. A regular motion has exponents like ln t / t, which are no larger.
    t : array, shape (samples,)
        Time since the beginning, where there are samples.
    running : array, shape (samples, k)
        The exponents up to there.
    sali : array, shape (samples,), or None
        The smaller alignment index, min ‖v₁ ± v₂‖, of two vectors of length 1 that are carried along:
        it falls to 0 exponentially where motions part exponentially, and like a power of t, or not at
        all, on tori. With one direction there is none.
    y : array, shape (rows,)
        The state at the end.
    iterations : int
        Of all steps, where the method iterates: those that values and slopes needed.
    """

    exponents: Array
    errors: Array
    t: Array
    running: Array
    sali: Array | None
    y: Array
    iterations: int

    def _shown(self) -> tuple[str, dict[str, Any]]:
        pairs = zip(self.exponents, self.errors, strict=True)
        words = ", ".join(f"{value:.4g} ± {error:.1g}" for value, error in pairs)
        return "Lyapunov exponents", {"exponents": words, "time": f"{self.t[-1]:.6g}"}

    def plot(self) -> Figure:
        """Plot the exponents' sizes over time, beside ln t / t, and the alignment index."""
        from ..plots.lyapunov_plot import lyapunov_figure

        return lyapunov_figure(self.t, self.running, self.sali)


def lyapunov(
    problem: Problem,
    y0: Any,
    *,
    t_end: Any = None,
    tau_end: Any = None,
    method: str | Method | None = None,
    step: Any = None,
    t0: float = 0.0,
    count: Any = None,
    directions: Any = None,
) -> Lyapunov:
    """Return Lyapunov exponents of a motion: of its numerical map, by exact derivatives.

    Directions tangent to the manifold of states (that of the problem's measure; without one all are)
    are carried along by steps in tangent numbers and made orthonormal on the way. The exponents are
    (1/t) log R_kk of the factor R: the largest, and with all directions the whole spectrum, whose sum
    is the mean growth of volumes.

    Parameters
    ----------
    problem, y0, t_end, tau_end, method, step, t0
        As those of `geomint.tangent_flow`: an end in the problem's own time, a method with steps of a
        given length.
    count : int, optional
        How many exponents, the largest. Default: all.
    directions : array_like, shape (rows, k), optional
        Where the directions begin, one a column; made orthonormal on the manifold in their order.
        Default: random ones, the same in every run.

    Raises
    ------
    ArgumentError, DomainError, FormError, DeclarationError, MethodError
        As `geomint.tangent_flow`.
    ConvergenceError, NonFiniteError, StepSizeError
        With t, step, residual and iterations.

    Notes
    -----
    Benettin, Galgani, Giorgilli, Strelcyn, Meccanica 15 (1980) 9; the alignment index: Ch. Skokos,
    J. Phys. A 34 (2001) 10029.

    Examples
    --------
    >>> import geomint as gi
    >>> scene = gi.load_scene("sphere-n3")
    >>> found = gi.lyapunov(scene.problem, scene.state, t_end=200.0, step=0.1)
    >>> found.exponents.shape  # T*S² has four dimensions
    (4,)
    """
    state, timeline, stepper = started(problem, y0, t_end, tau_end, method, step, t0)
    chosen = _directions(problem, count, directions)
    carried = Carried(problem, stepper, state, timeline.start, chosen)
    assert timeline.steps is not None
    span = characteristic_time(problem, state, timeline.h, timeline.start)
    every = int(np.clip(APART * span / abs(timeline.h), 1, max(timeline.steps, 1)))
    growing = _Growing(stepper, carried)
    marks = _marks(timeline.steps, every)
    taken, t, sums, alignment = 0, [], [], []
    for mark in marks:
        growing.take(timeline.start, timeline.h, taken, mark - taken, every)
        taken = mark
        t.append(abs(timeline.h) * taken)
        sums.append(growing.sums)
        alignment.append(growing.alignment)
    if timeline.remainder != 0.0:
        growing.take(timeline.start + timeline.h * taken, timeline.remainder, 0, 1, 1, taken)
        t.append(abs(timeline.h) * taken + abs(timeline.remainder))
        sums.append(growing.sums)
        alignment.append(growing.alignment)
    times, grown = np.array(t), np.array(sums)
    return Lyapunov(
        grown[-1] / times[-1],
        _errors(times, grown),
        times,
        grown / times[:, None],
        np.array(alignment) if grown.shape[1] > 1 else None,
        carried.kept("state")[: problem.rows].copy(),
        growing.iterations,
    )


def _directions(problem: Problem, count: Any, directions: Any) -> Array:
    """Return where directions begin: given, or random ones."""
    measure = problem.measure
    most = problem.rows - (0 if measure is None else measure.conditions)
    if directions is not None:
        if count is not None:
            raise DomainError("count", count, "nothing beside directions")
        found = columns("directions", directions, problem.rows)
        if found.shape[1] > most:
            raise DomainError("directions", directions, f"at most {most}, which are independent")
        return found
    number = most if count is None else whole("count", count, 1, most)
    return np.random.default_rng(20101).normal(size=(problem.rows, number))


def _marks(steps: int, every: int) -> list[int]:
    """Return after how many steps there are samples: even in log t, and the ends of equal parts."""
    early = np.geomspace(every, max(steps, every), EARLY)
    even = np.linspace(0.0, steps, BLOCKS + 1)[1:]
    marks = np.unique(np.round(np.concatenate([early, even]) / every).astype(np.int64)) * every
    return [*(int(m) for m in marks if 0 < m < steps), *([steps] if steps else [])]


def _errors(t: Array, grown: Array) -> Array:
    """Return standard errors of the exponents: of means over parts, and of the two halves."""
    at: npt.NDArray[np.int64] = np.searchsorted(t, np.linspace(0.0, t[-1], BLOCKS // 2 + 1)[1:])
    at = np.unique(np.concatenate([[0], np.minimum(at, len(t) - 1)]))
    if len(at) < 3:
        return np.full(grown.shape[1], np.inf)
    rates = np.diff(grown[at], axis=0) / np.diff(t[at])[:, None]
    spread = rates.std(axis=0, ddof=1) / np.sqrt(len(rates))
    half = int(np.searchsorted(t, 0.5 * t[-1]))
    change = grown[-1] / t[-1] - grown[half] / t[half]
    return np.asarray(np.hypot(spread, change))


class _Growing:
    """Directions, what they have grown by, and the steps that let them grow."""

    def __init__(self, stepper: Stepper, carried: Carried) -> None:
        self._stepper, self._carried = stepper, carried
        d = carried.sizes.d
        self._sums, self._carries, self._second = (scalar_block(n) for n in (d, d, 2))
        self._second.data[1] = 1.0
        self.iterations = 0
        sweep = growth_sweep(carried.kernel, carried.functions, carried.manifold, carried.numbers)
        self._sweep = sweep.call(
            stepper.compiled,
            **carried.arguments,
            sums=self._sums,
            carries=self._carries,
            second=self._second,
        )
        begin_at(carried.sizes, carried.kept("state"), carried.arguments["plain"])

    def take(
        self, t0: float, h: float, first: int, steps: int, every: int, before: int = 0
    ) -> None:
        """Take some steps after the first ones, so many at once."""
        for count, at_once in ((steps // every, every), (1, steps % every)):
            if count * at_once == 0:
                continue
            done = Advance(*self._sweep(t0=t0, h=h, first=first, times=count, steps=at_once))
            self.iterations += done.iterations
            if done.status != OK:
                self._stepper.move(t0, h)
                raise self._stepper.error(done, first, before)
            first += count * at_once

    @property
    def sums(self) -> Array:
        """The logarithms of the growth of all directions so far."""
        total: Array = self._sums.data + self._carries.data
        return total

    @property
    def alignment(self) -> float:
        """The smaller alignment index of the two vectors that began as the first two directions."""
        along, across = np.abs(self._second.data)
        return float(across * np.hypot(1.0, across / (1.0 + along)))
