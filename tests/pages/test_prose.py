"""A paragraph of a page is one line."""

from __future__ import annotations

from pathlib import Path

import pytest
from prose import WRITTEN, joined


@pytest.mark.parametrize("path", WRITTEN, ids=lambda path: path.stem)
def test_a_paragraph_is_a_line(path: Path) -> None:
    text = path.read_text("utf-8")
    assert text == joined(text), "python tests/pages/prose.py mends it"


def test_what_is_joined() -> None:
    """Paragraphs, items and captions; not code, formulas, tables, terms, options."""
    parts = ["# A", "| a |\n|---|", "```python\nx\ny\n```", "$$\na\nb\n$$"]
    kept = "\n\n".join([*parts, ":::{glossary}\nterm\n  text\n:::\n"])
    assert joined(kept) == kept
    figure = "```{figure} a.png\n:alt: b\n\nOne\ntwo.\n```\n"
    assert joined(figure) == figure.replace("One\ntwo", "One two")
    assert joined("one\ntwo\n\n- a\n  b\n- c\n") == "one two\n\n- a b\n- c\n"
