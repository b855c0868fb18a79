"""Readings by the words that stand for them: ``drift:energy``, ``exponent``."""

from typing import Any

from ....arguments import by_name
from ....errors import DomainError, nearest
from .of_runs import ExponentErrors, Exponents, ExponentVerdict
from .of_series import Digits, Drift, Final, Frequency, Highest, Lowest, Mean, Windows
from .reading import Reading

KINDS = {
    kind.kind: kind for kind in (Final, Drift, Lowest, Highest, Mean, Digits, Frequency, Windows)
}
OF_EXPONENTS = {kind.kind: kind for kind in (Exponents, ExponentErrors, ExponentVerdict)}
_KNOWN = ", ".join([*(f"{kind}:NAME" for kind in KINDS), *OF_EXPONENTS])
EXPECTED = f"{_KNOWN}, or a geomint.Reading"


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
    return by_name("readings", wanted, _reading, lambda reading: reading.name, EXPECTED)


def _reading(what: Any) -> Reading:
    if isinstance(what, Reading):
        return what
    if not isinstance(what, str):
        raise DomainError("readings", what, EXPECTED)
    kind, colon, of = (part.strip() for part in what.partition(":"))
    if not colon and kind in OF_EXPONENTS:
        return OF_EXPONENTS[kind]()
    if not colon or kind not in KINDS:
        raise DomainError("readings", what, f"{EXPECTED}.{nearest(kind, [*KINDS, *OF_EXPONENTS])}")
    return KINDS[kind](of)
