"""Command lines that nobody means, in a folder where something can be lost, or run.

The folder holds scenes and links to them, saved runs, a report, files of the user's, and runs with
code that makes the folder `saved.MARK`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from random import Random
from typing import NamedTuple

from tests.fuzz import hostile, saved
from tests.fuzz.judge import Judged, command_verdict
from tests.fuzz.scenes import mutated_text, originals, short, toml_text

__all__ = ["line_verdict"]

WRITING = ("run", "drift", "compare", "scan", "section", "chaos", "exact")
COMMANDS = (*WRITING, *("run", "check") * 6, "warm", "scenes", "methods", "inertia")
OPTIONS = {
    "--method": ("gauss-2", "rk-4", "auto", "verlet-2"), "--methods": ("gauss-2,rk-4:0.1", "rk-4"),
    "--step": ("0.1", "0.05"), "--tolerance": ("1e-3",), "--t-end": ("0.3",), "--tau-end": ("0.3",),
    "--representation": ("own", "ball", "reduced"), "--observe": ("energy", "all", "energy,K"),
}  # fmt: skip
FLAGS = ("--quiet", "--yes", "--paper", "--debug", "--help", "--version")
NEW = ("new.nc", "new.csv", "new", "new/deeper/run.nc", "notes/run.nc", "notes", ".")
AWAY = ("/", "..", "../a")
HOSTILE = (
    *(t for t in hostile.STRINGS if len(t) < 300 and "\0" not in t and t not in AWAY),
    *("-", "--", "-1", "/dev/null", "/dev/full", "/proc/self/mem", "\udcff.nc", "1e400", "nan"),
)


@cache
def _original() -> Path:
    """Make the folder that each case gets a copy of."""
    folder = Path(tempfile.mkdtemp(prefix="geomint-fuzz-"))
    scene = toml_text(short(originals()["sphere-n3"]))
    for place in ("notes", "report"):
        (folder / place).mkdir()
    for name in ("scene.toml", "other.toml", "scene.nc", "scene.csv", "notes/drift.toml"):
        (folder / name).write_text(scene, "utf-8")
    (folder / "broken.toml").write_text("[system", "utf-8")
    for name in ("notes/thesis.txt", "notes/report.html", "run.partial", ".geomint-notes"):
        (folder / name).write_text("two years of work", "utf-8")
    (folder / "plain.nc").write_bytes(saved.genuine())
    (folder / "evil.nc").write_bytes(saved.with_code())
    return folder


def _folder(place: Path, rng: Random) -> Path:
    """Make a copy, with the links that a copy would not keep."""
    folder = place / "work"
    shutil.copytree(_original(), folder)
    (folder / "mutated.toml").write_bytes(mutated_text(rng, run=True))
    for name, target in {
        "soft.toml": "scene.toml",
        "soft.nc": "scene.toml",
        "soft.csv": "notes/thesis.txt",
        "away": "notes",
        "loop": "loop",
        "gone.nc": "nowhere/run.nc",
    }.items():
        (folder / name).symlink_to(target)
    for name in ("hard.nc", "report/drift.csv", "report/report.html", "report/runs.csv"):
        os.link(folder / "scene.toml", folder / name)
    return folder


def _line(rng: Random, folder: Path) -> list[str]:
    """Return the arguments of a command that may overwrite, remove or run what is in the folder."""
    names = [str(path.relative_to(folder)) for path in sorted(folder.rglob("*"))]
    paths = [*names, *(f"notes/../{name}" for name in names), *(str(folder / n) for n in names)]
    scenes = [p for p in paths if p.endswith((".toml", "scene.nc", "scene.csv", "hard.nc"))]
    command = rng.choice(COMMANDS)
    line = [command]
    if command not in ("scenes", "methods", "inertia") or rng.random() < 0.1:
        line.append(rng.choice(rng.choice((scenes,) * 6 + (paths, HOSTILE))))
    if command in WRITING and rng.random() < 0.8:
        same = [*line[1:], *(f"./{path}" for path in line[1:])] or NEW
        line += ["--out", rng.choice(rng.choice((paths, paths, NEW, same, HOSTILE)))]
    for name in rng.sample(sorted(OPTIONS), rng.choice((0, 0, 0, 1, 2))):
        line += [name, rng.choice(rng.choice((OPTIONS[name],) * 3 + (HOSTILE,)))]
    line += rng.sample(FLAGS, rng.choice((0, 0, 1, 2)))
    if rng.random() < 0.05:
        rng.shuffle(line)
    return line


class Seen(NamedTuple):
    """What is at a path: the kind, the content or where a link leads, and the file's number."""

    kind: str
    content: bytes
    number: int = 0


def _state(folder: Path) -> dict[Path, Seen]:
    found = {}
    for path in folder.rglob("*"):
        if path.is_symlink():
            found[path] = Seen("link", os.fsencode(os.readlink(path)))
        elif path.is_dir():
            found[path] = Seen("folder", b"")
        elif path.is_file():
            found[path] = Seen("file", path.read_bytes(), path.stat().st_ino)
    return found


def _losses(line: list[str], folder: Path, before: dict[Path, Seen]) -> Iterator[str]:
    """Yield what was there and is not, unless it is what the command was to write."""
    out = [line[i + 1] for i in range(len(line) - 1) if line[i] == "--out"]
    places = {Path(os.path.realpath(folder / path)) for path in out if "\0" not in path}
    if not out and len(line) > 1:
        places.add(folder / f"{Path(line[1]).stem}.nc")  # the default of `run`
    inputs = {_number(folder, path) for path in line if path not in out}
    if line[1:2] == out[:1]:
        inputs |= {_number(folder, path) for path in out}
    after = _state(folder)
    for path, was in before.items():
        now = after.get(path)
        if now is None or now.kind != was.kind:
            yield f"{path.name} is no {was.kind} any more"
        elif now.content != was.content:
            if was.number in inputs:
                yield f"{path.name} was an input and has changed"
            elif not places & {path, path.parent}:
                yield f"{path.name} has changed"


def _number(folder: Path, path: str) -> int:
    try:
        return (folder / path).stat().st_ino
    except (OSError, ValueError):
        return -1


def line_verdict(rng: Random, seconds: float) -> Judged:
    """Return the verdict on a command line; one of twenty runs in a process of its own."""
    with tempfile.TemporaryDirectory() as name:
        folder = _folder(Path(os.path.realpath(name)), rng)
        line, before = _line(rng, folder), _state(folder)
        if rng.random() < 0.05:
            found = _alone(line, folder)
        else:
            found = command_verdict(line, folder, seconds)[0]
        detail = f"{line}: {found.detail}"
        if lost := list(_losses(line, folder, before)):
            return Judged("deletion", f"{', '.join(lost)}: {detail}")
        if any(folder.rglob(saved.MARK)):
            return Judged("execution", detail)
        return Judged(found.verdict, detail)


def _alone(line: list[str], folder: Path) -> Judged:
    command = [sys.executable, "-m", "geomint", *line]
    ended = subprocess.run(
        command, cwd=folder, capture_output=True, stdin=subprocess.DEVNULL, timeout=600
    )
    told = ended.stderr.decode("utf-8", "replace")
    if ("Traceback" in told and "--debug" not in line) or ended.returncode not in (0, 1, 2, 130):
        return Judged("traceback", f"code {ended.returncode}: {told[-300:]}")
    return Judged("typed" if ended.returncode else "ok", told[-200:])
