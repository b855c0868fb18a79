"""Typed errors and warnings: values that carry the numbers that they speak of.

Errors derive from `GeomintError`, warnings from `GeomintWarning`; these are shown at the line of the
user, and kept by the results of the calls that they are told in.
"""

from __future__ import annotations

import functools
import os
import pickle
import sys
import unicodedata
import warnings
from collections.abc import Callable, Iterable, Mapping
from contextvars import ContextVar
from difflib import get_close_matches
from math import log10
from typing import TYPE_CHECKING, Any, ClassVar, ParamSpec, TypeVar

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


P = ParamSpec("P")
R = TypeVar("R")

LONGEST = 300  # characters of a value in a message
LONGEST_MESSAGE = 3000  # characters: even where much is wrong
DIGITS = 4000  # bits of an integer beyond which nobody reads its digits
MOST_NAMES = 12  # known names that a message lists
LONGEST_WORD = 100  # characters of a name that is compared with known ones


class GeomintError(Exception):
    """Base of all errors that geomint raises on purpose.

    All of them can be copied and pickled with their attributes. Of a value that cannot be pickled
    the other process gets its text. Messages are of bounded length, without
    control characters.
    """

    def __init__(self, *args: Any) -> None:
        cut = (printable(shortened(a, LONGEST_MESSAGE)) if isinstance(a, str) else a for a in args)
        super().__init__(*cut)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), self.args, {k: _sent(v) for k, v in vars(self).items()})

    def __copy__(self) -> GeomintError:
        return _restored(type(self), self.args, vars(self))

    def __deepcopy__(self, memo: dict[int, Any]) -> GeomintError:
        return self.__copy__()  # what it speaks of stays what it was


def _restored(
    cls: type[GeomintError], args: tuple[Any, ...], attributes: dict[str, Any]
) -> GeomintError:
    error = cls.__new__(cls)
    error.args = args
    vars(error).update(attributes)
    return error


def _sent(value: Any) -> Any:
    """Return what another process gets of an attribute."""
    as_saved = getattr(value, "as_saved", None)
    if as_saved is not None:
        value = as_saved()
    try:
        pickle.dumps(value)
    except Exception:  # whatever a foreign object raises there
        return quoted(value)
    return value


def quoted(value: Any) -> str:
    """Return the text of a value for a message, of bounded length."""
    if isinstance(value, int) and value.bit_length() > DIGITS:
        return f"<an integer of about {round(value.bit_length() * log10(2.0))} digits>"
    try:
        text = repr(value)
    except Exception as failure:  # whatever a foreign object raises there
        return f"<{type(value).__name__}: {type(failure).__name__}>"
    return shortened(text)


def shortened(text: str, longest: int = LONGEST) -> str:
    """Return a text, or its beginning and end with its length."""
    if len(text) <= longest:
        return text
    return f"{text[: longest - 40]} … {text[-20:]} ({len(text)} characters)"


def raised(error: BaseException) -> str:
    """Return the kind of an error and what it says, on one line of bounded length."""
    try:
        text = " ".join(str(error).split())
    except Exception:  # whatever a foreign object raises there
        text = "?"
    return shortened(f"{type(error).__name__}: {text}", 500)


def printable(text: str) -> str:
    """Return a text without what would steer a terminal: control characters as their escapes."""
    return "".join(
        c if c in "\n\t" or unicodedata.category(c) not in ("Cc", "Cf", "Cs") else repr(c)[1:-1]
        for c in text
    )


