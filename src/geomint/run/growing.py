"""Directions that grow along a run: the steps, and what is noted of them on the way."""

import numpy as np

from ..arguments import Array
from ..kernels.numbers.blocks import scalar_block
from ..kernels.solve.status import NOT_CONVERGED, OK
from ..kernels.tangent.directions import begin_at
from ..kernels.tangent.exponents import growth_sweep
from ..methods.carried import Carried
from ..methods.stepper import Advance, Stepper
from .exponents import Lyapunov, standard_errors

ROUNDING = 2.0**-52  # of a direction's length a step: parts of a run may share its sign


class Growing:
    """Directions, what they have grown by, and the steps that let them grow."""

    def __init__(
        self, stepper: Stepper, carried: Carried, start: float, h: float, every: int
    ) -> None:
        self._stepper, self._carried = stepper, carried
        self._start, self._h, self._every = start, h, every
        d = carried.sizes.d
        self._noted = [scalar_block(n) for n in (d, d, 2)]
        self._sums, self._carries, self._second = self._noted
        self._second.data[1] = 1.0
        self.steps = self._iterations = 0
        self._t: list[float] = []
        self._grown: list[Array] = []
        self._alignment: list[float] = []

    def prepare(self) -> None:
        """Compile, or find in the cache, what takes the steps."""
        carried = self._carried
        sweep = growth_sweep(carried.kernel, carried.functions, carried.manifold, carried.numbers)
        self._sweep = sweep.call(
            self._stepper.compiled,
            **carried.arguments,
            sums=self._sums,
            carries=self._carries,
            second=self._second,
        )
        begin_at(carried.sizes, carried.kept("state"), carried.arguments["plain"])

    def take(self, steps: int) -> None:
        """Take steps, and make the directions orthonormal after every so many, and at their end."""
        begin = self._stepper.last_begin(
            self._start, self._h, self.steps + steps, self._stepper.end
        )
        last = int(begin != self._start)
        whole, rest = divmod(steps - last, self._every)
        parts = (self._start, whole, self._every), (self._start, 1, rest), (begin, 1, last)
        for t0, times, at_once in parts:
            if times * at_once:
                self._take(t0, self._h, self.steps, times, at_once)
                self.steps += times * at_once

    def cut(self, h: float) -> None:
        """Take one step of another length."""
        self._take(self._start + self._h * self.steps, h, 0, 1, 1, self.steps)
        self.steps += 1

    def _take(
        self, t0: float, h: float, first: int, times: int, steps: int, before: int = 0
    ) -> None:
        carried = self._carried
        known = carried.remembered
        sums = [block.data.copy() for block in self._noted]
        done = Advance(*self._sweep(t0=t0, h=h, first=first, times=times, steps=steps))
        if done.status == NOT_CONVERGED and carried.turn(self._stepper):
            self.prepare()
            carried.remembered = known
            for block, numbers in zip(self._noted, sums, strict=True):
                block.data[:] = numbers
            self._take(t0, h, first, times, steps, before)
            return
        self._iterations += done.iterations
        if done.status != OK:
            carried.remembered = known
            state = carried.kept("state")[: self._stepper.rows]
            raise self._stepper.error_of_slopes(done, state, t0, h, first, before)

    def sample(self, t: float) -> None:
        """Note what there is after that time."""
        along, across = np.abs(self._second.data)
        self._t.append(t)
        self._grown.append(self._sums.data + self._carries.data)
        self._alignment.append(float(across * np.hypot(1.0, across / (1.0 + along))))

    def found(self, rows: int, unit: float, status: str) -> Lyapunov:
        """Return what was sampled, as a result."""
        t, d = np.array(self._t), self._carried.sizes.d
        grown = np.array(self._grown).reshape(len(t), d)
        if len(t):
            grown = grown[:, np.argsort(-grown[-1], kind="stable")]
        running = grown / t[:, None]
        return Lyapunov(
            running[-1] if len(t) else np.zeros(d),
            np.hypot(standard_errors(t, grown), ROUNDING / abs(self._h)),
            t,
            running,
            np.array(self._alignment) if d > 1 else None,
            self._carried.kept("state")[:rows].copy(),
            unit,
            self.steps,
            self._iterations,
            status,
        )
