# The public names, for type checkers and for lazy_loader: what is not here is not public.

from . import scipy as scipy
from .arguments import as_vector as as_vector
from .cli.command import report as report
from .cli.commands.chaos import chaos_report as chaos_report
from .cli.commands.compare import compare_report as compare_report
from .cli.commands.drift import drift_report as drift_report
from .cli.commands.scan import scan_report as scan_report
from .cli.commands.section import section_report as section_report
from .cli.commands.stress import stress_report as stress_report
from .errors import (
    ArgumentError as ArgumentError,
    ClockError as ClockError,
    ConvergenceError as ConvergenceError,
    DeclarationError as DeclarationError,
    DeclarationWarning as DeclarationWarning,
    DomainError as DomainError,
    EndWarning as EndWarning,
    EnsembleError as EnsembleError,
    EventError as EventError,
    FormError as FormError,
    GeomintError as GeomintError,
    GeomintWarning as GeomintWarning,
    LeftOutWarning as LeftOutWarning,
    MethodError as MethodError,
    MissingCodeError as MissingCodeError,
    NonFiniteError as NonFiniteError,
    OutputError as OutputError,
    RankError as RankError,
    SceneError as SceneError,
    SendingError as SendingError,
    SpeedWarning as SpeedWarning,
    StateWarning as StateWarning,
    StepError as StepError,
    StepLimitError as StepLimitError,
    StepSizeError as StepSizeError,
    StepWarning as StepWarning,
    UnknownNameError as UnknownNameError,
    UnknownReferenceError as UnknownReferenceError,
    WatcherError as WatcherError,
)
from .kernels.compiling.recorded import field as field, helper as helper, observable as observable
from .kernels.groups.great_circle import (
    great_circle as great_circle,
    turn_coefficients as turn_coefficients,
)
from .kernels.numbers.arithmetic import (
    fma as fma,
    maximum as maximum,
    select as select,
    sqrt as sqrt,
    top as top,
)
from .kernels.numbers.blocks import (
    REST as REST,
    packed as packed,
    part as part,
    section as section,
)
from .kernels.numbers.circular import atan2 as atan2, cos as cos, sin as sin, tan as tan
from .kernels.numbers.exponential import exp as exp, log as log, pow as pow, tanh as tanh
from .methods.adaptive import Adaptive as Adaptive
from .methods.commutator_free import CommutatorFree as CommutatorFree
from .methods.composition import Compose as Compose
from .methods.exact import Exact as Exact
from .methods.explicit import RungeKutta as RungeKutta
from .methods.gauss import Gauss as Gauss
from .methods.lobatto import Lobatto as Lobatto
from .methods.method import Method as Method
from .methods.rattle import Rattle as Rattle
from .methods.registry import (
    find_method as find_method,
    method_names as method_names,
)
from .methods.rkmk import RKMK as RKMK
from .methods.splitting import Verlet as Verlet
from .plan import (
    SeveralRuns as SeveralRuns,
    make_plan as make_plan,
    run_methods as run_methods,
    run_scene as run_scene,
)
from .plots.view import View as View
from .problems.body_path import BodyPath as BodyPath
from .problems.derivatives import gradient as gradient, jacobian as jacobian
from .problems.evaluate import derivative as derivative, value as value
from .problems.forms import (
    Group as Group,
    GroupAction as GroupAction,
    Hamiltonian as Hamiltonian,
    Measure as Measure,
    Splitting as Splitting,
)
from .problems.groups import so3 as so3, so_n as so_n, translations as translations
from .problems.natural import (
    natural_in_space as natural_in_space,
    natural_on_sphere as natural_on_sphere,
)
from .problems.pointwise import pointwise as pointwise
from .problems.problem import Problem as Problem
from .problems.quadrature import with_quadrature as with_quadrature
from .problems.spaces.euclidean import Euclidean as Euclidean
from .problems.spaces.product import Product as Product
from .problems.spaces.rotations import RigidMotions as RigidMotions, Rotations as Rotations
from .problems.spaces.skew import Skew as Skew
from .problems.spaces.space import Space as Space
from .problems.spaces.sphere import Sphere as Sphere
from .problems.spaces.stiefel import Stiefel as Stiefel
from .problems.spaces.tangent_bundle import (
    TangentBundle as TangentBundle,
    TangentSphere as TangentSphere,
    TangentStiefel as TangentStiefel,
)
from .problems.systems import Model as Model, Reduction as Reduction, System as System
from .problems.time_transformation import time_transformed as time_transformed
from .problems.two_form import SymplecticForm as SymplecticForm
from .references.reference import Reference as Reference
from .reports.cite import Citation as Citation, cite as cite
from .run.draws import draw_states as draw_states
from .run.ensemble.growth import EnsembleGrowth as EnsembleGrowth
from .run.ensemble.readings.of_runs import Exponents as Exponents, SectionPoints as SectionPoints
from .run.ensemble.readings.of_series import Histogram as Histogram, Windows as Windows
from .run.ensemble.readings.reading import Reading as Reading
from .run.ensemble.result import Ensemble as Ensemble
from .run.ensemble.solve_ensemble import solve_ensemble as solve_ensemble
from .run.ensemble.store.opened import open_ensemble as open_ensemble
from .run.events import Event as Event, event as event
from .run.exponents import Lyapunov as Lyapunov
from .run.files.outputs import (
    check_file as check_file,
    check_folder as check_folder,
    whole_file as whole_file,
    whole_folder as whole_folder,
)
from .run.integrator import Integrator as Integrator
from .run.lyapunov import lyapunov as lyapunov
from .run.poincare import poincare_section as poincare_section
from .run.section import Section as Section
from .run.sensitivities import Sensitivities as Sensitivities, sensitivities as sensitivities
from .run.solution import Solution as Solution
from .run.solve import solve as solve
from .run.storage import load as load
from .run.tangent_flow import TangentFlow as TangentFlow, tangent_flow as tangent_flow
from .scene.load import (
    load_scene as load_scene,
    scene_names as scene_names,
)
from .scene.scene import Scene as Scene
from .stress.case import (
    StressAxis as StressAxis,
    StressCase as StressCase,
)
from .watch.birkhoff import (
    Average as Average,
    birkhoff_average as birkhoff_average,
    rotation_number as rotation_number,
)
from .watch.drift import Drift as Drift
from .watch.frequencies import Term as Term, frequencies as frequencies
from .watch.watcher import Watcher as Watcher

