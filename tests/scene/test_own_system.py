"""One's own system in every report: from Python, and a Python file on the command line."""

from __future__ import annotations

import json
import pickle
import shlex
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.scene.load import load_changed
from tests.pages.blocks import blocks, commands, page

MYSYS = next(block.text for block in blocks(page("my-own-system")) if block.info == "python")
OSCILLATOR = """
import geomint as gi

@gi.field
def field(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -params[0] * y[0]

@gi.observable
def energy(params, t, y, work):
    return (y[1] * y[1] + params[0] * y[0] * y[0]) / 2

def oscillator(stiffness: float = 4.0):
    kept = {"energy": energy}
    problem = gi.Problem("oscillator", (("q", 1), ("p", 1)), [stiffness], field=field, invariants=kept)
    return problem, [1.0, 0.0]

made = oscillator()
alone = made[0]
untold = lambda stiffness: made

def wrong(stiffness: float = 4.0):
    return stiffness

def broken(stiffness: float = 4.0):
    return 1 / 0
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "osc.py").write_text(OSCILLATOR, "utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path / "osc.py"


def ran(line: str) -> Any:
    return CliRunner().invoke(main, shlex.split(line))


@pytest.mark.usefixtures("blank_pictures")
def test_every_way_says_the_same(file: Path) -> None:
    """The file, the function, the pair, the problem with a state: the numbers of `solve`."""
    space: dict[str, Any] = {}
    exec(OSCILLATOR, space)
    problem, y0 = space["made"]
    given = {"t_end": 5.0, "step": 0.125, "method": "rk-4"}
    sol = gi.solve(problem, y0, observe=["energy"], **given)
    ways = [f"{file}:oscillator", space["oscillator"], space["made"], problem]
    for k, way in enumerate(ways):
        more = {"y0": y0} if way is problem else {}
        runs = gi.drift_report(way, file.parent / str(k), progress=False, **given, **more)
        assert runs[0].solution.drift["energy"].brief == sol.drift["energy"].brief
        frame = runs.to_dataframe()
        assert frame["largest deviation"].max() == sol.drift["energy"].max_abs_error
        assert runs.plot() is not None
        assert "<iframe" in runs._make()._repr_html_()
    again = runs.report(file.parent / "again")
    assert again.read_text("utf-8").count("oscillator") > 3
    result = ran(f"drift {file}:oscillator --t-end 5 --step 0.125 --method rk-4 --out shell")
    assert (result.exit_code, "running" in result.stderr) == (0, True), result.output
    told = [json.loads((file.parent / k / "drift.json").read_text()) for k in ("0", "shell")]
    assert told[1]["provenance"]["python"] == OSCILLATOR
    assert "def oscillator(" in (file.parent / "shell" / "report.html").read_text("utf-8")
    assert told[0]["methods"]["rk-4"]["quantities"] == told[1]["methods"]["rk-4"]["quantities"]


@pytest.mark.usefixtures("blank_pictures")
def test_its_numbers_vary(file: Path) -> None:
    """Parameters of a function, `params` of a problem, numbers of the state."""
    space: dict[str, Any] = {}
    exec(OSCILLATOR, space)
    common: dict[str, Any] = {"t_end": 2.0, "step": 0.125, "method": "rk-4", "progress": False}
    for what, key, y0 in (
        (space["oscillator"], "stiffness", None),
        (space["alone"], "params[0]", [1.0, 0.0]),
    ):
        many = gi.scan_report(
            what, "out", y0=y0, vary={key: [1.0, 9.0]}, show=["final:q"], **common
        )
        exact = np.cos(2.0 * np.sqrt([1.0, 9.0]))
        np.testing.assert_allclose(many.readings["final:q"], exact, atol=1e-3)
    result = ran(
        "scan osc.py:made --vary q[0]=1:2:2 --show final:q --t-end 2 --step 0.125 --method rk-4"
    )
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            "drift osc.py:oscilator --t-end 1",
            "no such name 'oscilator'. Did you mean 'oscillator'?",
        ),
        ("drift osc.py --t-end 1", "expected a name after it, such as osc.py:"),
        ("drift os.py:oscillator --t-end 1", "does not exist. Did you mean 'osc.py'?"),
        ("drift osc.py:oscillator", "expected an end: --t-end, or --tau-end"),
        ("drift osc.py:alone --t-end 1", "y0 = None: expected a state of 'oscillator'"),
        ("drift osc.py:untold --t-end 1", "as in `stiffness: float = 1.0`"),
        ("drift osc.py:wrong --t-end 1", "wrong returned 4.0: expected a Problem"),
        ("drift osc.py:broken --t-end 1", "broken failed in line 26 of osc.py: ZeroDivisionError"),
        ("section osc.py:made", "a component such as q[0]"),
        ("section osc.py:made --tolerance 1e-6", "expected --step: a tolerance is of the end"),
        ("section osc.py:made --event p[0] --axes q[0]", "at least 2 of them"),
        ("drift osc.py:field --t-end 1", "expected a name, the path of a TOML file"),
        ("scan osc.py:made --vary stiff=1:2:2 --t-end 1", "no such key"),
    ],
)
def test_what_is_wrong_is_said(line: str, said: str, file: Path) -> None:
    result = ran(line)
    assert result.exit_code == 2
    assert said in result.stderr
    assert "Traceback" not in result.stderr


def test_a_file_that_fails_is_named(file: Path) -> None:
    (file.parent / "bad.py").write_text("import nothing_of_the_kind\n", "utf-8")
    (file.parent / "a-b.py").touch()
    assert "a name that Python can import" in ran("drift a-b.py:x --t-end 1").stderr
    result = ran("drift bad.py:x --t-end 1")
    assert "'bad.py' failed in line 1 of bad.py: ModuleNotFoundError" in result.stderr
    with pytest.raises(gi.ArgumentError, match="Did you mean 'methods'"):
        gi.drift_report(f"{file}:oscillator", "out", t_end=1.0, method_s=["rk-4"])
    with pytest.raises(gi.SceneError, match="a scene has its own state"):
        gi.drift_report("ball-3d", "out", y0=[1.0])
    with pytest.raises(gi.DomainError, match="a result of a report"):
        gi.SeveralRuns(gi.load_scene("ball-3d")).report("out")


HELPED = OSCILLATOR.replace("stiffness: float = 4.0", "stiffness: float = springs.FIRST", 1)


def stiffness(source: str) -> float:
    return load_changed(source, t_end=1.0).content.system.model_extra["stiffness"]


def test_a_file_is_run_as_it_is_now(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It and what lies beside it, after edits within a second, and not what lies elsewhere."""
    (other := file.parent / "other").mkdir()
    for folder, first in ((file.parent, "5.0"), (other, "7.0")):
        (folder / "osc.py").write_text(f"import springs\n{HELPED}", "utf-8")
        (folder / "springs.py").write_text(f"FIRST = {first}\n", "utf-8")
    searched = list(sys.path)
    assert stiffness("osc.py:oscillator") == 5.0
    assert stiffness("other/osc.py:oscillator") == 7.0
    (file.parent / "springs.py").write_text("FIRST = 6.0\n", "utf-8")
    assert stiffness("osc.py:oscillator") == 6.0
    file.write_text(f"import springs\n{HELPED}".replace("springs.FIRST", "8 + 0 * 1.0"), "utf-8")
    assert stiffness("osc.py:oscillator") == 8.0
    assert sys.path == [*searched, str(file.parent)]
    assert not list(file.parent.rglob("*.pyc"))
    file.write_text("1 / 0", "utf-8")
    with pytest.raises(gi.SceneError, match="failed in line 1 of osc"):
        stiffness("osc.py:oscillator")
    assert "osc" not in sys.modules
    monkeypatch.setitem(sys.modules, "osc", imported := ModuleType("osc"))
    file.write_text(OSCILLATOR, "utf-8")
    assert stiffness("osc.py:oscillator") == 4.0
    assert sys.modules["osc"] is imported


