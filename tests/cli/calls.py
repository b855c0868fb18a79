"""Commands in this process, and in one of their own."""

from __future__ import annotations

import importlib.metadata
import json
import os
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main

__all__ = ["alone", "by_fixed_point", "content", "install", "invoke", "offer", "session"]

SESSION = """
import json, sys
from click.testing import CliRunner
from geomint.cli import main

def said(line):
    result = CliRunner().invoke(main, line.split(), env={"COLUMNS": "400"})
    return result.exit_code, result.stdout, result.stderr

told = {line: said(line) for line in sys.argv[2:]}
exec(sys.argv[1])
print(json.dumps(told))
"""


def invoke(*arguments: Any, columns: str = "120", **given: Any) -> Any:
    given = {"env": {"COLUMNS": columns}, **given}
    return CliRunner().invoke(main, [str(a) for a in arguments], **given)


def alone(folder: Path, *words: str, call: tuple[str, ...] = ("-m", "geomint"), **more: str) -> Any:
    """Run a command in a process of its own, in a folder; packages that lie there are installed."""
    paths = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": paths, **more}
    return subprocess.run(
        [sys.executable, *call, *words],
        **{"cwd": folder, "env": environment, "capture_output": True, "text": True, "check": False},
    )


def session(
    folder: Path, *lines: str, then: str = "", **more: str
) -> dict[str, tuple[int, str, str]]:
    """Return what command lines say, one after the other in one process, and do something `then`."""
    done = alone(folder, then, *lines, call=("-c", SESSION), **more)
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout.splitlines()[-1]))


def offer(monkeypatch: pytest.MonkeyPatch, group: str, name: str, thing: Any) -> None:
    """Let this be all that packages offer geomint."""
    others = importlib.metadata.entry_points

    class Point(EntryPoint):
        def load(self) -> Any:
            return thing

    def entry_points(**given: Any) -> Any:
        if "geomint" not in given.get("group", ""):
            return others(**given)
        return [Point(name, "other.package:THING", group)] if given["group"] == group else []

    monkeypatch.setattr(importlib.metadata, "entry_points", entry_points)


def install(folder: Path, name: str, entries: dict[str, dict[str, str]], title: str = "") -> None:
    """Write what pip would of a package with these entry points, group by group."""
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir(parents=True)
    words = f"Metadata-Version: 2.1\nName: {title or name}\nVersion: 1.0\n"
    (info / "METADATA").write_bytes(words.encode("latin-1"))
    lines = (
        f"[geomint.{group}]\n" + "".join(f"{key} = {value}\n" for key, value in of.items())
        for group, of in entries.items()
    )
    (info / "entry_points.txt").write_text("".join(lines), "utf-8")


def by_fixed_point(folder: Path) -> Path:
    """Write the scene sphere-n3 without Newton's method, so that long steps fail; return the file."""
    scene = gi.load_scene("sphere-n3")
    file = folder / "sphere-n3.toml"
    integrate = {"integrate": {"iteration": "fixed-point"}}
    file.write_text(scene.changed(**integrate).toml(), "utf-8")
    return file


def content(path: Path) -> dict[str, bytes]:
    files = [path] if path.is_file() else sorted(path.iterdir())
    return {file.name: file.read_bytes() for file in files}
