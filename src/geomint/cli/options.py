"""Options and helpers that several commands share."""

from __future__ import annotations

import functools
import shlex
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import DomainError, Gathered, printable

if TYPE_CHECKING:
    from ..plan import Estimate, MethodRun
    from ..scene import Scene

__all__ = [
    "EXIT_CODES",
    "built",
    "check_time",
    "chosen_scene",
    "debug_option",
    "end_options",
    "exit_code",
    "folder_option",
    "list_option",
    "methods_option",
    "paper_option",
    "partly",
    "patience",
    "print_failure",
    "print_line",
    "print_message",
    "print_notes",
    "reproducing_command",
    "say",
    "say_report",
    "scene_argument",
    "scene_choice",
    "scene_options",
    "tell_failure",
    "watched_option",
    "written",
    "yes_option",
]

PATIENCE = 1.0  # seconds
# "closed": nobody reads, as click has it. After a signal it is 128 and the signal's number.
EXIT_CODES = {"success": 0, "closed": 1, "forbidden": 1, "failed": 2, "interrupted": 130}


def list_option(
    *names: str, of: Callable[[str], Any] = str.strip, **given: Any
) -> Callable[..., Any]:
    """Return an option whose value is a list with commas between."""

    def parts(context: click.Context, option: click.Parameter, text: str | None) -> Any:
        if text is None:
            return None
        with suppress(ValueError):
            if found := [of(part) for part in text.split(",") if part.strip()]:
                return found
        kind = "names" if of is str.strip else "numbers"
        raise DomainError(names[0], text, f"{kind} with commas between")

    return click.option(*names, callback=parts, **given)


debug_option = click.option("--debug", is_flag=True, hidden=True, expose_value=False)

scene_argument = click.argument("scene")
_CHOICE = (
    scene_argument,
    click.option("--method", metavar="NAME", help="Use this method; `geomint methods` lists all."),
    click.option("--step", type=float, help="Step size, in the time of the problem (t or tau)."),
    click.option(
        "--tolerance",
        type=float,
        help="Relative error of the final state; chooses the step, and with --method auto the method.",
    ),
    click.option(
        "--representation",
        metavar="NAME",
        help="Form of the equations to integrate; `own` is the form of the scene.",
    ),
)
_ENDS = (
    click.option("--t-end", type=float, help="End time t (physical time)."),
    click.option("--tau-end", type=float, help="End time tau, in scenes that use tau."),
)
watched_option = list_option(
    "--observe",
    "quantities",
    metavar="LIST",
    help="Quantities or groups to measure instead of those of the scene, separated by commas.",
)

methods_option = list_option(
    "--methods",
    metavar="LIST",
    help="Several methods: NAME or NAME:STEP, separated by commas; without --method and --step.",
)


yes_option = click.option(
    "--yes", is_flag=True, help="Run even if the estimated time is more than a day."
)


def _still(context: click.Context, option: click.Parameter, quiet: bool) -> bool:
    """Let nothing say either that functions are compiled."""
    if quiet:
        from ..kernels.compiling.compile import listen

        context.call_on_close(listen(lambda name, seconds: None))
    return quiet


quiet_option = click.option(
    "--quiet", is_flag=True, callback=_still, help="Print no progress, no summary and no table."
)


paper_option = click.option(
    "--paper",
    is_flag=True,
    help="Also write files for a paper: figures as PDF, table and caption in LaTeX, BibTeX, data.",
)


def folder_option(default: str, files: str) -> Callable[..., Any]:
    """Return the option --out of a command that writes those files into a folder."""
    return click.option(
        "--out",
        default=default,
        show_default=True,
        type=click.Path(file_okay=False, path_type=Path),
        help=f"Write {files} to this folder.",
    )


