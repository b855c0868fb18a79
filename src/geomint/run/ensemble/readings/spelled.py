"""Readings by the words that stand for them: ``drift:energy``, ``exponent``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ....arguments import check_name
from ....errors import DomainError, nearest
from .of_runs import Exponents
from .of_series import Digits, Drift, Final, Frequency, Highest, Lowest, Mean, OfQuantity, Windows
from .reading import Reading

__all__ = ["KINDS", "chosen_readings"]

KINDS: dict[str, type[OfQuantity]] = {
    kind.kind: kind for kind in (Final, Drift, Lowest, Highest, Mean, Digits, Frequency, Windows)
}
EXPECTED = f"{', '.join(f'{kind}:NAME' for kind in KINDS)} or exponent, or a geomint.Reading"


def chosen_readings(wanted: Any) -> dict[str, Reading]:
    """Return the readings that are asked for, by name.

    Parameters
    ----------
    wanted : str, Reading, sequence of them, or mapping of names to them

    Raises
    ------
    DomainError
        For what is none, and for two of one name.
    """
    if isinstance(wanted, str | Reading):
        wanted = [wanted]
    try:
        pairs = list(wanted.items() if isinstance(wanted, Mapping) else ((None, x) for x in wanted))
    except Exception:  # whatever a foreign object raises there
        raise DomainError("readings", wanted, EXPECTED) from None
    chosen: dict[str, Reading] = {}
    for given, what in pairs:
        reading = _reading(what)
        name = reading.name if given is None else given
        check_name("readings", name)
        if name in chosen:
            raise DomainError("readings", name, "names unlike each other: give a mapping")
        chosen[name] = reading
    return chosen


def _reading(what: Any) -> Reading:
    if isinstance(what, Reading):
        return what
    if not isinstance(what, str):
        raise DomainError("readings", what, EXPECTED)
    kind, colon, of = (part.strip() for part in what.partition(":"))
    if not colon and kind == Exponents.kind:
        return Exponents()
    if not colon or kind not in KINDS:
        raise DomainError("readings", what, f"{EXPECTED}.{nearest(kind, [*KINDS, Exponents.kind])}")
    return KINDS[kind](of)
