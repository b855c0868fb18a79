"""What a command will do with a scene, where there is nothing more to it than what it integrates."""

from dataclasses import dataclass

from ..kernels.compiling.sameness import Compared
from ..scene.scene import Scene
from .choice import Route


@dataclass(frozen=True, eq=False, kw_only=True)
class Planned(Compared):
    """A scene, and what of it is integrated; `notes` are what is not done, in words."""

    scene: Scene
    route: Route
    notes: tuple[str, ...] = ()
