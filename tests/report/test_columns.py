"""Tables of the terminal break no word, however narrow it is."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given, strategies as st
from rich.console import Console
from rich.table import Column

import geomint as gi
from geomint.cli import main
from geomint.reports.columns import fitted

SCENES = gi.scene_names()


def words_of(text: str) -> set[str]:
    return set(text.split())


def shown(width: int, *parts: object, **others: object) -> str:
    stream = io.StringIO()
    console = Console(width=width, file=stream)
    console.print(fitted(console, *parts, **others))  # type: ignore[arg-type]
    return stream.getvalue()


ROWS = [
    ("an-unbroken-name-of-thirty-marks and more words beside", "words and words " * 8, "1.25"),
    ("short", "words that may be broken between them, as many as there are", "−3.5e-12"),
]
HEADINGS = ["name", "told", Column("number", justify="right", no_wrap=True)]


@given(st.integers(44, 200))
def test_words_are_whole(width: int) -> None:
    text = shown(width, HEADINGS, ROWS, ["number"])
    told = {word for row in ROWS for cell in row for word in cell.split()}
    if width < 53:  # 31 + 6 + 8 marks, and blanks
        told -= {row[2] for row in ROWS}
        assert "number" not in text
    assert told <= words_of(text)
    assert max(len(line.rstrip()) for line in text.splitlines()) <= width


def test_columns_are_left_out_in_their_order() -> None:
    headings = [Column(name, no_wrap=True) for name in ("first", "second", "third")]
    rows = [("x" * 10, "y" * 10, "z" * 10)]
    for width, left in ((40, "xyz"), (30, "xz"), (14, "z"), (8, "z")):
        text = shown(width, headings, rows, ["second", "first"])
        assert [c for c in "xyz" if c * 5 in text] == list(left)


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize(
    ("command", "width"), [*((c, 60) for c in ("drift", "scenes", "methods")), ("check", 80)]
)
def test_names_on_narrow_terminals(command: str, width: int, tmp_path: Path) -> None:
    drift = ["hamiltonized-n3", "--out", str(tmp_path), "--tau-end", "5"]
    words, names = {
        "scenes": ([], set(SCENES)),
        "methods": ([], {"rkmk-dormand-prince-5-adaptive", "gauss-8", "rattle-6"}),
        "check": (["hamiltonized-n3"], {"chaplygin-sphere-hamiltonized", "gauss-8", "p_tilde"}),
        "drift": (drift, {"energy", "tangency", "measure"}),
    }[command]
    result = CliRunner().invoke(main, [command, *words], env={"COLUMNS": str(width)})
    assert result.exit_code == 0, result.output
    assert {name for name in names if name not in result.stdout} == set()
    lines = result.stdout.splitlines()
    tables = [line for line in lines if not line.startswith(("report", "reference"))]
    assert max(map(len, tables)) <= width
    assert "…" not in result.stdout
