"""The runs of the command line: what is printed, the exit code, and the files that are written."""

import contextlib
import io
import json
import re
import shlex
import sys
import tempfile
from functools import partial
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import geomint as gi
from tests.kept.library import Runs

# Scenes with an early end, what section and scan look at, and the method of compare.
SCENES = """ball-3d --t-end=4 gamma[0] D=1:2:3 cf-4 | sphere-n3 --t-end=20 gamma[2] D=4:6:3 gauss-8
ellipsoid-n4 --t-end=4 x[0] a[1]=4:5:2 rattle-4 | neumann-n3 --t-end=10 q[0] strength=1:2:3 verlet-6
hamiltonized-n3 --tau-end=10 gamma[2] D=4:6:3 gauss-8
rolling-ball-n3 --t-end=10 g[0] m=2:3:2 gauss-8"""
ON_SCENES = """run {0} {1} --out run.nc | drift {0} {1} | check {0} | check {0} --for-drift
section {0} --event {2} --points 6 --motions 2 | scan {0} {1} --vary {3} --show final:{2},drift:energy
chaos {0} {1} --count 1 | compare {0} {1} --methods {4} --repeats 1 --paper
exact {0} --at 0,2.5 --out exact"""
ALONE = """--version | inertia --a 0.7,0.9,1.2,1.5 --m 2 --rho 1.5 | check ellipsoid-uneven
warm neumann-n3 --methods verlet-2 --quiet | check ball-3d --methods cf-4,gauss-8,rattle-2
drift neumann-n3 --t-end 40 --methods gauss-4,verlet-4:0.05,rk-4 --paper
drift hamiltonized-n3 --tau-end 20 --methods gauss-8,cf-4
run sphere-n3 --t-end 5 --step 0.25 --observe all --out run.nc
run veselova-n4 --t-end 20 --method auto --tolerance 1e-8 --out run.nc
scan neumann-n3 --draws 3 --seed 2 --t-end 5 --show final:q[0],exponent
section hamiltonized-n3 --event gamma[2] --exact --points 20 --direction up
stress --methods rk-4 --systems neumann --axis step --workers 1"""
QUICK = """--help | scenes | methods | inertia --moments 1,2,3 --d 1 | check ball-3d | drif | run ball-3
drift neumann-n3 --t-end 10 | exact hamiltonized-n3 --at 0,2.5 --out exact | exact ellipsoid-n4
run ball-3d --method gauss-99 | run ball-3d --step -1 | run ball-3d --t-end 1 --tau-end 1
drift neumann-n3 --methods gauss-8,gauss-8 | section ball-3d --event gamma[7] | run ball-3d --out
scan ball-3d --vary E=1:2:3 | exact hamiltonized-n3 --at x | inertia --moments 1,2
chaos ball-3d --count 99 | compare ball-3d --steps 0 | stress --methods no-such"""
NUMBER = r"\d[\d.]*(?:e[+-]?\d+)?"
TIMES = re.compile(  # where run times stand: a number and a unit of time, or a number under a key
    rf"(?<=steps in ){NUMBER} s \({NUMBER} a second\)|(?<=\(){NUMBER} seconds?(?=\))"
    rf"|{NUMBER}\u202f(?:ns|µs|ms|s)\b|(?<=seconds\": ){NUMBER}"
)
# Lines that are there or not by how long something takes, or whether it was compiled before.
NOTICE = re.compile(
    r"^(?:geomint: (?:compiling .*|building the scene …|planning …|timing …))?\n", re.M
)


def _told(command: str) -> dict[str, Any]:
    """Return all that a command leaves, without run times, versions and the machine."""
    (point,) = entry_points(group="console_scripts", name="geomint")
    out, errors, code, former = io.StringIO(), io.StringIO(), None, sys.argv
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            sys.argv = ["geomint", *shlex.split(command)]
            try:
                point.load()()
            except SystemExit as end:
                code = end.code
            finally:
                sys.argv = former
        files = {str(path): _file(path) for path in sorted(Path().rglob("*.*"))}
    texts = [_timeless(out.getvalue()), _timeless(NOTICE.sub("", errors.getvalue()))]
    return {"code": code, "output": texts[0], "messages": texts[1], "files": files}


def _file(path: Path) -> Any:
    """Return the text of a file, the data of a run; of pictures and pages only that they are there."""
    if path.suffix == ".nc":
        return gi.load(path)
    if path.suffix not in (".json", ".csv", ".tex", ".bib"):
        return "there"
    text = path.read_text("utf-8")
    if path.suffix == ".json":
        record = json.loads(text)
        place = record.get("provenance", {})
        for key in ("best", "versions", "cpu", "cores", "platform", "date"):  # best: the fastest
            own = json.dumps({key: record.get(key, place.get(key))}, indent=1, ensure_ascii=False)
            for told in (own[2:-2], own[2:-2].replace("\n", "\n ")):
                text = text.replace(told, f' "{key}": <machine>')
    separator = {".csv": ",", ".tex": "&"}.get(path.suffix)
    return _timeless(_without_seconds(text, separator) if separator else text)


def _without_seconds(text: str, separator: str) -> str:
    """Return a table with marks in columns whose heads say that they are run times."""
    rows = [line.split(separator) for line in text.splitlines()]
    head = next((row for row in rows if len(row) > 1), [])
    timed = {k for k, cell in enumerate(head) if "seconds" in cell or "(s)" in cell}
    for row in rows[rows.index(head) + 1 :] if timed else ():
        row[:] = ["<time>" if k in timed else cell for k, cell in enumerate(row)]
    return "\n".join(separator.join(row) for row in rows)


def _timeless(text: str) -> str:
    """Return a text with marks for run times; then columns of tables are as wide as they may be."""
    text, count = TIMES.subn("<time>", text)
    return re.sub(r" {2,}|─+", "  ", text) if count else text


def _listed(text: str) -> list[str]:
    return [each.strip() for each in re.split(r"[|\n]", text)]


def commands() -> Runs:
    """Every command on six scenes, and alone."""
    on_scenes = [f.format(*words.split()) for f in _listed(ON_SCENES) for words in _listed(SCENES)]
    for command in on_scenes + _listed(ALONE):
        yield command, partial(_told, command)


def quick_commands() -> Runs:
    """Some of them, and what is refused."""
    for command in _listed(QUICK):
        yield command, partial(_told, command)


PARTS = (commands, quick_commands)
