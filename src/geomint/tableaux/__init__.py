"""Coefficients of integration methods, as data: exact, validated, and rounded once.

The registries `RUNGE_KUTTA`, `COMMUTATOR_FREE` and `COMPOSITIONS` map names to frozen records;
`gauss_legendre` makes the Gauss methods, `lobatto_pair` the pairs of Lobatto IIIA and IIIB. Arrays of
binary coefficients are shared and read-only.
"""

from ._commutator_free import CommutatorFreeTableau, Flow, flow
from ._composition import Composition, substeps
from ._exact import row, rows
from ._gauss_tableau import GaussTableau
from ._tableau import Tableau
from .commutator_free import COMMUTATOR_FREE
from .composition import COMPOSITIONS, DEFAULT_COMPOSITION, default_composition
from .gauss_legendre import MAX_GAUSS_STAGES, gauss_legendre
from .lobatto import MAX_LOBATTO_STAGES, LobattoPair, lobatto_pair
from .order_conditions import commutator_free_defect, composition_defect, runge_kutta_defect
from .runge_kutta import RUNGE_KUTTA

__all__ = [
    "COMMUTATOR_FREE",
    "COMPOSITIONS",
    "DEFAULT_COMPOSITION",
    "MAX_GAUSS_STAGES",
    "MAX_LOBATTO_STAGES",
    "RUNGE_KUTTA",
    "CommutatorFreeTableau",
    "Composition",
    "Flow",
    "GaussTableau",
    "LobattoPair",
    "Tableau",
    "commutator_free_defect",
    "composition_defect",
    "default_composition",
    "flow",
    "gauss_legendre",
    "lobatto_pair",
    "row",
    "rows",
    "runge_kutta_defect",
    "substeps",
]
