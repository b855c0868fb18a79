"""Makes `support` importable from the tests of this folder; large n are among the slow tests."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark tests of all cases as slow where n is large."""
    for item in items:
        case = getattr(item, "callspec", None) and item.callspec.params.get("case")
        label = getattr(case, "label", "")
        if label.rpartition("-n")[2] in {"6", "7"}:
            item.add_marker(pytest.mark.slow)
