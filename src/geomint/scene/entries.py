"""Lists of methods, each with a step of its own if it has one: ``cf-4,rk-4:0.01``."""

from collections.abc import Iterable

from ..arguments import positive
from ..errors import DomainError
from ..methods.registry import find_method


def method_and_step(entry: str) -> tuple[str, float | None]:
    """Return the name and the step of an entry ``NAME`` or ``NAME:STEP``.

    Raises
    ------
    MethodError
        If there is no such method.
    DomainError
        If the step is no positive number.
    """
    name, colon, step = (part.strip() for part in entry.partition(":"))
    find_method(name)
    if not colon:
        return name, None
    try:
        number = float(step)
    except ValueError:
        raise DomainError(f"the step of {name!r}", step, "a positive number") from None
    return name, positive(f"the step of {name!r}", number)


def methods_and_steps(entries: Iterable[str]) -> list[tuple[str, float | None]]:
    """Return name and step of every entry, or raise `DomainError` if there is none, or one twice."""
    found = [method_and_step(entry) for entry in entries]
    if not found:
        raise DomainError("methods", found, "at least one method")
    if len(set(found)) < len(found):
        words = [name if step is None else f"{name}:{step:g}" for name, step in found]
        raise DomainError("methods", words, "each of them, with its step, once")
    return found