class GeomintWarning(UserWarning):
    """Something that the user should know of; its kinds are its subclasses.

    Runs keep theirs, as `geomint.Solution.warnings`. Those that say the same are equal.

    Parameters
    ----------
    text : str
        What was found, where, and what to do.
    quantity : str
        What it is about: ``"end"``, ``"step"``, the name of a piece or of an integral.
    size : float or None
        By how much; dimensionless where the text names no unit.
    time : float or None
        Where on the way, in the time that the text names.
    """

    text: str
    quantity: str

    def __init__(
        self,
        text: str,
        quantity: str = "",
        size: float | None = None,
        time: float | None = None,
    ) -> None:
        size, time = (None if x is None else float(x) for x in (size, time))
        text = printable(text)
        super().__init__(text, quantity, size, time)
        self.text, self.quantity, self.size, self.time = text, quantity, size, time

    def __str__(self) -> str:
        return self.text

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.args == getattr(other, "args", None)

    def __hash__(self) -> int:
        return hash((self.kind, self.args))

    @property
    def kind(self) -> str:
        """The name of its class."""
        return type(self).__name__

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON has it: kind, text, quantity, size and time."""
        return {"kind": self.kind, **vars(self)}

    @staticmethod
    def read(told: Mapping[str, Any]) -> GeomintWarning:
        """Return what `as_json` has told; of a kind that is not geomint's a plain one."""
        kinds = {kind.__name__: kind for kind in GeomintWarning.__subclasses__()}
        given = {name: value for name, value in told.items() if name != "kind"}
        return kinds.get(told["kind"], GeomintWarning)(**given)


class StateWarning(GeomintWarning):
    """A state is not the one that was given, such as one that was projected."""


class DeclarationWarning(GeomintWarning):
    """What is said of a problem does not fit: its parameters, an invariant, its Hamiltonian form."""


class StepWarning(GeomintWarning):
    """Steps are too long for the motion, or for the run."""


class EndWarning(GeomintWarning):
    """The state at the end may err by more than a tolerance, or than is promised of it."""


class LeftOutWarning(GeomintWarning):
    """Something that was asked for is not in the result, or not all of it."""


class SpeedWarning(GeomintWarning):
    """Something takes longer than it could, or longer than a day."""


class Gathered(list[GeomintWarning]):
    """Warnings that are told within, each once; if `quiet`, nobody else sees them."""

    def __init__(self, quiet: bool = False) -> None:
        super().__init__()
        self.quiet = quiet

    def __enter__(self) -> Gathered:
        above = _told.get()
        self.quiet = self.quiet or (above is not None and above.quiet)
        self._token = _told.set(self)
        return self

    def __exit__(self, *of: object) -> None:
        _told.reset(self._token)


_told: ContextVar[Gathered | None] = ContextVar("told", default=None)


def tell(warning: GeomintWarning) -> None:
    """Warn at the line of the first caller outside of geomint and systems; once of the same."""
    told = _told.get()
    if told is not None:
        if warning in told:  # of a run that began anew
            return
        told.append(warning)
        if told.quiet:
            return
    _show(warning)


def _show(warning: GeomintWarning) -> None:
    frame, level, own = sys._getframe(2), 3, _packages()
    while frame.f_back and str(frame.f_globals.get("__name__")).partition(".")[0] in own:
        frame, level = frame.f_back, level + 1
    warnings.warn(warning, stacklevel=level)


def _packages() -> set[str]:
    """Return geomint and the packages that register systems: a user did not write their lines."""
    systems = _registered("geomint.systems")
    return {"geomint", *(p.value.partition(":")[0].partition(".")[0] for p in systems)}


def _registered(group: str) -> Iterable[EntryPoint]:
    """Return the entry points of a group: packages are looked at anew where a folder has changed."""
    from importlib import metadata

    places = filter(os.path.exists, map(os.path.abspath, sys.path))
    return _read(metadata.entry_points, group, *((p, os.path.getmtime(p)) for p in places))


@functools.lru_cache(8)
def _read(entry_points: Callable[..., Iterable[EntryPoint]], group: str, *_: Any) -> Any:
    return tuple(entry_points(group=group))


