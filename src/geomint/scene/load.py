"""Scenes from files and from the packages that register them.

A package registers a folder of scene files under the entry-point group ``geomint.scenes``: the
value is the folder's dotted name, and a file ``ball.toml`` in it is the built-in scene ``ball``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from importlib.resources import files
from importlib.resources.abc import Traversable
from os import PathLike, fspath
from os.path import isfile, splitext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import SceneError, loaded, nearest, offered, quoted, shortened

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from .scene import Scene

LONGEST_FILE = 2**26  # characters: a million times have 20 million, /dev/zero has no end


def builtin_scenes() -> dict[str, Traversable]:
    """Return the files of all registered scenes by name, sorted."""

    def scenes_of(point: EntryPoint) -> dict[str, Traversable]:
        entries = {splitext(entry.name): entry for entry in files(loaded(point)).iterdir()}
        return {name: entry for (name, ending), entry in entries.items() if ending == ".toml"}

    expected = "a package with scene files"
    return dict(sorted(offered("geomint.scenes", parts=scenes_of, expected=expected).items()))


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
    found = ("scene", source, None, False)
    name, content, text, builtin = _found(source) if isinstance(source, str | PathLike) else found
    from .scene import Scene

    if isinstance(content, Scene):
        return content
    if not isinstance(content, Mapping):
        expected = "a name, the path of a TOML file, a mapping, or a Scene"
        raise SceneError(f"scene {quoted(content)}: expected {expected}")
    scene = Scene.from_content(name, content, text)
    if not builtin:
        scene.warn()
    return scene


def load_changed(
    source: str, drift: bool, written: Callable[[str], str] = str, **changes: Any
) -> Scene:
    """Return a scene from a built-in name or a TOML file, changed before it is checked.

    By its own section ``[drift]`` if `drift`, and then by `changes`, as `raw.overridden` takes them;
    `written` says where a user has given one of them.
    """
    name, content, text, _ = _found(source)
    from .raw import drift_changes, in_drift, overridden, places_of
    from .scene import Scene

    own = drift_changes(content) if drift else {}
    raw = overridden(overridden(content, **own), **changes)
    places = {**places_of(own, in_drift), **places_of(changes, written)}
    return Scene.from_content(name, raw, text if raw == content else None, places=places)


def _found(source: str | PathLike[str]) -> tuple[str, dict[str, Any], str, bool]:
    """Return name, content and text of a file or a built-in scene, and whether it is the latter."""
    name, path = fspath(source), Path(source)
    if isinstance(source, str) and not (name.endswith(".toml") or "/" in name or "\\" in name):
        known = builtin_scenes()
        if name in known:
            text = read_text(known[name])
            return name, parse(name, text), text, True
        if not isfile(name):  # of a name that is too long for one as well
            hint = nearest(name, known, "`geomint scenes`")
            raise SceneError(f"scene {quoted(name)}: neither a file nor a built-in scene.{hint}")
    text = read_text(path)
    return path.stem, parse(name, text), text, False


def read_text(path: Path | Traversable) -> str:
    """Return the text of a scene file, or raise `SceneError`."""
    from ..run.files.inputs import note_input

    try:
        with path.open("r", encoding="utf-8-sig") as file:
            if isinstance(path, Path):  # nothing is written into archives
                note_input(path)
            if len(text := file.read(LONGEST_FILE + 1)) <= LONGEST_FILE:
                return text
        why = f"is too long: expected at most {LONGEST_FILE} characters"
    except FileNotFoundError:
        close = nearest(path.name, [p.name for p in Path(str(path)).parent.glob("*.toml")])
        why = f"does not exist.{close}"
    except OSError as error:
        why = f"cannot be read: {error.strerror or '?'}"
    except ValueError as error:  # no UTF-8, or no path
        why = f"cannot be read: {error}"
    raise SceneError(f"scene file {quoted(str(path))} {why}")


def parse(name: str, text: str) -> dict[str, Any]:
    """Return the content of a TOML text, or raise `SceneError` with line and column."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        why = f"is not valid TOML: {shortened(str(error))}"
    except RecursionError:
        why = "is too deep: expected lists and tables that are not nested in hundreds of others"
    except ValueError:  # of Python: an integer that it does not read
        why = "has too long an integer: expected numbers of at most some thousands of digits"
    raise SceneError(f"scene {quoted(name)} {why}")
