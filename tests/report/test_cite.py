"""What to cite: every method and system has sources, and BibTeX can read them."""

from __future__ import annotations

import re
from importlib.metadata import entry_points
from pathlib import Path

import pytest

import geomint as gi
from geomint.references import literature
from geomint.references.latex import latex, latex_cell

ROOT = Path(__file__).parents[2]
FIELDS = {
    "article": {"author", "title", "journal", "year"},
    "book": {"author", "title", "publisher", "year"},
    "incollection": {"author", "title", "booktitle", "publisher", "year"},
    "misc": {"author", "title"},
}


ENTRY = re.compile(r"@(\w+)\{(\w+),((?:\s*\w+ = \{.*\},?\n)+)\}\n")
FIELD = re.compile(r"\s*(\w+) = \{(.*)\},?\n")


def entries(text):
    """Read BibTeX, a field a line, with balanced braces: {key: (kind, {field: value})}."""
    assert text.isascii()
    assert not ENTRY.sub("", text).strip()
    found = {}
    for kind, key, body in ENTRY.findall(text):
        assert key not in found
        fields = FIELD.findall(body)
        assert len(dict(fields)) == len(fields)
        for _, value in fields:
            marks = re.sub(r"\\.", "", value)
            depths = [marks[:i].count("{") - marks[:i].count("}") for i in range(len(marks) + 1)]
            assert min(depths) == depths[-1] == 0
        found[key] = (kind, dict(fields))
    return found


def check_entries(citation):
    read = entries(citation.bibtex)
    assert list(read) == [one.key for one in citation.references]
    for kind, fields in read.values():
        assert FIELDS[kind] <= fields.keys()
        assert fields["title"].startswith("{")
        assert "?" not in "".join(fields.values())
        assert re.fullmatch(r"\d{4}|", fields.get("year", ""))
        assert re.fullmatch(r"(10\.\d{4,}/\S+)?", fields.get("doi", ""))
        assert re.fullmatch(r"(\d+(--\d+)?)?", fields.get("pages", ""))
        for author in fields["author"].split(" and "):
            assert ", " in author or author[0] + author[-1] == "{}", author
    return read


def test_every_method_has_a_source():
    for name in gi.method_names():
        method, citation = gi.find_method(name), gi.cite(name)
        assert citation.parts[0][0] == f"method {name}"
        assert citation.parts[0][1], name
        assert citation.parts[0][1][0].year < 2006, name  # the original, not a textbook before it
        assert {one.key for one in method.references} < {one.key for one in citation.references}
        check_entries(citation)


def test_every_system_has_a_source():
    covered = set()
    for name in gi.scene_names():
        scene = gi.load_scene(name)
        covered.add(scene.content.system.name)
        reduced = (r.problem for r in scene.model.reductions)
        assert all(p.references for p in (*scene.model.problems.values(), *reduced)), name
        parts = dict(gi.cite(scene).parts)
        assert parts[f"system {scene.problem.name}"] == scene.problem.references
        assert parts[f"method {scene.method.name}"]
        check_entries(gi.cite(scene))
    assert covered == {found.name for found in entry_points(group="geomint.systems")}


def test_the_package_is_cited_as_its_file_says():
    lines = (ROOT / "CITATION.cff").read_text("utf-8").splitlines()
    own, paper = literature.GEOMINT, literature.JOVANOVIC_2010
    family, given = paper.authors[0].split(", ")
    assert gi.cite("rk-4").references[-1].note == f"Version {gi.__version__}"
    assert {line.strip().strip("- ") for line in lines} >= {
        f'title: "{own.title}"', f'name: "{own.authors[0]}"', f"version: {gi.__version__}",
        f'title: "{paper.title.replace("ⁿ", "^n")}"', f'journal: "{paper.journal}"',
        f'family-names: "{family}"', f'given-names: "{given}"', f"volume: {paper.volume}",
        f"year: {paper.year}", f"start: {paper.pages.partition('-')[0]}",
        f'notes: "arXiv:{paper.arxiv}"',
    }  # fmt: skip


def test_sources_are_told_apart_by_their_keys():
    ones = [one for one in vars(literature).values() if isinstance(one, gi.Reference)]
    for scene in map(gi.load_scene, gi.scene_names()):
        ones += [one for p in scene.model.problems.values() for one in p.references]
    different = {one.at(""): one for one in ones}.values()
    for names in ([one.key for one in different], [one.doi for one in different if one.doi]):
        assert len(set(names)) == len(names)


def test_a_result_says_both():
    scene = gi.load_scene("rubber-ball-n3")
    run = {"t_end": 0.1, "step": 0.05, "method": "cf-4", "compiled": False}
    citation = gi.cite(gi.solve(scene.problem, scene.state, **run))
    headings = ["system rubber-ball-rolling", "method cf-4", "software"]
    assert [what for what, _ in citation.parts] == headings
    assert citation.keys("method") == "CelledoniMarthinsenOwren2003"
    assert "four stages of order 4" in citation.text
    assert "four stages" not in citation.bibtex
    assert str(citation) + "\n" == citation.text
    loaded = gi.cite(scene.problem, "exact")
    assert dict(loaded.parts)["method exact"] == ()
    assert "no source is stated" in loaded.text


def test_what_cannot_be_cited_is_refused():
    with pytest.raises(gi.DomainError, match="what"):
        gi.cite(3.0)
    with pytest.raises(gi.SceneError):
        gi.cite("gauss-88")
    given = {"key": "A", "authors": ("B, C",), "title": "D"}
    wrong = {"key": "a b", "kind": "poem", "year": "1999", "authors": 3, "doi": None}
    for key, value in wrong.items():
        with pytest.raises(gi.DomainError):
            gi.Reference(**{**given, key: value})
    with pytest.raises(gi.DomainError, match="references"):
        gi.Problem(name="p", pieces=(("q", 1),), references=("a paper",))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("100 % of A_1 & {B}", r"100 \% of A\_1 \& \{B\}"),
        ("γ₁", r"$\gamma _{1}$"),
        ("T*S^(n−1)", r"T*S\textasciicircum{}(n$-$1)"),
        ("Jovanović, Nørsett", r"Jovanovi{\'{c}}, N{\o}rsett"),
        ("γ̇ = −ωγ", r"$\dot{\gamma }$ = $-\omega \gamma $"),
        ("\\", r"\textbackslash{}"),
        ("", ""),
        ("漢", "?"),
        ("a\x1b[31m\r", r"a\textbackslash{}x1b[31m\textbackslash{}r"),
        ("a\n\nb", "a  b"),  # an empty line would end what it is in
        ("\u202e", r"\textbackslash{}u202e"),
    ],
)
def test_text_as_latex(text, expected):
    assert latex(text) == expected
    assert latex(text).isascii()


def test_numbers_as_latex():
    for text, expected in (
        ("1.2e-11", r"$1.2\times10^{-11}$"),
        ("−3e+05", r"$-3\times10^{5}$"),
        ("(1.23 ± 0.05)e-15", r"$(1.23 \pm  0.05)\times10^{-15}$"),
        ("rattle-4", "rattle-4"),
        ("—", "---"),
        ("\x00\ud800 1e-5", r"\textbackslash{}x00\textbackslash{}ud800 $10^{-5}$"),
    ):
        assert latex_cell(text) == expected
