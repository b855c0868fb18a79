"""Scenes: what is integrated, from where, for how long, how, and what is watched."""

from .load import load_scene, scene_names
from .scene import Scene

__all__ = ["Scene", "load_scene", "scene_names"]
