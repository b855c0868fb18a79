"""A command of the table in a shell: its options, its progress, what it says, and its exit code."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import takewhile
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_args, get_origin

import click

from . import options
from .meanwhile import import_meanwhile

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from .command import Command, Listener

METAVARS = {"event": "NAME", "axes": "X,Y"}  # others are lists, or as click has them


def in_shell(command: Command) -> click.Command:
    """Return what does a command of the table in a shell."""
    chosen = ("method", "step", "tolerance", "representation")
    given: list[Any] = [
        options.scene_choice if set(chosen) & {*command.takes} else options.scene_argument
    ]
    given += [options.end_options] if "t_end" in command.takes else []
    given += [options.watched_option] if "quantities" in command.takes else []
    fields = command.section.model_fields
    given += [_option(key, fields[key]) for key in command.keys]
    always = [*takewhile(lambda name: not name.endswith(".tex"), command.files)]  # then a paper's
    given += [options.folder_option(command.folder or command.name, _listed(always))]
    given += [options.paper_option] if any(n.endswith(".tex") for n in command.files) else []
    given += [options.yes_option] if command.expected is not None else []
    given += [options.quiet_option, options.debug_option]

    def callback(scene: str, **keys: Any) -> int:
        return _carry_out(command, scene, **keys)

    for option in reversed(given):
        callback = option(callback)
    module = inspect.getmodule(command.plan)
    return click.command(command.name, help=inspect.getdoc(module))(callback)


def _listed(names: list[str]) -> str:
    return " and ".join((", ".join(names[:-1]), names[-1]))


def _option(key: str, field: FieldInfo) -> Callable[..., Any]:
    """Return the option of a key of a section."""
    name, kind = f"--{key.replace('_', '-')}", _bare(field.annotation)
    told: dict[str, Any] = {"help": field.description, "default": None}
    if get_origin(kind) is list:
        of = _bare(get_args(kind)[0])
        metavar = METAVARS.get(key, "LIST")
        return options.list_option(
            name, key, of=of if of in (float, int) else str.strip, metavar=metavar, **told
        )
    if get_origin(kind) is dict:
        return click.option(
            name, multiple=True, metavar="KEY=A:B:N", callback=_pairs, help=field.description
        )
    if get_origin(kind) is Literal:
        return click.option(name, type=click.Choice(get_args(kind)), **told)
    if kind is bool:
        flag = f"{name}/--no-{name[2:]}" if field.default else name
        return click.option(flag, is_flag=True, **told)
    if kind is int:
        least = next((m.ge for m in field.metadata if hasattr(m, "ge")), None)
        return click.option(name, type=click.IntRange(_least(field, least)), **told)
    return click.option(
        name, type=float if kind is float else str, metavar=METAVARS.get(key), **told
    )


def _least(field: FieldInfo, found: Any) -> int:
    """Return the least value of a whole number, whose bounds its type may have in a union."""
    for part in (field.annotation, *get_args(field.annotation)):
        for note in getattr(part, "__metadata__", ()):
            found = next((m.ge for m in note.metadata if hasattr(m, "ge")), found)
    return int(found or 0)


def _bare(kind: Any) -> Any:
    """Return a type without None, and without what is said of it."""
    if get_origin(kind) in (Union, UnionType):
        kind = next(part for part in get_args(kind) if part is not type(None))
    return _bare(get_args(kind)[0]) if get_origin(kind) is Annotated else kind


def _pairs(context: click.Context, option: click.Parameter, given: tuple[str, ...]) -> Any:
    pairs = dict(text.partition("=")[::2] for text in given)
    bad = [text for text in given if "=" not in text]
    if bad or len(pairs) < len(given):
        raise click.BadParameter(f"{bad or list(given)}: expected KEY=A:B:N, each key once")
    return pairs or None


def _carry_out(
    command: Command,
    scene: str,
    out: Path,
    quiet: bool,
    paper: bool = False,
    yes: bool = False,
    **keys: Any,
) -> int:
    """Plan, say what will not be done and how long the rest takes, run, and report."""
    from ..run.files.outputs import check_folder
    from .command import notes_of

    options.tell_file(scene)
    chosen = options.built(partial(command.scene, scene, keys, None, options.written))
    with options.patience("planning"):
        planned = command.plan(chosen)
    options.print_notes(chosen, notes_of(planned))
    if command.expected is not None:
        options.check_time(partial(command.expected, planned), yes)
    check_folder(out, command.files)
    import_meanwhile(at_once=command.expected is None)
    with _listening(command.name, not quiet) as listener:
        found = command.run(planned, listener)

    from ..reports.files import write
    from ..reports.terminal import show

    report = command.report(planned, found, options.reproducing_command())
    page = write(report, out, paper)
    for line in report.failures:
        options.print_message(line)
    if not quiet:
        show(report)
        options.say_report(
            f"report{options.partly(report.status)}", page, report.stem if paper else ""
        )
    return options.exit_code(report.outcome or report.status)


@contextmanager
def _listening(name: str, show: bool) -> Iterator[Listener]:
    """Yield who shows on standard error what is being done, or nothing; errors are told."""
    from .command import Listener

    def failed(error: BaseException | str, what: str) -> None:
        label = f"{what}: " if what else ""
        if isinstance(error, str):
            options.print_message(f"{label}{error}".rstrip(": "))
        else:
            options.print_failure(error, label=label)

    if not show:
        yield Listener(False, failed=failed)
        return
    from rich.console import Console

    status = Console(stderr=True).status(name)

    def doing(words: str) -> None:
        status.update(f"{name}: {words}")
        status.start()

    try:
        yield Listener(True, doing, failed)
    finally:
        status.stop()
