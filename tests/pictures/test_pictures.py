"""Pictures of motions show what the run has, with words, units and times."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text

import chaplygin as ch
import geomint as gi

BALL = ch.ChaplyginSphere.from_moments([1.0, 2.0, 3.0], m=1.0, rho=1.0)


def run(problem: gi.Problem, y0: Any = None, **given: Any) -> gi.Solution:
    y0 = problem.random_state(1) if y0 is None else y0
    more = {"t_end": 12.0, "step": 0.1, "method": "gauss-4", "dense": True, "progress": False}
    return gi.solve(problem, y0, **{**more, **given})


@pytest.fixture(scope="module")
def rolling() -> gi.Solution:
    return run(BALL.contact(rho=1.0))


@pytest.fixture(scope="module")
def few() -> gi.Solution:
    return run(BALL.contact(rho=1.0), dense=False, save_every=20)


def texts(figure: Any) -> str:
    return "\n".join(t.get_text() for t in figure.findobj(Text))


def test_the_pieces_over_time(rolling: gi.Solution) -> None:
    figure = rolling.plot()
    assert len(figure.axes) == len(rolling.problem.pieces)
    assert figure.canvas.manager is None  # a figure of pyplot would be one of the user's
    words = texts(figure)
    for word in ("ball-with-contact, gauss-4, t = 0 … 12", "γ[2]", "g[2, 1]", "t (dimensionless)"):
        assert word in words
    for line in figure.axes[0].lines:
        assert line.get_linestyle() != "None"


def test_what_is_named_over_time(rolling: gi.Solution) -> None:
    figure = rolling.plot("gamma[2]", "energy", "contact-1", span=(2.0, 5.0))
    assert "t = 2 … 5" in texts(figure)
    (gamma,), (energy,), (contact,) = (axes.lines for axes in figure.axes)
    t, y = gamma.get_data()
    states = rolling.sol(t)
    slices = rolling.problem.slices
    np.testing.assert_allclose(y, states[:, slices["gamma"].start + 2])
    np.testing.assert_allclose(contact.get_ydata(), states[:, slices["r"].start])
    expected = gi.value(rolling.problem, "energy", states[7])
    assert energy.get_ydata()[7] == pytest.approx(expected, rel=1e-14)
    low, high = figure.axes[1].get_ylim()
    assert high - low > 0.01  # not the roundings of what is constant


def test_a_phase_plane(rolling: gi.Solution) -> None:
    axes = rolling.plot_phase("gamma[0]", "gamma[1]").axes[0]
    x, y = axes.lines[0].get_data()
    assert np.all(np.hypot(x, y) <= 1.0 + 1e-12)
    assert axes.get_aspect() == 1.0
    assert axes.get_xlabel() == "γ[0] (dimensionless)"
    assert rolling.plot_phase("gamma[0]", "energy").axes[0].get_aspect() == "auto"


def test_the_sphere(rolling: gi.Solution) -> None:
    """In front and behind together it is the whole path, one of both at every sample."""
    view = gi.View(30.0, 20.0)
    axes = rolling.plot_sphere(view=view).axes[0]
    lines = [line for line in axes.lines if line.get_color() == "#0072B2"]
    back, front = (np.array(line.get_data()).T for line in lines)
    assert (np.isnan(front).any(axis=1) != np.isnan(back).any(axis=1)).all()
    seen = np.where(np.isnan(front), back, front)
    assert np.max(np.hypot(*seen.T)) <= 1.0 + 1e-12
    np.testing.assert_allclose(seen[0], view(rolling.sol(0.0)[3:6])[:2], atol=1e-12)
    dots = [line.get_xydata()[0] for line in axes.lines if line.get_marker() == "."]
    np.testing.assert_allclose(dots, view.axes[:2].T)  # where the axes leave the sphere
    other = rolling.plot_sphere("k").axes[0]
    assert "k[0]" in {t.get_text() for t in other.texts}


def test_the_trace(rolling: gi.Solution) -> None:
    figure = rolling.plot_trace()
    assert figure._repr_png_()[1:4] == b"PNG"  # as a notebook shows it
    (axes,) = figure.axes
    x, y = axes.lines[0].get_data()
    r = rolling.sol(12.0)[rolling.problem.slices["r"]]
    np.testing.assert_allclose([x[-1], y[-1]], r)
    assert (axes.get_xlabel(), axes.get_aspect()) == ("r[0] (dimensionless)", 1.0)


@pytest.mark.parametrize("name", ["plot", "plot_sphere", "plot_trace"])
def test_few_states_are_points_and_are_told(few: gi.Solution, name: str) -> None:
    figure = getattr(few, name)()
    assert "7 saved states, too far apart for a curve" in texts(figure).replace("\n", " ")
    shown = [line for axes in figure.axes for line in axes.lines if line.get_marker() == "."]
    assert sum(len(line.get_xdata()) for line in shown) >= 7
    blue = [line for axes in figure.axes for line in axes.lines if line.get_color() == "#0072B2"]
    assert all(line.get_linestyle() == "None" for line in blue)


def test_pieces_of_one_number_and_without_names() -> None:
    @gi.field
    def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = y[1]
        out[1] = -gi.sin(y[0])

    pendulum = gi.Problem("pendulum", (("angle", 1), ("momentum", 1)), field=motion)
    solution = run(pendulum, [2.0, 0.0], compiled=False, method="rk-4", save_every=1, dense=False)
    assert "angle" in texts(solution.plot())
    assert len(solution.plot("angle").axes) == 1
    label = solution.plot_phase("angle", "momentum").axes[0].get_ylabel()
    assert label == "momentum (dimensionless)"
    for call, told in (
        (lambda: solution.plot_sphere(), r"has angle \(1\), momentum \(1\)"),
        (lambda: solution.animate("x.gif"), r"has angle \(1\), momentum \(1\)"),
        (lambda: solution.plot_trace(), "rolling ball"),
    ):
        with pytest.raises(gi.DomainError, match=told):
            call()


def test_a_body_about_a_fixed_point_has_no_contact_point() -> None:
    problem = ch.VeselovaLR([1.0, 1.5, 2.2], r=1).lr()
    more = {"compiled": False, "method": "rk-4", "save_every": 1, "dense": False}
    solution = run(problem, t_end=2.0, **more)
    assert solution.plot_sphere().axes
    with pytest.raises(gi.DomainError, match="fixed point"):
        solution.plot_trace()


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda s: s.plot("gama"), "gamma"),
        (lambda s: s.plot("gamma[3]"), r"gamma\[0\] to gamma\[2\]"),
        (lambda s: s.plot(3), "name"),
        (lambda s: s.plot_phase("gamma", "k[0]"), r"gamma\[0\] to gamma\[2\]"),
        (lambda s: s.plot_phase("nothing", "k[0]"), "nothing"),
        (lambda s: s.plot_sphere("g"), "three numbers"),
        (lambda s: s.plot_sphere(3), "three numbers"),
        (lambda s: s.plot_trace(span=(0.0, 99.0)), "within the run"),
    ],
)
def test_names_that_are_not_there(rolling: gi.Solution, call: Any, told: str) -> None:
    with pytest.raises(gi.DomainError, match=told):
        call(rolling)


def test_a_view_is_a_rotation() -> None:
    for view in (gi.View(30.0, 40.0), gi.View(0.0, 90.0), gi.View(-360.0, -90.0)):
        np.testing.assert_allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(view.axes) == pytest.approx(1.0)
    assert gi.View().axes[1, 2] > 0.0  # E_3 points upwards
    for wrong in ({"azimuth": np.nan}, {"elevation": 91.0}, {"azimuth": "left"}):
        with pytest.raises(gi.DomainError, match=next(iter(wrong))):
            gi.View(**wrong)


def test_what_a_file_gives_back_is_drawn(few: gi.Solution, tmp_path: Any) -> None:
    few.save(tmp_path / "run.nc")
    saved = gi.load(tmp_path / "run.nc", few.problem)
    for call in (lambda s: s.plot("gamma", "energy"), lambda s: s.plot_trace()):
        assert texts(call(saved)) == texts(call(few))
