"""The picture of the design page is the tree of the packages, in the order of the layers."""

from __future__ import annotations

import re
import tomllib

from tests.pages.blocks import ROOT

PICTURE = (ROOT / "docs" / "design.md").read_text("utf-8").split("```text\n")[1].split("```")[0]


def drawn(start: str) -> list[list[str]]:
    """Return the rooms below a heading of the picture, line by line."""
    lines = PICTURE.split(f"{start}\n")[1].splitlines()
    indent = len(lines[0]) - len(lines[0].lstrip())
    rooms = []
    for line in lines:
        depth = len(line) - len(line.lstrip())
        if depth < indent or line.lstrip().startswith("│"):
            break
        if depth == indent:
            rooms.append(re.split(r"\s{3,}", line.strip())[0].split())
    return rooms


def built(folder: str) -> set[str]:
    """Return the modules and folders of a package."""
    return {
        path.stem
        for path in (ROOT / "src" / folder).iterdir()
        if (path.suffix == ".py" or (path / "__init__.py").exists()) and path.stem[:2] != "__"
    }


def test_every_room_is_drawn() -> None:
    """In the order of the layers: lines are those of the contract, which is exhaustive."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    for package in ("geomint", "chaplygin"):
        lines = drawn(f"{package}/")
        assert sorted(name for line in lines for name in line) == sorted(built(package))
        layers = next(c["layers"] for c in contracts if c.get("containers") == [package])
        assert [sorted(line) for line in lines] == [sorted(x.split(" | ")) for x in layers]
    after = PICTURE.split("    kernels ")[1].splitlines()[1:]
    names = [line.split()[0] for line in after if line.startswith(" " * 8)]
    assert sorted(names) == sorted(built("geomint/kernels"))
    assert len(built("geomint")) <= 18
