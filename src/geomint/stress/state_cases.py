"""Special states of all built-in scenes and test problems, and states at a distance from them.

They are those where formulas divide by nothing: pieces at rest, rows that are zero or equal, axes.
A kind makes such a state of another one. What a problem does not admit is projected as
`Problem.state` does it; where that is refused as well, there is none.
"""

import functools
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

import numpy as np

from ..arguments import Array
from ..errors import Gathered, GeomintError
from ..kernels.numbers.blocks import Block
from ..problems.deviation import sizes_of
from ..problems.evaluate import derivative, value, vector
from ..problems.problem import Problem
from ..problems.systems import Model
from ..problems.time_scale import characteristic_time
from .case import Names, StressAxis, StressCase
from .step_cases import QUICK, Build, Source

Make = Callable[[Problem, Array, np.random.Generator], Array]

UNCHANGED = 1e-14  # relative: generators that differ by less are the same
ADMITTED = 1e-6
NEWTON, ON, NEAR = 5, 1e-13, 1e-8  # steps; what is on a constraint; differences
TURNS = (0.3, 1.7, 4.0)  # of the largest row of the generator


def zero_rows(problem: Problem, y0: Array, rng: np.random.Generator) -> Array:
    """Return the state with one or two zero rows."""
    y = y0.copy()
    y[rng.permutation(len(y))[: rng.integers(1, 3)]] = 0.0
    return y


def equal_rows(problem: Problem, y0: Array, rng: np.random.Generator) -> Array:
    """Return the state with pieces whose rows are all the same."""
    y = y0.copy()
    for piece in problem.slices.values():
        if rng.random() < 0.6:
            y[piece] = y[piece][0]
    return y


def on_axes(problem: Problem, y0: Array, rng: np.random.Generator) -> Array:
    """Return a state whose pieces lie on axes: fixed points, steady rotations, separatrices."""
    y = y0.copy()
    for name, piece in problem.slices.items():
        rows = piece.stop - piece.start
        n = round(rows**0.5)
        if name == "g" and n * n == rows:
            rotation = np.eye(n)[rng.permutation(n)]
            rotation[0] *= np.linalg.det(rotation)
            y[piece] = rotation.ravel()
        else:
            y[piece] = 0.0
            y[piece.start + rng.integers(rows)] = rng.choice([1.0, -1.0, 0.5])
    return y


def resting(problem: Problem, y0: Array, names: Sequence[str]) -> Array:
    """Return the state with those pieces zero."""
    y = y0.copy()
    for name in names:
        y[problem.slices[name]] = 0.0
    return y


def resting_pieces(problem: Problem, y0: Array) -> list[Names]:
    """Return the single pieces that may be zero in a state, and all that may be so together."""

    def may(names: Sequence[str]) -> bool:
        y = allowed(problem, resting(problem, y0, names))
        return y is not None and not any(y[problem.slices[name]].any() for name in names)

    names = list(problem.slices)
    single = [(name,) for name in names if may((name,))]
    most: Names = ()
    for name in names:
        if may((*most, name)):
            most = (*most, name)
    pairs = [(one, two) for i, one in enumerate(names) for two in names[i + 1 :]]
    together = [most] if most else [pair for pair in pairs if may(pair)]
    return list(dict.fromkeys([*together, *single]))


def admitted(problem: Problem, y: Array) -> Array | None:
    """Return the state, if need be projected, or None."""
    with Gathered(quiet=True):
        try:
            return problem.canonical(y)
        except GeomintError:
            pass
        try:
            return problem.state(**{name: y[piece] for name, piece in problem.slices.items()})
        except (GeomintError, TypeError):  # TypeError: its state is made of other components
            return None


@np.errstate(all="ignore")
def allowed(problem: Problem, y: Array) -> Array | None:
    """Return the state, on its manifold to rounding, or None.

    `Problem.canonical` leaves what is off by little as it is, and test problems admit any state: both
    are moved to their constraints by Newton's method, which leaves rows that are zero as they are.
    """
    state = admitted(problem, y)
    if state is None or "g" in problem.slices:  # rotations are projected well enough
        return state
    names = list(problem.constraints)
    if problem.admit is not None:  # states that are admitted can only be off by little
        names = [name for name in names if abs(value(problem, name, state)) <= ADMITTED]
    if not names:
        return state
    form = problem.hamiltonian
    hidden = problem.admit is None and form is not None and len(names) == form.constraints

    def off(x: Array) -> Array:
        """Return the constraints, which are quadratic, and where they are not named their slopes."""
        here = np.array([value(problem, name, x) for name in names])
        if not hidden:
            return here
        rate = 0.5 * derivative(problem, x)
        behind, ahead = (
            [value(problem, name, x + s * rate) for name in names] for s in (-1.0, 1.0)
        )
        return np.concatenate([here, np.array(ahead) - np.array(behind)])

    free, sizes = np.flatnonzero(state), sizes_of(problem, state)
    for _ in range(NEWTON):  # momenta may be much smaller than positions
        now = off(state)
        if not np.isfinite(now).all() or not len(free):
            break
        units = NEAR * np.diag(sizes)[free]
        slopes = np.array([off(state + d) - now for d in units]).T / (NEAR * sizes[free])
        largest = np.max(np.abs(slopes), axis=1)
        weights = np.where(largest > 0.0, 1.0 / np.maximum(largest, 1e-300), 0.0)
        if not np.isfinite(largest).all():
            break
        moves = np.linalg.lstsq(weights[:, None] * slopes, weights * now, rcond=1e-5)[0]
        state[free] -= moves
    return state if np.max(np.abs(off(state))) <= ON else None


