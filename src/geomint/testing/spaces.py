"""What every space of states has."""

import contextlib
import pickle
import warnings

import numpy as np

from ..arguments import Array, whole
from ..errors import DomainError, GeomintWarning
from ..kernels.compiling.signatures import CONSTRAINT, VALUE
from ..problems.forms import Group
from ..problems.spaces.conditions import differences
from ..problems.spaces.euclidean import Euclidean
from ..problems.spaces.repair import length
from ..problems.spaces.space import Space
from ..problems.spaces.tangent_bundle import TangentBundle
from .groups import check_group, moved
from .judge import checks, hold, small, sure

__all__ = ["check_space"]

ROUNDING = 1e-13
INDEPENDENT = 1e-8
SCALES = (1.0, 1e-75, 1e75, 0.0)  # of what has no condition but direction: vectors of bundles


@checks(Space)
def check_space(space: Space, states: int = 5) -> None:
    """Raise `AssertionError` for the first property of a space that does not hold.

    It is a value (compared, hashed, pickled). Random points are admissible as they are; conditions and
    constraints vanish there, and are independent; small defects are repaired with a warning, larger
    ones refused. Tangent parts are tangent; retractions return to the space; the group moves points to
    points.

    Parameters
    ----------
    space : Space
    states : int
        How many random points are taken, from seeds 0, 1, …
    """
    copy = pickle.loads(pickle.dumps(space))
    sure(copy == space and hash(copy) == hash(space), f"{space!r} is not the value that it pickles")
    sure(repr(copy) == repr(space), f"{space!r} prints another value when it is pickled")
    ends = [(s.start, s.stop) for s in space.slices.values()]
    rows = [k for start, stop in ends for k in range(start, stop)]
    sure(rows == list(range(space.rows)), f"the slices of {space!r} are not its rows: {ends}")
    sure(space.conditions < space.rows, f"{space!r} has as many conditions as rows")
    for seed in range(whole("states", states, 1)):
        y = _random(space, seed)
        _check_point(space, y)
        _check_constraint(space, y)
        _check_repair(space, y, np.random.default_rng([seed, 1]))
        _check_settled(space, y, np.random.default_rng([seed, 3]))
        _check_tangents(space, y, np.random.default_rng([seed, 2]).normal(size=space.rows))
        _check_elsewhere(space, seed)
    for scale in SCALES:
        _check_scale(space, y, scale)
    if space.group is not None:
        check_group(space.group, space.rows)
        _check_moves(space, space.group, y)


def _random(space: Space, seed: int) -> Array:
    """Return a random point: the same for the same seed, admissible as it is."""
    components = space.random(np.random.default_rng(seed))
    with warnings.catch_warnings(action="error"):
        y = space.project(**components)
        again = space.project(**space.random(np.random.default_rng(seed)))
    hold(y, space.join(components), f"`project` changes a random point of {space!r}")
    hold(y, again, f"`random` of {space!r} is another point for the same seed")
    other = space.join(space.random(np.random.default_rng(seed + 1)))
    sure((y != other).any(), f"`random` of {space!r} is one point for two seeds")
    return y


def _check_point(space: Space, y: Array) -> None:
    """Conditions and constraints vanish and are independent."""
    size = max(1.0, length(y)) ** 2
    small(space.defects(y), ROUNDING * size, f"conditions of {space!r} are not 0 at a random point")
    for name, f in space.constraints.items():
        value = VALUE.run(f, params=space.params, t=0.0, y=y, work=0)
        small(
            value, ROUNDING * size, f"constraint {name!r} of {space!r} is not 0 at a random point"
        )
    values = np.linalg.svd(space.normals(y), compute_uv=False) if space.conditions else np.ones(1)
    text = f"conditions of {space!r} depend on each other: singular values {values}"
    sure(values[-1] > INDEPENDENT * values[0], text)


def _check_constraint(space: Space, y: Array) -> None:
    """Hold the constraint for RATTLE to be 0, with its Jacobian, if the space has one."""
    try:
        constraint = space.constraint
    except NotImplementedError:
        return

    def written(x: Array) -> tuple[Array, Array]:
        m = space.conditions
        g, G = CONSTRAINT.run(constraint, params=space.params, q=x, g=m, G=m * space.rows, work=0)
        return g, G.reshape(-1, space.rows)

    slopes = differences(lambda x: written(x)[0], y, 1e-3 * np.eye(space.rows)).T / 1e-3
    g, G = written(y)
    small(g, ROUNDING * max(1.0, length(y)) ** 2, f"`constraint` of {space!r} is not 0 on it")
    small(G - slopes, 1e-5 * max(1.0, length(y)), f"`constraint` of {space!r} has another Jacobian")


