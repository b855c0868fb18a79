"""Commands in processes of their own: what they import, and streams that are closed or full."""

import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main, meanwhile
from tests.cli.calls import alone

HEAVY = ("numba", "matplotlib", "scipy", "jinja2", "llvmlite")
IMPORTED = f"""
import sys, geomint.run.files.outputs
from geomint.cli import main
for line in sys.argv[1:]:
    try:
        main(line.split())
    except SystemExit as exit:
        print("IMPORTED", exit.code, *[name for name in {HEAVY} if name in sys.modules])
"""


def test_nothing_heavy_is_imported_for_help_lists_plans_and_typos(tmp_path):
    """They answer at once; so do signals that are taken over, and outputs that are tested."""
    scene = gi.load_scene("sphere-n3").toml().replace("t_end", "tend")
    (tmp_path / "typo.toml").write_text(scene, encoding="utf-8")
    good = ["--help", "--version", "drift --help", "scenes", "methods", "check ball-3d"]
    bad = ["drift bal-3d --out x", "drift typo.toml --out x", "check typo.toml"]
    done = alone(tmp_path, *good, *bad, call=("-c", IMPORTED))
    told = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("IMPORTED")]
    assert told == [["0"]] * len(good) + [["2"]] * len(bad), done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="a shell of POSIX")
@pytest.mark.parametrize(
    ("command", "closed", "code", "told"),
    [
        ("scenes", ">&-", 2, "geomint: standard output cannot be written"),
        ("methods", ">&- 2>&-", 2, ""),
        pytest.param("scenes", "2>&- <&-", 0, "", marks=pytest.mark.nightly),
        pytest.param("check sphere-n", "2>/dev/full", 2, "", marks=pytest.mark.nightly),
        ("--help", ">/dev/full", 2, "geomint: standard output cannot be written"),
        ("methods", "| true", 1, ""),
    ],
)
def test_streams_that_are_closed_or_full(command, closed, code, told):
    geomint = f"set -o pipefail; {sys.executable} -m geomint {command} {closed}"
    done = subprocess.run(["bash", "-c", geomint], capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    assert done.stderr.startswith(told)
    assert done.stderr.count("\n") == bool(told)


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252"])
def test_what_an_encoding_lacks_is_escaped(encoding):
    """Names, titles and tables have letters that no encoding but those of Unicode has."""
    for words in (("methods",), ("check", "hamiltonized-n3"), ("inertia", "--help")):
        done = CliRunner(charset=encoding).invoke(main, words)
        assert done.exit_code == 0, words
        assert words[0] != "check" or "\\u" in done.stdout


def test_what_a_page_needs_is_imported_beside_the_run_and_once(monkeypatch):
    """Not before it has begun; what cannot be imported is no failure there."""
    names, before = [], sys.getswitchinterval()

    def imported(run):
        run()
        for thread in threading.enumerate():
            if thread.name == "importing the page":
                thread.join(10.0)
        return names

    def importing(name):
        names.append(name)
        return 1 / (len(names) - 1)  # which fails at first

    monkeypatch.setattr(meanwhile, "importlib", SimpleNamespace(import_module=importing))
    meanwhile.WHEN_RUNNING.clear()  # of commands that have not come to a run
    meanwhile.import_meanwhile()
    assert names == []
    scene = gi.load_scene("sphere-n3").changed(time={"t_end": 5.0})
    assert imported(lambda: gi.run_scene(scene, progress=False)) == ["geomint.reports.files"]
    assert imported(lambda: gi.run_scene(scene, progress=False)) == ["geomint.reports.files"]
    assert len(imported(lambda: meanwhile.import_meanwhile(at_once=True))) > 2
    assert (meanwhile.WHEN_RUNNING, sys.getswitchinterval()) == ([], before)
