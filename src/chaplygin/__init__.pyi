# The public names, for type checkers and for lazy_loader: what is not here is not public.

from .ball import ball_problem as ball_problem
from .classical import classical_problem as classical_problem
from .hamiltonized import hamiltonized_problem as hamiltonized_problem
from .inertia import (
    GeneralInertia as GeneralInertia,
)
from .inertia import (
    SpecialInertia as SpecialInertia,
)
from .reduced import reduced_problem as reduced_problem
from .sphere import ChaplyginSphere as ChaplyginSphere

__all__ = [
    "ChaplyginSphere",
    "GeneralInertia",
    "SpecialInertia",
    "ball_problem",
    "classical_problem",
    "hamiltonized_problem",
    "reduced_problem",
]
