"""Pictures of exact motions, and the command that makes them."""

import csv
import json

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

import chaplygin as ch
import geomint as gi
from chaplygin.pictures.diagrams import draw_bifurcations, draw_rotation_numbers
from chaplygin.pictures.motion import TURNS, draw_vertical, motion_figure
from geomint.cli import main
from tests.chaplygin.exact_support import problem_of


@pytest.fixture(scope="module")
def path():
    problem = ch.ChaplyginSphere(
        inertia=ch.SpecialInertia.from_moments([1.0, 1.5, 2.6], 1.0)
    ).classical()
    return ch.ContactPath(problem.exact(problem.random_state(1)), 1.0)


def test_the_vertical_stays_within_its_curves(path):
    """Where the trajectory goes the λ are inside of their ovals; the curves are at their ends."""
    figure = motion_figure(path.exact, path)
    assert len(figure.axes) == 4
    curves = [line for line in figure.axes[0].lines if line.get_color() == "#d55e00"]
    free = [e for o in path.exact.separation.ovals for e in (o.low_axis, o.high_axis) if e is None]
    assert len(curves) == 2 * 8 * len(free)
    for line in figure.axes[0].lines:
        points = np.array(line.get_data())
        inside = np.hypot(*points)
        assert np.nanmax(inside, initial=0.0) < 1.0 + 1e-12
    straight, curved = (np.array(line.get_data()) for line in figure.axes[2].lines)
    ratio = path.exact.frequencies[1] / path.exact.frequencies[0]
    np.testing.assert_allclose(np.diff(straight[1]), ratio * np.diff(straight[0]), atol=1e-9)
    assert 0.0 < np.max(np.abs(curved - straight)) < 1.0  # θ and φ are the same after each turn
    (trace,) = next(a for a in figure.axes if a.get_title().startswith("contact point")).lines
    end = 2 * np.pi * TURNS / np.max(np.abs(path.exact.mean_frequencies))
    np.testing.assert_allclose(trace.get_xydata()[-1], path.contact(end) - end * path.drift)


def test_figures_of_all_kinds_of_tori():
    """Their vertical is drawn in three dimensions, else refused."""
    for pattern in ("2", "4", "lagrange", "circle-4"):
        problem = problem_of(pattern, "sphere-tau")
        exact = problem.exact(problem.random_state(1))
        assert len(motion_figure(exact).axes) == (3 if pattern == "lagrange" else 2)
        if pattern == "4":
            with pytest.raises(gi.DomainError, match="three dimensions"):
                draw_vertical(Figure().subplots(), exact)


def test_diagrams():
    a, D = [0.8, 1.1, 1.5], 4.0
    problem = ch.ChaplyginSphere(a, D).hamiltonized()
    states = [problem.random_state(seed) for seed in range(5)]
    axes = Figure().subplots(1, 2)
    draw_bifurcations(axes[0], a, D, states)
    heights = sorted(line.get_ydata()[0] for line in axes[0].lines[:3])
    np.testing.assert_allclose(heights, sorted(ch.critical_energies(a, D, 1.0)))
    found = draw_rotation_numbers(axes[1], problem, states, "number", range(5))
    expected = ch.frequency_map(problem, states).rotation_numbers
    np.testing.assert_array_equal(found, expected)


def test_the_discriminant():
    """It vanishes at the critical energies, and is the product of squared distances of e and a_i."""
    a, D, K = np.array([0.8, 1.1, 1.5]), 4.0, 2.0
    for H in ch.critical_energies(a, D, K):
        assert ch.discriminant(a, D, K, H) < 1e-28
    problem = ch.ChaplyginSphere(a, D).hamiltonized()
    y = problem.random_state(2)
    exact = problem.exact(y)
    K, H = gi.value(problem, "K", y), gi.value(problem, "energy", y)
    e = next(end for end in exact.ovals.ravel() if np.min(np.abs(end - a)) > 1e-9)
    r1 = K / D - 2 * H
    expected = np.prod((e - a) ** 2) * (D * r1) ** 6
    assert ch.discriminant(a, D, K, H) == pytest.approx(expected, rel=1e-10)


def run(*words):
    return CliRunner().invoke(main, ["exact", *words])


@pytest.mark.usefixtures("blank_pictures")
def test_the_command(tmp_path):
    result = run("hamiltonized-n3", "--at", "0,1e9", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "frequency in τ" in result.output
    assert "t = 1000000000:" in result.output
    assert (tmp_path / "exact.png").exists()
    record = json.loads((tmp_path / "exact.json").read_text("utf-8"))
    scene = gi.load_scene("hamiltonized-n3")
    exact = scene.problem.exact(scene.state)
    assert record["frequencies"] == exact.frequencies.tolist()
    assert record["mean_frequencies"] == exact.mean_frequencies.tolist()
    assert [row["t"] for row in record["states"]] == [0.0, 1e9]
    assert record["states"][1]["state"] == exact(1e9).tolist()
    with (tmp_path / "exact.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))[1:]
    numbers = np.array(rows, float)
    np.testing.assert_array_equal(numbers[:, 3:], exact.at_tau(numbers[:, 0]))
    ends = np.array(record["ovals"])
    assert np.all(numbers[:, 1:3] >= ends[:, 0] - 1e-12)
    assert np.all(numbers[:, 1:3] <= ends[:, 1] + 1e-12)
    page = (tmp_path / "exact.html").read_text("utf-8")
    turn, mean = 2.0 * np.pi / np.max(np.abs(exact.frequencies)), exact.mean_frequencies
    ends = [" … ".join(f"{x:.15g}" for x in oval) for oval in exact.ovals]
    facts = [
        f"{exact.condition:.3g}<",
        f"{exact.longest:.3g}<",
        f"{turn:.6g}<",
        f"{abs(mean[1]):.15g}",
    ]
    told = f"A unit of τ takes {exact.clock.mean:.6g} of t", "a = (0.8, 1.1, 1.5)", "quasi-periodic"
    for word in (scene.title, "hamiltonized-n3", f"{turn:.6g}", f"{abs(mean[1]):.15g}", told[0]):
        assert word in " ".join(result.output.split())
    for word in (scene.title, "hamiltonized-n3", *told, "What to cite", *facts, *ends):
        assert word in page


def test_a_film(tmp_path):
    result = run("hamiltonized-n3", "--animate", str(tmp_path / "r.gif"), "--frames", "2")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "r.gif").stat().st_size > 1000


@pytest.mark.nightly
@pytest.mark.parametrize("scene", ["veselova-classical", "rubber-ball-n3", "veselova-n4"])
def test_pages_of_other_systems(scene, tmp_path):
    """Of any dimension, with and without a contact point."""
    result = run(scene, "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    page = (tmp_path / "exact.html").read_text("utf-8")
    figure = page.split("<figure", 1)[1].split("</figure>")[0]
    assert figure.count("data:image") == (2 if scene == "veselova-n4" else 3)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("neumann-n3", "no representation of this scene"),
        ("veselova-n4 --animate x.gif", "ball in R³"),
        ("hamiltonized-n3 --at 1,x", "commas"),
        ("hamiltonized-n3 --at nan", "finite"),
        ("hamiltonized-n3 --frames 5", "--animate"),
        ("hamiltonized-n3 --paper", "--out"),
        ("homogeneous-n4 --out x", "steady turn"),
        ("ball-3d --animate a.gif --frames 1000000000", "10000"),  # all are held in memory
    ],
)
def test_bad_command_lines(words, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*words.split())
    assert result.exit_code == 2
    assert told in result.stderr
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]
