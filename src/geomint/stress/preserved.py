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

from collections.abc import Mapping

import numpy as np

from ..arguments import Array
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import ACTION
from ..kernels.numbers.blocks import Block, scalar_block
from ..problems.deviation import sizes_of
from ..problems.evaluate import rates_of, value_of
from ..problems.problem import Problem

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
        self._kinds: dict[str, dict[str, float]] = {}

    def value(self, name: str, t: float, y: Array) -> float:
        """Return a diagnostic at a state."""
        f = self._problem.diagnostics[name]
        return value_of(self._problem, f, y, self._compiled)(y, t)

    def scale(self, name: str, t: float, y: Array, pieces: bool = False) -> float:
        """Return max(|f|, Σ |y_i ∂f/∂y_i|), a rounding of every number of y changes f by ε times it.

        Numbers that are 0 count with the size of their piece: the next step rounds what they become.
        So do pieces that are 0, with the size of the state; and all numbers with `pieces`, as
        iterations end where they no longer change a piece.
        """
        f = self.value(name, t, y)
        if len(y) > MANY:
            return max(abs(f), self._sampled_scale(name, t, y))
        total = 0.0
        whole = sizes_of(self._problem, y)
        for i, size in enumerate(1e-5 * np.where((y == 0.0) | pieces, whole, np.abs(y))):
            above, below = y.copy(), y.copy()
            above[i] += size
            below[i] -= size
            up, down = self.value(name, t, above) - f, self.value(name, t, below) - f
            # A norm has a kink where it is 0: there the two sides' difference misses the slope.
            total += 1e5 * 0.5 * max(abs(up - down), abs(up + down))
        return max(abs(f), total)

    def _sampled_scale(self, name: str, t: float, y: Array) -> float:
        """Return the root of Σ (y_i ∂f/∂y_i)², from changes of random signs: a lower bound."""
        rng = np.random.default_rng(4)
        signs = rng.choice([-1.0, 1.0], (2 * SAMPLES, len(y)))
        ends = [
            (self.value(name, t, y + 1e-5 * s * y), self.value(name, t, y - 1e-5 * s * y))
            for s in signs
        ]
        return 1e5 * 0.5 * float(np.sqrt(np.mean([(up - down) ** 2 for up, down in ends])))

    def preserved(self, keeps: tuple[str, ...]) -> dict[str, float]:
        """Return the diagnostics that are of one of those kinds, and how nearly, relative."""
        kinds = [self.of_kind(kind) for kind in keeps if kind in _DEFECTS]
        return {name: defect for kind in kinds for name, defect in kind.items()}

    def of_kind(self, kind: str) -> dict[str, float]:
        """Return the diagnostics of a kind that `Method.keeps` may name, and how nearly they are."""
        if kind not in self._kinds:
            defects = {name: _DEFECTS[kind](self, name) for name in self._candidates(kind)}
            self._kinds[kind] = {name: d for name, d in defects.items() if d <= EXACT}
        return self._kinds[kind]

    def _candidates(self, kind: str) -> Mapping[str, Recorded]:
        problem = self._problem
        if kind == "constraints":
            return problem.constraints
        form = problem.action if kind == "group orbits" else problem.field
        return {} if form is None else {**problem.invariants, **problem.constraints}

    def _states(self) -> list[tuple[float, Array]]:
        rng = np.random.default_rng(20100)
        return [
            (rng.uniform(0, 3), self._sizes * rng.normal(size=self._problem.rows))
            for _ in range(SAMPLES)
        ]

    def change_on_orbits(self, name: str) -> float:
        """Return the largest relative difference of the values at exp(ξ)·y and at y."""
        group = self._problem.action.group  # type: ignore[union-attr]
        rng, worst = np.random.default_rng(569), 0.0

        act = Bound(group.act, ACTION).call(self._compiled)
        act.set(layout=Block(group.layout), work=scalar_block(group.work))

        def increment(xi: Array, y: Array) -> Array:
            out = np.zeros(len(y))
            act(xi=Block(xi), y=Block(y), out=Block(out))
            return out

        for t, y in self._states():
            xi = rng.normal(size=group.algebra_rows) / np.sqrt(group.algebra_rows)
            if group.algebra_rows <= FEW:
                # Rotations by a radian, translations by the size of what they move.
                units = np.eye(group.algebra_rows)
                moves = [float(np.max(np.abs(increment(row, y)) / self._sizes)) for row in units]
                xi /= [max(move, 1e-300) for move in moves]
            moved = y + increment(xi, y)
            x, z = self.value(name, t, y), self.value(name, t, moved)
            worst = max(worst, _relative(x - z, max(abs(x), abs(z))))
        return worst

    def change_along_field(self, name: str) -> float:
        """Return the largest relative third difference along a line, or slope along the field.

        The slope is relative to the sum of the sizes of its terms. Where rounding of the values
        hides it, nothing is known: that counts as a change.
        """
        rng, worst = np.random.default_rng(2), 0.0
        problem = self._problem
        for t, y in self._states():
            d = self._sizes * rng.normal(size=len(y))
            line = [self.value(name, t, y + k * d) for k in range(4)]
            third = line[3] - 3.0 * line[2] + 3.0 * line[1] - line[0]
            worst = max(worst, _relative(third, 8.0 * max(map(abs, line))))
            if worst > EXACT:
                return worst
            v = rates_of(problem, y, self._compiled)(problem, y, t)
            v = v / (np.max(np.abs(v) / self._sizes) or 1.0)
            slopes = [self._rise(name, t, y, v[i] * row) for i, row in enumerate(np.eye(len(y)))]
            terms = float(np.sum(np.abs(slopes)))
            if terms * SEEN < max(map(abs, line)):
                return np.inf
            worst = max(worst, _relative(self._rise(name, t, y, v), terms))
        return worst

    def _rise(self, name: str, t: float, y: Array, v: Array) -> float:
        return self.value(name, t, y + v) - self.value(name, t, y - v)


def _relative(difference: float, size: float) -> float:
    if difference == 0.0:
        return 0.0
    return abs(difference) / size if size > 0.0 and np.isfinite(difference) else np.inf


_DEFECTS = {
    "constraints": lambda quantities, name: 0.0,
    "group orbits": Quantities.change_on_orbits,
    "quadratic invariants": Quantities.change_along_field,
}
