"""Integration methods: each is a name, the form it needs, its coefficients and a kernel."""

from .adaptive import Adaptive
from .commutator_free import CommutatorFree
from .composition import Compose
from .exact import Exact
from .explicit import RungeKutta
from .gauss import Gauss
from .lobatto import Lobatto
from .method import Method
from .rattle import Rattle
from .registry import find_method, find_solver, method_names, methods
from .rkmk import RKMK
from .splitting import Verlet

__all__ = [
    "RKMK",
    "Adaptive",
    "CommutatorFree",
    "Compose",
    "Exact",
    "Gauss",
    "Lobatto",
    "Method",
    "Rattle",
    "RungeKutta",
    "Verlet",
    "find_method",
    "find_solver",
    "method_names",
    "methods",
]
