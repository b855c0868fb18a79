"""A drift report opens with the motion; what is within round-off is folded."""

from __future__ import annotations

import copy
import dataclasses
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.plan.first_turns import MOST_STEPS, FirstTurns, first_turns
from geomint.plots.drift_plots import panel_figure
from geomint.report.kinds import by_roundoff
from geomint.report.motion_panels import motion_draws
from geomint.run.stretch import stretch_of

SHORT = {"t_end": 30.0}


class Order(HTMLParser):
    """Headings, pictures, and whether a picture is folded."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, str]] = []
        self.folds = 0

    def handle_starttag(self, tag: str, attributes: Any) -> None:
        self.folds += tag == "details"
        if tag == "img":
            kind = "folded" if self.folds else "picture"
            self.found.append((kind, dict(attributes)["alt"]))

    def handle_endtag(self, tag: str) -> None:
        self.folds -= tag == "details"


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> tuple[gi.SeveralRuns, str]:
    folder = tmp_path_factory.mktemp("report")
    scene = gi.load_scene("ball-3d").changed(time=SHORT)
    result = gi.drift_report(scene, folder, progress=False)
    return result, (folder / "report.html").read_text(encoding="utf-8")


def test_the_motion_comes_first(reported: tuple[gi.SeveralRuns, str]) -> None:
    result, page = reported
    order = Order()
    order.feed(page)
    words = [alt for _, alt in order.found]
    assert words[0] == "the path of gamma on the unit sphere"
    assert words[1] == "the path of the contact point in the plane"
    assert words[2].startswith("γ₁, γ₂, γ₃ over time")
    assert page.index("The motion") < page.index("What was kept")
    assert "k̇ = k × ω,  γ̇ = γ × ω" in page
    assert "The first turns, t = 0 … 30, by cf-4." in page
    assert result.motion is not None
    assert result.motion.stretch.joined


def test_what_is_within_roundoff_is_folded(reported: tuple[gi.SeveralRuns, str]) -> None:
    result, page = reported
    order = Order()
    order.feed(page)
    shown, folded = by_roundoff(result)
    assert list(shown) == ["energy", "measure"]
    for kind, names in (("picture", shown), ("folded", folded)):
        alts = " ".join(alt for found, alt in order.found if found == kind)
        assert all(name in alts for several in names.values() for name in several)
    assert "32 ε × scale: K, area, norm, spatial-momentum</summary>" in page
    for name in ("K", "area", "norm", "spatial-momentum"):  # their figures are in the table
        drift = result[0].drift[name]
        assert drift.within_roundoff
        assert f"{drift.max_abs_error:.3g}" in page


def test_one_quantity_beyond_roundoff_shows_its_kind(
    reported: tuple[gi.SeveralRuns, str],
) -> None:
    run = reported[0][0]
    assert run.solution is not None
    lost = dataclasses.replace(run.drift["norm"], max_abs_error=1.0)
    solution = copy.copy(run.solution)
    solution.drift = {**run.drift, "norm": lost}
    result = gi.SeveralRuns(reported[0].scene, [dataclasses.replace(run, solution=solution)])
    shown, folded = by_roundoff(result)
    assert shown["constraints"] == ["norm", "spatial-momentum"]
    assert "constraints" not in folded


def test_the_first_turns_are_those_of_the_run(reported: tuple[gi.SeveralRuns, str]) -> None:
    result, _ = reported
    plan = result[0].plan
    assert plan is not None
    assert result.motion is not None
    stretch = result.motion.stretch
    run = gi.solve(
        plan.problem, plan.state, t_end=30.0, method="cf-4", step=0.02, t_eval=stretch.times
    )
    np.testing.assert_allclose(stretch.states, run.y, atol=1e-13)


@pytest.mark.parametrize("name", gi.scene_names())
def test_every_scene_has_equations(name: str) -> None:
    for problem in gi.load_scene(name).model.problems.values():
        assert problem.equations, problem.name


FEW = ("hamiltonized-n3", "rolling-ball-n4", "ellipsoid-n4")
OTHERS = [pytest.param(n, marks=pytest.mark.nightly) for n in gi.scene_names() if n not in FEW]


@pytest.mark.parametrize("name", [*FEW, *OTHERS])
def test_every_scene_has_a_picture(name: str) -> None:
    scene = gi.load_scene(name)
    plan = gi.make_plan(scene.for_drift(), "drift")
    motion = first_turns(plan)
    assert motion is not None
    assert motion.stretch.joined
    assert len(motion.stretch.times) <= MOST_STEPS
    result = gi.SeveralRuns(scene, motion=motion)
    assert len(motion_draws(result)) >= 2


def test_where_the_run_fails_there_is_what_was_reached(tmp_path: Path) -> None:
    scene = gi.load_scene("hamiltonized-n3").changed(
        time={"tau_end": 100.0},
        integrate={"method": "gauss-2", "step": 3.0},
        observe={"quantities": ["energy"]},
    )
    result = gi.drift_report(scene, tmp_path, progress=False, methods=["gauss-2", "rk-4:0.1"])
    assert result["rk-4"].status == "success"
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert re.search(r"The motion", page)


def test_states_of_a_smaller_problem_are_lifted() -> None:
    """Equal parameters are integrated in fewer dimensions, and shown in all."""
    scene = gi.load_scene("homogeneous-n4").for_drift()
    plan = gi.make_plan(scene, "drift")
    motion = first_turns(plan)
    assert motion is not None
    assert motion.stretch.states.shape[1] == motion.problem.rows


@pytest.mark.parametrize("rows", [(1,), (2,), (1, 1), (9,)])
def test_systems_without_a_sphere(rows: tuple[int, ...]) -> None:
    """Of one number there is no plane; units are those of the problem."""

    @gi.field
    def falling(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        for i in range(len(y)):
            out[i] = -y[i]

    pieces = tuple((f"y{i}", count) for i, count in enumerate(rows))
    problem = gi.Problem("falling", pieces, field=falling, units={"t": "s", "y": "m"})
    solution = gi.solve(problem, np.ones(sum(rows)), t_end=2.0, method="rk-4", dense=True)
    motion = FirstTurns(problem, "rk-4", stretch_of(solution))
    draws = motion_draws(gi.SeveralRuns(gi.load_scene("ball-3d"), motion=motion))
    assert sum(each.square for each in draws) == (sum(rows) > 1)
    for each in draws:
        (axes,) = panel_figure(each.draw, square=each.square).axes
        assert "(m)" in axes.get_ylabel()
        assert axes.get_xlabel() in ("t (s)", "y0₁ (m)", "y0 (m)")


def test_nothing_to_show() -> None:
    result = gi.SeveralRuns(gi.load_scene("ball-3d"))
    assert motion_draws(result) == []
