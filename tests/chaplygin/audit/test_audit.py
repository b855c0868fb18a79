"""The audit of the paper: its claims, its files, and that it notices what is wrong."""

from __future__ import annotations

import dataclasses
import functools
import json
import re
import runpy
import shutil
import sys
import types
from html import escape
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import geomint as gi
from chaplygin import commands
from geomint.cli import main
from tests.paper import run as running
from tests.paper.claim import FAILS, HOLDS, VERDICTS, evaluate
from tests.paper.command import audit as command
from tests.paper.points import sample
from tests.paper.report import as_json, distinct, markdown
from tests.paper.run import CLAIMS, audit

CLAIM = {claim.label: claim for claim in CLAIMS}
ROOT = Path(__file__).parents[3]
TABLE = ROOT / "docs" / "audit-table.md"

# What the audit is known to find; a change of this list is a finding about the paper.
MISPRINTS = {
    "Hamilton", "ch-lagr", "IOP", "remark:lagrange", "referee", "text:reduced-integrals",
    "fedorov", "VC", "text:w", "VFK", "text:n3", "extended2", "elipsoid", "SI", "theorem:lagrange",
    "remark:last",
}  # fmt: skip
RESTRICTED = {
    "red:eq", "text:truncated-flow", "red:eq2", "text:homogeneous-forms", "text:chaplygin-change",
    "text:almost-hamiltonian",
}  # fmt: skip
STRONGER = {"operator"}
ON_MANIFOLD = {"theorem:ro", "text:extended:H-special", "3.2", "text:f1-K", "ints"}
# Labels that show what another one has shown before.
REPEATED = {
    "text:truncated-flow", "red:eq2", "text:almost-hamiltonian", "text:extended:H-special", "text:f1-K",
    "ints", "VFK", "text:n3", "theorem:lagrange",
}  # fmt: skip

# The labels of the paper's source, in its order: every ``\label{…}`` is the label of a claim.
# fmt: off
LABELS = (
    "constraints", "Hamilton", "ham:eq", "moment_map", "dim:uslov", "red:eq", "bundle*",
    "mom:map", "red:eq2", "sym:red", "KF", "ch-lagr", "ch-constr", "red:lag", "c1", "c2", "c3",
    "c4", "ch", "hg", "oO", "K", "PE", "ch-red", "ch-red2", "mu", "SO(n-1):red", "mu*", "iso",
    "Chap", "mu-ch", "cl:int", "cl", "zero", "uslovi", "smene", "veza", "phi", "T1", "r1", "r2",
    "red:ham", "hat", "IK", "OMEGA", "2-form", "IM", "nova", "sphere", "operator", "IOP",
    "IOP1", "sing", "ro1", "ro2", "operator*", "xi", "VOLUME", "redLR", "DENSITY", "div1",
    "div2", "div3", "ham0", "hamiltonian", "main", "CM", "mapping", "hamiltonian*", "psi",
    "hamiltonian-flow", "ham_q", "ham_p", "*", "***", "**", "referee", "classical", "3.1", "la",
    "3.2", "ints", "tr1", "fedorov", "VC", "PoissonV", "VFK", "bundle", "cond_X", "dotX->P",
    "condX", "rest_St", "dot_P", "inertia_tensor", "extended1", "extended2", "ham:ves",
    "elipsoid", "CH-VP", "linearizacija", "kk", "komutiranje", "S_n", "SI",
)
# fmt: on

# Of theorems and remarks without a label: where the claims about them are.
UNLABELLED = {
    *("theorem:ro", "theorem:lagrange", "remark:rubber", "remark:physical", "remark:lagrange"),
    *("remark:lagrange:J", "remark:densities", "remark:densities:3", "remark:hochgerner"),
    *("remark:FeJo", "remark:operators", "remark:operators:tr1", "remark:right-invariance"),
    *("remark:not-noether", "remark:last"),
}


@pytest.fixture(scope="module")
def found():
    return audit((2, 3, 4), points=3, seed=3)


