# The public names, for type checkers and for lazy_loader: what is not here is not public.

from .ball import ball_problem as ball_problem
from .classical import classical_problem as classical_problem
from .contact import contact_problem as contact_problem
from .ellipsoid import ellipsoid_problem as ellipsoid_problem
from .hamiltonized import hamiltonized_problem as hamiltonized_problem
from .inertia import (
    GeneralInertia as GeneralInertia,
)
from .inertia import (
    SpecialInertia as SpecialInertia,
)
from .reduced import reduced_problem as reduced_problem
from .rolling import rolling_problem as rolling_problem
from .sphere import ChaplyginSphere as ChaplyginSphere
from .veselova import Veselova as Veselova
from .veselova_classical import veselova_classical_problem as veselova_classical_problem
from .veselova_hamiltonized import (
    veselova_hamiltonized_problem as veselova_hamiltonized_problem,
)
from .veselova_reduced import veselova_reduced_problem as veselova_reduced_problem

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
