"""A paragraph of a page is one line; the front door is in plain words."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

from geomint.cli import main
from tests.pages.blocks import ROOT, page
from tests.pages.prose import WRITTEN, joined

# Words for which "How we write" in CONTRIBUTING has plainer ones.
NOT_PLAIN = re.compile(
    r"\b(?:(?:is|are) told|says so|of (?:one's|its|their) own|beside|anew|what is [^.,]*, that)\b"
)


@pytest.mark.parametrize("path", WRITTEN, ids=lambda path: path.stem)
def test_a_paragraph_is_a_line(path: Path) -> None:
    text = path.read_text("utf-8")
    assert text == joined(text), "python tests/pages/prose.py mends it"


def test_what_is_joined() -> None:
    """Paragraphs, items and captions; not code, formulas, tables, terms, options."""
    kept = "# A\n\n| a |\n|---|\n\n```python\nx\ny\n```\n\n$$\na\nb\n$$\n\n:::{glossary}\nt\n  u\n:::\n"
    figure = "```{figure} a.png\n:alt: b\n\nOne two.\n```\n"
    assert joined(kept) == kept
    assert joined(figure.replace("One two", "One\ntwo")) == figure
    assert joined("one\ntwo\n\n- a\n  b\n- c\n") == "one two\n\n- a b\n- c\n"


def test_pages_of_the_gallery_are_short() -> None:
    """And begin with a title; the build of the docs runs them."""
    examples = sorted((ROOT / "docs" / "examples").glob("*.py"))
    assert len(examples) >= 10
    for path in examples:
        lines = path.read_text("utf-8").splitlines()
        assert (len(lines) <= 30, lines[0], lines[2]) == (True, '"""', "=" * len(lines[1])), path


def test_the_front_door_is_plain() -> None:
    """README, start page, and the help of all commands, in which every option has a text."""
    readme = page("README").read_text("utf-8")
    assert len(readme.split()) <= 900
    texts, context = [readme, page("index").read_text("utf-8")], click.Context(main)
    for command in (main, *(main.get_command(context, n) for n in main.list_commands(context))):
        assert command is not None
        texts.append(command.get_help(click.Context(command)))
        for option in command.params:
            assert not isinstance(option, click.Option) or option.hidden or option.help, option
    assert NOT_PLAIN.findall(" ".join(" ".join(texts).lower().split())) == []
