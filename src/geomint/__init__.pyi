# The public names, for type checkers and for lazy_loader: what is not here is not public.

from .drift import Drift as Drift
from .errors import (
    ClockError as ClockError,
)
from .errors import (
    ConvergenceError as ConvergenceError,
)
from .errors import (
    DeclarationError as DeclarationError,
)
from .errors import (
    DomainError as DomainError,
)
from .errors import (
    FormError as FormError,
)
from .errors import (
    GeomintError as GeomintError,
)
from .errors import (
    GeomintWarning as GeomintWarning,
)
from .errors import (
    MethodError as MethodError,
)
from .errors import (
    NonFiniteError as NonFiniteError,
)
from .errors import (
    OutputError as OutputError,
)
from .errors import (
    SceneError as SceneError,
)
from .errors import (
    StepError as StepError,
)
from .errors import (
    StepLimitError as StepLimitError,
)
from .errors import (
    StepSizeError as StepSizeError,
)
from .errors import (
    TruthError as TruthError,
)
from .evaluate import (
    derivative as derivative,
)
from .evaluate import (
    value as value,
)
from .forms import (
    Group as Group,
)
from .forms import (
    GroupAction as GroupAction,
)
from .forms import (
    Hamiltonian as Hamiltonian,
)
from .forms import (
    Measure as Measure,
)
from .forms import (
    Splitting as Splitting,
)
from .frequencies import (
    Term as Term,
)
from .frequencies import (
    frequencies as frequencies,
)
from .groups import (
    so3 as so3,
)
from .groups import (
    so_n as so_n,
)
from .integrate import solve as solve
from .kernels.arithmetic import (
    cos as cos,
)
from .kernels.arithmetic import (
    fma as fma,
)
from .kernels.arithmetic import (
    log as log,
)
from .kernels.arithmetic import (
    maximum as maximum,
)
from .kernels.arithmetic import (
    select as select,
)
from .kernels.arithmetic import (
    sin as sin,
)
from .kernels.arithmetic import (
    sqrt as sqrt,
)
from .kernels.arithmetic import (
    top as top,
)
from .kernels.blocks import part as part
from .kernels.great_circle import (
    great_circle as great_circle,
)
from .kernels.great_circle import (
    turn_coefficients as turn_coefficients,
)
from .kernels.recorded import (
    field as field,
)
from .kernels.recorded import (
    helper as helper,
)
from .kernels.recorded import (
    observable as observable,
)
from .methods.commutator_free import CommutatorFree as CommutatorFree
from .methods.composition import Compose as Compose
from .methods.explicit import RungeKutta as RungeKutta
from .methods.gauss import Gauss as Gauss
from .methods.method import Method as Method
from .methods.rattle import Rattle as Rattle
from .methods.registry import (
    find_method as find_method,
)
from .methods.registry import (
    method_names as method_names,
)
from .methods.rkmk import RKMK as RKMK
from .methods.splitting import Verlet as Verlet
from .natural import natural_on_sphere as natural_on_sphere
from .outputs import (
    check_file as check_file,
)
from .outputs import (
    check_folder as check_folder,
)
from .outputs import (
    whole_file as whole_file,
)
from .outputs import (
    whole_folder as whole_folder,
)
from .plan import (
    SeveralRuns as SeveralRuns,
)
from .plan import (
    make_plan as make_plan,
)
from .plan import (
    run_methods as run_methods,
)
from .plan import (
    run_scene as run_scene,
)
from .pointwise import pointwise as pointwise
from .problem import (
    Problem as Problem,
)
from .problem import (
    as_vector as as_vector,
)
from .quadrature import with_quadrature as with_quadrature
from .report.drift_page import drift_report as drift_report
from .scene.load import (
    load_scene as load_scene,
)
from .scene.load import (
    scene_names as scene_names,
)
from .scene.scene import Scene as Scene
from .solution import Solution as Solution
from .storage import (
    SavedSolution as SavedSolution,
)
from .storage import (
    load as load,
)
from .stress.case import (
    Rescaled as Rescaled,
)
from .stress.case import (
    StressAxis as StressAxis,
)
from .stress.case import (
    StressCase as StressCase,
)
from .systems import (
    Model as Model,
)
from .systems import (
    System as System,
)

__version__: str

__all__ = [
    "RKMK",
    "ClockError",
    "CommutatorFree",
    "Compose",
    "ConvergenceError",
    "DeclarationError",
    "DomainError",
    "Drift",
    "FormError",
    "Gauss",
    "GeomintError",
    "GeomintWarning",
    "Group",
    "GroupAction",
    "Hamiltonian",
    "Measure",
    "Method",
    "MethodError",
    "Model",
    "NonFiniteError",
    "OutputError",
    "Problem",
    "Rattle",
    "Rescaled",
    "RungeKutta",
    "SavedSolution",
    "Scene",
    "SceneError",
    "SeveralRuns",
    "Solution",
    "Splitting",
    "StepError",
    "StepLimitError",
    "StepSizeError",
    "StressAxis",
    "StressCase",
    "System",
    "Term",
    "TruthError",
    "Verlet",
    "as_vector",
    "check_file",
    "check_folder",
    "cos",
    "derivative",
    "drift_report",
    "field",
    "find_method",
    "fma",
    "frequencies",
    "great_circle",
    "helper",
    "load",
    "load_scene",
    "log",
    "make_plan",
    "maximum",
    "method_names",
    "natural_on_sphere",
    "observable",
    "part",
    "pointwise",
    "run_methods",
    "run_scene",
    "scene_names",
    "select",
    "sin",
    "so3",
    "so_n",
    "solve",
    "sqrt",
    "top",
    "turn_coefficients",
    "value",
    "whole_file",
    "whole_folder",
    "with_quadrature",
]
