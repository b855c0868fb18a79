"""The weight of the project only falls: its numbers are at the ceilings of `weight.toml`.

    python .ci/weight.py                  fails where a number is above or below its ceiling
    python .ci/weight.py --lower          writes the ceilings that fell, never a higher one
    python .ci/weight.py --raise WORDS    writes higher ceilings too; WORDS: what was deleted for them

Code lines are lines with tokens, without blanks, comments and docstrings; tokens are those of these
lines. Code can hide in other folders, data and templates: they have ceilings too, by lines that are
not blank, words and signs. Prose, pictures and measurements weigh nothing. A ceiling above that of
the last commit, or of the one before it, needs a new line in `raised`.
"""

import argparse
import ast
import datetime
import io
import json
import re
import subprocess
import sys
import tokenize
import tomllib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parents[1]
CEILINGS = ROOT / ".ci" / "weight.toml"
HEAD = "# Written by `python .ci/weight.py`, not by hand.\n"
FOLDERS = ("src", "tests", "benchmarks")
PARTS = [f"{place}{kind}" for kind in ("", "-data") for place in (*FOLDERS, "elsewhere")]
UNITS = ("files", "lines", "tokens")
NUMBERS = [(part, unit) for part in PARTS for unit in UNITS]
WEIGHTLESS = ["*.md", "*.rst", "*.ipynb", "*.png", "*.svg", "*.gif", "/benchmarks/results"]
WEIGHTLESS += ["/.ci/weight.toml", "/tests/surface.txt"]
DOCUMENTED = (ast.Module, ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
LAYOUT = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)

Weights = dict[str, dict[str, int]]


def sources() -> Iterator[Path]:
    """Yield the files that weigh something, without what git ignores."""
    ignored = (ROOT / ".gitignore").read_text("utf-8").split()
    patterns = [pattern.rstrip("/") for pattern in ignored] + WEIGHTLESS
    for top in ROOT.iterdir():
        if top.name == ".ci" or not top.name.startswith("."):
            for path in (top, *top.rglob("*")):
                place = PurePosixPath("/", path.relative_to(ROOT).as_posix())
                skipped = any(
                    p.match(pattern) for p in (place, *place.parents) for pattern in patterns
                )
                if path.is_file() and not skipped:
                    yield path


def docstrings(tree: ast.Module) -> set[int]:
    """Return the lines of docstrings."""
    lines: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            lines.update(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    return lines


def weigh(source: str) -> tuple[int, int]:
    """Return code lines and tokens of a Python file; a formatted string is one token."""
    prose, lines, tokens, depth = docstrings(ast.parse(source)), set[int](), 0, 0
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type in LAYOUT or token.start[0] in prose or token.type == tokenize.ENDMARKER:
            continue
        kind = tokenize.tok_name[token.type]  # FSTRING_START from Python 3.12 on
        depth -= kind.endswith("STRING_END")
        tokens += depth == 0 and not kind.endswith("STRING_END")
        depth += kind.endswith("STRING_START")
        lines.update(range(token.start[0], token.end[0] + 1))
    return len(lines), tokens


def weights() -> Weights:
    """Return the numbers of every part."""
    found = {part: dict.fromkeys(UNITS, 0) for part in PARTS}
    for path in sources():
        top, text = path.relative_to(ROOT).parts[0], path.read_text("utf-8", errors="replace")
        lines = [line for line in text.splitlines() if line.strip()]
        numbers = len(lines), len(re.findall(r"\w+|[^\w\s]", text))
        if path.suffix == ".py":
            numbers = weigh(text)
        row = found[(top if top in FOLDERS else "elsewhere") + "-data" * (path.suffix != ".py")]
        for unit, number in zip(UNITS, (1, *numbers), strict=True):
            row[unit] += number
    return found


def unsaid(ceilings: Weights, raised: list[str]) -> Iterator[str]:
    """Yield the ceilings above those of a commit without a line that says why."""
    for commit in ("HEAD", "HEAD^"):
        shown = subprocess.run(
            ["git", "show", f"{commit}:./.ci/weight.toml"],
            cwd=ROOT,
            capture_output=True,
            check=False,
        )
        before = tomllib.loads(shown.stdout.decode())
        new = "\n".join(line for line in raised if line not in before.get("raised", ()))
        for part, unit in NUMBERS if before else ():
            to = re.findall(rf" {part} {unit} \d+ → (\d+)(?:, [^:]*)?: \S", new)
            if ceilings[part][unit] > max([before[part][unit], *map(int, to)]):
                yield f"{part} {unit}: the ceiling was raised since {commit} without words"


def faults(found: Weights, ceilings: Weights) -> Iterator[str]:
    """Yield the numbers that are not at their ceilings."""
    for part, unit in NUMBERS:
        number, ceiling = found[part][unit], ceilings[part][unit]
        if number > ceiling:
            yield f"{part} {unit}: {number}, above the ceiling {ceiling}"
        elif number < ceiling:
            yield f"{part} {unit}: {number}, below the ceiling {ceiling}: --lower writes it"


def write(found: Weights, ceilings: Weights, raised: list[str], words: str) -> None:
    """Write the ceilings that fell; with words, those that rose too."""
    risen = []
    for part, unit in NUMBERS:
        number, ceiling = found[part][unit], ceilings[part][unit]
        if number > ceiling:
            risen.append(f"{part} {unit} {ceiling} → {number}")
        if number < ceiling or words:
            ceilings[part][unit] = number
    if risen and words:
        raised.append(f"{datetime.date.today()} {', '.join(risen)}: {words}")
    rows = [HEAD, f"raised = {json.dumps(raised, ensure_ascii=False, indent=4)}\n"]
    for part, numbers in ceilings.items():
        rows.append("\n".join([f"\n[{part}]", *(f"{u} = {n}" for u, n in numbers.items()), ""]))
    CEILINGS.write_text("".join(rows), "utf-8")


def main() -> None:
    """Compare, or write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--lower", action="store_true")
    parser.add_argument("--raise", dest="words", metavar="WORDS", type=str.strip, default="")
    given = parser.parse_args()
    ceilings = tomllib.loads(CEILINGS.read_text("utf-8"))
    raised, found = ceilings.pop("raised"), weights()
    if given.lower or given.words:
        write(found, ceilings, raised, given.words)
    sys.exit("\n".join([*faults(found, ceilings), *unsaid(ceilings, raised)]) or None)


if __name__ == "__main__":
    main()
