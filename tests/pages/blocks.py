"""The blocks of code of README and docs, and what stands beside them."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PAGES = [README, ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Attributes
    ----------
    info : str
        What follows the fence: ``python``, ``console``, …; empty where nothing does.
    text : str
    line : int
        Of the fence, counted from 0.
    indent : int
        Columns by which the fence is indented on the page.
    near : str
        The last line of text before the block, and nothing where another block is next to it.
    """

    info: str
    text: str
    line: int
    indent: int
    near: str


def page(name: str) -> Path:
    """Return the path of a page by its name: ``README``, or the stem of a page of docs."""
    return README if name == "README" else ROOT / "docs" / f"{name}.md"


def blocks(path: Path) -> list[Block]:
    """Return all fenced blocks of a page in their order."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    found = []
    for token in MarkdownIt("commonmark").parse(text):
        if token.type == "fence" and token.map is not None:
            start = token.map[0]
            indent = len(lines[start]) - len(lines[start].lstrip())
            above = [line.strip() for line in lines[:start] if line.strip()]
            near = above[-1] if above and not above[-1].startswith("```") else ""
            found.append(Block(token.info.strip(), token.content, start, indent, near))
    return found


def prose(path: Path) -> str:
    """Return a page without its blocks of code, white space made single."""
    lines = path.read_text(encoding="utf-8").splitlines()
    for block in blocks(path):
        if not block.info.startswith("{"):
            for i in range(block.line, block.line + len(block.text.splitlines()) + 2):
                lines[i] = ""
    return " ".join(" ".join(lines).split())


@dataclass(frozen=True)
class Example:
    """A block of Python with what it prints, where the page shows it in the next block."""

    source: str
    line: int
    output: Block | None


def examples(path: Path) -> list[Example]:
    """Return the Python of a page; output is a block ``text`` that follows with no words between."""
    found, all_blocks = [], blocks(path)
    for block, after in zip(all_blocks, [*all_blocks[1:], None], strict=True):
        if block.info != "python":
            continue
        shown = after if after is not None and after.info == "text" and not after.near else None
        found.append(Example(block.text, block.line, shown))
    return found


@dataclass(frozen=True)
class Command:
    """A command of a ``console`` block, and the lines that follow it."""

    text: str
    output: tuple[str, ...]
    line: int
    indent: int


def commands(path: Path) -> list[Command]:
    """Return all commands of the console blocks of a page."""
    found = []
    for block in blocks(path):
        if block.info != "console":
            continue
        lines = block.text.splitlines()
        starts = [i for i, line in enumerate(lines) if line.startswith("$ ")]
        for i, end in zip(starts, [*starts[1:], len(lines)], strict=True):
            text = lines[i][2:].split(" # ")[0].strip()
            line = block.line + 1 + i
            found.append(Command(text, tuple(lines[i + 1 : end]), line, block.indent))
    return found


def invocations() -> Iterator[tuple[str, str]]:
    """Yield (page, command line) of every geomint command that any page shows in a block."""
    for path in PAGES:
        for block in blocks(path):
            if block.info not in ("", "console", "shell"):
                continue
            text = re.sub(r"\\\n\s*", "", block.text)
            for line in text.splitlines():
                for part in re.split(r"&&|;", line.split(" # ")[0].removeprefix("$ ")):
                    if part.strip().startswith("geomint "):
                        yield path.name, part.strip()


def rewrite(path: Path, replaced: list[tuple[int, int, int, str]]) -> None:
    """Put other lines in the place of some: (first line, number of lines, indent, text)."""
    lines = path.read_text(encoding="utf-8").splitlines()
    for start, count, indent, text in sorted(replaced, reverse=True):
        lines[start : start + count] = textwrap.indent(text, " " * indent).splitlines()
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
