"""Scenes: what is integrated, from where, for how long, how, and what is watched."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .load import load_scene, scene_names
    from .scene import Scene

__all__ = ["Scene", "load_scene", "scene_names"]

_PUBLIC = {"Scene": "scene", "load_scene": "load", "scene_names": "load"}


def __getattr__(name: str) -> Any:
    # An unknown scene name is reported before anything that imports numpy.
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_PUBLIC[name]}"), name)
