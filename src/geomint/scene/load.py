"""Scenes from files and from the packages that register them.

A package registers a folder of scene files under the entry-point group ``geomint.scenes``: the
value is the folder's dotted name, and a file ``ball.toml`` in it is the built-in scene ``ball``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.metadata import entry_points
from importlib.resources import files
from importlib.resources.abc import Traversable
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import SceneError, nearest, quoted, shortened

if TYPE_CHECKING:
    from .scene import Scene

__all__ = ["builtin_scenes", "load_changed", "load_scene", "scene_names"]


def builtin_scenes() -> dict[str, Traversable]:
    """Return the files of all registered scenes by name, sorted."""
    found: dict[str, Traversable] = {}
    for point in sorted(entry_points(group="geomint.scenes"), key=lambda p: p.name):
        try:
            entries = list(files(point.value).iterdir())
        except (ImportError, FileNotFoundError, NotADirectoryError):
            continue  # a package that was removed or is broken must not take the others with it
        for entry in entries:
            if entry.name.endswith(".toml"):
                found.setdefault(entry.name.removesuffix(".toml"), entry)
    return dict(sorted(found.items()))


def scene_names() -> list[str]:
    """Return the names of the built-in scenes."""
    return list(builtin_scenes())


def load_scene(source: str | PathLike[str] | Mapping[str, Any] | Scene) -> Scene:
    """Return a scene from a built-in name, the path of a TOML file, or its content.

    What has to be changed to make an initial state admissible is in the scene's `notes`; for all
    but built-in scenes it is a `GeomintWarning` too.

    Raises
    ------
    SceneError
        For an unknown name, a file that cannot be read or is no TOML, and any content that makes
        no sense: one message with the key, the value and what was expected for each flaw.
    """
    text: str | None = None
    content: Mapping[str, Any] | None = None
    name, builtin = "scene", False
    if isinstance(source, str | PathLike):
        name, text, builtin = _found(source)
        content = parse(name if builtin else fspath(source), text)
    elif isinstance(source, Mapping):
        content = source
    from .scene import Scene

    if isinstance(source, Scene):
        return source
    if content is None:
        expected = "a name, the path of a TOML file, a mapping, or a Scene"
        raise SceneError(f"scene {quoted(source)}: expected {expected}")
    scene = Scene.from_content(name, content, text)
    if not builtin:
        scene.warn()
    return scene


def load_changed(source: str, drift: bool, **changes: Any) -> Scene:
    """Return a scene from a built-in name or a TOML file, changed before it is checked.

    By its own section ``[drift]`` if `drift`, and then by `changes`, as `raw.overridden` takes them.
    """
    name, text, builtin = _found(source)
    content = parse(name if builtin else source, text)
    from .raw import drift_changes, overridden
    from .scene import Scene

    raw = overridden(content, **drift_changes(content)) if drift else content
    raw = overridden(raw, **changes)
    return Scene.from_content(name, raw, text if raw == content else None)


def _found(source: str | PathLike[str]) -> tuple[str, str, bool]:
    """Return name and text of a file or a built-in scene, and whether it is the latter."""
    name, path = fspath(source), Path(source)
    if isinstance(source, str) and not (name.endswith(".toml") or "/" in name or "\\" in name):
        known = builtin_scenes()
        if name in known:
            return name, known[name].read_text(encoding="utf-8"), True
        if not _is_file(path):
            hint = nearest(name, known, "`geomint scenes`")
            raise SceneError(f"scene {quoted(name)}: neither a file nor a built-in scene.{hint}")
    return path.stem, _read(path), False


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # such as a name that is too long for one
        return False


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        close = nearest(path.name, [p.name for p in path.parent.glob("*.toml")])
        raise SceneError(f"scene file {quoted(str(path))} does not exist.{close}") from None
    except OSError as error:
        reason = error.strerror or "?"
        raise SceneError(f"scene file {quoted(str(path))} cannot be read: {reason}") from None
    except ValueError as error:  # no UTF-8, or no path
        raise SceneError(f"scene file {quoted(str(path))} cannot be read: {error}") from None


def parse(name: str, text: str) -> dict[str, Any]:
    """Return the content of a TOML text, or raise `SceneError` with line and column."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(
            f"scene {quoted(name)} is not valid TOML: {shortened(str(error))}"
        ) from None
    except RecursionError:
        expected = "lists and tables that are not nested in hundreds of others"
        raise SceneError(f"scene {quoted(name)} is too deep: expected {expected}") from None
    except ValueError:  # of Python: an integer that it does not read
        expected = "numbers of at most some thousands of digits"
        raise SceneError(
            f"scene {quoted(name)} has too long an integer: expected {expected}"
        ) from None
