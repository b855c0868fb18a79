"""Ctrl-C, SIGTERM, SIGHUP: what was computed is written, with an exit code of its own."""

import json
import os
import signal
import threading
from contextlib import contextmanager

import pytest

import geomint as gi
from geomint.cli import meanwhile, signals
from geomint.compare import runs as compare
from tests.cli.calls import invoke

LONG = ("sphere-n3", "--t-end", "5e7")  # minutes, but no hour: no trial comes before the run


@contextmanager
def handler(number, wanted):
    """Let a signal do something else: those who start the tests may ignore it."""
    before = signal.signal(number, wanted)
    try:
        yield
    finally:
        signal.signal(number, before)


def interrupted(*arguments, number=signal.SIGINT):
    """Send a signal to this process once a command integrates; return what it says."""
    timer = threading.Timer(0.2, os.kill, (os.getpid(), number))
    meanwhile.WHEN_RUNNING.append(timer.start)
    usual = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
    with handler(number, usual):
        try:
            result = invoke(*arguments)
            assert signal.getsignal(number) is usual
        finally:  # or it would come to whatever is next
            meanwhile.WHEN_RUNNING.clear()
            timer.cancel()
    assert "Traceback" not in result.stderr
    return result


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("methods", [("gauss-8",), ("gauss-8", "rk-4:0.5")])
def test_an_interrupted_drift_leaves_a_report(methods, tmp_path):
    line = ("drift", *LONG, "--methods", ",".join(methods), "--out", tmp_path)
    number, code = {1: (signal.SIGINT, 130), 2: (signal.SIGHUP, 129)}[len(methods)]
    assert interrupted(*line, number=number).exit_code == code
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "gauss-8: interrupted." in page
    record = json.loads((tmp_path / "drift.json").read_text(encoding="utf-8"))
    entry = record["methods"]["gauss-8"]
    assert record["status"] == entry["run"]["status"] == "interrupted"
    assert entry["run"]["steps"] > 1000
    assert {q["samples"] for q in entry["quantities"].values()} == {entry["run"]["steps"]}
    for name in methods[1:]:
        assert record["methods"][name.split(":")[0]]["status"] == "not run"


def test_an_interrupted_run_leaves_its_states(tmp_path):
    out = tmp_path / "run.nc"
    assert interrupted("run", *LONG, "--out", out, number=signal.SIGTERM).exit_code == 143
    saved = gi.load(out)
    assert saved.status == "interrupted"
    assert saved.tau[-1] == pytest.approx(saved.provenance["steps"] * saved.provenance["step"])


def test_a_comparison_keeps_what_it_has(tmp_path, monkeypatch):
    """The points before Ctrl-C, in a report that says so; exit code 130."""
    attempt, points = compare.attempt, []

    def interrupting(*arguments, **options):
        if len(points) == 3:
            raise KeyboardInterrupt
        points.append(attempt(*arguments, **options))
        return points[-1]

    monkeypatch.setattr(compare, "attempt", interrupting)
    line = ("compare", "sphere-n3", "--t-end", "5", "--methods", "rk-4,gauss-8", "--repeats", "1")
    result = invoke(*line, "--reference", "exact", "--out", tmp_path)
    assert result.exit_code == 130
    assert "report (interrupted)" in result.stdout
    record = json.loads((tmp_path / "compare.json").read_text(encoding="utf-8"))
    assert (record["status"], len(record["points"])) == ("interrupted", 3)
    assert "was interrupted" in (tmp_path / "compare.html").read_text(encoding="utf-8")


def test_signals_that_are_ignored_stay_so():
    """SIGTERM must not go the way of a Ctrl-C that nobody hears, as in the background of a script."""
    with (
        handler(signal.SIGINT, signal.SIG_IGN),
        handler(signal.SIGHUP, signal.SIG_IGN),
        handler(signal.SIGTERM, signal.SIG_DFL),
    ):
        with signals.signals_as_ctrl_c() as received:
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGINT)
        assert received == [signal.SIGTERM]
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
