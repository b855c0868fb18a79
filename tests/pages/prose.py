"""A paragraph of a page, or an item of a list, is one line: ``python tests/pages/prose.py`` mends."""

from __future__ import annotations

import re
from collections.abc import Iterator

from tests.pages.blocks import PAGES

# What begins a line of its own: headings, tables, items, quotes, options, targets, HTML, mathematics.
_OWN = re.compile(r"\s*(#|\||[-*+] |\d+\. |>|:[\w-]+:|\(.*\)=$|<|\$\$|%|\+\+\+|:::)")
_FENCE = re.compile(r"\s*(`{3,}|:{3,})(\{?[\w-]*)")
_IN_PROSE = ("{figure", "{note", "{grid", "{tip", "{warning")  # directives whose contents are prose

# Tables are made by programs.
WRITTEN = [path for path in PAGES if not path.stem.endswith("-table")]


def joined(text: str) -> str:
    """Return a page with every paragraph on one line; code, tables and terms stay as they are."""
    lines: list[str] = []
    open_for_more = False
    for line, is_prose in _lines(text):
        words = line.strip()
        goes_on = is_prose and bool(words) and not _OWN.match(line)
        if goes_on and open_for_more:
            lines[-1] = f"{lines[-1].rstrip()} {words}"
        else:
            lines.append(line)
        begins_item = bool(re.match(r"\s*([-*+]|\d+\.) ", line))
        open_for_more = is_prose and bool(words) and (goes_on or begins_item)
        open_for_more &= not line.endswith(("  ", "\\"))
    return "\n".join(lines) + "\n"


def _lines(text: str) -> Iterator[tuple[str, bool]]:
    """Yield lines, and whether they are prose."""
    open_fences: list[tuple[str, bool]] = []  # with whether what is inside is prose
    in_formula = False
    for line in text.splitlines():
        fence, inside = _FENCE.match(line), not open_fences or open_fences[-1][1]
        if open_fences and line.strip() == open_fences[-1][0]:
            open_fences.pop()
            yield line, False
        elif fence and inside:
            open_fences.append((fence[1], fence[2].startswith(_IN_PROSE)))
            yield line, False
        elif inside and (in_formula or line.strip().startswith("$$")):
            in_formula ^= line.count("$$") == 1
            yield line, False
        else:
            yield line, inside


if __name__ == "__main__":
    for path in WRITTEN:
        before = path.read_text("utf-8")
        if (after := joined(before)) != before:
            path.write_text(after, "utf-8")
            print(path.name)