__version__: str

__all__ = [
    "REST",
    "RKMK",
    "Adaptive",
    "ArgumentError",
    "Average",
    "BodyPath",
    "Citation",
    "ClockError",
    "CommutatorFree",
    "Compose",
    "ConvergenceError",
    "DeclarationError",
    "DeclarationWarning",
    "DomainError",
    "Drift",
    "EndWarning",
    "Ensemble",
    "EnsembleError",
    "EnsembleGrowth",
    "Euclidean",
    "Exact",
    "Exponents",
    "FormError",
    "Gauss",
    "GeomintError",
    "GeomintWarning",
    "Group",
    "GroupAction",
    "Hamiltonian",
    "Histogram",
    "Integrator",
    "LeftOutWarning",
    "Lobatto",
    "Lyapunov",
    "Measure",
    "Method",
    "MethodError",
    "MissingCodeError",
    "Model",
    "NonFiniteError",
    "OutputError",
    "Problem",
    "Product",
    "RankError",
    "Rattle",
    "Reading",
    "Reduction",
    "Reference",
    "RigidMotions",
    "Rotations",
    "RungeKutta",
    "Scene",
    "SceneError",
    "SectionPoints",
    "SendingError",
    "Sensitivities",
    "SeveralRuns",
    "Skew",
    "Solution",
    "Space",
    "SpeedWarning",
    "Sphere",
    "Splitting",
    "StateWarning",
    "StepError",
    "StepLimitError",
    "StepSizeError",
    "StepWarning",
    "Stiefel",
    "StressAxis",
    "StressCase",
    "SymplecticForm",
    "System",
    "TangentBundle",
    "TangentFlow",
    "TangentSphere",
    "TangentStiefel",
    "Term",
    "UnknownNameError",
    "UnknownReferenceError",
    "Verlet",
    "View",
    "Watcher",
    "WatcherError",
    "Windows",
    "as_vector",
    "birkhoff_average",
    "chaos_report",
    "check_file",
    "check_folder",
    "cite",
    "compare_report",
    "cos",
    "derivative",
    "draw_states",
    "drift_report",
    "field",
    "find_method",
    "fma",
    "frequencies",
    "gradient",
    "great_circle",
    "helper",
    "jacobian",
    "load",
    "load_scene",
    "log",
    "lyapunov",
    "make_plan",
    "maximum",
    "method_names",
    "natural_in_space",
    "natural_on_sphere",
    "observable",
    "open_ensemble",
    "packed",
    "part",
    "pointwise",
    "report",
    "rotation_number",
    "run_methods",
    "run_scene",
    "scan_report",
    "scene_names",
    "scipy",
    "section",
    "section_report",
    "select",
    "sensitivities",
    "sin",
    "so3",
    "so_n",
    "solve",
    "solve_ensemble",
    "sqrt",
    "tangent_flow",
    "time_transformed",
    "top",
    "translations",
    "turn_coefficients",
    "value",
    "whole_file",
    "whole_folder",
    "with_quadrature",
]