@np.errstate(all="ignore")
def is_steady(problem: Problem, y0: Array) -> bool:
    """Tell whether y(t) = exp(tξ)·y0 solves ẏ = ξ(t, y)·y with one ξ, to rounding.

    It does if ξ(t, exp(tξ)·y0) = ξ for all t: looked at for some.
    """
    if problem.action is None:
        return False
    group, generator = problem.action.group, problem.action.generator

    xi_at = functools.partial(vector, problem, generator, group.algebra_rows)
    xi = xi_at(y0)
    size = float(np.max(np.abs(xi)))
    for turn in TURNS:
        t = turn / size if size > 0.0 else turn
        increment, work = np.zeros(problem.rows), Block(np.zeros(group.work))
        group.act(Block(group.layout), Block(t * xi), Block(y0), Block(increment), work)
        if not np.max(np.abs(xi_at(y0 + increment, t) - xi)) <= UNCHANGED * size:
            return False
    return True


REST = StressAxis("rest", "pieces at rest", "their size, relative")
ZEROS = StressAxis("zeros", "zero and equal rows", "distance")
STEADY = StressAxis("steady", "steady motions and fixed points", "distance")

_RESTS = (1e-8, 1e-100, 0.0)
_ZEROS = (1e-10, 0.0)
_DISTANCES = (1e-1, 1e-6, 1e-12, 0.0)
_FRACTION, _STEPS = 0.02, 50  # in times of the usual state: what stands still has none
_MOST_ROWS = 30
_TRIES = 40  # random choices until one is admitted


def cases(sources: Iterable[Source]) -> list[StressCase]:
    """Return the cases of the three axes, each problem in its smallest size."""
    smallest: dict[tuple[str, Names], tuple[str, Build, str, Problem, Array]] = {}
    for source, build in sources:
        model = build()
        for name, problem in model.problems.items():
            key = problem.name, tuple(problem.slices)
            if key not in smallest or problem.rows < smallest[key][3].rows:
                smallest[key] = source, build, name, problem, model.states[name]
    return [
        case for source, build, name, problem, y0 in smallest.values()
        if problem.rows <= _MOST_ROWS
        for case in _of_problem(source, build, name, problem, y0)
    ]  # fmt: skip


def _of_problem(
    source: str, build: Build, name: str, problem: Problem, y0: Array
) -> Iterator[StressCase]:
    time = characteristic_time(problem, y0)

    def along(
        axis: StressAxis, values: tuple[float, ...], kind: str, special: Array | None
    ) -> Iterator[StressCase]:
        """Yield states on the way from the special one to the usual one."""
        if special is None:
            return
        for distance in values:
            away = distance * (y0 - special)
            if "g" in problem.slices:  # between two rotations there is none
                away[problem.slices["g"]] = 0.0
            y = allowed(problem, special + away)
            if y is not None:
                yield StressCase(
                    f"{source}-{kind}",
                    axis,
                    distance,
                    0,
                    partial(_started, build, name, y),
                    representations=(name,),
                    step=_FRACTION * time,
                    steps=_STEPS,
                    steady=axis is STEADY and distance == 0.0 and is_steady(problem, y),
                    quick=(name,) if name == QUICK and distance == 0.0 else (),
                )

    for pieces in resting_pieces(problem, y0):
        yield from along(REST, _RESTS, "-".join(pieces), resting(problem, y0, pieces))
    kinds = {"zero-rows": zero_rows, "equal-rows": equal_rows}
    for kind, make in kinds.items():
        yield from along(ZEROS, _ZEROS, kind, _first(problem, y0, make))
    special = _first(problem, y0, on_axes)
    yield from along(STEADY, _DISTANCES, "axes", special)
    still = resting_pieces(problem, special) if special is not None else []
    if special is not None and still:
        yield from along(STEADY, _DISTANCES, "still", resting(problem, special, still[0]))


def _first(problem: Problem, y0: Array, make: Make) -> Array | None:
    """Return the first state of a kind that is admitted and moves at a finite velocity."""
    rng = np.random.default_rng(1)
    for _ in range(_TRIES):
        y = allowed(problem, make(problem, y0, rng))
        if y is not None and np.isfinite(derivative(problem, y)).all():
            return y
    return None


def _started(build: Build, name: str, y: Array) -> Model:
    return Model({name: build().problems[name]}, {name: y})
