"""One's own systems where scenes are: a problem with a state, or a function that makes one.

A Python file and a name in it stand for what has that name, ``"mysys.py:sleigh"``. The file is run.
"""

from __future__ import annotations

import importlib
import inspect
import sys
import traceback
from collections.abc import Callable, Mapping
from dataclasses import replace
from os import PathLike, fspath
from pathlib import Path
from types import ModuleType
from typing import Any, get_type_hints

import numpy as np
from pydantic import BaseModel, create_model

from ..errors import DomainError, GeomintError, SceneError, nearest, quoted, raised
from ..problems.problem import Problem
from ..problems.spaces.pieces import joined_pieces
from ..problems.systems import Model, System
from ..run.files.inputs import note_input
from .model import Number, Section

MAKES = "a Problem with its state, as a pair (problem, y0), or a function that returns one"
KINDS = (float, int, bool, str)  # of parameters; and lists of numbers
TAKEN = ("name",)  # keys of [system] that every system has

Own = tuple[System, dict[str, Any]]  # the system, and the sections [system] and [initial]


def own_system(what: Any, y0: Any = None, name: str = "") -> Own | None:
    """Return the system of a problem or a function; None for anything else.

    Parameters
    ----------
    what : Problem, (Problem, y0), or function
        A function has annotated parameters with defaults, which are the keys of ``[system]``; of a
        problem alone these are its `params`. The keys of ``[initial]`` are the pieces of the state.
    y0 : array_like, optional
        A state of the problem. A function may return its own.
    name : str
        Of the system; default: that of the problem.
    """
    if isinstance(what, tuple) and len(what) == 2 and isinstance(what[0], Problem):
        what, y0 = what[0], what[1] if y0 is None else y0
    if isinstance(what, Problem):
        return _of_problem(what, y0, name or what.name)
    if inspect.isfunction(what):
        return _of_function(what, y0, name or what.__name__)
    return None


def _of_problem(problem: Problem, y0: Any, name: str) -> Own:
    if y0 is None:
        raise DomainError("y0", y0, f"a state of {problem.name!r}: its {problem.rows} numbers")
    kept = {"params": (list[Number], problem.params.tolist())} if len(problem.params) else {}

    def build(parameters: BaseModel, initial: BaseModel) -> Model:
        given = getattr(parameters, "params", [])
        same = given == problem.params.tolist()
        made = problem if same else replace(problem, params=np.array(given))
        return _model(made, initial.model_dump())

    state = _pieces(problem, problem.canonical(y0))
    system = _system(name, kept, problem, build)
    return system, {"system": {"name": name, **{k: v for k, (_, v) in kept.items()}}, **state}


def _of_function(function: Callable[..., Any], y0: Any, name: str) -> Own:
    fields = _fields(function)

    def build(parameters: BaseModel, initial: BaseModel) -> Model:
        problem, state = _made(function, parameters.model_dump())
        given = {key: value for key, value in initial.model_dump().items() if value is not None}
        if state is None and not given:
            raise SceneError(f"{name}: it has no state: expected y0, or {MAKES}")
        own = {} if state is None else _pieces(problem, problem.canonical(state))["initial"]
        return _model(problem, {**own, **given})

    defaults = {key: default for key, (_, default) in fields.items()}
    problem, _ = _made(function, defaults)
    system = _system(name, fields, problem, build)
    initial = {} if y0 is None else _pieces(problem, problem.canonical(y0))
    return system, {"system": {"name": name, **defaults}, **initial}


def _system(
    name: str, fields: Mapping[str, Any], problem: Problem, build: Callable[..., Model]
) -> System:
    parameters = create_model("Parameters", __base__=Section, **fields)
    pieces: dict[str, Any] = {  # what is one number may be written as one
        piece: ((Number | list[Number] if rows == 1 else list[Number]) | None, None)
        for piece, rows in problem.pieces
    }
    initial = create_model("Initial", __base__=Section, **pieces)
    return System(name, "a system of one's own", parameters, initial, build, own=True)


