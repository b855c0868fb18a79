"""The check of the weight fails where something was added, moved out of sight, or taken away."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

pytestmark = pytest.mark.nightly
WEIGHT = Path(__file__).parents[1] / ".ci" / "weight.py"
FILES = {
    ".gitignore": "__pycache__/\n/docs/_build/\n",
    "src/package/a.py": 'def f(x):\n    """Prose."""\n    y = [x, 1]  # comment\n    return y\n',
    "src/package/page.html.j2": "<p>{{ title }}</p>\n",
    "docs/page.md": "Words.\n",
    ".ci/weight.toml": (WEIGHT.parent / "weight.toml").read_text("utf-8"),
}


class Tree:
    """A small project under git."""

    def __init__(self, root: Path) -> None:
        self.root = root
        for name, text in FILES.items():
            self.write(name, text)
        shutil.copy(WEIGHT, root / ".ci")
        self.git("init", "-q")
        assert not self.check("--raise", "the beginning")
        self.commit()

    def write(self, name: str, text: str) -> None:
        (self.root / name).parent.mkdir(parents=True, exist_ok=True)
        (self.root / name).write_text(text, "utf-8")

    def change(self, name: str, old: str, new: str) -> None:
        text = (self.root / name).read_text("utf-8")
        assert old in text
        self.write(name, text.replace(old, new))

    def git(self, *words: str) -> None:
        who = ("-c", "user.name=a", "-c", "user.email=a@b")
        subprocess.run(["git", *who, *words], cwd=self.root, check=True)

    def commit(self) -> None:
        self.git("add", ".")
        self.git("commit", "-q", "-m", "Words")

    def check(self, *options: str) -> list[str]:
        """Return what the check finds."""
        run = [sys.executable, ".ci/weight.py", *options]
        done = subprocess.run(run, cwd=self.root, capture_output=True, text=True, check=False)
        assert bool(done.returncode) == bool(done.stderr)
        return done.stderr.splitlines()


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    return Tree(tmp_path)


A = "src/package/a.py"
CHANGES: dict[str, tuple[Callable[[Tree], None], list[str]]] = {
    "a file": (lambda t: t.write("src/b.py", ""), ["src files: 2, above"]),
    "a token": (lambda t: t.change(A, "[x, 1]", "[x, 10, 2]"), ["src tokens: 17, above"]),
    "moved to docs": (
        lambda t: (t.root / A).rename(t.root / "docs/a.py"),
        ["src files: 0, below", "elsewhere files: 2, above"],
    ),
    "moved to a template": (
        lambda t: (
            t.change(A, "    y = [x, 1]  # comment\n", ""),
            t.change("src/package/page.html.j2", "title }}", "[x, 1] }}"),
        ),
        ["src lines: 2, below", "src-data tokens: 16, above"],
    ),
    "moved to data": (lambda t: t.write("docs/a.json", "[1]"), ["elsewhere-data files: 1, above"]),
    "less": (lambda t: t.change(A, ", 1]", "]"), ["src tokens: 13, below"]),
    "raised by hand": (
        lambda t: (
            t.change(A, "[x, 1]", "[x, 1, 2]"),
            t.change(".ci/weight.toml", "tokens = 15", "tokens = 17"),
        ),
        ["src tokens: the ceiling was raised since HEAD without words"],
    ),
}


@pytest.mark.parametrize("name", CHANGES)
def test_what_the_check_finds(name: str, tree: Tree) -> None:
    change, told = CHANGES[name]
    change(tree)
    found = tree.check()
    for line in told:
        assert any(fault.startswith(line) for fault in found), found


def test_what_weighs_nothing(tree: Tree) -> None:
    tree.change("docs/page.md", "Words", "More words")
    tree.change(A, "Prose.", "Much\n    more.")
    tree.write("docs/_build/a.js", "f(1)\n")
    assert not tree.check()


def test_lower_never_raises(tree: Tree) -> None:
    tree.change(A, "x", "longer_name")
    tree.change(A, "    return y\n", "    return [*y, 2]\n")
    tree.change("src/package/page.html.j2", "{{ title }}", "")
    above = ["src tokens: 20, above the ceiling 15"]
    assert tree.check("--lower") == above == tree.check()


def test_words_raise_a_ceiling_once(tree: Tree) -> None:
    tree.change(A, "    return", "    z = 2\n    return")
    assert not tree.check("--raise", "nothing, but it is short")
    assert not tree.check()
    tree.commit()
    assert not tree.check()
    tree.change(A, "z = 2", "z = [2]")
    tree.change(".ci/weight.toml", "tokens = 18", "tokens = 20")
    assert len(tree.check()) == 2  # since either commit
    tree.commit()
    assert tree.check() == ["src tokens: the ceiling was raised since HEAD^ without words"]