def offered(
    group: str,
    own: Iterable[str] = (),
    parts: Callable[[EntryPoint], Mapping[str, Any]] = lambda point: {point.name: point},
    expected: str = "",
) -> dict[str, Any]:
    """Return what the entry points of a group stand for, by names; of one name the first.

    geomint's own come first, then those of other packages in alphabetical order. What is broken, or
    has a name that is taken, is left out, which is told.

    Parameters
    ----------
    group : str
    own : iterable of str
        Names that geomint has otherwise.
    parts : callable
        Returns what one entry point stands for, by names. Default: itself; nothing is imported.
    expected : str
        What that must be.
    """
    name_of = functools.cache(_name_of)  # of what is in a file

    def rank(point: EntryPoint) -> tuple[bool, str, str]:
        package = name_of(point.dist)
        return package != "geomint", package, point.name

    found: dict[str, Any] = {}
    owners = dict.fromkeys(own, "geomint")
    for point in sorted(_registered(group), key=rank):
        package = name_of(point.dist)
        where = f"entry point {point.name!r} of the group {group} is left out"
        try:
            new = parts(point)
        except (Exception, SystemExit) as error:  # a package that is broken, or was removed
            why = f"{where}: expected {expected}; {raised(error)}"
            _leave_out(f"package {package!r}: {why}", point.name)
            continue
        for name in new:
            if name in owners:
                why = f"{owners[name]!r} has that name; expected another one"
                _leave_out(f"package {package!r}: {name!r} of {where}: {why}", name)
            else:
                found[name], owners[name] = new[name], package
    return found


def _name_of(dist: Any) -> str:
    try:
        return str(dist.name)
    except Exception:  # whatever its files lack
        return "?"


@functools.cache  # what is installed is told once, and kept by no run
def _leave_out(said: str, name: str) -> None:
    _show(LeftOutWarning(said, name))


def loaded(point: EntryPoint) -> Any:
    """Return what an entry point stands for; `MissingCodeError`, whatever its package raises."""
    try:
        with warnings.catch_warnings():  # what it does to filters is its own
            return point.load()
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever its modules raise when they are imported
        what = f"entry point {point.name!r} of the group {point.group}"
        why = f"{point.value!r} cannot be loaded: {raised(error)}"
        raise MissingCodeError(what, why) from error


def keeping(function: Callable[P, R]) -> Callable[P, R]:
    """Return a function whose result, or what an error has of it, keeps its `warnings`."""

    @functools.wraps(function)
    def kept(*args: P.args, **named: P.kwargs) -> R:
        with Gathered() as told:
            try:
                found = function(*args, **named)
            except StepError as error:
                if error.partial is not None:
                    vars(error.partial)["warnings"] = tuple(told)
                raise
        vars(found)["warnings"] = tuple(told)
        if (above := _told.get()) is not None:
            above += [warning for warning in told if warning not in above]
        return found

    return kept


class DomainError(GeomintError, ValueError):
    """A parameter, state or option outside the domain of what it was given to.

    Attributes
    ----------
    name : str
        What was wrong.
    value : object
        What it was; None also of what is missing, for which the error is made with ``...``.
    partial : object
        Of a reading that fails in `geomint.solve_ensemble`: the ensemble with what is done.
    """

    def __init__(self, name: str, value: Any, expected: str) -> None:
        name = name if isinstance(name, str) else quoted(name)
        given = "is missing" if value is ... else f"= {quoted(value)}"
        super().__init__(f"{name} {given}: expected {expected}")
        self.name, self.value, self.expected = name, None if value is ... else value, expected
        self.partial: Any = None


class ArgumentError(GeomintError, TypeError):
    """A call with arguments that the function does not take; the message says what it takes.

    Attributes
    ----------
    names : tuple of str
        The keywords that it does not know.
    """

    def __init__(self, what: str, names: tuple[str, ...] = ()) -> None:
        super().__init__(what)
        self.names = names


