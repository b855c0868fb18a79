"""Names of the package are where the pages say: API entries, files, links, methods, versions."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import entry_points, metadata
from pathlib import Path

import pytest

import chaplygin
import geomint as gi
from docs import tables
from docs.public_names import with_public_names
from geomint.tableaux import COMPOSITIONS, RUNGE_KUTTA
from tests.pages.blocks import PAGES, README, ROOT, blocks, page as page_of, prose

API = ROOT / "docs" / "api"
SYSTEMS = {found.name: found for found in entry_points(group="geomint.systems")}
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))


def test_what_is_public_is_documented_by_its_public_name() -> None:
    """And once: pages list modules, and what is public of them is taken out."""
    pages = [tables.with_modules(p.read_text("utf-8")) for p in API.glob("*.rst")]
    text = "\n".join(map(with_public_names, pages))
    listed = re.findall(r"auto(?:class|function|exception):: (\S+)", text)
    listed += [f"geomint.{name}" for name in re.findall(r"py:data:: (\w+)\n", text)]
    listed += re.findall(r"automodule:: (geomint\.scipy)\n", text)
    assert len(listed) == len(set(listed))
    for package in (gi, chaplygin):
        assert {f"{package.__name__}.{name}" for name in package.__all__} <= set(listed)


def targets(path: Path) -> list[tuple[str, str]]:
    """Return the files that a page links or shows, with the anchor."""
    text = path.read_text("utf-8")
    for block in blocks(path):
        if not block.info.startswith("{"):
            text = text.replace(block.text, "")
    found = re.findall(r"\]\(([^()\s]+)\)", text) + re.findall(r'<img src="([^"]+)"', text)
    found += re.findall(r"```\{(?:figure|include)\} (\S+)", text)
    return [target.partition("#")[::2] for target in found if not re.match(r"https?:", target)]


def anchors(path: Path) -> set[str]:
    """Return the anchors of the headings of a page."""
    heads = re.findall(r"^#+ (.*)$", path.read_text("utf-8"), re.MULTILINE)
    words = [re.sub(r"[^\w\- ]", "", head.replace("`", "").lower()) for head in heads]
    return {word.strip().replace(" ", "-") for word in words}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_links_lead_somewhere(path: Path) -> None:
    for target, anchor in targets(path):
        place = (path.parent / target).resolve() if target else path
        assert place.exists(), target
        assert not anchor or anchor in anchors(place), f"{target}#{anchor}"
    for name in re.findall(r"benchmarks/[\w/.-]+\.(?:py|json|png)", path.read_text("utf-8")):
        assert (ROOT / name).exists(), name


def test_the_source_distribution_has_what_pages_link() -> None:
    included = PROJECT["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]
    for path in (README, ROOT / "CONTRIBUTING.md"):
        named = [target for target, _ in targets(path)]
        named += re.findall(r"(?:^|[\s`])(\.ci/\w+|docs/[\w-]+\.md)", path.read_text("utf-8"))
        assert named
        for name in named:
            assert any(name == entry or name.startswith(f"{entry}/") for entry in included), name


def test_the_long_description_has_no_relative_links() -> None:
    """As an installation has it: a package index would look for them at its own address."""
    text = metadata("geomint")["Description"] or metadata("geomint").get_payload()
    assert text.startswith("# geomint")
    assert not re.findall(r"\]\((?!https?:)[^)]*\)|<img src=\"(?!https?:)", text)


def test_versions_agree() -> None:
    """A release has one number and one date; before it there is no date."""
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    changes = (ROOT / "CHANGELOG.md").read_text("utf-8")
    version = PROJECT["project"]["version"]
    assert gi.__version__ == metadata("geomint")["Version"] == version
    assert re.search(r"^version: (\S+)$", citation, re.MULTILINE)[1] == version
    released = re.search(r"^date-released: (\S+)$", citation, re.MULTILINE)
    dated = re.search(rf"^## \[{re.escape(version)}\] - (\S+)$", changes, re.MULTILINE)
    assert (released and released[1]) == (dated and dated[1])
    assert re.search(r"^## \[(\S+)\]", changes, re.MULTILINE)[1] in ("Unreleased", version)


FAMILIES = r"gauss|rattle|verlet|cf|cg|rk|rkmk|dop853|heun|kutta|bogacki-shampine|dormand-prince"
EXAMPLES = {"ralston-4", "midpoint-2", "free-top"}  # of the pages on adding methods and systems


def test_methods_that_pages_name_exist() -> None:
    """Code such as `gauss-8` or `cf-4:0.02`; not `rkmk-TABLEAU` or `cf-…`."""
    seen = set()
    for path in PAGES:
        for name in re.findall(rf"`((?:{FAMILIES})-[a-z0-9-]+)(?::[\d.]+)?`", prose(path)):
            seen.add(name)
            assert name in EXAMPLES or gi.find_method(name), path.name
    assert len(seen) > 30


def expanded(cell: str) -> set[str]:
    """Return the names that a cell of the table of methods stands for."""
    found: list[str] = []
    parts = re.split(r"`([^`]+)`", cell)
    for between, name in zip(parts[::2], parts[1::2], strict=False):
        if name.startswith("-"):
            name = re.sub(r"-\d+$", name, found[0])
        if "…" in between:
            stem, last = name.rsplit("-", 1)
            first = int(found[-1].rsplit("-", 1)[1])
            found += [f"{stem}-{i}" for i in range(first + 1, int(last))]
        found.append(name)
    return set(found)


WORDS = {"TABLEAU": RUNGE_KUTTA, "COMPOSITION": COMPOSITIONS}
WORDS |= {"METHOD": ("gauss-1", "verlet-2"), "ORDER": "123456789"}


def any_of(word: re.Match[str]) -> str:
    """Return a pattern of the names that a word in capitals stands for."""
    return "(?:" + "|".join(map(re.escape, WORDS[word[0]])) + ")"


def test_every_method_is_listed() -> None:
    text = page_of("choose-a-method").read_text("utf-8").split("## All methods", 1)[1]
    text = text.split("\n## ", 1)[0]
    rows = [line.split("|")[1:-1] for line in text.splitlines() if line.startswith("| ")][1:]
    names, patterns = set(), []
    known = {name: gi.find_method(name) for name in gi.method_names()}
    for _, cell, order, needs, *_ in rows:
        given = expanded(cell)
        plain = {name for name in given if name == name.lower()}
        names |= plain
        patterns += [re.sub(r"[A-Z]+", any_of, name) for name in given - plain]
        orders = {gi.find_method(name).order for name in plain & set(known)}
        if len(orders) > 1:
            first, last = (int(word) for word in re.findall(r"\d+", order))
            assert (min(orders), max(orders)) == (first, last), cell
            assert {known[name].needs for name in plain} == {needs.strip(" `")}, cell
    assert all(gi.find_method(name) for name in names if name in known or "suzuki" in name)
    left = {n for n in set(known) - names if not any(re.fullmatch(p, n) for p in patterns)}
    assert not left


def test_scenes_and_systems_are_on_the_pages() -> None:
    """By tables that are made of the registries, on the pages about them."""
    for page, table, names in (
        ("scene-files", "scene_keys", sorted(SYSTEMS)),
        ("systems", "scenes", gi.scene_names()),
    ):
        assert f"{{{{ {table} }}}}" in (ROOT / "docs" / f"{page}.md").read_text("utf-8")
        rows = getattr(tables, table)().splitlines()[2:]
        assert [re.match(r"\| `([\w-]+)`: ", row)[1] for row in rows] == names


def test_keys_of_systems_are_explained() -> None:
    """By their declaration, or in words beside the generated table: in a table or a sentence."""
    page = (ROOT / "docs" / "scene-files.md").read_text("utf-8")
    part = page.split("\n## `[system]`", 1)[1].split("\n## `[time]`", 1)[0]
    assert "{{ scene_keys }}" in part
    for name, found in SYSTEMS.items():
        system = found.load()
        for key, field in {**system.parameters.model_fields, **system.initial.model_fields}.items():
            assert field.description or f"`{key}`" in part, (name, key)
