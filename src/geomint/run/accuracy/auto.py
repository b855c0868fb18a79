"""``method="auto"``: which method a problem and a tolerance want, by a table that this version has.

It depends on nothing else, so that answers do not depend on the machine. What it rests on is counted
in iterations: the eight lanes of a Gauss step evaluate up to eight stages at once, so that one costs
the same with 4 stages and with 8, and with 9 twice as much. More stages make longer steps, until the
iteration converges too slowly, at 1.2 characteristic times or so. Fewer are chosen only where eight
would err hundreds of times less than was asked for, for nearly the same work. On all built-in scenes
that was the fastest of all families; measured: `benchmarks/tolerance.py`.
"""

import functools

from ...errors import MethodError
from ...methods.composition import Compose
from ...methods.gauss import Gauss
from ...methods.method import Method
from ...methods.rattle import Rattle
from ...methods.registry import AUTO
from ...methods.rkmk import RKMK
from ...methods.splitting import Verlet
from ...problems.problem import Problem

# From which tolerance on how many stages are enough, and orders of compositions.
STAGES = ((1e-3, 5), (1e-5, 6), (3e-7, 7), (0.0, 8))
ORDERS = ((1e-4, 4), (1e-7, 6), (0.0, 8))


def is_auto(method: object) -> bool:
    """Tell whether the method is to be chosen."""
    return isinstance(method, str) and method == AUTO


def auto_method(problem: Problem, tolerance: float | None) -> tuple[Method, str]:
    """Return the method for a problem and a tolerance, and why.

    The first that the problem has a form for: Gauss collocation of fields, Runge–Kutta–Munthe-Kaas
    methods of actions, splittings, RATTLE.

    Raises
    ------
    MethodError
        Without a tolerance.
    """
    if tolerance is None:
        raise MethodError(f"method = {AUTO!r} needs a tolerance, by which it is chosen")
    stages, order = (
        next(n for least, n in table if tolerance >= least) for table in (STAGES, ORDERS)
    )
    if problem.field is not None:
        reason = f"{stages} stages for a tolerance of {tolerance:g}, evaluated at once"
        return _gauss(stages), reason
    if problem.action is not None:
        return RKMK("dop853"), "the problem has a group action and no field"
    if problem.splitting is not None:
        return Compose(Verlet(), order), "the problem has a splitting, and no field or action"
    return Compose(Rattle(), order), "the problem has a Hamiltonian form only"


_gauss = functools.cache(Gauss)