class UnknownNameError(GeomintError, KeyError):
    """A name that a result does not have; the message says which it has, and what asks for more.

    Attributes
    ----------
    name : object
    """

    __str__ = Exception.__str__  # not the text in quotes, as of a key
    asked_by: ClassVar[dict[str, str]] = {"drift": "observe", "runs": "methods"}

    def __init__(self, what: str, name: Any, known: Iterable[str]) -> None:
        hint = nearest(str(name), known) or " There are none."
        asked = self.asked_by.get(what, what)
        super().__init__(f"{what}[{quoted(name)}]: no such name.{hint} Ask for more by {asked}=…")
        self.name = name


class ByName(dict[str, R]):
    """What a result has by name: a name that it does not have is an `UnknownNameError`."""

    def __init__(self, values: Any = (), what: str = "values") -> None:
        super().__init__(values)
        self.what = what

    def __missing__(self, name: Any) -> R:
        raise UnknownNameError(self.what, name, self)


class MethodError(GeomintError, ValueError):
    """An unknown method, or options that it does not have."""


class FormError(GeomintError, TypeError):
    """A method and a problem that do not fit: the method needs a form that the problem lacks."""


class SendingError(GeomintError, pickle.PicklingError):
    """A function that another process cannot find, so that nothing that has it can be sent there.

    Attributes
    ----------
    function, module : str
        Its qualified name, and the module in which it was made.
    """

    def __init__(self, function: str, module: str, reason: str = "") -> None:
        why = "cannot be found by another process: put it into a module, or install cloudpickle"
        super().__init__(f"function {function!r} of {module!r} {reason or why}")
        self.function, self.module = function, module


class MissingCodeError(GeomintError, ImportError):
    """What would have to be there and is not: an optional library, the code of a problem in a file.

    Attributes
    ----------
    what : str
    """

    def __init__(self, what: str, reason: str) -> None:
        super().__init__(f"{what}: {reason}")
        self.what = what


class DeclarationError(GeomintError, TypeError):
    """A function that does not fit what its problem declares: sizes, arguments, what it writes.

    Attributes
    ----------
    problem : str or None
        The problem's name.
    function : str
        What the function is to it, such as ``"field"`` or ``"invariants['energy']"``.
    block : str or None
        The block in which something was wrong, such as ``"out"``.
    index, size : int or None
        The row, and how many rows the block has.
    """

    def __init__(
        self,
        problem: str | None,
        function: str,
        what: str,
        block: str | None = None,
        index: int | None = None,
        size: int | None = None,
    ) -> None:
        of = "" if problem is None else f" of problem {problem!r}"
        super().__init__(f"{function}{of} {what}")
        self.problem, self.function, self.block = problem, function, block
        self.index, self.size = index, size


class SceneError(GeomintError, ValueError):
    """A scene that cannot be understood; the message names each key, value and expectation."""


class OutputError(GeomintError, OSError):
    """A file that cannot be written; what was there before is as it was.

    Attributes
    ----------
    path : str
    """

    def __init__(
        self, path: str | os.PathLike[str], reason: str, number: int | None = None
    ) -> None:
        super().__init__(f"{quoted(os.fspath(path))} cannot be written: {reason}")
        self.path, self.number = os.fspath(path), number

    @property
    def errno(self) -> int | None:  # type: ignore[override]
        """The number that the operating system gave, such as `errno.ENOSPC`."""
        return self.number


class StepError(GeomintError, ArithmeticError):
    """An integration that ended at a step.

    Attributes
    ----------
    t : float
        Time (the method's own) at the start of the step that failed.
    step : int
        Number of steps completed before it.
    residual : float
        What the failed step left.
    iterations : int
        Iterations of the step that failed.
    partial : object
        The result up to the last good step, where there is one. In another process what can be
        saved of it, as `geomint.load` gives it.
    """

    reason = "the step failed"
    step, residual, iterations = 0, 0.0, 0
    partial: Any = None

    def __init__(
        self, t: float, step: int, residual: float, iterations: int, hint: str = ""
    ) -> None:
        super().__init__(
            f"{self.reason} at t = {t:.9g} (step {step}; residual {residual:.3g} after "
            f"{iterations} iterations){': ' + hint if hint else ''}"
        )
        self.t, self.step, self.residual, self.iterations = t, step, residual, iterations


