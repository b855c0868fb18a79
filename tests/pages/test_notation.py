"""The tables of pages against the problems themselves: states, times, forms, quantities."""

from __future__ import annotations

import re

import pytest

from geomint import load_scene
from tests.pages.blocks import page
from tests.pages.catalogue import makers, problems

DIMENSIONS = (3, 4, 5)
NOTATION = page("notation").read_text("utf-8")


def rows(text: str, heading: str, columns: int) -> list[list[str]]:
    """Return the cells of the tables between a heading and the next one, without their heads."""
    part = re.split(r"\n##+ ", text.split(f"{heading}\n", 1)[1])[0]
    lines = [line for line in part.splitlines() if line.startswith("| ")]
    cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    found = [row for row in cells if len(row) == columns and "`" in "".join(row)]
    assert found
    return found


STATES = rows(NOTATION, "## Orders of the flat states", 4)
QUANTITIES = rows(NOTATION, "## Names of quantities", 3)


def sizes(cell: str, n: int, r: int) -> dict[str, int]:
    """Return the pieces of a cell, such as `k` (n(n−1)/2, triangle), with their rows."""
    values = {"n": n, "n·n": n * n, "n−1": n - 1, "n(n−1)/2": n * (n - 1) // 2, "n·r": n * r}
    found = re.findall(r"`(\w+)` \(((?:[^(),]|\([^()]*\))+)[,)]", cell)
    return {name: values[size] if size in values else int(size) for name, size in found}


def cell_of(name: str, problem) -> tuple[str, int]:
    """Return the part of a cell that speaks of a variant of the problem, and r."""
    (cell,) = (row[1] for row in STATES if row[0] == f"`{name}`")
    if "with `attitude=True`" in cell:
        plain, more = cell.split("; with `attitude=True` then ")
        return (f"{plain}, {more}" if "g" in problem.slices else plain), 1
    if "r = 1:" in cell:
        one, more = cell.removeprefix("r = 1: ").split("; r > 1: ")
        return (more, 2) if "X" in problem.slices else (one, 1)
    return cell, 1


def test_every_maker_has_a_row() -> None:
    assert sorted(row[0].strip("`") for row in STATES) == sorted(makers())


@pytest.mark.parametrize("n", DIMENSIONS)
def test_states_times_and_forms(n: int) -> None:
    by_name = {row[0].strip("`"): row for row in STATES}
    for name, made in problems(n).items():
        _, _, time, forms = by_name[name]
        for problem in made:
            cell, r = cell_of(name, problem)
            assert sizes(cell, n, r) == dict(problem.pieces), name
            assert list(sizes(cell, n, r)) == [piece for piece, _ in problem.pieces], name
            assert time == {"t": "t", "tau": "τ"}[problem.time], name
            assert re.sub(r" \(\w+\)", "", forms) == ", ".join(problem.forms), name
            form = problem.hamiltonian
            assert ("separable" in forms) == bool(form is not None and form.separable), name


def names_of(cell: str) -> str:
    """Return a pattern of the names that a cell lists: numbers in them stand for any."""
    spans = [re.escape(span) for span in re.findall(r"`([^`]+)`", cell)]
    return "|".join(re.sub(r"\d+", r"\\d+", span) for span in spans)


def test_quantities() -> None:
    """Each name of each problem has a row that names the problem, and no row names another."""
    found: dict[str, set[str]] = {row[0]: set() for row in QUANTITIES}
    for n in DIMENSIONS:
        for name, made in problems(n).items():
            for quantity in {q for problem in made for q in problem.diagnostics}:
                matching = [r[0] for r in QUANTITIES if re.fullmatch(names_of(r[0]), quantity)]
                assert len(matching) == 1, (name, quantity, matching)
                found[matching[0]].add(name)
    for cell, _, where in QUANTITIES:
        named = set(re.findall(r"`([^`]+)`", where))
        expected = makers() - named if where.startswith("all") else named
        assert named <= makers()
        assert found[cell] == expected, cell


FORM_WORDS = {"ODE": "field", "separable Hamiltonian": "hamiltonian", "Hamiltonian": "hamiltonian"}


def test_forms_of_the_page_on_systems() -> None:
    text = page("systems").read_text("utf-8")
    heads = ("## The chain of the Chaplygin sphere", "## Holonomic relatives")
    heads += ("## Without slipping and twisting, and about a fixed point",)
    table = [row for head in heads for row in rows(text, head, 5) if row[3].startswith("`")]
    seen = set()
    for _, _, forms, made_by, scene in table:
        code = made_by.strip("`").split("(")[0]
        name = f"ChaplyginSphere{code}" if code.startswith(".") else code
        words = [FORM_WORDS.get(word, word) for word in forms.split(", ")]
        words = [word for word in words if not word.startswith("with ")]
        known = problems(3).get(name)  # what the page on notation does not have, its scene has
        problem = known[0] if known else load_scene(scene.strip("`")).problem
        assert words == list(problem.forms), name
        seen.add(name)
    assert seen >= makers()
