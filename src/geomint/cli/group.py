"""The command group: lazy commands, and errors as one message and an exit code."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import traceback
import warnings
from collections.abc import Iterator, Sequence
from typing import Any

import click

from .. import __version__
from ..errors import GeomintError, GeomintWarning, nearest, raised
from ..run.files.inputs import inputs_of_command
from .options import exit_code, print_failure, print_message
from .plugged import summary
from .signals import signals_as_ctrl_c
from .table import find_command, other_commands, own_commands


@contextlib.contextmanager
def _one_command() -> Iterator[None]:
    """Show geomint's warnings as lines of its own, and know of no inputs of other commands.

    They are shown whatever Python does with warnings, but for a shell that completes a word. What is
    done to filters within ends with it.
    """
    other = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any) -> None:
        if issubclass(category, GeomintWarning):
            print_message(f"warning: {message}")
        else:
            other(message, category, *where)

    with warnings.catch_warnings(), inputs_of_command():
        warnings.showwarning = show  # type: ignore[assignment]
        warnings.simplefilter("default", GeomintWarning)
        if "_GEOMINT_COMPLETE" in os.environ:
            warnings.simplefilter("ignore")
        yield


class _Named(click.ParamType):  # type: ignore[type-arg]
    """A path that is not empty: as a path that would be the current folder."""

    def __init__(self, path: click.ParamType[Any]) -> None:
        self._path, self.name = path, path.name

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "":
            self.fail("an empty name; expected the path of a file or folder", param, ctx)
        return self._path.convert(value, param, ctx)


class LazyGroup(click.Group):
    """A group that imports a command when it is called, and turns errors into exit codes."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands, the built-in ones first."""
        return [*own_commands(), *sorted(other_commands())]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command that was not added; for an unknown one suggest the nearest name."""
        known = self.list_commands(ctx)
        if cmd_name in self.commands:
            command = self.commands[cmd_name]
        elif cmd_name not in known:
            if cmd_name and not cmd_name.startswith("-") and not ctx.resilient_parsing:
                hint = nearest(cmd_name, known, "`geomint --help`")
                ctx.fail(f"no such command {cmd_name!r}.{hint}")
            return None
        else:
            try:
                found = find_command(cmd_name)
            except GeomintError:
                if ctx.resilient_parsing:  # a shell completes a word
                    return None
                raise
            from .shell import in_shell

            command = found if isinstance(found, click.Command) else in_shell(found)
        for parameter in command.params:
            if isinstance(parameter.type, click.Path):  # of plugged-in commands too
                parameter.type = _Named(parameter.type)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands without importing any."""
        rows = [(name, summary(module)) for name, module in own_commands().items()]
        others = sorted(other_commands().items())
        rows += [(name, summary(*point.value.split(":", 1))) for name, point in others]
        with formatter.section("Commands"):
            formatter.write_dl(rows)

    @_one_command()
    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run; an error is a message on standard error and exit code 2, with --debug a traceback too.

        Ctrl-C is 130; SIGTERM and SIGHUP end a run as Ctrl-C does, with exit codes 143 and 129. Where
        it does not stand alone, errors are raised.
        """
        if not standalone_mode:
            return super().main(args, prog_name, complete_var, False, **extra)
        arguments = list(sys.argv[1:] if args is None else args)
        _mend_streams()
        with signals_as_ctrl_c() as received:
            try:
                result = super().main(arguments, prog_name, complete_var, False, **extra)
                code = result if isinstance(result, int) else 0
            except click.ClickException as error:
                with contextlib.suppress(OSError, ValueError):
                    error.show()
                code = error.exit_code
            except (click.Abort, KeyboardInterrupt):
                print_message("interrupted")
                code = exit_code("interrupted")
            except Exception as error:
                code = _failed(error, arguments)
        code = 128 + received[0] if received and code == exit_code("interrupted") else code
        _mend_streams()
        try:
            sys.stdout.flush()  # or its failure would only show after Python's exit
        except OSError as error:
            code = _output_failed(error)
        sys.exit(code)


def _mend_streams() -> None:
    """Let characters that an encoding lacks be escaped; a closed standard output fails when written."""
    for name, mode in (("stdout", os.O_RDONLY), ("stderr", os.O_WRONLY)):
        try:
            if isinstance(getattr(sys, name), io.TextIOWrapper | None):
                getattr(sys, name).reconfigure(errors="backslashreplace")
        except (AttributeError, ValueError):  # from the start, or by another package
            setattr(sys, name, os.fdopen(os.open(os.devnull, mode), "w", encoding="utf-8"))
        except OSError:  # of what is in the buffer: it fails again
            pass


def _failed(error: Exception, arguments: Sequence[str]) -> int:
    """Tell of an error; return the exit code after it."""
    stdout = sys.stdout
    _mend_streams()
    of_file = isinstance(error, OSError) and error.filename is not None
    if isinstance(error, GeomintError) or of_file:
        print_failure(error, arguments)
        return exit_code("failed")
    if "--debug" in arguments:
        traceback.print_exception(error)
    if isinstance(error, OSError) or sys.stdout is not stdout:
        return _output_failed(error)
    print_message(f"a defect, or settings around geomint: {raised(error)}; --debug shows where")
    return exit_code("failed")


def _output_failed(error: Exception) -> int:
    """Return the exit code after standard output could not be written; quiet after ``| head``."""
    # What is still in the buffer must not be tried again at the end of Python.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, BrokenPipeError):
        return exit_code("closed")
    print_message(f"standard output cannot be written: {getattr(error, 'strerror', error)}")
    return exit_code("failed")


@click.group(
    cls=LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, prog_name="geomint")
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
def main(debug: bool) -> None:
    """Integrate mechanical systems for very long times and measure what they conserve.

    SCENE is the name of a built-in scene (`geomint scenes`) or the path of a TOML file.
    """