def _fields(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the annotations of a function's parameters, and their defaults."""
    name, fields = function.__name__, {}
    try:
        hints = get_type_hints(function)
    except Exception as error:  # whatever they name
        expected = "annotations that can be read where the function is written"
        raise SceneError(f"{name}: expected {expected} ({raised(error)})") from error
    for key, parameter in inspect.signature(function).parameters.items():
        kind, default = hints.get(key), parameter.default
        listed = kind in (list, tuple) or getattr(kind, "__origin__", None) in (list, tuple)
        if (kind not in KINDS and not listed) or default is parameter.empty:
            expected = "an annotation float, int, bool, str or list[float], and a default"
            raise SceneError(f"{name}: {key}: expected {expected}, as in `{key}: float = 1.0`")
        if key in TAKEN or hasattr(BaseModel, key) or key.startswith("_"):
            raise SceneError(
                f"{name}: {key}: expected another name: this one has a meaning already"
            )
        if listed:
            if not isinstance(default, list | tuple):
                raise SceneError(f"{name}: {key} = {quoted(default)}: expected a list of numbers")
            kind, default = list[Number], list(default)
        fields[key] = (Number if kind is float else kind, default)
    return fields


def _made(function: Callable[..., Any], given: Mapping[str, Any]) -> tuple[Problem, Any]:
    """Return the problem that a function makes, and its state if it has one."""
    try:
        made = function(**given)
    except GeomintError as error:
        raise SceneError(f"{function.__name__}: {error}") from error
    except Exception as error:
        raise SceneError(f"{function.__name__} failed{_where(error)}: {raised(error)}") from error
    problem, state = made if isinstance(made, tuple) and len(made) == 2 else (made, None)
    if not isinstance(problem, Problem):
        raise SceneError(f"{function.__name__} returned {quoted(made)}: expected {MAKES}")
    return problem, state


def _pieces(problem: Problem, y: Any) -> dict[str, dict[str, list[float]]]:
    """Return a state as the section ``[initial]``."""
    return {"initial": {piece: y[rows].tolist() for piece, rows in problem.slices.items()}}


def _model(problem: Problem, pieces: Mapping[str, Any]) -> Model:
    state = problem.canonical(joined_pieces(problem.pieces, pieces))
    return Model({problem.name: problem}, {problem.name: state})


# --- files in Python ---------------------------------------------------------------------------------


def in_python(source: str | PathLike[str]) -> tuple[Path, str] | None:
    """Return the file and the name of ``"mysys.py:sleigh"``; None if it is no file in Python."""
    path, _, name = fspath(source).rpartition(":")
    if fspath(source).endswith(".py"):
        path, name = fspath(source), ""
    return (Path(path), name) if path.endswith(".py") else None


def named_in(path: Path, name: str) -> Any:
    """Run a file, and return what has that name in it, or raise `SceneError`."""
    if not path.is_file():
        close = nearest(path.name, [p.name for p in path.absolute().parent.glob("*.py")])
        raise SceneError(f"Python file {quoted(str(path))} does not exist.{close}")
    if not path.stem.isidentifier():
        expected = "a name that Python can import, such as mysys.py"
        raise SceneError(f"Python file {quoted(str(path))}: expected {expected}")
    module = _run(path)
    known = [
        key
        for key, value in vars(module).items()
        if isinstance(value, Problem | tuple)
        or (inspect.isfunction(value) and value.__module__ == module.__name__)
    ]
    if not name or not hasattr(module, name):
        said = f"{path}: no such name {name!r}" if name else f"{path}: expected a name after it"
        hint = nearest(name, known) if name else f", such as {path}:{(known or ['sleigh'])[-1]}"
        raise SceneError(f"{said}{'.' if name else ''}{hint}")
    return getattr(module, name)


_loaded: dict[str, ModuleType] = {}  # what files that were run have left in sys.modules
_searched: list[
    str
] = []  # the last file's folder, where other processes look for what they are sent


def _run(path: Path) -> ModuleType:
    """Run a file as it is now: neither it nor what lies beside it is taken from an earlier run."""
    note_input(path)
    file, folder = path.absolute(), str(path.absolute().parent)
    for name, module in _loaded.items():
        if sys.modules.get(name) is module:
            del sys.modules[name]
    sys.path[:] = [where for where in sys.path if where not in _searched]
    importlib.invalidate_caches()
    before, written = dict(sys.modules), sys.dont_write_bytecode
    sys.modules[path.stem] = module = ModuleType(path.stem)
    module.__file__ = str(file)
    sys.path.insert(0, folder)
    sys.dont_write_bytecode = True  # Python takes what is edited within a second for the same
    try:
        code = compile(file.read_bytes(), str(file), "exec", dont_inherit=True)
        exec(code, vars(module))
    except BaseException as error:
        sys.modules.pop(path.stem, None)
        if isinstance(error, GeomintError) or not isinstance(error, Exception):
            raise
        said = f"failed{_where(error, str(path))}: {raised(error)}"
        raise SceneError(f"Python file {quoted(str(path))} {said}") from error
    finally:
        sys.dont_write_bytecode = written
        sys.path.remove(folder)
        _loaded.clear()
        _loaded.update({k: m for k, m in sys.modules.items() if _beside(k, m, folder, before)})
        if path.stem in before:  # somebody has imported it, and goes on with that
            sys.modules[path.stem] = before[path.stem]
    _searched[:] = [] if folder in sys.path else [folder]
    sys.path.extend(_searched)
    return module


def _beside(name: str, module: ModuleType, folder: str, before: Mapping[str, ModuleType]) -> bool:
    """Tell whether a module is new, and of a file or a package that lies in a folder."""
    file, place = getattr(module, "__file__", None), Path(folder, name.partition(".")[0])
    if module is before.get(name) or not file:
        return False
    return Path(file) == place.with_suffix(".py") or place in Path(file).parents


def _where(error: BaseException, file: str = "") -> str:
    """Return the line in which an error was raised: the last one of a file, if it is named."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if not file or Path(f.filename) == Path(file).absolute()]
    return f" in line {own[-1].lineno} of {Path(own[-1].filename).name}" if own else ""
