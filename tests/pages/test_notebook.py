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
    client = NotebookClient(
        book, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    return client.execute()


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MPLBACKEND", raising=False)  # a notebook has its own


def kinds(cell: Any) -> list[list[str]]:
    return [sorted(output.get("data", {output.output_type: ""})) for output in cell.outputs]


def without_compiling(cells: list[Any]) -> list[Any]:
    """Leave out the one line that says that functions are compiled, where they are not in the cache."""
    found = [
        (cell, output)
        for cell in cells
        for output in cell.outputs
        if output.get("text", "").startswith("geomint: compiling (once")
    ]
    assert len(found) <= 1
    for cell, output in found:
        cell.outputs.remove(output)
    return cells


@pytest.mark.filterwarnings("ignore")  # of the libraries that start a kernel
def test_the_notebook_of_the_docs(kernel: None, tmp_path: Path) -> None:
    book = nbformat.read(NOTEBOOK, as_version=4)
    shown = [kinds(cell) for cell in book.cells if cell.cell_type == "code"]
    ran = executed(book, tmp_path).cells
    cells = without_compiling([cell for cell in ran if cell.cell_type == "code"])
    assert [kinds(cell) for cell in cells] == shown
    assert not [
        output
        for cell in cells
        for output in cell.outputs
        if output.output_type in ("stream", "error")
    ]
    assert (tmp_path / "ball.nc").exists()
    assert "True" in [output.data["text/plain"] for cell in cells for output in cell.outputs]


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


@pytest.mark.filterwarnings("ignore")
def test_a_bar_leaves_nothing_behind(kernel: None, tmp_path: Path) -> None:
    """It is shown, and what remains in the cell and its exports is empty."""
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(PROGRESS)])
    outputs = executed(book, tmp_path).cells[0].outputs
    assert [dict(output.data) for output in outputs] == [{"text/plain": "", "text/html": ""}]
