"""A command: what geomint does with a scene, or with one's own system, from the shell and from Python.

A command is a module of this room, or an entry point of the group ``geomint.commands``: an object of
type `Command`. The first line of its module says in ``geomint --help`` what it does. A key of its
section is a key of scenes, an option of the shell and a keyword in Python at once.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ArgumentError, DomainError, GeomintError, LeftOutWarning, nearest, tell
from ..run.calls import still
from ..run.files.outputs import check_folder
from ..run.reported import Reported
from ..scene.load import load_changed
from ..scene.model import SECTIONS, Section
from ..scene.scene import Scene
from .table import find_command

if TYPE_CHECKING:
    from ..plan.duration import Estimate
    from ..reports.report import Report

STEPPED: tuple[str, ...] = (
    "method",
    "step",
    "tolerance",
    "representation",
)  # keys of scenes that a command takes
ENDS: tuple[str, ...] = ("t_end", "tau_end")
WATCHED: tuple[str, ...] = ("quantities",)
RESERVED = {"what", "y0", "scene", "out", "paper", "progress", "quiet", "yes", "debug", "observe"}


@dataclass(frozen=True)
class Listener:
    """Who is told how far a command is.

    Attributes
    ----------
    progress : bool or None
        As in `geomint.solve`.
    doing : callable
        Told what is being done, in words.
    failed : callable
        Told of an error that leaves a part of what was asked for, and what it is about.
    """

    progress: bool | None = None
    doing: Callable[[str], object] = lambda words: None
    failed: Callable[[BaseException | str, str], object] = lambda error, what: None


@dataclass(frozen=True, eq=False)
class Command:
    """A row of the table of commands.

    Parameters
    ----------
    name : str
    section : type of Section
        Its fields are the keys of the scene's section `key`, options and keywords.
    plan : callable
        ``plan(scene)``: what will be done. It may have `notes`, what is not done, in words.
    run : callable
        ``run(planned, listener)``: what was found, which has `status`; parts of it after Ctrl-C.
    report : callable
        ``report(planned, found, command)``: a `Report`; `command` is the command line, if it is one.
    files : tuple of str
        All that may lie in the folder of the report.
    takes : sequence of str
        Which keys of ``[time]``, ``[integrate]`` and ``[observe]`` it takes.
    use : str
        Whose changes of the scene it runs with: ``"drift"``, ``"compare"``, or ``"run"``.
    key : str
        The section of scenes; default: `name`.
    folder : str
        Where the shell writes; default: `name`.
    expected : callable, optional
        ``expected(planned)``: how long it will take, where that may be long.
    """

    name: str
    section: type[Section]
    plan: Callable[[Scene], Any]
    run: Callable[[Any, Listener], Any]
    report: Callable[[Any, Any, str | None], Report]
    files: tuple[str, ...]
    takes: Sequence[str] = (*STEPPED, *ENDS)
    use: str = "run"
    key: str = ""
    folder: str = ""
    expected: Callable[[Any], Estimate] | None = None

    def __post_init__(self) -> None:
        """Let scenes have its section, whose keys are none of the words that all commands have."""
        for key in sorted(RESERVED & self.section.model_fields.keys()):
            expected = "another name: all commands have an option or an argument of that name"
            raise DomainError(f"{self.name}: key", key, expected)
        SECTIONS.setdefault(self.key or self.name, self.section)

    @property
    def keys(self) -> list[str]:
        """The keys of its section that are its own: those of the scene are said once."""
        changing = {*STEPPED, *ENDS, *WATCHED, "every"}  # of a scene: of two sections
        taken = changing if self.use in ("drift", "compare") else {*self.takes}
        return [name for name in self.section.model_fields if name not in taken]

    def scene(
        self,
        what: Any,
        given: dict[str, Any],
        y0: Any = None,
        written: Callable[[str], str] | None = None,
    ) -> Scene:
        """Return what is asked for, as a scene that is checked once.

        Raises
        ------
        ArgumentError
            For a key that is none of the command's.
        """
        known = [*self.takes, *self.keys]
        for key in given:
            if key not in known:
                hint = nearest(key, [*known, "y0", "progress", "paper"])
                raise ArgumentError(f"{self.name}: no keyword {key!r}.{hint}")
        own = {key: given[key] for key in self.keys if given.get(key) is not None}
        changes = {key: value for key, value in given.items() if key in self.takes}
        sections = {self.key or self.name: own} if own else {}
        return load_changed(what, self.use, written, y0, sections, **changes)


def notes_of(planned: Any) -> tuple[str, ...]:
    """Return what is asked for and will not be done, in words."""
    return tuple(getattr(planned, "notes", ()))


def in_python(command: Command) -> Callable[..., Any]:
    """Return the function that does in Python what a command does in a shell."""

    def function(
        what: Any,
        out: str | PathLike[str],
        *,
        y0: Any = None,
        progress: bool | None = None,
        paper: bool = False,
        **keys: Any,
    ) -> Any:
        if "observe" in keys:
            keys["quantities"] = keys.pop("observe")
        planned = command.plan(command.scene(what, keys, y0))
        for note in notes_of(planned):
            tell(LeftOutWarning(note))
        check_folder(out, command.files)
        errors: list[tuple[str, BaseException | str]] = []
        heard = Listener(progress, failed=lambda error, what: errors.append((what, error)))
        found = command.run(planned, heard)
        make = partial(command.report, planned, found, None)
        if isinstance(found, Reported):
            object.__setattr__(found, "_make", make)
        make().write(Path(out), paper)
        for what, error in errors:
            if not what and isinstance(error, BaseException):  # of the whole: it is told of now
                raise error
        return found

    function.__name__ = function.__qualname__ = f"{command.name}_report"
    function.__doc__ = _documented(command)
    return still(function)


def report(name: str, what: Any, out: str | PathLike[str], **keys: Any) -> Any:
    """Do what ``geomint NAME`` does, and write its report.

    Parameters
    ----------
    name : str
        Of a command: ``"drift"``, ``"compare"``, ``"scan"``, ``"section"``, ``"chaos"``, or one that
        another package adds.
    what, out, **keys
        As `geomint.drift_report` and the others take them.

    Returns
    -------
    object
        What was found.

    Raises
    ------
    GeomintError
        For a name that is none, and as the command does.

    Examples
    --------
    >>> import tempfile
    >>> import geomint as gi
    >>> folder = tempfile.mkdtemp()
    >>> found = gi.report("chaos", "hamiltonized-n3", folder, tau_end=10.0, progress=False)
    >>> isinstance(found, gi.Lyapunov)
    True
    """
    if name == "stress":
        from .commands.stress import stress_report

        return stress_report(what, out, **keys)
    found = find_command(name)
    if not isinstance(found, Command):
        raise GeomintError(f"command {name!r} makes no report in Python")
    return in_python(found)(what, out, **keys)


def _documented(command: Command) -> str:
    """Return the documentation of what does a command in Python."""
    fields = command.section.model_fields
    own = "\n".join(f"    `{key}`: {fields[key].description}" for key in command.keys)
    taken = ", ".join(f"`{key}`" for key in command.takes)
    said = inspect.getdoc(inspect.getmodule(command.plan)) or command.name
    more = DOCUMENTED.format(taken=taken, section=command.key or command.name, own=own)
    return f"{said}\n{more}"


DOCUMENTED = """
Parameters
----------
what : Problem, Scene, name, path or mapping
    One's own problem with its state `y0`, or a scene; also a function that makes a problem, and a
    text such as ``"mysys.py:sleigh"``, a name in a Python file, which is run.
out : path
    A folder; made if it is not there. Files of an earlier report are replaced.
y0 : array_like, optional
    Where a problem of one's own begins.
progress : bool, optional
    Show progress. Default: if standard error is a terminal.
paper : bool
    Also write what goes into a paper, as ``--paper`` does.
**keys
    Those of the scene: {taken}. And those of ``[{section}]``:

{own}

Returns
-------
object
    What was found, with `plot`, `to_dataframe` and `report`; after Ctrl-C what was found by then.

Raises
------
SceneError, FormError, MethodError, DomainError, OutputError
    Before anything is computed.
StepError
    If a method fails on the way.
"""
