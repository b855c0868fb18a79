"""Ctrl-C: what was computed is written, exit code 130."""

import json
import resource
import signal
import subprocess
import sys
import time

import pytest

import geomint as gi

LONG = "1e12"
CPU_SECONDS = 120


def heed_interrupts():
    """Whoever starts the tests may ignore signals, as shells in the background and nohup do.

    If the tests are killed, what they have started ends soon by itself.
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS))


def interrupted(arguments, out, ready, number=signal.SIGINT):
    """Start a command, send a signal once it integrates, and return (exit code, standard error)."""
    process = subprocess.Popen(
        [sys.executable, "-m", "geomint", *arguments, "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=heed_interrupts,
    )
    try:
        time.sleep(ready)
        assert process.poll() is None, process.stderr.read()
        process.send_signal(number)
        _, stderr = process.communicate(timeout=60)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
    return process.returncode, stderr


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    """Fill the cache of compiled code and return how long a short run takes after that."""
    out = tmp_path_factory.mktemp("warm")
    arguments = [sys.executable, "-m", "geomint", "drift", "sphere-n3", "--t-end", "5"]
    for _ in range(2):
        begun = time.perf_counter()
        subprocess.run([*arguments, "--out", str(out)], check=True, capture_output=True)
    return time.perf_counter() - begun


@pytest.mark.nightly
def test_an_interrupted_drift_leaves_a_report(warm, tmp_path):
    arguments = ["drift", "sphere-n3", "--yes", "--t-end", LONG]
    code, stderr = interrupted(arguments, tmp_path, warm + 2.0)
    assert code == 130
    assert "Traceback" not in stderr
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "interrupted" in page
    record = json.loads((tmp_path / "drift.json").read_text(encoding="utf-8"))
    (entry,) = record["methods"].values()
    assert record["status"] == entry["run"]["status"] == "interrupted"
    assert entry["run"]["steps"] > 1000
    assert {q["samples"] for q in entry["quantities"].values()} == {entry["run"]["steps"]}


@pytest.mark.nightly
def test_interrupted_methods_leave_a_report(warm, tmp_path):
    arguments = ["drift", "sphere-n3", "--yes", "--t-end", LONG, "--methods", "gauss-8,rk-4"]
    code, stderr = interrupted(arguments, tmp_path, warm + 2.0)
    assert code == 130
    assert "Traceback" not in stderr
    record = json.loads((tmp_path / "drift.json").read_text(encoding="utf-8"))
    assert record["status"] == record["methods"]["gauss-8"]["status"] == "interrupted"
    assert record["methods"]["gauss-8"]["run"]["steps"] > 1000
    assert record["methods"]["rk-4"]["status"] == "not run"
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "gauss-8: interrupted." in page


@pytest.mark.parametrize(
    ("number", "expected"),
    [
        pytest.param(signal.SIGINT, 130, marks=pytest.mark.nightly),
        pytest.param(signal.SIGTERM, 143, marks=pytest.mark.nightly),
        (signal.SIGHUP, 129),
    ],
)
def test_an_interrupted_run_leaves_its_states(warm, tmp_path, number, expected):
    """SIGTERM and SIGHUP end it as Ctrl-C does."""
    out = tmp_path / "run.nc"
    code, stderr = interrupted(
        ["run", "sphere-n3", "--yes", "--t-end", LONG], out, warm + 2.0, number
    )
    assert code == expected
    assert "Traceback" not in stderr
    saved = gi.load(out)
    assert saved.status == "interrupted"
    assert saved.tau[-1] == pytest.approx(saved.provenance["steps"] * saved.provenance["step"])


def test_ctrl_c_does_not_outlive_the_run():
    before = signal.getsignal(signal.SIGINT)
    gi.run_scene(gi.load_scene("sphere-n3").changed(time={"t_end": 2.0}), progress=False)
    assert signal.getsignal(signal.SIGINT) is before


def test_a_comparison_keeps_what_it_has(tmp_path, monkeypatch):
    """The points before Ctrl-C, in a report that says so; exit code 130."""
    from click.testing import CliRunner

    from geomint.cli import main
    from geomint.compare import runs as compare

    attempt, points = compare.attempt, []

    def interrupting(*arguments, **options):
        if len(points) == 3:
            raise KeyboardInterrupt
        points.append(attempt(*arguments, **options))
        return points[-1]

    monkeypatch.setattr(compare, "attempt", interrupting)
    arguments = ["compare", "sphere-n3", "--t-end", "5", "--methods", "rk-4,gauss-8"]
    result = CliRunner().invoke(main, [*arguments, "--repeats", "1", "--out", str(tmp_path)])
    assert result.exit_code == 130
    assert "report (interrupted)" in result.stdout
    record = json.loads((tmp_path / "compare.json").read_text(encoding="utf-8"))
    assert record["status"] == "interrupted"
    assert len(record["points"]) == 3
    assert "was interrupted" in (tmp_path / "compare.html").read_text(encoding="utf-8")


def test_sigterm_where_ctrl_c_is_ignored():
    """As in the background of a script: SIGTERM must not go the way of a Ctrl-C that nobody hears."""
    from geomint.cli.signals import signals_as_ctrl_c

    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with signals_as_ctrl_c() as received:
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGINT)
        assert received == [signal.SIGTERM]
    finally:
        signal.signal(signal.SIGINT, before)


def test_signals_that_are_ignored_stay_so():
    from geomint.cli.signals import signals_as_ctrl_c

    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with signals_as_ctrl_c():
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        signal.signal(signal.SIGHUP, before)
