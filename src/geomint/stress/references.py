"""How many cells of a sweep were judged by references, and how sure those are."""

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from .judge import Cell


def references_of(cells: Sequence[Cell]) -> dict[str, Any]:
    """Return what ``stress.json`` says of references.

    `judged` is the number of cells with one; `known` what the worst of them is known to by its own
    estimate; `confirmed`, `confirmed_worst` the median and worst accuracy of the second method;
    `without` the number of cells that could have had one and were compared with a finer run.
    """
    known = [cell.known for cell in cells if cell.known is not None]
    second = [cell.confirmed for cell in cells if cell.confirmed is not None]
    return {
        "judged": len(known),
        "known": max(known, default=None),
        "confirmed": statistics.median(second) if second else None,
        "confirmed_worst": max(second, default=None),
        "without": sum("no reference" in cell.message for cell in cells),
    }


def references_in_words(found: Mapping[str, Any]) -> str:
    """Return the same in words."""
    words = "References: none."
    if found["judged"]:
        words = (
            f"References: {found['judged']} cells have one, known to "
            f"{max(found['known'], 1e-19):.2g} or better by its own estimate and confirmed by a "
            f"second method, known to {found['confirmed']:.2g} in the median and "
            f"{found['confirmed_worst']:.2g} at worst."
        )
    if found["without"]:
        words += f" {found['without']} are compared with a finer run, for the reason they name."
    return words
