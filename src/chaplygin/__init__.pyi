# The public names, for type checkers and for lazy_loader: what is not here is not public.

from .ball.classical import classical_problem as classical_problem
from .ball.contact import contact_problem as contact_problem
from .ball.hamiltonized import hamiltonized_problem as hamiltonized_problem
from .ball.momentum import ball_problem as ball_problem
from .ball.reduced import reduced_problem as reduced_problem
from .ball.rolling import rolling_problem as rolling_problem
from .ball.sphere import ChaplyginSphere as ChaplyginSphere
from .inertia import (
    GeneralInertia as GeneralInertia,
)
from .inertia import (
    SpecialInertia as SpecialInertia,
)
from .related.ellipsoid import ellipsoid_problem as ellipsoid_problem
from .veselova.body import Veselova as Veselova
from .veselova.classical import veselova_classical_problem as veselova_classical_problem
from .veselova.hamiltonized import (
    veselova_hamiltonized_problem as veselova_hamiltonized_problem,
)
from .veselova.reduced import veselova_reduced_problem as veselova_reduced_problem

__all__ = [
    "ChaplyginSphere",
    "GeneralInertia",
    "SpecialInertia",
    "Veselova",
    "ball_problem",
    "classical_problem",
    "contact_problem",
    "ellipsoid_problem",
    "hamiltonized_problem",
    "reduced_problem",
    "rolling_problem",
    "veselova_classical_problem",
    "veselova_hamiltonized_problem",
    "veselova_reduced_problem",
]
