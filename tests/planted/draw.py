"""Draws mutants of the code, weighted by code lines, and runs the tests that should see them.

    python -m tests.planted.draw --seed 1 --count 100 [--room src/geomint/run] [--row fast] …

A code line is drawn, and a change in it, or else in the function around it. The same seed gives the
same mutants as long as the code is the same.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import io
import random
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from tests.planted.faults import ROOT
from tests.planted.run import Job, options, tell

FIRST = {  # the folders that run first, where they have not the name of the room
    "arguments": "asked", "errors": "outputs asked", "kernels": "methods kernels run",
    "kernels.compiling": "kernels sending", "kernels.groups": "kernels spaces methods",
    "kernels.numbers": "kernels", "kernels.tangent": "measure kernels run", "plan": "scene cli",
    "plots": "report pictures", "problems": "declaring methods spaces run", "problems.spaces": "spaces",
    "references": "report", "run": "run scene", "run.ensemble": "ensemble",
    "run.exact": "methods/test_exact_roots.py chaplygin", "run.files": "outputs cli",
    "run.storage": "outputs", "scipy": "methods/test_scipy.py", "tableaux": "tableaux methods",
    "testing": "spaces watch", "watch": "watch report",
}  # fmt: skip
SIGNS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+")}
ORDERS = {
    ast.Lt: ("<", "<="), ast.LtE: ("<=", "<"), ast.Gt: (">", ">="), ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="), ast.NotEq: ("!=", "=="), ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"), ast.In: ("in", "not in"), ast.NotIn: ("not in", "in"),
}  # fmt: skip
SKIPPED = (ast.Import, ast.ImportFrom, ast.JoinedStr, ast.Raise)
UNCHANGED = {"isinstance", "issubclass", "hasattr", "getattr", "setattr", "cast", "TypeVar"}


class Change(NamedTuple):
    """Other text in place of bytes of a file."""

    line: int
    function: str
    kind: str
    start: int
    end: int
    text: bytes


class Changes(ast.NodeVisitor):
    """Finds all changes of a module."""

    def __init__(self, source: bytes) -> None:
        self._source, self.found, self._names = source, list[Change](), list[str]()
        lines = source.splitlines(keepends=True)
        self._starts = [sum(map(len, lines[:k])) for k in range(len(lines) + 1)]
        self.visit(ast.parse(source))

    def visit(self, node: Any) -> None:
        """Note what can be changed at a node, and go on inside of it."""
        if isinstance(node, SKIPPED) or _of_typing(node):
            return
        name = getattr(node, "name", "") if isinstance(node, ast.FunctionDef | ast.ClassDef) else ""
        self._names += [name] if name else []
        for kind, place, text in self._at(node):
            start, end = place if isinstance(place, tuple) else self._span(place)
            own = ".".join(self._names)
            self.found.append(Change(node.lineno, own, kind, start, end, text))
        for field, value in ast.iter_fields(node):
            if field not in ("annotation", "returns"):
                for child in value if isinstance(value, list) else [value]:
                    if isinstance(child, ast.AST):
                        self.visit(child)
        del self._names[len(self._names) - bool(name) :]

    def _span(self, node: ast.AST) -> tuple[int, int]:
        n: Any = node
        begin, end = self._starts[n.lineno - 1], self._starts[n.end_lineno - 1]
        return begin + n.col_offset, end + n.end_col_offset

    def _text(self, node: ast.AST) -> bytes:
        return self._source[slice(*self._span(node))]

    def _between(self, left: ast.AST, right: ast.AST, old: str, new: str) -> tuple[Any, bytes]:
        """Return where an operator is, and the other one."""
        start, end = self._span(left)[1], self._span(right)[0]
        at = self._source.index(old.encode(), start, end)
        return (at, at + len(old)), new.encode()

    def _at(self, node: ast.AST) -> Iterator[tuple[str, Any, bytes]]:
        match node:
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub() as op, right=right):
                if not (_is_text(left) or _is_text(right)):
                    yield "sign", *self._between(left, right, *SIGNS[type(op)])
            case ast.AugAssign(target=left, op=ast.Add() | ast.Sub() as op, value=right):
                if not _is_text(right):
                    yield "sign", *self._between(left, right, *SIGNS[type(op)])
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                yield "sign", node, self._text(operand)
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                yield "comparison", *self._between(left, right, *ORDERS[type(op)])
            case ast.Subscript(slice=ast.Constant(value=int()) | ast.BinOp() as index):
                yield "index", index, self._text(index) + b" + 1"
            case ast.Subscript(slice=ast.Name(id=name) as index) if len(name) == 1:
                yield "index", index, self._text(index) + b" + 1"
            case ast.Expr(value=ast.Call()):
                yield "dropped call", node, b"pass"
            case ast.Call(args=[one], keywords=[]) if not isinstance(one, ast.Starred):
                yield "dropped call", node, b"(%b)" % self._text(one)
            case ast.Call(func=function, args=[one, two, *_]):
                starred = isinstance(one, ast.Starred) or isinstance(two, ast.Starred)
                if not starred and getattr(function, "id", "") not in UNCHANGED:
                    (start, _), (_, end) = self._span(one), self._span(two)
                    middle = self._source[self._span(one)[1] : self._span(two)[0]]
                    text = self._text(two) + middle + self._text(one)
                    yield "swapped", (start, end), text
            case ast.Constant(value=bool() | int() | float() as value):
                others = [not value] if isinstance(value, bool) else [value + 1, value - 1]
                for other in others:
                    yield "constant", node, repr(other).encode()


def _of_typing(node: ast.AST) -> bool:
    """Tell whether nothing of a statement is run, but by who checks types or reads names."""
    if isinstance(node, ast.If):
        return getattr(node.test, "id", "") == "TYPE_CHECKING"
    targets = node.targets if isinstance(node, ast.Assign) else []
    return any(getattr(target, "id", "") == "__all__" for target in targets)


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or isinstance(getattr(node, "value", None), str | bytes)


def code_lines(source: bytes) -> list[int]:
    """Return the lines with code, without those of strings that are statements."""
    prose = set[int]()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            prose.update(range(node.lineno, (node.end_lineno or 0) + 1))
    tokens = tokenize.tokenize(io.BytesIO(source).readline)
    kinds = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)
    left_out = (*kinds, tokenize.ENCODING, tokenize.ENDMARKER)
    return sorted({t.start[0] for t in tokens if t.type not in left_out} - prose)


def drawn(seed: int, count: int, room: str = "src") -> Iterator[Job]:
    """Yield mutants, all of them different."""
    rng, home, known = random.Random(seed), ROOT / room, set[tuple[Path, Change]]()
    paths = sorted(home.rglob("*.py")) if home.is_dir() else [home]
    lines = [(path, line) for path in paths for line in code_lines(path.read_bytes())]
    changes_of = functools.cache(lambda path: Changes(path.read_bytes()).found)
    while len(known) < count:
        path, line = rng.choice(lines)
        here = [c for c in changes_of(path) if c.line == line]
        if not here:  # of the function that begins, or goes on, there
            before = [c for c in changes_of(path) if c.line < line]
            function = max(before).function if before else ""
            here = [c for c in changes_of(path) if c.function == function]
        if not here:
            continue
        kind = rng.choice(sorted({c.kind for c in here}))
        change = rng.choice([c for c in here if c.kind == kind])
        job = _job(f"drawn-{seed}-{len(known) + 1}", path, change)
        if job is not None and (path, change) not in known:
            known.add((path, change))
            yield job


def _job(name: str, path: Path, change: Change) -> Job | None:
    """Return what is to be run for a change, or nothing if it is none, or no code."""
    source, inside = path.read_bytes(), path.relative_to(ROOT)
    other = source[: change.start] + change.text + source[change.end :]
    with contextlib.suppress(SyntaxError):
        if ast.dump(ast.parse(other)) != ast.dump(ast.parse(source)):
            package, *parts = inside.relative_to("src").with_suffix("").parts
            rooms = [".".join(parts[:k]) for k in range(len(parts), 0, -1)]
            own = package if package == "chaplygin" and parts[0] != "stress" else parts[0]
            own = own if (ROOT / "tests" / own).is_dir() else "cli"
            folders = next(
                (FIRST[room] for room in rooms if own != "chaplygin" and room in FIRST), own
            )
            begin = source.rfind(b"\n", 0, change.start) + 1
            ends = (source, change.end), (other, change.start + len(change.text))
            old, new = (x[begin : x.find(b"\n", end)].decode().strip() for x, end in ends)
            place = f"{package}.{rooms[0]}:{change.function}"
            told = place, change.kind, old, new, inside, other.decode()
            return Job(name, *told, tuple(folders.split()))
    return None


if __name__ == "__main__":
    parser = options("drawn.json")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--room", default="src", help="a folder or file below src")
    given = parser.parse_args()
    tell([*drawn(given.seed, given.count, given.room)], given)
