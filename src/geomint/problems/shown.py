"""How values show themselves: some lines of text, a table in a notebook."""

import textwrap
from collections.abc import Mapping
from html import escape
from typing import Any

from ..errors import printable, quoted, shortened

WIDTH = 80  # columns
LONGEST = 200  # characters of a fact
MOST = 8  # facts in a text; a table has all


class Shown:
    """What says of itself a heading and facts by name, and is shown by them everywhere."""

    def _shown(self) -> tuple[str, Mapping[str, Any]]:
        raise NotImplementedError

    def __repr__(self) -> str:
        heading, facts = self._shown()
        words = [f"{name} {_text(fact)}" for name, fact in facts.items()]
        more = [f"and {len(words) - MOST} more"] if len(words) > MOST else []
        text = f"<{_text(heading)}: {'; '.join([*words[:MOST], *more])}>"
        return textwrap.fill(text, WIDTH, subsequent_indent="  ", break_on_hyphens=False)

    def _repr_html_(self) -> str:
        heading, facts = self._shown()
        return table(heading, facts)


def table(heading: str, facts: Mapping[str, Any]) -> str:
    """Return an HTML table of facts by name, under its heading. Whatever they say is escaped."""
    cell = '<{0} style="text-align:left;vertical-align:top">{1}</{0}>'
    rows = "".join(
        f"<tr>{cell.format('th', _html(name))}{cell.format('td', _html(fact))}</tr>"
        for name, fact in facts.items()
    )
    style = "text-align:left;font-weight:bold;white-space:nowrap"
    caption = f'<caption style="{style}">{_html(heading)}</caption>'
    return f"<table>{caption}<tbody>{rows}</tbody></table>"


def _text(value: Any) -> str:
    """Return a fact in one line of bounded length, without control characters."""
    text = value if isinstance(value, str) else quoted(value)
    return " ".join(printable(shortened(text, LONGEST)).split())


def _html(value: Any) -> str:
    return escape(_text(value))