def _check_settled(space: Space, y: Array, rng: np.random.Generator) -> None:
    """Hold states that are said to be settled to be admitted as they are."""
    sizes = np.array([0.0, 1e-15, 1e-14, 1e-13, 1e-12, 1e-9, 1.0])
    states = y + sizes[:, None] * rng.normal(size=(len(sizes), len(y)))
    states = np.vstack([states, np.full(len(y), np.nan), np.full(len(y), np.inf)])
    told = space.settled(states)
    sure(told.shape == (len(states),), f"`settled` of {space!r} does not tell of each state")
    for state in states[told]:
        with (
            warnings.catch_warnings(record=True, action="always") as found,
            contextlib.suppress(DomainError),
        ):
            if np.array_equal(space.admit(state), state) and not found:
                continue
        raise AssertionError(f"`settled` of {space!r} says so of {state}, which is not admitted so")


def _check_repair(space: Space, y: Array, rng: np.random.Generator) -> None:
    """Repair what is near, with a warning, and once; refuse what is not."""
    if not space.conditions:
        return None
    normals = space.normals(y)
    away = rng.normal(size=len(normals)) @ (
        normals / np.linalg.norm(normals, axis=1, keepdims=True)
    )
    away /= length(away)
    with warnings.catch_warnings(record=True, action="always") as caught:
        near = space.admit(y + 1e-8 * away)
    told = any(issubclass(w.category, GeomintWarning) for w in caught)
    sure(told, f"{space!r} admits a state that is 1e-8 off without a warning")
    small(
        space.defects(near), ROUNDING * max(1.0, length(y)) ** 2, f"{space!r} repairs a state badly"
    )
    small(near - y, 1e-7, f"{space!r} repairs a state that is 1e-8 off far away")
    try:
        with warnings.catch_warnings(action="error"):
            hold(space.admit(near), near, f"{space!r} repairs a repaired state again")
            space.admit(y + 0.1 * away)
    except (DomainError, GeomintWarning) as error:
        sure(isinstance(error, DomainError), f"{space!r} repairs what is far away: {error}")
        return _check_named(space, y, away)
    raise AssertionError(f"{space!r} admits a state that is 0.1 off")


def _check_named(space: Space, y: Array, away: Array) -> None:
    """Project what a user names far away to the space, and say so; or refuse it."""
    with warnings.catch_warnings(record=True, action="always") as caught:
        try:
            found = space.project(**space.split(y + 0.1 * away))
        except DomainError:
            return
    sure(caught, f"`project` of {space!r} changes what is 0.1 off without a warning")
    size = max(1.0, length(found)) ** 2
    small(space.defects(found), ROUNDING * size, f"`project` of {space!r} leads to no point of it")


def _check_elsewhere(space: Space, seed: int) -> None:
    """Conditions and constraints, from another row on and of the tangent bundle."""
    others = [Euclidean(1, "a row before") * space]
    with contextlib.suppress(DomainError, NotImplementedError):
        others.append(TangentBundle(space, "a vector"))
    for other in others:
        _check_point(other, other.join(other.random(np.random.default_rng(seed))))


def _check_tangents(space: Space, y: Array, v: Array) -> None:
    """Tangent parts are tangent, and retractions are points near y + hv."""
    tangent, size = space.tangent(y, v), max(1.0, length(y)) ** 2
    small(
        space.tangent(y, tangent) - tangent, ROUNDING * size, f"tangent parts of {space!r} change"
    )
    if space.conditions:
        slopes = space.normals(y) @ tangent
        small(slopes, 10 * ROUNDING * size, f"tangent parts of {space!r} are not tangent")
    for h in (1e-2, 1e-3):
        z = space.retract(y, h * tangent)
        small(space.defects(z), ROUNDING * size, f"retractions of {space!r} leave it")
        near = space.distance(z, y + h * tangent)
        back = space.distance(y + h * tangent, z)
        sure(near == back, f"distances of {space!r} are {near} and {back} the other way round")
        small(near, 20.0 * size * h * h, f"retractions of {space!r} are not near y + {h:g} v")
    text = f"`retract` of {space!r} moves y where v is 0"
    small(space.retract(y, 0.0 * v) - y, ROUNDING * size, text)
    small(space.distance(y, y), 0.0, f"a point of {space!r} has a distance from itself")


def _check_scale(space: Space, y: Array, scale: float) -> None:
    """Where a vector of a bundle is admissible, so is it in any length, bit for bit."""
    parts = space.split(y)
    for factor in space.factors:
        for name, _ in factor.pieces[1:]:
            parts[name] = scale * parts[name]
    z = space.join(parts)
    hold(space.admit(z), z, f"{space!r} changes vectors of the size of {scale:g}")


def _check_moves(space: Space, group: Group, y: Array) -> None:
    """Move a point to a point."""
    xi = np.random.default_rng(0).normal(size=group.algebra_rows)
    z = moved(group, xi / length(xi), y)
    text = f"{group.name} moves points out of {space!r}"
    small(space.defects(z), ROUNDING * max(1.0, length(z)) ** 2, text)
