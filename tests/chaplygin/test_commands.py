"""The command `geomint inertia`."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

import chaplygin as ch
from geomint.cli import main


def run(*words):
    return CliRunner().invoke(main, ["inertia", *words])


def test_moments_and_back():
    result = run("--moments", "1,2,3", "--m", "2", "--rho", "1.5")
    assert result.exit_code == 0
    lines = dict(line.split(" = ", 1) for line in result.output.splitlines())
    assert float(lines["D"]) == 4.5
    a = [float(x) for x in lines["a"].strip("[]").split(",")]
    assert ch.SpecialInertia(a, 4.5).moments == pytest.approx([1, 2, 3], rel=1e-14)
    assert [float(x) for x in lines["moments"].strip("[]").split(",")] == pytest.approx([1, 2, 3])
    entries = [line.split(" ")[2] for line in result.output.splitlines() if line[:2] == "I("]
    assert [float(x) for x in entries] == pytest.approx([3, 2, 1])


def test_a_in_dimension_four():
    result = run("--a", "0.8,1,1.1,1.2", "--d", "4")
    assert "I(E_3∧E_4)" in result.output
    assert "moments" not in result.output


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--d 4", "exactly one"),
        ("--a 1,x --d 4", "commas"),
        ("--a 3,2 --d 4", "a = "),
        ("--moments 1,2,3", "--rho"),
        ("--moments 1,2,3 --d 1 --m 1", "alone"),
        ("--moments 1,2,3 --m -1 --rho 1", "--m"),
        ("--moments 1,2,3 --m -1 --rho -1", "--rho"),
        ("--moments 1,2,3 --m 1 --rho 1e308", "--m rho² = inf"),
        ("--moments 1,2,3 --m 1 --rho 1e-308", "--m rho² = 0"),
        ("--moments , --d 1", "numbers with commas"),
    ],
)
def test_bad_input_is_named(words, told):
    result = run(*words.split())
    assert result.exit_code == 2
    assert told in result.stderr
