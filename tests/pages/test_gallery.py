"""Pages of the gallery are short, and begin with a title; the build of the docs runs them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.pages.blocks import ROOT

EXAMPLES = sorted((ROOT / "docs" / "examples").glob("*.py"))


def test_there_are_enough() -> None:
    assert len(EXAMPLES) >= 10


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_a_page_is_short(path: Path) -> None:
    lines = path.read_text("utf-8").splitlines()
    assert len(lines) <= 30
    assert lines[0] == '"""'
    assert lines[2] == "=" * len(lines[1])
