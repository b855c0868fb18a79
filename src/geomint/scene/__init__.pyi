from .load import load_scene as load_scene, scene_names as scene_names
from .scene import Scene as Scene
