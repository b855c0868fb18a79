"""Large n run at night."""

import pytest


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Leave tests of all cases to the night where n is large."""
    for item in items:
        case = getattr(item, "callspec", None) and item.callspec.params.get("case")
        label = getattr(case, "label", "")
        if label.rpartition("-n")[2] in {"6", "7"}:
            item.add_marker(pytest.mark.nightly)
