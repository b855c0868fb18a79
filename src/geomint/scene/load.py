"""Scenes from files and from the packages that register them.

A package registers a folder of scene files under the entry-point group ``geomint.scenes``: the
value is the folder's dotted name, and a file ``ball.toml`` in it is the built-in scene ``ball``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib.resources import files
from importlib.resources.abc import Traversable
from os import PathLike, fspath
from os.path import isfile, splitext
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import SceneError, loaded, nearest, offered, quoted, shortened

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from ..problems.systems import System
    from .scene import Scene
    from .validate import Checked

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


class Found(NamedTuple):
    """A scene before it is checked: its content, its text if it has one, its system if that is own."""

    name: str
    content: Mapping[str, Any]
    text: str | None = None
    builtin: bool = False
    system: System | None = None
    former: Checked | None = None


def load_scene(source: Any) -> Scene:
    """Return a scene from a built-in name, the path of a TOML file, or its content.

    What has to be changed to make an initial state admissible is in the scene's `notes`; for all
    but built-in scenes it is a `GeomintWarning` too.

    Parameters
    ----------
    source : str, path, mapping or Scene

    Raises
    ------
    SceneError
        For an unknown name, a file that cannot be read or is no TOML, and any content that makes
        no sense: one message with the key, the value and what was expected for each flaw.
    """
    found = _found(source)
    if isinstance(found, Found):
        from .scene import Scene

        content = found.content
        if found.system is not None:
            content = _with_end(dict(content), "run", found, str)
        scene = Scene.from_content(found.name, content, found.text, system=found.system)
        if not found.builtin:
            scene.warn()
        return scene
    return found


def load_changed(
    source: Any,
    use: str = "run",
    written: Callable[[str], str] | None = None,
    y0: Any = None,
    sections: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
    **changes: Any,
) -> Scene:
    """Return a scene that is changed before it is checked: once.

    Parameters
    ----------
    source : str, path, mapping, Scene, Problem, (Problem, y0) or function
        As `load_scene` takes it; or one's own system, see `geomint.scene.own.own_system`. A text
        ``"mysys.py:sleigh"`` is the system of that name in a Python file, which is run.
    use : str
        What for: ``"drift"`` and ``"compare"`` have sections that change the scene.
    written : callable, optional
        Says where a user has given a change.
    y0 : array_like, optional
        The initial state.
    sections : mapping
        Keys of sections, in place of what is there.
    **changes
        As `raw.overridden` takes them.
    """
    found = _found(source, y0)
    from .raw import changes_for, merged, overridden, places_of, plain, without_changed
    from .scene import Scene

    if isinstance(found, Scene):
        scene = found
        own = scene.system if scene.system.own else None
        found = Found(scene.name, scene.sections, scene.text, True, own, scene.checked)
    for pair in (("step", "tolerance"), ("t_end", "tau_end")):
        both = {key: changes[key] for key in pair if changes.get(key) is not None}
        if len(both) == 2:
            told = " and ".join(f"{(written or str)(key)} {value:g}" for key, value in both.items())
            raise SceneError(f"{told}: expected one of them")
    if use == "drift":
        sections = _one_or_several(sections, changes, written or str)
    changed = changes_for(use, found.content)
    raw = overridden(overridden(found.content, **changed), **changes)
    raw = merged(without_changed(raw, use, changes), plain(sections))
    if y0 is not None and (found.system is None or found.former is not None):
        raise SceneError(f"y0 = {quoted(y0)}: expected a Problem; a scene has its own state")
    if found.system is not None and found.former is None:
        raw = _with_end(raw, use, found, written or str)
    others = {key: value for key, value in changed.items() if changes.get(key) is None}
    places = places_of(others, f"[{use}] {{}}".format)
    if written is not None:
        places |= places_of(changes, written)
        places |= {
            f"[{name}] {key}": written(key) for name, keys in sections.items() for key in keys
        }
    text = found.text if raw == found.content else None
    made = Scene.from_content(found.name, raw, text, found.former, places, found.system)
    if written is None and not found.builtin:
        made.warn()
    return made


def _with_end(
    raw: dict[str, Any], use: str, found: Found, written: Callable[[str], str]
) -> dict[str, Any]:
    """Return the content of one's own system, which has no end; where none is needed with any."""
    if raw.get("time"):
        return raw
    if use == "section" and not raw.get("integrate", {}).get("tolerance"):
        return {**raw, "time": {"t_end": 1.0}}
    expected = f"an end: {written('t_end')}, or {written('tau_end')} of a problem in τ"
    if use == "section":
        expected = f"{written('step')}: a tolerance is of the end, which sections have not"
    raise SceneError(f"{found.name}: expected {expected}")


def _one_or_several(
    sections: Mapping[str, Mapping[str, Any]],
    changes: Mapping[str, Any],
    written: Callable[[str], str],
) -> Mapping[str, Mapping[str, Any]]:
    """Return sections in which a method or a step that is given takes the place of a list."""
    own = sections.get("drift", {})
    single = [key for key in ("method", "step") if changes.get(key) is not None]
    if own.get("methods") is None:
        return {**sections, "drift": {**own, "methods": None}} if single else sections
    if single:
        told = f"{written('methods')}: expected neither {written('method')} nor {written('step')}"
        raise SceneError(f"{told}; write NAME:STEP")
    return {**sections, "drift": {"method": None, "step": None, **own}}


def _found(source: Any, y0: Any = None) -> Found | Scene:
    """Return what stands for a scene, or the scene itself."""
    named = None
    if isinstance(source, str | PathLike):
        from .own import in_python

        named = in_python(source)
        if named is None:
            return _read(source)
    if isinstance(source, Mapping):
        return Found("scene", source)
    from .own import named_in, own_system
    from .scene import Scene

    what, name = source, ""
    if named is not None:
        what, name = named_in(*named), named[1]
    if isinstance(what, Scene):
        return what
    own = own_system(what, y0, name)
    if own is None:
        expected = (
            "a name, the path of a TOML file, a mapping, a Scene, or a Problem with its state"
        )
        raise SceneError(f"scene {quoted(source)}: expected {expected}")
    system, content = own
    if named is not None:
        system = replace(system, source=named[0].read_text("utf-8", "replace"))
    return Found(system.name, content, system=system)


def _read(source: str | PathLike[str]) -> Found:
    """Return what is in a file or a built-in scene."""
    name, path = fspath(source), Path(source)
    if isinstance(source, str) and not (name.endswith(".toml") or "/" in name or "\\" in name):
        known = builtin_scenes()
        if name in known:
            text = read_text(known[name])
            return Found(name, parse(name, text), text, True)
        if not isfile(name):  # of a name that is too long for one as well
            hint = nearest(name, known, "`geomint scenes`")
            raise SceneError(f"scene {quoted(name)}: neither a file nor a built-in scene.{hint}")
    text = read_text(path)
    return Found(path.stem, parse(name, text), text)


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
