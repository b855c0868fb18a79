"""What reports leave for a paper: LaTeX that TeX can read, fonts and widths that journals ask for."""

from __future__ import annotations

import csv
import re
import zlib

import pytest
from click.testing import CliRunner
from matplotlib.mathtext import MathTextParser

from geomint.cli import main

# Steps are as long as a test wants them.
pytestmark = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")

SCENE = """
title = "50 % of a_1 & {γ̇} at 10^-3, č"
[system]
name = "chaplygin-sphere-hamiltonized"
a = [0.8, 1.1, 1.5]
D = 4.0
[initial]
gamma = [0.48, 0.6, 0.64]
p = [3.0, -4.0, 1.5]
[time]
tau_end = 4.0
[integrate]
method = "rk-4"
step = 0.125
[observe]
quantities = ["energy", "K"]
"""
COMMANDS = {
    "drift": ("s.toml",),
    "drift of several": ("s.toml", "--methods", "rk-4,gauss-8:0.25"),
    "chaos": ("s.toml", "--count", "2"),
    "section": ("s.toml", "--event", "gamma[2]", "--points", "3"),
    "scan": ("s.toml", "--vary", "D=2:4:3", "--show", "drift:energy"),
    "compare": ("s.toml", "--methods", "rk-4,gauss-8", "--repeats", "1", "--tau-end", "1"),
    "exact": ("s.toml",),
    "audit": ("--n", "3", "--points", "1"),
}
SLOW = {"drift", "compare", "exact", "chaos"}
SIZE = re.compile(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]")
mathematics = MathTextParser("path")
each = pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.nightly] * (n in SLOW)) for n in COMMANDS]
)


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Return a function that runs a command once, and gives its folder and the stem of its files."""
    made = {}

    def folder(name):
        if name not in made:
            place = tmp_path_factory.mktemp(name.replace(" ", "-"))
            (place / "s.toml").write_text(SCENE, encoding="utf-8")
            command = name.split()[0]
            words = [w if w != "s.toml" else str(place / w) for w in COMMANDS[name]]
            words = [command, *words, "--paper", "--out", str(place / "out")]
            result = CliRunner().invoke(main, words)
            assert result.exit_code in (0, 1), result.output + result.stderr
            assert f"for a paper: {place / 'out' / command}-paper.tex" in result.output
            made[name] = place / "out", command
        return made[name]

    return folder


def plain(text):
    """Return LaTeX without comments, checked: braces, environments, mathematics, special characters."""
    assert text.isascii()
    lines = [line for line in text.splitlines() if not line.startswith("%")]
    text = "\n".join(lines)
    bare = re.sub(r"\\\\(?=\n)|\\[\\{}$&#%_]", "", text)
    assert not set("#%") & set(bare)
    depth = 0
    for character in bare:
        depth += {"{": 1, "}": -1}.get(character, 0)
        assert depth >= 0
    assert depth == 0
    assert bare.count("$") % 2 == 0
    open_ones = []
    for kind, name in re.findall(r"\\(begin|end)\{([^}]*)\}", bare):
        if kind == "begin":
            open_ones.append(name)
        else:
            assert open_ones.pop() == name
    assert not open_ones
    for formula in re.findall(r"\$([^$]*)\$", bare):
        mathematics.parse(f"${formula}$")
    words = re.sub(r"\$[^$]*\$", "", bare)
    assert not set("_^") & set(re.sub(r"\{\\\W\{", "", words))
    return bare


@each
def test_the_latex(name, folders):
    folder, stem = folders(name)
    table = plain((folder / f"{stem}-table.tex").read_text("ascii"))
    caption = plain((folder / f"{stem}-caption.tex").read_text("ascii"))
    document = plain((folder / f"{stem}-paper.tex").read_text("ascii"))
    columns = re.search(r"\\begin\{tabular\}\{([lr]+)\}", table)[1]
    rows = re.search(r"\\toprule\n(.*)\\bottomrule", table, re.DOTALL)[1].splitlines()
    rows = [row for row in rows if row != r"\midrule"]
    assert len(rows) > 1
    assert {row.count("&") for row in rows} == {len(columns) - 1}
    for word in ("\\toprule", "\\midrule", "\\bottomrule", "\\caption", "\\label"):
        assert table.count(word) == 1
    keys = set(re.findall(r"@\w+\{(\w+),", (folder / f"{stem}.bib").read_text("ascii")))
    cited = re.findall(r"\\cite\{([^}]*)\}", caption)
    assert cited
    assert {key for keys_ in cited for key in keys_.split(",")} <= keys
    for file in re.findall(r"\\input\{([^}]*)\}", document):
        assert (folder / f"{file}.tex").exists()
    pictures = re.findall(r"\\includegraphics\{([^}]*)\}", document)
    assert sorted(pictures) == sorted(path.name for path in folder.glob("*.pdf"))
    for words in ("Software: geomint", "python", "numpy"):
        assert words in caption
    if name != "audit":
        assert "a = (0.8, 1.1, 1.5), D = 4" in caption
        assert "Initial state: gamma = (0.48, 0.6, 0.64)" in caption


@each
def test_the_figures(name, folders):
    """Type 42 and no Type 3; a column of 8.6 cm, or the 17.8 cm of a page of two."""
    folder, _ = folders(name)
    for path in folder.glob("*.pdf"):
        content = path.read_bytes()
        assert b"/FontFile2" in content
        assert b"/Type3" not in content
        assert b"/CreationDate" not in content
        width, height = (float(x) / 72 * 2.54 for x in SIZE.search(content).groups())
        assert min(abs(width - 8.6), abs(width - 17.8)) < 0.01, path.name
        assert 4.0 < height < 24.0
        sizes = set()
        for stream in re.findall(rb"stream\r?\n(.*?)endstream", content, re.DOTALL):
            try:
                text = zlib.decompress(stream)
            except zlib.error:
                continue
            sizes |= {float(x) for x in re.findall(rb"/[\w-]+ ([\d.]+) Tf", text)}
        assert max(sizes) == 8.0
        assert min(sizes) >= 5.6  # of indices and powers


@each
def test_the_data(name, folders):
    folder, stem = folders(name)
    with (folder / f"{stem}.csv").open(newline="", encoding="utf-8") as stream:
        first, *rows = list(csv.reader(stream))
    assert rows
    assert {len(row) for row in rows} == {len(first)}
    assert (folder / f"{stem}.json").exists()


@pytest.mark.parametrize(
    ("command", "words"),
    [
        pytest.param("drift", ("--methods", "lobatto-8:3.9,rk-4"), marks=pytest.mark.nightly),
        ("drift", ("--method", "lobatto-8", "--step", "3.9")),
        ("compare", ("--methods", "lobatto-8", "--steps", "3.9", "--tau-end", "3.95")),
        ("section", ("--event", "gamma[2]", "--level", "1.5", "--points", "1")),
        ("scan", ("--vary", "D=2:4:2", "--vary", "a[0]=0.7:0.8:2", "--show", "drift:energy")),
    ],
)
def test_where_little_was_found(command, words, tmp_path, monkeypatch):
    """Steps that do not converge, nothing that is conserved, no points: all files are there."""
    monkeypatch.setattr("geomint.run.poincare.PATIENCE", 1000)
    (tmp_path / "s.toml").write_text(SCENE, encoding="utf-8")
    out = tmp_path / "out"
    arguments = [command, str(tmp_path / "s.toml"), *words, "--paper", "--out", str(out)]
    result = CliRunner().invoke(main, arguments)
    assert not isinstance(result.exception, Exception), result.exception
    for kind in ("table", "caption", "paper"):
        plain((out / f"{command}-{kind}.tex").read_text("ascii"))
    assert (out / f"{command}.pdf").exists()


def test_the_windows_are_those_of_the_drifts(folders):
    folder, _ = folders("drift of several")
    with (folder / "drift.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["method"] for row in rows} == {"rk-4", "gauss-8"}
    assert {row["quantity"] for row in rows} == {"energy", "K"}
    import json

    record = json.loads((folder / "drift.json").read_text("utf-8"))
    for method, found in record["methods"].items():
        for name, drift in found["quantities"].items():
            own = [r for r in rows if (r["method"], r["quantity"]) == (method, name)]
            assert max(float(r["largest deviation"]) for r in own) <= drift["max_abs_error"]


def test_titles_cannot_break_out(folders):
    folder, _ = folders("drift of several")
    table = (folder / "drift-table.tex").read_text("ascii")
    assert r"50 \% of a\_1 \& \{$\dot{\gamma }$\} at 10\textasciicircum{}-3, {\v{c}}" in table


@each
def test_the_pages_say_what_to_cite(name, folders):
    folder, stem = folders(name)
    page = "report.html" if stem == "drift" else f"{stem}.html"
    text = (folder / page).read_text("utf-8")
    assert "What to cite" in text
    assert "@misc{geomint," in text


def test_paper_needs_a_folder():
    for words in (("exact", "ball-3d", "--paper"), ("audit", "--paper")):
        result = CliRunner().invoke(main, list(words))
        assert result.exit_code == 2
        assert "--out" in result.stderr


def test_scenes_have_no_characters_that_latex_does_not_know():
    """Nothing of the built-in scenes, quantities and equations becomes a question mark."""
    import geomint as gi
    from geomint.references.latex import latex

    for name in gi.scene_names():
        scene = gi.load_scene(name)
        for problem in scene.model.problems.values():
            texts = [
                scene.title,
                scene.content.description,
                *problem.equations,
                *problem.diagnostics,
            ]
            texts += [*problem.units.values(), *problem.parameters]
            for text in texts:
                assert latex(text).count("?") == text.count("?"), text
