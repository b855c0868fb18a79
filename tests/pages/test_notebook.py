"""The notebook of the docs runs, shows what it showed, and leaves nothing else in its cells."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from tests.pages.blocks import ROOT

NOTEBOOK = ROOT / "docs" / "first-minutes.ipynb"
SHOWN = ("text/plain", "text/html", "image/png")


def executed(book: Any, folder: Path) -> Any:
    """Return a notebook that was run, with the backend for pictures that notebooks have."""
    client = NotebookClient(
        book, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    return client.execute()


def kinds(cell: Any) -> list[list[str]]:
    return [sorted(output.get("data", {output.output_type: ""})) for output in cell.outputs]


def without_compiling(cells: list[Any]) -> list[Any]:
    """Leave out the one line that says that functions are compiled, where they are not in the cache."""
    told = "geomint: compiling (once"
    for cell in cells:
        cell.outputs = [o for o in cell.outputs if not o.get("text", "").startswith(told)]
    return cells


# Warnings are of the libraries that start a kernel.
pytestmark = [pytest.mark.nightly, pytest.mark.filterwarnings("ignore")]


def test_the_notebook_of_the_docs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("MPLBACKEND", raising=False)
    book = nbformat.read(NOTEBOOK, as_version=4)
    shown = [kinds(cell) for cell in book.cells if cell.cell_type == "code"]
    ran = executed(book, tmp_path).cells
    cells = without_compiling([cell for cell in ran if cell.cell_type == "code"])
    assert [kinds(cell) for cell in cells] == shown
    outputs = [output for cell in cells for output in cell.outputs]
    assert not {output.output_type for output in outputs} & {"stream", "error"}
    assert (tmp_path / "ball.nc").exists()
    assert "True" in [output.data["text/plain"] for output in outputs]


PROGRESS = """
from geomint.run import progress
progress._DELAY = 0.0
import time
with progress.Progress(None, 4.0, "a <b> label") as bar:
    bar.begin()
    for done in range(4):
        time.sleep(0.01)
        bar.update(float(done))
        assert bar._bar is not None
"""


def test_a_bar_leaves_nothing_behind(tmp_path: Path) -> None:
    """It is shown, and what remains in the cell and its exports is empty."""
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(PROGRESS)])
    outputs = executed(book, tmp_path).cells[0].outputs
    assert [dict(output.data) for output in outputs] == [{"text/plain": "", "text/html": ""}]
