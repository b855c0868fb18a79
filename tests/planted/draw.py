"""Draws mutants of the code, weighted by code lines, and runs the tests that should see them.

    python -m tests.planted.draw --seed 1 --count 100 [--room src/geomint/run] [--row fast] …

A code line is drawn, and a change in it, or else in the function around it. The same seed gives the
same mutants as long as the code is the same.
"""

from __future__ import annotations

import ast
import random
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

from tests.planted.faults import ROOT
from tests.planted.run import Job, options, tell

OTHER: dict[type, tuple[str, str]] = {
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Lt: ("<", "<="), ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="), ast.GtE: (">=", ">"), ast.Eq: ("==", "!="), ast.NotEq: ("!=", "=="),
    ast.Is: ("is", "is not"), ast.IsNot: ("is not", "is"), ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
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


class Changes:
    """All changes of a module, and its code lines."""

    def __init__(self, source: bytes) -> None:
        self._source, self.found, self._names = source, list[Change](), list[str]()
        self._starts = [0, *accumulate(map(len, source.splitlines(keepends=True)))]
        self.lines = set[int]()
        self._visit(ast.parse(source))

    def _visit(self, node: Any) -> None:
        """Note what can be changed at a node, and go on inside of it."""
        named = getattr(node, "targets", [getattr(node, "test", None)])[0]
        if isinstance(node, SKIPPED) or getattr(named, "id", "") in ("__all__", "TYPE_CHECKING"):
            return
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return  # prose
        self.lines |= {node.lineno} if hasattr(node, "lineno") else set()
        own = [node.name] if isinstance(node, ast.FunctionDef | ast.ClassDef) else []
        self._names += own
        for kind, place, text in self._at(node):
            start, end = place if isinstance(place, tuple) else self._span(place)
            function = ".".join(self._names)
            self.found.append(Change(node.lineno, function, kind, start, end, text))
        for field, value in ast.iter_fields(node):
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST) and field not in ("annotation", "returns"):
                    self._visit(child)
        del self._names[len(self._names) - len(own) :]

    def _span(self, n: Any) -> tuple[int, int]:
        begin, end = self._starts[n.lineno - 1], self._starts[n.end_lineno - 1]
        return begin + n.col_offset, end + n.end_col_offset

    def _text(self, node: Any) -> bytes:
        return self._source[slice(*self._span(node))]

    def _operator(self, left: Any, operator: Any, right: Any) -> tuple[tuple[int, int], bytes]:
        """Return where an operator is, and the other one."""
        old, new = (word.encode() for word in OTHER[type(operator)])
        at = self._source.index(old, self._span(left)[1], self._span(right)[0])
        return (at, at + len(old)), new

    def _at(self, node: Any) -> Iterator[tuple[str, Any, bytes]]:
        """Yield the kinds of changes of a node, where they are made, and the new text."""
        match node:
            case ast.AugAssign(target=x, op=op, value=y) | ast.BinOp(left=x, op=op, right=y):
                if type(op) in OTHER and not (_is_text(x) or _is_text(y)):
                    yield "sign", *self._operator(x, op, y)
            case ast.UnaryOp(op=ast.USub(), operand=x):
                yield "sign", node, self._text(x)
            case ast.Compare(left=x, ops=[op], comparators=[y]):
                yield "comparison", *self._operator(x, op, y)
            case ast.Subscript(slice=ast.Constant(value=int()) | ast.BinOp() | ast.Name() as x):
                if len(getattr(x, "id", "i")) == 1:  # longer names may be those of keys
                    yield "index", x, self._text(x) + b" + 1"
            case ast.Expr(value=ast.Call()):
                yield "dropped call", node, b"pass"
            case ast.Call(args=[x], keywords=[]) if not isinstance(x, ast.Starred):
                yield "dropped call", node, b"(%b)" % self._text(x)
            case ast.Call(func=function, args=[x, y, *_]):
                starred = isinstance(x, ast.Starred) or isinstance(y, ast.Starred)
                if not starred and getattr(function, "id", "") not in UNCHANGED:
                    (start, middle), (rest, end) = self._span(x), self._span(y)
                    text = self._text(y) + self._source[middle:rest] + self._text(x)
                    yield "swapped", (start, end), text
            case ast.Constant(value=bool() | int() | float() as x):
                for other in [not x] if isinstance(x, bool) else [x + 1, x - 1]:
                    yield "constant", node, repr(other).encode()


def _is_text(node: Any) -> bool:
    return isinstance(node, ast.JoinedStr) or isinstance(getattr(node, "value", None), str | bytes)


def drawn(seed: int, count: int, room: str = "src") -> Iterator[Job]:
    """Yield mutants, all of them different."""
    rng, home, known = random.Random(seed), ROOT / room, set[tuple[Path, Change]]()
    paths = sorted(home.rglob("*.py")) if home.is_dir() else [home]
    changes = {path: Changes(path.read_bytes()) for path in paths}
    lines = [(path, line) for path in paths for line in sorted(changes[path].lines)]
    while len(known) < count:
        path, line = rng.choice(lines)
        found = changes[path].found
        here = [c for c in found if c.line == line]
        if not here:  # of the function that begins, or goes on, there
            function = max([c for c in found if c.line < line], default=None)
            here = [c for c in found if function and c.function == function.function]
        if here:
            kind = rng.choice(sorted({c.kind for c in here}))
            change = rng.choice([c for c in here if c.kind == kind])
            source = path.read_bytes()
            other = source[: change.start] + change.text + source[change.end :]
            if (path, change) not in known and is_other(source, other):
                known.add((path, change))
                yield _job(f"drawn-{seed}-{len(known)}", path, change, source, other)


def is_other(source: bytes, other: bytes) -> bool:
    """Tell whether a change is one, and leaves code."""
    try:
        return ast.dump(ast.parse(other)) != ast.dump(ast.parse(source))
    except SyntaxError:
        return False


def _job(name: str, path: Path, change: Change, source: bytes, other: bytes) -> Job:
    """Return what is to be run for a change."""
    inside = path.relative_to(ROOT)
    module = ".".join(inside.relative_to("src").with_suffix("").parts)
    begin = source.rfind(b"\n", 0, change.start) + 1
    ends = (source, change.end), (other, change.start + len(change.text))
    old, new = (x[begin : x.find(b"\n", end)].decode().strip() for x, end in ends)
    place = f"{module}:{change.function}"
    return Job(name, place, change.kind, old, new, inside, other.decode())


if __name__ == "__main__":
    parser = options("drawn.json")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--room", default="src", help="a folder or file below src")
    given = parser.parse_args()
    tell([*drawn(given.seed, given.count, given.room)], given)
