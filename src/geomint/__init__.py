"""Structure-preserving integration on Lie groups and constraint manifolds.

Importing geomint imports neither numba nor matplotlib: both come when they are needed.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_PUBLIC = {
    "ConvergenceError": "errors",
    "DomainError": "errors",
    "FormError": "errors",
    "GeomintError": "errors",
    "GeomintWarning": "errors",
    "MethodError": "errors",
    "NonFiniteError": "errors",
    "SceneError": "errors",
    "StepError": "errors",
    "Group": "problem",
    "GroupAction": "problem",
    "Hamiltonian": "problem",
    "Problem": "problem",
    "as_vector": "problem",
    "CommutatorFree": "methods.commutator_free",
    "Compose": "methods.composition",
    "Gauss": "methods.gauss",
    "Method": "methods.method",
    "RKMK": "methods.rkmk",
    "Rattle": "methods.rattle",
    "RungeKutta": "methods.explicit",
    "find_method": "methods.registry",
    "method_names": "methods.registry",
    "Scene": "scene.scene",
    "load_scene": "scene.load",
    "scene_names": "scene.load",
    "make_plan": "plan",
    "run_scene": "plan",
    "drift_report": "report.drift_page",
    "SavedSolution": "storage",
    "load": "storage",
    "Drift": "drift",
    "Solution": "solution",
    "solve": "integrate",
    "Model": "systems",
    "System": "systems",
    "so3": "groups",
    "so_n": "groups",
    "field": "kernels.recorded",
    "helper": "kernels.recorded",
    "observable": "kernels.recorded",
    "cos": "kernels.arithmetic",
    "fma": "kernels.arithmetic",
    "maximum": "kernels.arithmetic",
    "select": "kernels.arithmetic",
    "sin": "kernels.arithmetic",
    "sqrt": "kernels.arithmetic",
    "part": "kernels.blocks",
}

__all__ = ["__version__", *sorted(_PUBLIC)]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_PUBLIC[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *_PUBLIC])
