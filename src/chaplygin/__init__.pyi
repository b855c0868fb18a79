# The public names, for type checkers and for lazy_loader: what is not here is not public.

from .ball.body import Ball as Ball
from .ball.classical import classical_problem as classical_problem
from .ball.contact import contact_problem as contact_problem
from .ball.hamiltonized import hamiltonized_problem as hamiltonized_problem
from .ball.momentum import ball_problem as ball_problem, cotangent_problem as cotangent_problem
from .ball.poisson import poisson_problem as poisson_problem, poisson_tensor as poisson_tensor
from .ball.reconstruction import (
    RolledPath as RolledPath,
    geometric_phase as geometric_phase,
    rolled_path as rolled_path,
)
from .ball.reduced import reduced_problem as reduced_problem
from .ball.rolling import rolling_problem as rolling_problem
from .ball.sphere import ChaplyginSphere as ChaplyginSphere
from .controls import (
    MultiplierDefects as MultiplierDefects,
    almost_poisson_tensor as almost_poisson_tensor,
    multiplier_defects as multiplier_defects,
)
from .conversion import converted as converted
from .correspondence.maps import (
    Correspondence as Correspondence,
    chaplygin_change as chaplygin_change,
    fedorov_ball as fedorov_ball,
    fedorov_body as fedorov_body,
    fedorov_constants as fedorov_constants,
    fedorov_state as fedorov_state,
    gauss_map as gauss_map,
    hamiltonization as hamiltonization,
    to_clebsch as to_clebsch,
    to_neumann as to_neumann,
)
from .exact.classical import ExactBall as ExactBall
from .exact.flow import ExactFlow as ExactFlow
from .exact.frequency_map import (
    FrequencyMap as FrequencyMap,
    action_variables as action_variables,
    critical_energies as critical_energies,
    discriminant as discriminant,
    frequency_map as frequency_map,
    resonances as resonances,
)
from .exact.reconstruction import ContactPath as ContactPath, attitude as attitude
from .inertia import GeneralInertia as GeneralInertia, SpecialInertia as SpecialInertia
from .related.clebsch import clebsch_problem as clebsch_problem, neumann_problem as neumann_problem
from .related.ellipsoid import ellipsoid_problem as ellipsoid_problem
from .rubber.rolling import rubber_rolling_problem as rubber_rolling_problem
from .rubber.sphere import RubberSphere as RubberSphere
from .spheroconical import Spheroconical as Spheroconical, SpheroconicalPoint as SpheroconicalPoint
from .veselova.body import Veselova as Veselova, VeselovaLR as VeselovaLR
from .veselova.classical import veselova_classical_problem as veselova_classical_problem
from .veselova.classical_multiplier import (
    veselova_multiplier_problem as veselova_multiplier_problem,
)
from .veselova.hamiltonized import veselova_hamiltonized_problem as veselova_hamiltonized_problem
from .veselova.lr import lr_problem as lr_problem
from .veselova.reduced import veselova_reduced_problem as veselova_reduced_problem
from .veselova.stiefel import stiefel_problem as stiefel_problem

__all__ = [
    "Ball",
    "ChaplyginSphere",
    "ContactPath",
    "Correspondence",
    "ExactBall",
    "ExactFlow",
    "FrequencyMap",
    "GeneralInertia",
    "MultiplierDefects",
    "RolledPath",
    "RubberSphere",
    "SpecialInertia",
    "Spheroconical",
    "SpheroconicalPoint",
    "Veselova",
    "VeselovaLR",
    "action_variables",
    "almost_poisson_tensor",
    "attitude",
    "ball_problem",
    "chaplygin_change",
    "classical_problem",
    "clebsch_problem",
    "contact_problem",
    "converted",
    "cotangent_problem",
    "critical_energies",
    "discriminant",
    "ellipsoid_problem",
    "fedorov_ball",
    "fedorov_body",
    "fedorov_constants",
    "fedorov_state",
    "frequency_map",
    "gauss_map",
    "geometric_phase",
    "hamiltonization",
    "hamiltonized_problem",
    "lr_problem",
    "multiplier_defects",
    "neumann_problem",
    "poisson_problem",
    "poisson_tensor",
    "reduced_problem",
    "resonances",
    "rolled_path",
    "rolling_problem",
    "rubber_rolling_problem",
    "stiefel_problem",
    "to_clebsch",
    "to_neumann",
    "veselova_classical_problem",
    "veselova_hamiltonized_problem",
    "veselova_multiplier_problem",
    "veselova_reduced_problem",
]
