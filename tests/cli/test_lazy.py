"""`--help` and a typo answer at once: nothing heavy is imported."""

import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest

HEAVY = ("numba", "matplotlib", "scipy", "jinja2", "llvmlite")
PROBE = f"""
import sys
import threading
from types import SimpleNamespace
from geomint.cli import main
try:
    main(sys.argv[1:])
except SystemExit as exit:
    code = exit.code
print("IMPORTED", *[name for name in {HEAVY!r} if name in sys.modules])
sys.exit(code)
"""


def imported(*arguments):
    done = subprocess.run(
        [sys.executable, "-c", PROBE, *arguments], capture_output=True, text=True, check=False
    )
    last = done.stdout.splitlines()[-1]
    assert last.startswith("IMPORTED"), done.stderr
    return done.returncode, set(last.split()[1:])


def write(folder, text):
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.fixture
def typo(tmp_path):
    return write(
        tmp_path,
        """
        [system]
        name = "chaplygin-sphere-reduced"
        a = [0.8, 1.1, 1.5]
        D = 4.0
        [initial]
        gamma = [0.6, 0.0, 0.8]
        p = [0.8, 1.0, -0.6]
        [time]
        tend = 1.0
        """,
    )


@pytest.mark.parametrize(
    "arguments",
    [["--help"], ["--version"], ["drift", "--help"], ["run", "--help"], ["compare", "--help"]],
    ids=" ".join,
)
def test_help_imports_not_even_numpy(arguments):
    code, names = imported(*arguments)
    assert code == 0
    assert names == set()


@pytest.mark.parametrize("arguments", [["scenes"], ["methods"], ["check", "ball-3d"]], ids=" ".join)
def test_lists_and_plans_import_nothing_heavy(arguments):
    code, names = imported(*arguments)
    assert code == 0
    assert names == set()


def test_typos_import_nothing_heavy(tmp_path, typo):
    out = ["--out", str(tmp_path / "out")]
    for arguments in (["drift", "bal-3d", *out], ["drift", typo, *out], ["check", typo]):
        code, names = imported(*arguments)
        assert code == 2
        assert names == set()


def test_what_a_page_needs_is_imported_beside_the_run_and_once(monkeypatch):
    """Not before it has begun; what cannot be imported is no failure there."""
    from geomint.cli import meanwhile
    from geomint.run.progress import WHEN_RUNNING, Progress

    names, before = [], sys.getswitchinterval()
    monkeypatch.setattr(meanwhile, "importlib", SimpleNamespace(import_module=names.append))
    meanwhile.import_meanwhile("drift_page")
    assert names == []
    for _ in range(2):
        with Progress(False, 1.0, "run") as bar:
            bar.begin()
    waiting = [t for t in threading.enumerate() if t.name == "importing drift_page"]
    for thread in waiting:
        thread.join(10.0)
    assert names[0] == "geomint.report.drift_page"
    assert len(names) == len(set(names)) == 1 + len(meanwhile._DRAWING)
    assert WHEN_RUNNING == []
    monkeypatch.setattr(meanwhile, "importlib", SimpleNamespace(import_module=lambda name: 1 / 0))
    meanwhile.import_meanwhile("drift_page", at_once=True)
    for thread in [t for t in threading.enumerate() if t.name == "importing drift_page"]:
        thread.join(10.0)
    assert sys.getswitchinterval() == before
