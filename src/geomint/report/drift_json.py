"""``drift.json``: the numbers of a drift report."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..drift import Drift
from .provenance import finite_json

__all__ = ["drift_record", "write_drift_json"]


def drift_record(drifts: Mapping[str, Drift], provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of ``drift.json``.

    Every quantity has `initial`, `max_abs_error`, `max_rel_error` (null where the initial value is
    0; `scale` is then what to compare with), `final_error`, `slope` per unit of the scene's time,
    `slope_stderr` and `class`. All numbers are finite or null.
    """
    return {
        "quantities": {name: finite_json(drift.as_json()) for name, drift in drifts.items()},
        "provenance": finite_json(provenance),
    }


def write_drift_json(path: Path, record: Mapping[str, Any]) -> None:
    """Write the record as strict JSON."""
    text = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")
