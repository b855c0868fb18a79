"""What a problem says of its motion, held against it: constants, and forms that are one motion.

Looked at a little later than a run starts: at rest, and where a force vanishes, nothing would be seen.
Derivatives are exact, so that what is left is rounding, unless a sign or a term is wrong.
"""

import math
from contextlib import suppress

import numpy as np

from ..arguments import Array
from ..errors import DeclarationError, DeclarationWarning, Gathered, GeomintError, tell
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import VALUE
from .declaration import FEW, Fingerprints, kept_with
from .derivatives import gradient, jacobian
from .deviation import sizes_of
from .evaluate import TINY, derivative, value
from .problem import Problem
from .spaces.conditions import differences
from .time_scale import jacobian as by_differences

LATER = 1e-3  # of the shortest time of the motion: states stay on their manifold to its cube
SLOPE = 1e-5  # of sizes: over which differences are taken of what has no tangent numbers
OFF = 1e-6  # of the terms that should cancel
APART = 1e-5  # of rates, which may be difference quotients
QUOTIENT = 1e-6  # ten times the time over which flows of a splitting are taken for its rates
ERRED = 0.05  # of such terms, where a run has come to: it errs, and leaves its manifold
ROUGH = 1e-9  # of a difference of times: roundings of these
NOISE = 1e-8  # of what rates are where the motion is not at rest

Claim = tuple[str, float, str]  # what is not so: its name, its size, and both in words


def claims_kept(
    problem: Problem,
    y: Array,
    t: float = 0.0,
    functions: Fingerprints = (),
    moved: bool = False,
    ahead: float = math.inf,
) -> tuple[Claim, ...]:
    """Return `false_claims`, looked for once for parameters and functions, where the first run starts.

    None in states of more than `FEW` numbers, where plain Python takes long. Where the run has `moved`
    to, only large ones: it errs.

    Parameters
    ----------
    functions : tuple of str
        What `check_problem` has returned.
    ahead : float
        How much of the run lies ahead, or with its sign behind: it is looked at there.
    """
    said = problem.invariants or problem.constraints or len(problem.forms) > 1
    if problem.rows > FEW or not said or not ahead:
        return ()

    def looked_for() -> tuple[Claim, ...]:
        with Gathered(quiet=True), suppress(Exception):
            if moved:  # flows need a state on the manifold
                found = false_claims(problem, problem.canonical(y), t, ahead)
                return tuple(claim for claim in found if claim[1] > ERRED)
            return false_claims(problem, y, t, ahead)
        return ()  # of functions that plain Python cannot evaluate there

    return kept_with(problem, ("claims", moved, functions), looked_for)


def tell_false_claims(
    problem: Problem, y: Array, t: float, ahead: float, functions: Fingerprints, moved: bool = False
) -> None:
    """Warn of them; where the first run has `moved` to too: at rest nothing is seen."""
    for name, size, text in claims_kept(problem, y, t, functions, moved, ahead):
        tell(DeclarationWarning(text, name, size))


@np.errstate(all="ignore")
def false_claims(
    problem: Problem, y: Array, t: float = 0.0, ahead: float = math.inf
) -> tuple[Claim, ...]:
    """Return what a problem says of its motion through a state, and is not so.

    Invariants and constraints are constant: of ``dI/dt = ∂I/∂t + Σ ∂I/∂y_i ẏ_i`` the sum is to vanish
    beside its terms. Other forms have the rates of the first one. Where the motion is at rest, or no
    number, nothing is told.

    Returns
    -------
    tuple of (name, size, text)
        The sum relative to the terms, or the difference relative to the rates of a piece.
    """
    sizes, rates = sizes_of(problem, y), derivative(problem, y, t)
    slopes = _slopes(problem, y, t)
    if not np.isfinite([*rates, *slopes.ravel()]).all():
        return ()
    paces = np.append(np.abs(np.linalg.eigvals(slopes)), np.abs(rates) / sizes)
    fastest, found = float(paces.max()), list[Claim]()
    first, *others = problem.forms
    rough = {"action": QUOTIENT, "splitting": QUOTIENT * max(1.0, fastest)}.get(first, NOISE)
    if not TINY < fastest < np.inf:
        return ()
    h = math.copysign(min(LATER / fastest, 0.5 * abs(ahead)), ahead)
    later, z = t + h, y + h * (rates + 0.5 * h * slopes @ rates)
    with Gathered(quiet=True), suppress(GeomintError):
        z = problem.canonical(z)
    rates = derivative(problem, z, later)
    for form in others:
        at = (z, later) if form == "hamiltonian" else (y, t)  # quotients tell how far z is off
        frozen = float(form == "splitting")  # for an absolute time, if it is a short one
        apart = np.abs(derivative(problem, *at, form) - derivative(problem, *at))
        for piece, rows in problem.slices.items():
            off, most = float(apart[rows].max()), float(np.abs(rates[rows]).max())
            noise = APART * (fastest + frozen) * float(sizes[rows].max())
            if off > (APART + frozen * QUOTIENT * fastest) * most + 0.1 * noise:
                size = off / max(off, most)
                what = f"{first} and {form} of {problem.name!r} are not one motion"
                found.append((form, size, f"{what}: rates of {piece} differ by {size:.2g}"))
                break
    for kind, known in (("invariant", problem.invariants), ("constraint", problem.constraints)):
        for name, f in known.items():
            if VALUE.reads(f, "t") and math.ulp(later) > ROUGH * abs(h):
                continue  # so late that times round to more than differences take
            along, alone = _gradient(problem, f, z, later, sizes, h)
            terms = np.append(along * rates, alone)
            off, all_of_them = float(abs(terms.sum())), float(np.abs(terms).sum())
            noise = rough * fastest * float(np.abs(along * sizes).sum())
            if off > OFF * all_of_them + noise:
                size = off / all_of_them
                what = f"the {kind} {name!r} of {problem.name!r} is not constant along the motion"
                why = f"its rate is {size:.2g} of the terms that should cancel; a sign or a term is"
                found.append((name, size, f"{what}: {why} wrong, in it or in the equations"))
    return tuple(found)


def _slopes(problem: Problem, y: Array, t: float) -> Array:
    """Return ∂ẏ/∂y, exact where the field takes tangent numbers."""
    if problem.field is not None:
        with suppress(DeclarationError):
            return jacobian(problem, y, t)
    return by_differences(problem, y, t, derivative)


def _gradient(
    problem: Problem, f: Recorded, y: Array, t: float, sizes: Array, h: float
) -> tuple[Array, float]:
    """Return the derivatives of a quantity by the state and by time."""
    alone = 0.0
    if VALUE.reads(f, "t"):
        alone = (value(problem, f, y, t + h) - value(problem, f, y, t - h)) / (2.0 * h)
    with suppress(DeclarationError):
        return gradient(problem, f, y, t), alone
    steps = np.diag(SLOPE * sizes)
    return differences(lambda z: np.array(value(problem, f, z, t)), y, steps) / (
        SLOPE * sizes
    ), alone
