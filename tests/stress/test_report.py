"""The command, its files and its exit code."""

import dataclasses
import itertools
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

import geomint as gi
from geomint.cli import main
from geomint.stress import judge, sweep
from tests.stress.stress_support import AXES, CASES

FILES = {"stress.html", "stress.json", "stress.png", "stress.svg"}


def cells(*verdicts):
    told = {"axis": AXES[0].name, "n": 3, "allowed": 1e-15, "h": 0.1, "steps": 3, "seconds": 0.01}
    return [
        judge.Cell(
            system=f"ball/{number % 2}", value=float(number // 3), label=f"{number // 3}",
            method=("rk-4", "gauss-8", "cf-4")[number % 3], verdict=verdict,
            message="<script>" if verdict == "wrong" else "",
            error=float("nan") if verdict == "wrong" else 1e-9, **told,
        )
        for number, verdict in enumerate(verdicts)
    ]  # fmt: skip


@pytest.fixture
def stressed(monkeypatch, tmp_path):
    """Return a function that calls the command with cells that nobody has computed."""

    def stress(found, interrupted=False, *options):
        asked = []

        def fake(selection, listener, **more):
            asked.extend((selection, more))
            listener.begin(len(found))
            for cell in found:
                listener.cell_done(cell)
            return sweep.Result(found, AXES, gi.method_names(), 1.0, interrupted)

        monkeypatch.setattr(sweep, "run_selection", fake)
        line = ["stress", "--out", str(tmp_path / "a" / "b"), *options]
        result = CliRunner().invoke(main, line, env={"COLUMNS": "120"})
        assert {path.name for path in (tmp_path / "a" / "b").iterdir()} == FILES
        return result, tmp_path / "a" / "b" / "stress.json", asked

    return stress


def test_files(stressed):
    verdicts = [*judge.VERDICTS, *judge.VERDICTS, *["hung"] * 16]
    result, path, _ = stressed(cells(*verdicts))
    assert result.exit_code == 1
    assert "stress.html" in result.stdout.replace("\n", "")
    off = {"wrong": "not finite, allowed 1e-15; <script>"}
    told = [
        f"{verdict}: {('rk-4', 'gauss-8', 'cf-4')[k % 3]} on ball/{k % 2}, edge {k // 3}: "
        f"state off by {off.get(verdict, '1e-09, allowed 1e-15')}"
        for k, verdict in enumerate(verdicts)
        if verdict in judge.FORBIDDEN
    ]
    lines = [line.split() for line in result.stdout.splitlines()]
    head = lines.index(["axis", *judge.VERDICTS])
    assert ["References:", "none."] in lines[:head]
    assert lines[head + 1] == ["edge", *"222222", "18"]
    listed = [line[:6] for line in lines[head + 2 :] if line[:1] and line[0] in judge.FORBIDDEN]
    bad = [(v, k) for k, v in enumerate(verdicts) if v in judge.FORBIDDEN]
    assert listed == [
        [v, ("rk-4", "gauss-8", "cf-4")[k % 3], f"ball/{k % 2}", "edge", f"{k // 3}", "state"]
        for v, k in bad[:20]
    ]
    assert "22 forbidden verdicts" in result.stdout
    assert result.stderr.splitlines()[:22] == told
    text = path.with_name("stress.html").read_text(encoding="utf-8")
    assert "&lt;script&gt;" in text
    assert "<script>" not in text
    assert "22 forbidden verdicts in 30 cells" in text
    assert "… and 2 more" in text
    assert "http" not in text.replace("http://www.w3.org", "")
    data = json.loads(path.read_text(encoding="utf-8"))
    assert "References: none." in text
    assert data["references"]["judged"] == 0
    assert data["counts"] == dict.fromkeys(judge.VERDICTS, 2) | {"hung": 18}


@pytest.mark.usefixtures("blank_pictures")
def test_the_report_counts_references(stressed):
    (cell,) = cells("ok")
    found = [
        dataclasses.replace(cell, known=known, confirmed=confirmed, message=message)
        for known, confirmed, message in (
            (1e-25, 1e-13, ""), (2e-20, 1e-12, ""), (0.0, 1e-14, ""),
            (None, None, "no reference (UnknownReferenceError: …): compared with a finer run"),
            (None, None, ""),
        )
    ]  # fmt: skip
    _, path, _ = stressed(found)
    assert json.loads(path.read_text("utf-8"))["references"] == {
        "judged": 3, "known": 2e-20, "confirmed": 1e-13, "confirmed_worst": 1e-12, "without": 1,
    }  # fmt: skip
    page = path.with_name("stress.html").read_text("utf-8")
    for word in ("3 cells", "1e-19", "1e-13", "1e-12", "1 are compared"):
        assert word in page


def test_the_picture_of_all_axes_is_not_clipped(stressed, monkeypatch):
    """All that is drawn of every axis with all its values lies on the figure, nothing on top."""
    methods, figures, verdicts = gi.method_names(), [], itertools.cycle(judge.VERDICTS)
    made = [
        judge.Cell(c.system, c.axis.name, c.value, c.text, c.n, m, next(verdicts), error=0.0)
        for c in CASES
        for m in (methods[0], methods[-1])
    ]

    def saved(figure, to, **_):
        figures.append(figure)
        Path(to).touch() if not hasattr(to, "write") else None

    monkeypatch.setattr(Figure, "savefig", saved)
    stressed(made)
    figure = figures[0]
    assert len(figure.axes) == len(AXES)
    figure.canvas.draw()
    boxes = [panel.get_tightbbox() for panel in figure.axes] + [figure.legends[0].get_tightbbox()]
    for box in boxes:
        assert min(box.x0, box.y0) >= 0.0
        assert box.x1 <= figure.bbox.x1
        assert box.y1 <= figure.bbox.y1
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert max(box.y1 for box in boxes) > figure.bbox.y1 - 5.0
    figures.clear()
    found = cells(
        *judge.VERDICTS
    )  # columns and rows, and a better one and a worse one in one place
    stressed([*found, dataclasses.replace(found[1], verdict="ok", error=0.1)])
    (panel,) = figures[0].axes
    (squares,) = panel.collections
    corners = [(*path.vertices.min(axis=0), len(path.vertices) - 1) for path in squares.get_paths()]
    half, places = (0, 2, 3), [(0, 0), (0, 2), (0, 1), (1, 0), (1, 2), (1, 1), (2, 0)]
    assert corners == [(*place, 4) for place in places[:2]] + [half] + [
        (*place, 4) for place in places[2:]
    ]
    colours = dict(zip(["ok", "~", "half", *"∘–×!∞"], squares.get_facecolors()[:, :3], strict=True))
    light, dark = np.array([0.87, 0.93, 0.97]), np.array([0.19, 0.51, 0.74])
    np.testing.assert_allclose(colours["ok"], light + 7.0 / 15.0 * (dark - light))  # 1e-9
    np.testing.assert_allclose(colours["half"], dark)
    symbols = {text.get_text(): tuple(np.floor(text.get_position())) for text in panel.texts}
    assert symbols == dict(zip("~∘–×!∞", places[1:], strict=True))


@pytest.mark.usefixtures("blank_pictures")
def test_exit_codes(stressed):
    """And the options: each is asked for."""
    for verdicts, interrupted, code in (
        (("ok", "failed", "refused", "unresolved"), False, 0),
        (("ok", "wrong"), False, 1),
        (("untyped",), False, 1),
        (("hung",), False, 1),
        (("ok",), True, 130),
    ):
        result, _, plain = stressed(cells(*verdicts), interrupted)
        assert result.exit_code == code, result.output
    line = "--methods rk-4 --systems neumann --axis step --quick --seconds 7 --workers 1 --quiet"
    result, _, asked = stressed(cells("ok"), False, *line.split())
    assert result.output == ""
    assert plain == [sweep.Selection(), {"cases": None, "seconds": 60.0, "workers": 2}]
    chosen = sweep.Selection(("rk-4",), ("neumann",), ("step",), True)
    assert asked == [chosen, {"cases": None, "seconds": 7.0, "workers": 1}]


def test_ctrl_c_keeps_what_was_done(monkeypatch):
    def interrupted(groups, **options):
        yield cells("ok")[0]
        raise KeyboardInterrupt

    monkeypatch.setattr(sweep, "sweep", interrupted)

    listener = SimpleNamespace(begin=lambda total: None, cell_done=lambda cell: None)
    result = sweep.run_selection(sweep.Selection(("rk-4",), (), ("momentum",)), listener)
    assert result.interrupted
    assert [cell.verdict for cell in result.cells] == ["ok"]


def test_unknown_names(tmp_path):
    for options in (["--axis", "edg"], ["--systems", "spher"], ["--methods", "rk-5"]):
        result = CliRunner().invoke(main, ["stress", "--out", str(tmp_path), *options])
        assert result.exit_code == 2
        assert "Did you mean" in result.stderr


@pytest.mark.usefixtures("blank_pictures")
def test_one_cell_end_to_end(tmp_path):
    line = "stress --methods rk-4 --axis momentum --systems sphere-n3 --quick --workers 1 --out"
    result = CliRunner().invoke(main, [*line.split(), str(tmp_path)])
    assert result.exit_code == 0, result.output
    data = json.loads((tmp_path / "stress.json").read_text(encoding="utf-8"))
    assert {cell["label"] for cell in data["cells"]} == {"1e-150", "1e+151"}
    assert {cell["verdict"] for cell in data["cells"]} == {"ok"}


@pytest.mark.nightly
def test_quick_run(tmp_path):
    result = CliRunner().invoke(main, ["stress", "--quick", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
