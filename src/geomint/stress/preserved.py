"""What a method is to preserve to round-off on a problem, and whether it did.

A method states kinds of quantities (`Method.keeps`); which quantities of a problem are of that kind
is found by evaluating them, at random states of that size off the manifold: no problem says it.

* ``"group orbits"``: f(exp(ξ)·y) = f(y) for every ξ;
* ``"quadratic invariants"``: f is a polynomial of degree ≤ 2, and ∇f·ẏ = 0 wherever ẏ is defined;
* ``"constraints"``: the constraints of the problem.

What holds identically is found to hold to rounding. So does what holds nearly, such as the energy of
a ball that is nearly homogeneous on the orbits of rotations: the defect that was found, at most
1e-12, is then more that a run may be off.

``"steady motions"`` is about motions, not about quantities: `geomint.stress.judge`.
"""

import functools
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ..arguments import Array
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.signatures import ACTION
from ..kernels.numbers.blocks import Block, scalar_block
from ..problems.deviation import sizes_of
from ..problems.evaluate import rates_of, value_of
from ..problems.problem import Problem
from ..problems.spaces.conditions import differences

SAMPLES = 3
FEW = 40  # numbers in a state up to which its functions run in plain Python
MANY = 300  # numbers in a state from which on their effects are sampled, not summed
SEEN = 1e3  # values may be this much larger than the changes that are looked for
EXACT = 1e-12  # relative: what is off by more does not hold


class Quantities:
    """The diagnostics of a problem, and the kinds that they are of.

    They are evaluated in plain Python where that is cheaper than a compilation.
    """

    def __init__(self, problem: Problem, y0: Array) -> None:
        self._problem, self._sizes = problem, sizes_of(problem, y0)
        self._compiled = problem.rows > FEW
        self.of_kind = functools.cache(self._of_kind)

    def value(self, name: str, t: float, y: Array) -> float:
        """Return a diagnostic at a state."""
        f = self._problem.diagnostics[name]
        return value_of(self._problem, f, y, self._compiled)(y, t)

    def scale(self, name: str, t: float, y: Array) -> float:
        """Return max(|f|, Σ |s_i ∂f/∂y_i|): f changes by ε times it where a piece of size s is rounded.

        By pieces, as iterations end where they no longer change one, and numbers that are 0 are none
        after a step; a piece that is 0 counts with the size of the state. Of many numbers it is the
        root of the sum of squares, from changes of random signs: a lower bound.
        """
        f, many, sizes = self.value(name, t, y), len(y) > MANY, sizes_of(self._problem, y)
        signs = np.random.default_rng(4).choice([-1.0, 1.0], (2 * SAMPLES, len(y)))
        ways = 1e-5 * (signs * np.abs(y) if many else np.diag(sizes))
        up, down = (np.array([self.value(name, t, y + s * d) - f for d in ways]) for s in (1, -1))
        # A norm has a kink where it is 0: there the two sides' difference misses the slope.
        terms = 0.5e5 * np.maximum(np.abs(up - down), np.abs(up + down))
        return max(abs(f), float(np.sqrt(np.mean(terms**2)) if many else np.sum(terms)))

    def preserved(self, keeps: tuple[str, ...]) -> dict[str, float]:
        """Return the diagnostics that are of one of those kinds, and how nearly, relative."""
        return {name: defect for kind in keeps for name, defect in self.of_kind(kind).items()}

    def _of_kind(self, kind: str) -> dict[str, float]:
        """Return the diagnostics of a kind that `Method.keeps` may name, and how nearly they are."""
        problem = self._problem
        if kind == "constraints":
            return dict.fromkeys(problem.constraints, 0.0)
        changes = {
            "group orbits": self._along_orbits if problem.action else None,
            "quadratic invariants": self._along_field if problem.field else None,
        }.get(kind)
        names = {**problem.invariants, **problem.constraints} if changes else {}
        found = {name: _largest(changes(name)) for name in names if changes}
        return {name: off for name, off in found.items() if off <= EXACT}

    @functools.cached_property
    def _states(self) -> list[tuple[float, Array]]:
        rng = np.random.default_rng(20100)
        return [
            (rng.uniform(0, 3), self._sizes * rng.normal(size=self._problem.rows))
            for _ in range(SAMPLES)
        ]

    @functools.cached_property
    def _moved(self) -> list[Array]:
        """The states, moved by elements of the group: rotations by a radian, and the like."""
        group, rng = self._problem.action.group, np.random.default_rng(569)  # type: ignore[union-attr]
        act = Bound(group.act, ACTION).call(self._compiled)
        act.set(layout=Block(group.layout), work=scalar_block(group.work))

        def increment(xi: Array, y: Array) -> Array:
            out = np.zeros(len(y))
            act(xi=Block(xi), y=Block(y), out=Block(out))
            return out

        def moved(y: Array) -> Array:
            xi = rng.normal(size=group.algebra_rows) / np.sqrt(group.algebra_rows)
            if group.algebra_rows <= FEW:  # translations by the size of what they move
                units = [increment(row, y) / self._sizes for row in np.eye(group.algebra_rows)]
                xi /= np.maximum(np.max(np.abs(units), axis=1), 1e-300)
            return y + increment(xi, y)

        return [moved(y) for _, y in self._states]

    def _along_orbits(self, name: str) -> Iterator[float]:
        """Yield the relative differences of the values at exp(ξ)·y and at y."""
        for (t, y), moved in zip(self._states, self._moved, strict=True):
            x, z = self.value(name, t, y), self.value(name, t, moved)
            yield _relative(x - z, max(abs(x), abs(z)))

    def _along_field(self, name: str) -> Iterator[float]:
        """Yield relative third differences along a line, and slopes along the field.

        A slope is relative to the sum of the sizes of its terms. Where rounding of the values hides
        it, nothing is known: that counts as a change.
        """
        problem, rng = self._problem, np.random.default_rng(2)
        for t, y in self._states:
            at: Any = functools.partial(self.value, name, t)
            d = self._sizes * rng.normal(size=len(y))
            line = [at(y + k * d) for k in range(4)]
            yield _relative(np.diff(line, 3)[0], 8.0 * np.max(np.abs(line)))
            v = rates_of(problem, y, self._compiled)(problem, y, t)
            v = v / (np.max(np.abs(v) / self._sizes) or 1.0)
            terms = np.sum(np.abs(differences(at, y, np.diag(v))))
            hidden = 2.0 * terms * SEEN < np.max(np.abs(line))
            yield np.inf if hidden else _relative(differences(at, y, v[None])[0], terms)


def _largest(changes: Iterable[float]) -> float:
    """Return the largest change, or the first that is too large."""
    worst = 0.0
    for change in changes:
        worst = max(worst, change)
        if worst > EXACT:
            break
    return worst


def _relative(difference: float, size: float) -> float:
    if difference == 0.0:
        return 0.0
    return abs(difference) / size if size > 0.0 and np.isfinite(difference) else np.inf
