"""Reports: plots, HTML pages that open from disk, and JSON beside them."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .drift_page import drift_report, write_drift_report
    from .several_page import write_several_report

__all__ = ["drift_report", "write_drift_report", "write_several_report"]

# What lies in the folder of a report.
DRIFT_FILES = ("drift.json", "drift.png", "drift.svg", "report.html")
COMPARE_FILES = (
    "compare.html",
    "compare.json",
    "compare.png",
    "compare.svg",
    "compare-drift.png",
    "compare-drift.svg",
)
STRESS_FILES = ("stress.html", "stress.json", "stress.png", "stress.svg")


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = "several_page" if name == "write_several_report" else "drift_page"
    return getattr(importlib.import_module(f"{__name__}.{module}"), name)
