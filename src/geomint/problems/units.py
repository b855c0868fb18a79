"""Units of pieces, quantities and times, for labels."""

from collections.abc import Mapping

NO_UNIT = "dimensionless"


def unit_among(units: Mapping[str, str], name: str) -> str:
    """Return the unit of a piece, a component (``"r[0]"``), a quantity or a time.

    That of ``"omega-1"`` may be given as that of ``"omega"``. What is not named is dimensionless.
    """
    piece = name.partition("[")[0]
    family = piece.rstrip("0123456789").removesuffix("-")
    return next((units[key] for key in (piece, family) if key in units), NO_UNIT)