def verdicts(result):
    return {r.claim.label: r.verdict for r in result.results}


def test_claims_are_complete_records():
    assert len(LABELS) == len(set(LABELS)) == 104
    assert {*LABELS, *UNLABELLED} <= set(CLAIM)
    assert len(CLAIMS) == len(CLAIM)
    for claim in CLAIMS:
        assert claim.statement
        assert claim.lines
        assert (claim.check is None) == bool(claim.reason)
        assert (claim.verdict_if_amended is None) == (not claim.amendment)


def test_findings(found):
    assert not found.unexplained
    by_verdict = {v: {k for k, w in verdicts(found).items() if w == v} for v in VERDICTS}
    assert sum(map(len, by_verdict.values())) == len(found.results)
    assert by_verdict["misprint"] == MISPRINTS
    assert by_verdict["needs a restriction"] == RESTRICTED
    assert by_verdict["condition stronger than needed"] == STRONGER
    assert by_verdict["holds on the manifold only"] == ON_MANIFOLD


def test_findings_are_counted_once(found):
    """A finding has the verdict of its first claim, and claims that name it have the same."""
    assert set(found.findings) == (MISPRINTS | RESTRICTED | STRONGER | ON_MANIFOLD) - REPEATED
    for first, results in found.findings.items():
        assert results[0].claim.label == first
        assert len({r.verdict for r in results}) == 1
        assert len(results) == 1 or first in {"red:eq", "theorem:ro", "3.2", "VC", "SI"}
    numbers = {"misprint": 13, "needs a restriction": 3, "condition stronger than needed": 1}
    assert distinct(found) == {"holds on the manifold only": 2, **numbers}


def test_what_cites_a_formula_that_fails_says_so(found):
    """Theorem 7 holds of the corrected constraints, Theorem 8 of the corrected Veselova problem."""
    failing = {r.claim.label for results in found.findings.values() for r in results}
    citing = {r.claim.label: r for r in found.results if r.claim.cites}
    assert {"rest_St", "CH-VP:ii", "CH-VP:iii", "theorem:lagrange"} <= set(citing)
    for result in citing.values():
        assert set(result.claim.cites) <= failing
        if result.verdict == "holds":
            assert f"cites ({result.claim.cites[0]})" in result.remark
            assert result.remark in markdown(found).replace("\\", "")


def test_every_statement_is_evaluated_off_the_manifold_too(found):
    for result in found.results:
        if result.residual is not None:
            assert result.points >= 3
            assert result.off_manifold is not None
    by_label = {r.claim.label: r for r in found.results}
    for label in ("PE", "kk", "fedorov"):  # what nobody claims there does not hold there
        assert by_label[label].off_manifold >= FAILS


def test_the_gap_is_wide(found):
    """Nothing lies within three powers of ten of the middle of the thresholds."""
    below, above = found.gap
    assert below <= HOLDS
    assert above >= FAILS
    assert above / below > 1e10


@pytest.mark.nightly
def test_another_seed_gives_the_same_verdicts(found):
    again = audit((2, 3, 4), points=6, seed=11)
    assert verdicts(again) == verdicts(found)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_all_dimensions_give_the_same_verdicts(seed):
    result = audit(seed=seed)
    assert not result.unexplained
    labels = {k for k, v in verdicts(result).items() if v == "misprint"}
    assert labels == MISPRINTS
    assert all(r.points >= 20 for r in result.results if r.residual is not None)
    assert result.gap[1] / result.gap[0] > 1e10


def planted(label, change):
    """Return a claim whose printed form was changed, with what was printed as its correction."""
    claim = CLAIM[label]

    def check(point, amended):
        left, right, *size = claim.check(point)
        return left, right if amended else change(right), *size

    return dataclasses.replace(
        claim, check=check, verdict_if_amended="misprint", amendment="as it was"
    )


