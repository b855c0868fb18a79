"""The command, its files and its exit code."""

import dataclasses
import json

import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.stress import sweep
from geomint.stress.judge import VERDICTS, Cell
from geomint.stress.page import stress_record, write_stress_report
from tests.stress.stress_support import CASES

FILES = {"stress.html", "stress.json", "stress.png", "stress.svg"}
AXES = list(dict.fromkeys(case.axis for case in CASES))


def cells(*verdicts):
    axis = AXES[0]
    methods = ["rk-4", "gauss-8", "cf-4"]
    return [
        Cell(
            system=f"ball/{number % 2}",
            axis=axis.name,
            value=float(number // 3),
            label=f"{number // 3}",
            n=3,
            method=methods[number % 3],
            verdict=verdict,
            message="<script>" if verdict == "wrong" else "",
            error=float("nan") if verdict == "wrong" else 1e-9,
            allowed=1e-15,
            h=0.1,
            steps=3,
            seconds=0.01,
        )
        for number, verdict in enumerate(verdicts)
    ]


def test_files(tmp_path):
    found = cells(*VERDICTS, *VERDICTS)
    record = stress_record(found, AXES, 1.5, "geomint stress")
    page = write_stress_report(record, gi.method_names(), tmp_path / "a" / "b")
    assert {path.name for path in page.parent.iterdir()} == FILES
    text = page.read_text(encoding="utf-8")
    assert "&lt;script&gt;" in text
    assert "<script>" not in text
    assert "6 forbidden verdicts in 14 cells" in text
    assert "http" not in text.replace("http://www.w3.org", "")
    data = json.loads((page.parent / "stress.json").read_text(encoding="utf-8"))
    assert len(data["cells"]) == 14
    for cell in data["cells"]:
        assert cell["verdict"] in VERDICTS
    assert "References: none." in text
    assert data["references"]["judged"] == 0
    assert data["counts"] == dict.fromkeys(VERDICTS, 2)


def test_the_picture_of_all_axes_is_not_clipped():
    """All that is drawn of every axis with all its values lies on the figure, nothing on top."""
    from geomint.stress.picture import stress_figure

    methods = gi.method_names()
    made = [
        dataclasses.asdict(Cell(c.system, c.axis.name, c.value, c.text, c.n, m, "ok", error=0.0))
        for c in CASES
        for m in (methods[0], methods[-1])
    ]
    figure = stress_figure(
        made, methods, dict.fromkeys(methods, "one"), [dataclasses.asdict(a) for a in AXES]
    )
    assert len(figure.axes) == len(AXES)
    figure.canvas.draw()
    boxes = [panel.get_tightbbox() for panel in figure.axes] + [figure.legends[0].get_tightbbox()]
    for box in boxes:
        assert min(box.x0, box.y0) >= 0.0
        assert box.x1 <= figure.bbox.x1
        assert box.y1 <= figure.bbox.y1
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


@pytest.mark.parametrize(
    ("verdicts", "interrupted", "code"),
    [
        (("ok", "failed", "refused", "unresolved"), False, 0),
        (("ok", "wrong"), False, 1),
        (("untyped",), False, 1),
        (("hung",), False, 1),
        (("ok",), True, 130),
    ],
)
def test_exit_code(monkeypatch, tmp_path, verdicts, interrupted, code):
    def fake(selection, listener, **options):
        found = cells(*verdicts)
        listener.begin(len(found))
        for cell in found:
            listener.cell_done(cell)
        return sweep.Result(found, AXES, gi.method_names(), 1.0, interrupted)

    monkeypatch.setattr(sweep, "run_selection", fake)
    result = CliRunner().invoke(main, ["stress", "--out", str(tmp_path)], env={"COLUMNS": "120"})
    assert result.exit_code == code, result.output
    assert {path.name for path in tmp_path.iterdir()} == FILES
    assert "stress.html" in result.stdout.replace("\n", "")


def test_ctrl_c_keeps_what_was_done(monkeypatch):
    def interrupted(groups, **options):
        yield cells("ok")[0]
        raise KeyboardInterrupt

    monkeypatch.setattr(sweep, "sweep", interrupted)

    class Silent:
        def begin(self, total):
            pass

        def cell_done(self, cell):
            pass

    result = sweep.run_selection(sweep.Selection(("rk-4",), (), ("momentum",)), Silent())
    assert result.interrupted
    assert [cell.verdict for cell in result.cells] == ["ok"]


def test_unknown_names(tmp_path):
    for options in (["--axis", "edg"], ["--systems", "spher"], ["--methods", "rk-5"]):
        result = CliRunner().invoke(main, ["stress", "--out", str(tmp_path), *options])
        assert result.exit_code == 2
        assert "Did you mean" in result.stderr


def test_one_cell_end_to_end(tmp_path):
    arguments = ["--methods", "rk-4", "--axis", "momentum", "--systems", "sphere-n3", "--quick"]
    result = CliRunner().invoke(main, ["stress", "--out", str(tmp_path), *arguments])
    assert result.exit_code == 0, result.output
    data = json.loads((tmp_path / "stress.json").read_text(encoding="utf-8"))
    assert {cell["label"] for cell in data["cells"]} == {"1e-150", "1e+151"}
    assert {cell["verdict"] for cell in data["cells"]} == {"ok"}


@pytest.mark.nightly
def test_quick_run(tmp_path):
    result = CliRunner().invoke(main, ["stress", "--quick", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