def test_other_processes_find_what_they_are_sent(file: Path) -> None:
    """They import the file, where this one ran its text."""
    problem = load_changed(f"{file}:oscillator", t_end=1.0).problem
    sent = pickle.dumps(problem)
    del sys.modules["osc"]
    assert pickle.loads(sent) == problem


def test_what_no_process_finds_is_told_before(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Somebody has imported the file, goes on with that, and has no cloudpickle."""
    monkeypatch.setitem(sys.modules, "cloudpickle", None)
    monkeypatch.setitem(sys.modules, "osc", ModuleType("osc"))
    with pytest.raises(gi.SendingError, match="install cloudpickle"):
        gi.stress_report("osc.py:oscillator", "out", methods=["rk-4"])


def test_a_file_may_have_another_encoding(file: Path) -> None:
    file.write_bytes(f"# coding: latin-1\n# \xe9\n{OSCILLATOR}".encode("latin-1"))
    scene = load_changed("osc.py:oscillator", t_end=1.0)
    assert "# coding: latin-1" in scene.system.source


def test_what_decides_is_in_the_hash(file: Path) -> None:
    """Of a system that its name does not tell: its code and its state."""

    def hash_of(text: str, **given: Any) -> str:
        file.write_text(text, "utf-8")
        return load_changed(f"{file}:oscillator", t_end=1.0, **given).hash

    usual = hash_of(OSCILLATOR)
    assert hash_of(f"# the same\n{OSCILLATOR}") == usual
    others = [hash_of(OSCILLATOR.replace("-params[0] * y[0]", "-params[0] * y[0] ** 3"))]
    others += [hash_of(OSCILLATOR.replace("[1.0, 0.0]", "[1.0, 0.5]"))]
    assert len({usual, *others}) == 3


@pytest.mark.parametrize(
    ("parameter", "said"),
    [
        ("list_of: list = None", "list_of = None: expected a list of numbers"),
        ("weight: Weight = 1.0", "expected annotations that can be read"),
        ("model_dump: float = 1.0", "model_dump: expected another name"),
        ("_w: float = 1.0", "_w: expected another name"),
        ("name: str = 'x'", "name: expected another name"),
    ],
)
def test_parameters_that_no_scene_could_have(parameter: str, said: str, file: Path) -> None:
    text = f"from __future__ import annotations\n{OSCILLATOR}"
    file.write_text(text.replace("4.0):", f"4.0, {parameter}):", 1), "utf-8")
    result = ran("drift osc.py:oscillator --t-end 1")
    assert (result.exit_code, said in result.stderr) == (2, True), result.output


def test_a_piece_of_one_number_is_a_number(file: Path) -> None:
    scene = load_changed(f"{file}:oscillator", t_end=1.0).changed(initial={"q": 2.0})
    assert scene.state.tolist() == [2.0, 0.0]


@pytest.mark.parametrize("given", [{"workers": 0}, {"seconds": 0.0}, {"seconds": np.nan}])
def test_a_stress_test_has_time_and_workers(given: dict[str, Any], file: Path) -> None:
    with pytest.raises(gi.DomainError):
        gi.report("stress", f"{file}:oscillator", "out", **given)


@pytest.mark.nightly
def test_a_script_that_is_read_again_is_told(file: Path) -> None:
    """By processes of the stress test, where it lacks the guard."""
    told = (
        "gi.stress_report(osc.oscillator, 'out', methods=['rk-4'], axis=['rest'], progress=False)"
    )
    (file.parent / "script.py").write_text(f"import geomint as gi\nimport osc\n{told}\n", "utf-8")
    done = subprocess.run([sys.executable, "script.py"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "below `if __name__ == " in done.stderr.splitlines()[-1]


@pytest.mark.nightly
def test_the_commands_of_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the time that it tells: see benchmarks; here, that they do what it shows."""
    (tmp_path / "mysys.py").write_text(MYSYS, "utf-8")
    monkeypatch.chdir(tmp_path)
    for command in commands(page("my-own-system")):
        result = ran(command.text.removeprefix("geomint "))
        assert result.exit_code == 0, (command.text, result.output)
    assert {p.name for p in tmp_path.iterdir()} >= {"report", "section", "scan", "chaos"}
    monkeypatch.syspath_prepend(tmp_path)
    second = [block for block in blocks(page("my-own-system")) if block.info == "python"][1]
    exec(second.text, {})
