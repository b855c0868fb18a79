"""What reports leave for a paper: LaTeX that TeX can read, fonts and widths that journals ask for."""

from __future__ import annotations

import contextlib
import csv
import itertools
import json
import re
import zlib

import pytest
from click.testing import CliRunner
from matplotlib.mathtext import MathTextParser

import geomint as gi
from geomint.cli import main
from geomint.references.latex import latex

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
TOLD = {
    "drift of several": r"""windows of time, relative to the scale of each quantity, a line a method
Method: rk-4, order 4, step 0.125 in $\tau $; gauss-8, order 16, step 0.25 in $\tau $~\cite{
quantity & class & largest error (dimensionless) & slope, per unit of $\tau $
rk-4 & energy & undetermined & 0.00982 & $(3.5 \pm  1.2)\times10^{-3}$ """,
    "scan": r""": 3 runs (3 values of D from 2 to 4).
Method: rk-4, order 4, 96 steps in all~\cite{
drift:energy & 0.007816 & 0.009822 & 0.01275 & 3 """,
}
SLOW = {"drift", "compare", "exact", "chaos", "audit", "section"}
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
    text = "\n".join(line for line in text.splitlines() if not line.startswith("%"))
    bare = re.sub(r"\\\\(?=\n)|\\[\\{}$&#%_]", "", text)
    assert not set("#%") & set(bare)
    depths = list(itertools.accumulate({"{": 1, "}": -1}.get(mark, 0) for mark in bare))
    assert min(depths) == depths[-1] == 0
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
def test_the_files(name, folders):
    folder, stem = folders(name)
    table = plain((folder / f"{stem}-table.tex").read_text("ascii"))
    caption = plain((folder / f"{stem}-caption.tex").read_text("ascii"))
    document = plain((folder / f"{stem}-paper.tex").read_text("ascii"))
    assert {w for w in TOLD.get(name, "").splitlines() if w not in table + caption} == set()
    columns = re.search(r"\\begin\{tabular\}\{([lr]+)\}", table)[1]
    rows = re.search(r"\\toprule\n(.*)\\bottomrule", table, re.DOTALL)[1].splitlines()
    rows = [row for row in rows if row != r"\midrule"]
    assert len(rows) > 1
    assert {row.count("&") for row in rows} == {len(columns) - 1}
    for word in ("toprule", "midrule", "bottomrule", "caption", "label"):
        assert table.count(f"\\{word}") == 1
    keys = set(re.findall(r"@\w+\{(\w+),", (folder / f"{stem}.bib").read_text("ascii")))
    cited = re.findall(r"\\cite\{([^}]*)\}", caption)
    assert set() < {key for keys_ in cited for key in keys_.split(",")} <= keys
    for file in re.findall(r"\\input\{([^}]*)\}", document):
        assert (folder / f"{file}.tex").exists()
    pictures = re.findall(r"\\includegraphics\{([^}]*)\}", document)
    assert sorted(pictures) == sorted(path.name for path in folder.glob("*.pdf"))
    first, *rows = csv.reader((folder / f"{stem}.csv").read_text("utf-8").splitlines())
    assert {len(row) for row in rows} == {len(first)}
    assert (folder / f"{stem}.json").exists()
    page = (folder / ("report.html" if stem == "drift" else f"{stem}.html")).read_text("utf-8")
    assert page.index("What to cite") < page.index("@misc{geomint,")
    told = ["a = (0.8, 1.1, 1.5), D = 4", "Initial state: gamma = (0.48, 0.6, 0.64)"]
    for words in ("Software: geomint", "python", "numpy", *(told if name != "audit" else ())):
        assert words in caption


@each
def test_the_figures(name, folders):
    """Type 42 and no Type 3; a column of 8.6 cm, or the 17.8 cm of a page of two."""
    folder, _ = folders(name)
    for path in folder.glob("*.pdf"):
        content = path.read_bytes()
        assert [x in content for x in (b"/FontFile2", b"/Type3", b"/CreationDate")] == [1, 0, 0]
        width, height = (float(x) / 72 * 2.54 for x in SIZE.search(content).groups())
        assert min(abs(width - 8.6), abs(width - 17.8)) < 0.01, path.name
        assert 4.0 < height < 24.0
        sizes = set()
        for stream in re.findall(rb"stream\r?\n(.*?)endstream", content, re.DOTALL):
            with contextlib.suppress(zlib.error):
                text = zlib.decompress(stream)
                sizes |= {float(x) for x in re.findall(rb"/[\w-]+ ([\d.]+) Tf", text)}
        assert (max(sizes), min(sizes) >= 5.6) == (8.0, True)  # of indices and powers


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("drift", "--methods rk-4:2,gauss-8:0.25"),
        pytest.param("drift", "--step 2", marks=pytest.mark.nightly),
        pytest.param("drift", "--method lobatto-8 --step 3.9", marks=pytest.mark.nightly),
        pytest.param(
            "compare", "--methods lobatto-8 --steps 3.9 --tau-end 3.95", marks=pytest.mark.nightly
        ),
    ],
)
def test_where_little_was_found(command, words, tmp_path):
    """Steps that fail, nothing that is conserved: all files are there."""
    (tmp_path / "s.toml").write_text(SCENE, encoding="utf-8")
    out = tmp_path / "out"
    arguments = [command, str(tmp_path / "s.toml"), *words.split(), "--paper", "--out", str(out)]
    result = CliRunner().invoke(main, arguments)
    assert not isinstance(result.exception, Exception), result.exception
    for kind in ("table", "caption", "paper"):
        plain((out / f"{command}-{kind}.tex").read_text("ascii"))
    assert (out / f"{command}.pdf").exists()


def test_a_report_of_several(folders):
    """Windows are those of the drifts; a title cannot break out."""
    folder, _ = folders("drift of several")
    rows = list(csv.DictReader((folder / "drift.csv").read_text("utf-8").splitlines()))
    record = json.loads((folder / "drift.json").read_text("utf-8"))
    for key in itertools.product(("rk-4", "gauss-8"), ("energy", "K")):
        own = [r for r in rows if (r["method"], r["quantity"]) == key]
        largest = record["methods"][key[0]]["quantities"][key[1]]["max_abs_error"]
        assert max(float(r["largest deviation"]) for r in own) == pytest.approx(largest, rel=1e-3)
    table = (folder / "drift-table.tex").read_text("ascii")
    assert r"50 \% of a\_1 \& \{$\dot{\gamma }$\} at 10\textasciicircum{}-3, {\v{c}}" in table


def test_scenes_have_no_characters_that_latex_does_not_know():
    """Nothing of the built-in scenes, quantities and equations becomes a question mark."""
    for scene in map(gi.load_scene, gi.scene_names()):
        texts = [scene.title, scene.content.description]
        for p in scene.model.problems.values():
            texts += [*p.equations, *p.diagnostics, *p.units.values(), *p.parameters]
        assert not [text for text in texts if latex(text).count("?") != text.count("?")]
