"""Pages of the gallery are short, and begin with a title; the build of the docs runs them."""

from __future__ import annotations

from tests.pages.blocks import ROOT

EXAMPLES = sorted((ROOT / "docs" / "examples").glob("*.py"))


def test_pages_are_short() -> None:
    assert len(EXAMPLES) >= 10
    for path in EXAMPLES:
        lines = path.read_text("utf-8").splitlines()
        assert len(lines) <= 30, path
        assert (lines[0], lines[2]) == ('"""', "=" * len(lines[1])), path