class EnsembleError(GeomintError, RuntimeError):
    """Workers of an ensemble have ended before its members.

    Attributes
    ----------
    partial : Ensemble
        With the members that are done.
    """

    partial: Any = None

    def __init__(self, what: str) -> None:
        super().__init__(what)


class WatcherError(StepError):
    """What watches a quantity along a run has failed; the run ends there.

    Attributes
    ----------
    name : str
        The name of the quantity.
    """

    def __init__(self, name: str, t: float, what: str) -> None:
        GeomintError.__init__(self, f"the watcher of {name!r} failed after t = {t:.9g}: {what}")
        self.name, self.t = name, t


class EventError(StepError):
    """An event that cannot be told: not a number, not smooth, too many in a step.

    Attributes
    ----------
    name : str
        The name of the event.
    """

    def __init__(self, name: str, t: float, step: int | None, residual: float, what: str) -> None:
        of_step = "" if step is None else f" (step {step})"  # None: there are none
        GeomintError.__init__(self, f"event {name!r} {what}: at t = {t:.9g}{of_step}")
        self.name, self.t, self.step, self.residual = name, t, step or 0, residual


class ConvergenceError(StepError):
    """The iteration of an implicit step did not converge."""

    reason = "the implicit step did not converge"


class RankError(ConvergenceError):
    """Constraints that depend on each other, where motions part or cannot be told apart.

    The residual is the largest change of a momentum in the step, or that of an iteration which did not
    converge.
    """

    reason = "constraints are not independent, so that the step is not determined"


class NonFiniteError(StepError):
    """A step gave a number that is not finite."""

    reason = "the step gave a number that is not finite"


class StepLimitError(StepError):
    """More steps than `max_steps` allows an adaptive method."""

    reason = "the end is not reached within max_steps"


class ClockError(StepError):
    """Physical time that does not get to `t_end`: dt/dτ is 0 or negative, or tends to 0.

    The residual is what is left of it.
    """

    reason = "physical time does not get to its end"


class StepSizeError(StepError):
    """No step of a size that would do: too large for the coordinates of a group, or too small.

    Attributes
    ----------
    h : float
        The step that was tried last.
    """

    reason = "the step size does not serve"

    def __init__(
        self, t: float, step: int, residual: float, iterations: int, hint: str = "", h: float = 0.0
    ) -> None:
        super().__init__(t, step, residual, iterations, hint)
        self.h = h


class UnknownReferenceError(GeomintError, ArithmeticError):
    """A reference solution that is not known well enough for the errors that it should judge.

    Attributes
    ----------
    known : float
        To what it is known, relative; infinity where nothing is known of it.
    judges : float
        The smallest error that it was meant to judge.
    """

    def __init__(self, reason: str, known: float, judges: float, advice: str) -> None:
        super().__init__(
            f"no reference to judge errors of {judges:.2g} by: {reason}. Expected: {advice}"
        )
        self.known, self.judges = known, judges


def closest(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that is probably meant; None if there is none like it."""
    folded = {name.casefold(): name for name in known}
    word = word[:LONGEST_WORD].casefold()  # comparing takes the product of the lengths
    close = get_close_matches(word, folded, n=1, cutoff=0.5)
    return folded[close[0]] if close else None


def nearest(word: str, known: Iterable[str], lister: str = "") -> str:
    """Return `` Did you mean 'x'?`` for the closest known word, or the known ones.

    Of more than a dozen only some are listed, and what lists them, where a command does.
    """
    words = list(known)
    close = closest(word, words)
    if close is not None:
        return f" Did you mean {close!r}?"
    if not words:
        return ""
    more = f", … ({len(words)} in all)" if len(words) > MOST_NAMES else ""
    listed = f"; {lister} lists them" if lister and more else ""
    return f" Known: {', '.join(sorted(words)[:MOST_NAMES])}{more}{listed}."
