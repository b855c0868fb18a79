"""The picture of the design page is the tree of the packages, in the order of the layers."""

from __future__ import annotations

import re
import tomllib

import pytest

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


@pytest.mark.parametrize(
    ("start", "folder"),
    [("geomint/", "geomint"), ("chaplygin/", "chaplygin")],
)
def test_every_room_is_drawn(start: str, folder: str) -> None:
    names = [name for line in drawn(start) for name in line]
    assert sorted(names) == sorted(built(folder))


def test_rooms_of_the_kernels_are_drawn() -> None:
    after = PICTURE.split("    kernels ")[1].splitlines()[1:]
    names = [line.split()[0] for line in after if line.startswith(" " * 8)]
    assert sorted(names) == sorted(built("geomint/kernels"))


@pytest.mark.parametrize("package", ["geomint", "chaplygin"])
def test_the_picture_is_in_the_order_of_the_layers(package: str) -> None:
    """Lines are the layers of the contract, which is exhaustive."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]
    layers = next(c["layers"] for c in contracts["contracts"] if c.get("containers") == [package])
    assert [sorted(line) for line in drawn(f"{package}/")] == [
        sorted(layer.split(" | ")) for layer in layers
    ]


def test_a_package_has_few_rooms() -> None:
    assert len(built("geomint")) <= 18
