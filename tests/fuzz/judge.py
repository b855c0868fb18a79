"""What a case ended with: one verdict, and the words that tell why."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import click
import numpy as np

import geomint as gi
from geomint.cli import main

__all__ = ["BAD", "VERDICTS", "Judged", "command_verdict", "judged", "only_finite"]

BAD = (
    *("traceback", "hang", "died", "not finite", "stray file", "long message", "disagreement"),
    *("deletion", "execution", "silent read"),
)
VERDICTS = ("ok", "typed", "interrupted", *BAD)
LONGEST = 4000  # characters of a message, however much is wrong


@dataclass(frozen=True)
class Judged:
    """A verdict, and the last line of what was raised with the place where that was."""

    verdict: str
    detail: str = ""

    @property
    def bad(self) -> bool:
        """Whether this must not be."""
        return self.verdict in BAD


def judged(call: Callable[[], Any], finite: Callable[[Any], bool] = lambda value: True) -> Judged:
    """Return what a call ends with; `finite` looks at what it returns."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            value = call()
            if not finite(value):
                return Judged("not finite", repr(value)[:300])
    except (KeyboardInterrupt, click.Abort):
        return Judged("interrupted")
    except (gi.GeomintError, click.ClickException) as error:
        return _refusal(error)
    except OSError as error:
        named = error.filename is not None  # as the command line tells them
        return Judged("typed", "OSError") if named else Judged("traceback", _place(error))
    except Exception as error:
        return Judged("traceback", _place(error))
    return Judged("ok")


def _refusal(error: Exception) -> Judged:
    text = error.format_message() if isinstance(error, click.ClickException) else str(error)
    if len(text) > LONGEST:
        return Judged("long message", f"{len(text)} characters: {text[:200]}")
    return Judged("typed", f"{type(error).__name__}: {text[:200]}")


def _place(error: BaseException) -> str:
    """Return the error and the innermost line of the project that it passed."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if "/geomint/" in f.filename or "/chaplygin/" in f.filename]
    at = f"{Path(own[-1].filename).name}:{own[-1].lineno} {own[-1].name}" if own else "?"
    try:
        text = str(error)
    except Exception:
        text = "(no text)"
    return f"{type(error).__name__} at {at}: {text[:150]}"


def only_finite(value: Any) -> bool:
    """Tell whether a result that says success holds finite numbers only."""
    if isinstance(value, gi.Solution):
        if not value.success:
            return True
        arrays = [value.y, value.tau, *([] if value.physical is None else [value.physical])]
        return all(np.isfinite(a).all() for a in arrays)
    if isinstance(value, gi.Problem):
        return bool(np.isfinite(value.params).all())
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        return bool(np.isfinite(value).all())
    return True


@contextlib.contextmanager
def alarm(seconds: float, again: float = 1.0) -> Iterator[None]:
    """Press Ctrl-C after some seconds, and again, that many times as late, as often as it takes."""

    def ring(number: int, frame: FrameType | None) -> None:
        signal.raise_signal(signal.SIGINT)

    pressed = signal.signal(signal.SIGINT, signal.default_int_handler)
    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds, again * seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        signal.signal(signal.SIGINT, pressed)


_written: list[str] | None = None


def _watch(event: str, arguments: tuple[Any, ...]) -> None:
    """Keep the paths of what is written, made, moved or removed."""
    if _written is None:
        return
    if event == "open":
        path, mode, flags = arguments
        writes = flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT) if isinstance(flags, int) else 0
        if isinstance(path, str | bytes) and (writes or (mode and set(mode) & set("wax+"))):
            _written.append(os.path.abspath(os.fsdecode(path)))
    elif event in ("os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.symlink", "os.link"):
        _written.extend(
            os.path.abspath(os.fsdecode(a)) for a in arguments[:2] if isinstance(a, str | bytes)
        )


_hooked = False


@contextlib.contextmanager
def files_written() -> Iterator[list[str]]:
    """Give the list of paths that are written to in the meantime."""
    global _written, _hooked
    if not _hooked:
        sys.addaudithook(_watch)
        _hooked = True
    _written = found = []
    try:
        yield found
    finally:
        _written = None


def stray(paths: list[str], folder: Path) -> list[str]:
    """Return the paths that lie neither in the folder nor in a cache."""
    homes = [str(folder), os.environ.get("NUMBA_CACHE_DIR", "\0"), "/dev/", "/proc/"]
    homes += [str(Path("~/.cache").expanduser()), "/root/.config/matplotlib"]
    return [p for p in paths if not p.startswith(tuple(homes))]


def command_verdict(arguments: list[str], folder: Path, seconds: float = 0.0) -> tuple[Judged, Any]:
    """Return the verdict on a command line, run in `folder`, and what the command returned."""
    streams = [
        io.TextIOWrapper(io.BytesIO(), "utf-8", errors=errors)
        for errors in ("strict", "backslashreplace")
    ]
    returned: list[Any] = []
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(streams[0]),
        contextlib.redirect_stderr(streams[1]),
        files_written() as paths,
        alarm(seconds, 5.0) if seconds else contextlib.nullcontext(),
    ):
        verdict = judged(
            lambda: returned.append(main.main(arguments, "geomint", standalone_mode=False))
        )
    outside = stray(paths, folder)
    if outside:
        return Judged("stray file", ", ".join(outside)[:300]), None
    return verdict, returned[0] if returned else None


def check_scene(data: bytes, arguments: list[str]) -> Judged:
    """Return the verdict on ``geomint check`` of a scene file."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(os.path.realpath(name))
        (folder / "scene.toml").write_bytes(data)
        return command_verdict(["check", "scene.toml", *arguments], folder)[0]


STEPS = ("ConvergenceError", "NonFiniteError", "StepSizeError", "StepLimitError")


def run_scene(data: bytes, seconds: float) -> Judged:
    """Return the verdict on ``geomint run`` of a scene file, and on whether `check` agrees.

    A run that takes longer is interrupted, as by Ctrl-C.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(os.path.realpath(name))
        (folder / "scene.toml").write_bytes(data)
        checked, _ = command_verdict(["check", "scene.toml"], folder)
        if checked.bad:
            return checked
        arguments = ["run", "scene.toml", "--quiet", "--yes", "--out", "out/run.nc"]
        verdict, code = command_verdict(arguments, folder, seconds)
        if verdict.bad or verdict.verdict == "interrupted":
            return verdict
        of_step = verdict.detail.startswith(STEPS)
        if checked.verdict != verdict.verdict and not of_step:
            told = f"check: {checked.verdict} {checked.detail}, run: {verdict.verdict} {verdict.detail}"
            return Judged("disagreement", told)
        if verdict.verdict == "ok":
            saved = gi.load(folder / "out" / "run.nc")
            if code not in (0, None):
                told = "not finite" if saved.success or not saved.message else "typed"
                return Judged("interrupted" if code == 130 else told, f"code {code}")
            if not only_finite(saved):
                return Judged("not finite", "states")
        return verdict
