"""Run what the pages show. ``python -m tests.pages.session NAME …`` writes new outputs into pages."""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from click.testing import CliRunner
from llvmlite.binding import get_host_cpu_features

import geomint as gi
from geomint.cli import main
from tests.pages.blocks import Command, blocks, commands, examples, page, rewrite

WIDTH = "100"  # columns of the terminal that pages show
SLOW = ("drift", "compare", "exact", "audit", "stress")
NOT_RUN = ("pip", "python -m venv", "geomint check bad.toml")

# What a command says of itself where it takes long: not on a fast machine, nor with code in a cache.
PATIENCE = re.compile(r"geomint: (.* …|compiling .*)$")
# Pages are written on a processor with AVX-512, by linear algebra made for it. Others round initial
# states in another way: roundings are others, and so are iterations.
WRITTEN_HERE = get_host_cpu_features().get("avx512f") and "OPENBLAS_CORETYPE" not in os.environ
NEAR = 0.1
_SMALL = r"e[−-](?:1[3-9]|[2-9]\d)"
_ROUNDINGS = re.compile(rf"\([−-]?[\d.]+ ± [\d.]+\){_SMALL}|[−-]?[\d.]+{_SMALL}")
_LOCAL = re.compile(r"^ *local error: [\d.e+-]+, at (?:t|τ|tau) = [\d.e+-]+$")
_TIMES = re.compile(r"in [\d.e+-]+ s \([\d.e+-]+ a second\)")


def without_times(lines: Sequence[str]) -> list[str]:
    """Return lines of output as they are compared; of a long run time tells which steps are ranked."""
    timeless = (_TIMES.sub("in … s", line.rstrip()) for line in lines)
    return [_LOCAL.sub("local error: …", line) for line in timeless]


def is_slow(command: str) -> bool:
    """Tell whether a command takes more than a moment."""
    return command.startswith(tuple(f"geomint {name}" for name in SLOW))


def run_command(text: str, folder: Path) -> list[str]:
    """Return what a command prints, both streams in their order; geomint's run in this process."""
    words = shlex.split(text)
    if words[0] != "geomint":
        return subprocess.check_output(["bash", "-c", text], cwd=folder, text=True).splitlines()
    with contextlib.chdir(folder), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = CliRunner().invoke(main, words[1:], env={"COLUMNS": WIDTH})
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    lines = [line.rstrip() for line in result.output.splitlines()]
    shown = [line for line in lines if not PATIENCE.match(line)]
    return "\n".join(shown).strip("\n").splitlines()


def save_files(name: str, folder: Path) -> None:
    """Write the TOML of a page under the names that its text, or the next command, gives them."""
    found = blocks(page(name))
    for i, block in enumerate(found):
        if block.info != "toml":
            continue
        later = [b.text for b in found[i + 1 : i + 3] if b.info == "console"]
        named = re.search(r"`([\w-]+\.toml)`", block.near) or re.search(
            r"geomint \w+ ([\w-]+\.toml)", "\n".join(later)
        )
        if named:
            (folder / named.group(1)).write_text(block.text, encoding="utf-8")


def outputs(name: str, folder: Path, slow: bool) -> list[tuple[Command, list[str]]]:
    """Run the commands of a page; the slow ones only if wanted."""
    save_files(name, folder)
    found = []
    for command in commands(page(name)):
        if command.text.startswith(NOT_RUN) or (is_slow(command.text) and not slow):
            continue
        found.append((command, run_command(command.text, folder)))
    return found


def printed(source: str, scope: dict[str, Any], path: str, line: int) -> str:
    """Run a block of Python in a namespace; return what it prints, and its warnings after that."""
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        exec(compile("\n" * (line + 1) + source, path, "exec"), scope)
    told = [f"{w.category.__name__}: {w.message}" for w in caught]
    return stream.getvalue() + "".join(f"{text}\n" for text in told)


def same(shown: Sequence[str], got: Sequence[str]) -> bool:
    """Compare lines but for times; a line … stands for any others."""
    lines = without_times("\n".join(shown).rstrip().splitlines())
    pattern = "\n".join(".*" if line == "…" else re.escape(line) for line in lines)
    found = "\n".join(without_times(got)).rstrip()
    if re.fullmatch(pattern, found, re.DOTALL):
        return True
    return not WRITTEN_HERE and "…" not in lines and alike("\n".join(lines), found)


def alike(shown: str, got: str) -> bool:
    """Compare words: numbers to a tenth, and any that are roundings."""
    words = [_ROUNDINGS.sub("0", text).split() for text in (shown, got)]
    return len(words[0]) == len(words[1]) and all(map(_near, *words))


def _near(one: str, other: str) -> bool:
    if one == other:
        return True
    try:
        x, y = (float(word.replace("−", "-").strip("(),;:")) for word in (one, other))
    except ValueError:
        return False
    return abs(x - y) <= NEAR * max(abs(x), abs(y))


def write(name: str) -> None:
    """Write the outputs of all commands and of all Python of a page into it."""
    path, changes = page(name), []
    with tempfile.TemporaryDirectory() as folder:
        for command, lines in outputs(name, Path(folder), slow=True):
            if command.output and "…" not in command.output:
                at, count = command.line + 1, len(command.output)
                if not same(command.output, lines):
                    changes.append((at, count, command.indent, "\n".join(lines)))
        scope: dict[str, Any] = {"__name__": "page"}
        with contextlib.chdir(folder):
            for example in examples(path):
                text = printed(example.source, scope, str(path), example.line)
                if example.output is not None:
                    shown = example.output
                    count = len(shown.text.splitlines())
                    changes.append((shown.line + 1, count, shown.indent, text.rstrip("\n")))
    rewrite(path, changes)


if __name__ == "__main__":
    for given in sys.argv[1:]:
        try:
            write(given)
        except gi.GeomintError as error:
            sys.exit(f"{given}: {error}")