def _all_of(*options: Callable[..., Any]) -> Callable[..., Any]:
    """Return what adds several options to a command, in their order."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        return functools.reduce(lambda f, option: option(f), reversed(options), command)

    return add


# The argument SCENE, and the options that change how it is integrated.
scene_choice = _all_of(*_CHOICE)

# The options that say where a run ends.
end_options = _all_of(*_ENDS)

# The argument SCENE and the options that change it, as `chosen_scene` takes them.
scene_options = _all_of(*_CHOICE[:4], *_ENDS, *_CHOICE[4:], watched_option, debug_option)


def chosen_scene(scene: str, use: str = "run", **changes: Any) -> Scene:
    """Return a scene, for a use of it, with what the command line changes in it."""
    from ..scene.load import load_changed

    tell_file(scene)
    return built(functools.partial(load_changed, scene, use, written, **changes))


def built(make: Callable[[], Scene]) -> Scene:
    """Return the scene that a function makes; its notes are printed, not told as warnings."""
    with Gathered(quiet=True), patience("building the scene"):
        return make()


def tell_file(scene: str) -> None:
    """Say that a file in Python is run."""
    from ..scene.own import in_python

    if found := in_python(scene):
        print_message(f"running {found[0]}")


def written(key: str) -> str:
    """Return the option of the command line that changes a key of a scene."""
    return "--observe" if key == "quantities" else f"--{key.replace('_', '-')}"


def print_notes(scene: Scene, more: Iterable[str] = ()) -> None:
    """Print what was changed to make the initial state admissible, and `more`."""
    for note in (*scene.notes, *more):
        print_message(f"note: {note}")


def print_message(text: str) -> None:
    """Print a line of geomint's own on standard error; where that cannot be written, nothing."""
    with suppress(OSError, ValueError):  # full, or closed
        click.echo(f"geomint: {printable(text)}", err=True)


def print_line(text: str) -> None:
    """Print a line in which there may be what strangers have written: titles, names."""
    click.echo(printable(text))


def say(what: str, path: Path) -> None:
    """Print where something was written."""
    print_line(f"{what}: {path}")


def say_report(what: str, page: Path, stem: str = "") -> None:
    """Print where a report was written, and what is for a paper, whose names begin with `stem`."""
    say(what, page)
    if stem:
        say("for a paper", page.parent / f"{stem}-paper.tex")


def print_failure(
    failure: BaseException, arguments: Sequence[str] | None = None, label: str = ""
) -> None:
    """Print an error, after a label.

    With ``--debug`` among the arguments, by default those of this process, the traceback too.
    """
    if "--debug" in (sys.argv if arguments is None else arguments):
        traceback.print_exception(failure)
    print_message(f"{label}{failure}")


def tell_failure(run: MethodRun) -> None:
    """Print why a run did not reach its end, if so."""
    if run.error is not None:
        print_failure(run.error, label=f"{run.label}: {run.status}: ")
    elif run.status != "success":
        print_message(f"{run.label}: {run.status}: {run.message}".rstrip(": "))


def partly(status: str) -> str:
    """Return how to say that a result is not all that was asked for."""
    return "" if status == "success" else f" ({status})"


def check_time(expected: Callable[[], Estimate], allowed: bool) -> None:
    """Print how long a command will take if that is beyond an hour; refuse beyond a day.

    Raises
    ------
    GeomintError
        Beyond a day as measured, unless that is allowed.
    """
    from ..errors import GeomintError
    from ..run.progress import DAY, HOUR

    with patience("timing"):
        found = expected()
    if found.measured and found.seconds > DAY and not allowed:
        raise GeomintError(f"this takes {found}: give --yes for more than a day, or an earlier end")
    if found.seconds > HOUR:
        print_message(f"note: this takes {found}")
        # It has been said: not again by the run.
        warnings.filterwarnings("ignore", "at its pace this run takes")


@contextmanager
def patience(doing: str) -> Iterator[None]:
    """Say on standard error what is being done if it has lasted a second."""
    timer = threading.Timer(PATIENCE, click.echo, (f"geomint: {doing} …",), {"err": True})
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def reproducing_command() -> str:
    """Return the command line of this run."""
    return shlex.join(["geomint", *sys.argv[1:]])


def exit_code(status: str) -> int:
    """Return the exit code after what a status says; what is not known is a failure."""
    return EXIT_CODES.get(status, EXIT_CODES["failed"])