@pytest.mark.parametrize("label", ["r2", "c1", "ham_q", "la", "sphere", "DENSITY", "kk"])
def test_a_planted_misprint_is_caught(label):
    import numpy as np

    points = [sample(3, i) for i in range(2)]
    misprinted = planted(label, lambda right: -np.asarray(right))
    assert evaluate(misprinted, points).verdict == "misprint"
    uncorrected = dataclasses.replace(misprinted, verdict_if_amended=None, amendment="")
    broken = dataclasses.replace(
        uncorrected, check=functools.partial(misprinted.check, amended=False)
    )
    assert evaluate(broken, points).verdict == "unexplained"


def invoke(*words):
    return CliRunner().invoke(command, words, catch_exceptions=True, standalone_mode=False)


def only(monkeypatch, *claims):
    monkeypatch.setattr(running, "audit", functools.partial(audit, claims=claims))


def test_something_unexplained_is_exit_code_1(monkeypatch):
    claim = CLAIM["SI"]
    wrong = dataclasses.replace(claim, check=lambda point, amended: claim.check(point, False))
    only(monkeypatch, wrong, CLAIM["kk"])
    result = invoke("--n", "3", "--points", "1")
    assert result.return_value == 1
    assert "unexplained: SI" in result.output


def test_both_commands_write_what_was_found(tmp_path, monkeypatch):
    """``geomint audit``, and ``python -m tests.paper`` where another installation has no audit."""
    monkeypatch.chdir(tmp_path)
    only(monkeypatch, CLAIM["extended2"], CLAIM["kk"], CLAIM["phi"], CLAIM["theorem:ro"])
    records = []
    for place in ("one", "two"):
        line = ["--n", "3,4", "--points", "4", "--out", place, "--markdown", f"{place}.md"]
        monkeypatch.setattr(sys, "argv", ["geomint", "audit", *line])
        if place == "one":
            result = CliRunner().invoke(main, ["audit", *line])
            assert (result.exit_code, "misprint" in result.output) == (0, True)
        else:
            monkeypatch.setattr(main, "commands", {})
            monkeypatch.setattr(sys, "argv", ["tests.paper", *line])
            with pytest.raises(SystemExit) as ended:
                runpy.run_module("tests.paper", run_name="__main__")
            assert ended.value.code in (0, None)
        records.append(json.loads((tmp_path / place / "audit.json").read_text(encoding="utf-8")))
        told = records[-1]["provenance"]
        assert told["command"] == " ".join(["geomint", "audit", *line])
        assert {"geomint", "numpy", "python"} <= set(told["versions"])
    first, second = (record["claims"] for record in records)
    assert first == second
    page = (tmp_path / "one" / "audit.html").read_text(encoding="utf-8")
    assert all(escape(claim["statement"]) in page for claim in first)
    rows = (tmp_path / "one" / "audit.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 1 + len(first)
    row = {claim["label"]: claim for claim in first}
    assert row["extended2"]["residual"] >= FAILS
    assert row["extended2"]["corrected_residual"] <= HOLDS
    assert row["extended2"]["points"] == 4
    assert row["kk"]["corrected"] is None
    assert row["phi"]["residual"] is None
    assert row["theorem:ro"]["off_manifold_residual"] >= FAILS
    assert records[0]["n"] == [3, 4]
    assert "`extended2`" in (tmp_path / "one.md").read_text(encoding="utf-8")


def test_what_is_printed(monkeypatch):
    only(monkeypatch, CLAIM["extended2"], CLAIM["kk"])
    short = invoke("--n", "3", "--points", "1").output
    assert "extended2" not in short
    assert "5.3" in short
    findings = invoke("--n", "3", "--points", "1", "--list", "findings").output
    assert "extended2" in findings
    assert "kk" not in findings
    listed = invoke("--n", "3", "--points", "1", "--list", "all").output
    assert "kk" in listed
    assert ": 1 claims" in listed  # below its section
    assert invoke("--n", "3", "--points", "1", "--quiet").output == ""


@pytest.mark.parametrize("text", ["", "1,2", "8", "three"])
def test_bad_dimensions_are_named(text):
    result = invoke("--n", text)
    assert isinstance(result.exception, gi.DomainError)
    assert "--n" in str(result.exception)


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Let the command of an installation be called; return the folder around the package."""
    folder = tmp_path / "lib"
    (folder / "site-packages" / "chaplygin").mkdir(parents=True)
    file = shutil.copy(commands.__file__, folder / "site-packages" / "chaplygin")
    monkeypatch.setattr(commands, "audit", runpy.run_path(file)["audit"])
    return folder


def test_without_sources_it_is_said_where_the_audit_lies(installed):
    for words in ([], ["--n", "3", "--out", "x"], ["--quiet"]):
        result = CliRunner().invoke(main, ["audit", *words])
        assert result.exit_code == 2
        assert len(result.stderr.splitlines()) == 1
        assert "tests/paper" in result.stderr
        assert "python -m tests.paper" in result.stderr
    result = CliRunner().invoke(main, ["audit", "--help"])
    assert result.exit_code == 0
    assert "tests/paper" in result.stdout


@pytest.mark.parametrize("place", ["current folder", "another project", "another package"])
def test_strangers_code_is_not_run(place, tmp_path, monkeypatch):
    """Whether it lies in the current folder, around the package, or was imported before."""
    (tmp_path / "tests" / "paper").mkdir(parents=True)
    for name in ("__init__.py", "paper/__init__.py", "paper/command.py"):
        (tmp_path / "tests" / name).write_text("raise SystemExit(99)", encoding="utf-8")
    named = "other" if place == "another project" else "geomint"
    (tmp_path / "pyproject.toml").write_text(f'[project]\nname = "{named}"\n', encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    for name in [n for n in sys.modules if n.partition(".")[0] == "tests"]:
        monkeypatch.delitem(sys.modules, name)
    if place == "another package":
        monkeypatch.setitem(sys.modules, "tests", types.ModuleType("tests"))
    lies = {"current folder": tmp_path / "lib", "another project": tmp_path}
    monkeypatch.setattr(commands, "SOURCES", lies.get(place, ROOT))
    given = click.Command("audit")
    assert commands._of_sources(given) is given


def test_json_schema(found):
    document = as_json(found)
    json.dumps(document, allow_nan=False)
    assert {"claims", "n", "points", "seed"} <= set(document)
    for row in document["claims"]:
        assert row["verdict"] in VERDICTS
        assert {"label", "statement", "residual", "corrected", "corrected_residual"} <= set(row)
        if row["verdict"] == "not checkable numerically":
            assert row["reason"]
        else:
            assert row["residual"] is not None
        if row["verdict"] in ("misprint", "needs a restriction"):
            assert row["corrected"]
            assert row["corrected_residual"] <= HOLDS


def test_markdown_has_every_claim(found):
    text = markdown(found)
    for result in found.results:
        assert f"| `{result.claim.label}`" in text
    rows = [line for line in text.splitlines() if line.startswith("| `")]
    widths = {len(re.split(r"(?<!\\)\|", row)) for row in rows}
    assert widths == {6, 7}


def rows_of(text):
    """Return statement and verdict by label of the tables of all claims, whatever the residuals."""
    rows = {}
    for line in text[text.index("### 1 ") :].splitlines():
        if line.startswith("| `"):
            place, statement, _, _, verdict = re.split(r"(?<!\\)\|", line)[1:6]
            rows[place.split("`")[1]] = (statement, verdict)
    return rows


@pytest.mark.nightly
def test_the_docs_page_is_up_to_date():
    assert rows_of(TABLE.read_text(encoding="utf-8")) == rows_of(markdown(audit(points=1)))


def test_the_docs_page_lists_the_claims(found):
    assert set(rows_of(TABLE.read_text(encoding="utf-8"))) == set(rows_of(markdown(found)))
