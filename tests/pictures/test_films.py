"""Films: as many frames as they say, at the times that they say, of what turns as it turns."""

from __future__ import annotations

import itertools
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.animation import FFMpegWriter
from matplotlib.figure import Figure
from PIL import Image

import chaplygin as ch
import geomint as gi

BALL = ch.ChaplyginSphere.from_moments([1.0, 2.0, 3.0], m=1.0, rho=1.0)


def roll(y0: dict[str, Any], end: float, step: float, **given: Any) -> gi.Solution:
    problem = BALL.contact(rho=1.0)
    run = {"t_end": end, "step": step, "method": "gauss-4", "dense": True}
    return gi.solve(problem, problem.state(gamma=[0.6, 0.0, 0.8], **y0), **{**run, **given})


@pytest.fixture(scope="module")
def rolling() -> gi.Solution:
    return roll({"k": [6.0, -2.0, 7.0]}, 40.0, 0.1)


@pytest.fixture
def frames(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    """What films would draw: words, their time, and where lines are; nothing is drawn."""

    def film(solution: gi.Solution, **given: Any) -> list[Any]:
        found: list[Any] = []

        def note(figure: Figure, to: Any, **_: Any) -> None:
            words = figure.texts[0].get_text()
            time = float(re.findall(r"[tτ] = (\S+)", words)[-1])
            axes = figure.axes[0]
            lines = [np.array(line.get_data(), float).T for line in axes.lines]
            found.append((time, words, lines, (*axes.get_xlim(), *axes.get_ylim())))

        monkeypatch.setattr(Figure, "savefig", note)
        solution.animate(tmp_path / "a.html", **given)
        return found

    return film


def ends(lines: list[Any], point: Any) -> bool:
    """Tell whether any of the lines ends at a point of the picture."""
    return any(len(x) and np.allclose(x[-1], gi.View()(point)[:2], atol=1e-9) for x in lines)


@pytest.mark.parametrize("follow", [False, True])
def test_a_gif(rolling: gi.Solution, tmp_path: Path, follow: bool) -> None:
    seen: list[tuple[int, int]] = []
    given = {"span": (2.0, 2.2), "fps": 10.0, "speed": 1.0, "follow": follow}
    path = rolling.animate(tmp_path / "a.gif", **given, progress=lambda i, n: seen.append((i, n)))
    with Image.open(path) as image:
        pictures = []
        for i in range(image.n_frames):
            image.seek(i)
            pictures.append(np.asarray(image.convert("L")).astype(int))
    assert len(pictures) == 3 == len(seen)
    assert all(np.any(x != y) for x, y in itertools.pairwise(pictures))


def test_a_page(rolling: gi.Solution, tmp_path: Path) -> None:
    path = rolling.animate(tmp_path / "a.html", span=(0.0, 0.2), fps=10.0, speed=1.0)
    page = path.read_text(encoding="utf-8")
    assert page.count("iVBORw0KGgo") == 3
    assert not re.findall(r"(?:src|href)=.http|https?://", page)
    assert "t = 0 … 0.2" in page


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_a_video(rolling: gi.Solution, tmp_path: Path) -> None:
    path = rolling.animate(tmp_path / "a.mp4", span=(0.0, 0.3), fps=10.0, speed=1.0)
    assert path.read_bytes()[4:8] == b"ftyp"


def test_without_ffmpeg(
    rolling: gi.Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(gi.DomainError, match=r"\.gif or \.html.*ffmpeg"):
        rolling.animate(tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []


def test_frames_are_where_the_ball_is(rolling: gi.Solution, frames: Any) -> None:
    """`speed` is time of the motion over time of the film, the last frame at the end."""
    found = frames(rolling, span=(10.0, 16.0), fps=20.0, speed=3.0)
    times = np.linspace(10.0, 16.0, 41)
    np.testing.assert_allclose([frame[0] for frame in found], times, atol=0.0051)
    assert "t = 16.00 (dimensionless)" in found[-1][1]
    for t, (_, _, lines, _) in zip(times, found, strict=True):
        contact = rolling.sol(t)[rolling.problem.slices["r"]]
        assert ends(lines, [*contact, 0.0])


@pytest.mark.parametrize("follow", [False, True])
def test_what_a_frame_shows(rolling: gi.Solution, frames: Any, follow: bool) -> None:
    """Circles of the body, before and behind; a grid of radii around all of the trace, or the ball."""
    found = frames(rolling, span=(10.0, 10.2), fps=10.0, speed=1.0, follow=follow)
    view, where, angle = gi.View(), rolling.problem.slices, np.linspace(0.0, 2.0 * np.pi, 73)
    circle = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    trace = rolling.sol(np.linspace(10.0, 10.2, 401))[:, where["r"]]
    around = 1.6 + 8.0 * follow
    low, high = np.floor(trace.min(axis=0) - around), np.ceil(trace.max(axis=0) + around)
    sides = itertools.product((0.0, 2.0), (low[0], high[0]), (low[1], high[1]))
    corners = view(np.array([(x, y, z) for z, x, y in sides]))
    for time, (_, _, lines, window) in zip((10.0, 10.1, 10.2), found, strict=True):
        grid = np.array([line for line in lines[:-8] if len(line) == 2]).reshape(-1, 2)
        assert len(grid) == 2 * (high - low + 1.0).sum()
        for end in (np.min, np.max):
            np.testing.assert_allclose(end(grid, axis=0), end(corners[:4, :2], axis=0))
        y = rolling.sol(time)
        middle, g = view(np.array([*y[where["r"]], 1.0]))[:2], y[where["g"]].reshape(3, 3)
        half = 4.0 * np.array([1.0, 4.4 * 0.84 / (6.4 * 0.96)])
        limits = [middle - half, middle + half]
        limits = limits if follow else [np.min(corners, axis=0)[:2], np.max(corners, axis=0)[:2]]
        np.testing.assert_allclose(window, np.transpose(limits).ravel())
        np.testing.assert_allclose(lines[-7], middle + circle[:, :2])
        for number, shift in enumerate((1, 2, 0)):
            shown = view(np.roll(circle, shift, axis=1) @ g.T)
            before = shown[:, 2:] >= 0.0
            for line, there in zip(lines[-6 + 2 * number :][:2], (before, ~before), strict=True):
                np.testing.assert_allclose(line, np.where(there, middle + shown[:, :2], np.nan))


def test_a_film_without_a_speed(rolling: gi.Solution, frames: Any) -> None:
    """At most twelve seconds: a calm beginning, or all of the span that is named."""
    times = [frame[0] for frame in frames(rolling)]
    assert len(times) == 12 * 25 + 1
    assert times[-1] < 40.0
    attitudes = rolling.sol(np.linspace(0.0, times[-1], 301))[:, rolling.problem.slices["g"]]
    attitudes = attitudes.reshape(-1, 3, 3)
    cosines = np.einsum("kij,kij->k", attitudes[1:], attitudes[:-1])
    turns = np.arccos(0.5 * (cosines - 1.0)) / (2 * np.pi) * 25.0
    assert 0.175 < turns.max() <= 0.354  # of a turn a second: 0.35
    assert frames(rolling, span=(0.0, 40.0), fps=30.0)[-1][0] == 40.0
    with pytest.warns(gi.GeomintWarning, match="of a turn between two frames"):
        frames(rolling, span=(0.0, 4.0), fps=5.0, speed=10.0)


def test_saved_states_are_filmed(frames: Any) -> None:
    """Each frame is a state that there is, and bears its time."""
    solution = roll({"k": [1.0, 2.0, 3.0]}, 6.0, 0.05, dense=False, save_every=1)
    for time, _, lines, _ in frames(solution, fps=7.0, speed=1.0):
        nearest = np.argmin(np.abs(solution.t - time))
        assert solution.t[nearest] == pytest.approx(time, abs=0.0051)
        assert ends(lines, [*solution.y[nearest, solution.problem.slices["r"]], 0.0])


def test_what_has_no_attitude_is_a_direction(frames: Any) -> None:
    """In τ, with its clock the ball; backwards from the last to the first."""
    hamiltonized = BALL.hamiltonized()
    given = {"method": "rk-4", "step": 0.1, "save_every": 1, "compiled": False}
    y0 = hamiltonized.random_state(1)
    solution = gi.solve(hamiltonized, y0, tau_end=-3.0, **given, clock=False)
    found = frames(solution, fps=2.0, speed=1.0)
    assert "τ = -0.50" in found[1][1]
    for row, (_, _, lines, window) in zip(range(0, 31, 5), found, strict=True):
        trail = gi.View()(solution.y[max(0, row - 8) : row + 1, :3])  # a quarter of the frames
        before = trail[:, 2:] >= 0.0
        for line, there in zip(lines[-3:], (before, ~before, before | True), strict=True):
            np.testing.assert_allclose(line, np.where(there, trail[:, :2], np.nan)[-len(line) :])
        assert ([len(line) for line in lines[-3:]]) == [len(trail), len(trail), 1]
        assert window == (-1.3, 1.3, -1.25, 1.25)
    assert "t = " in frames(gi.solve(hamiltonized, y0, tau_end=3.0, **given), fps=8.0)[1][1]
    neumann = ch.neumann_problem([1.0, 2.0, 3.5])
    solution = gi.solve(neumann, neumann.random_state(1), t_end=3.0, **given)
    assert ends(frames(solution, span=(0.0, 0.5), fps=4.0, speed=1.0)[-1][2], solution.y[5, :3])


def test_a_ball_at_rest(frames: Any) -> None:
    found = frames(roll({"k": np.zeros(3)}, 1.0, 0.25), fps=0.5)
    assert len(found) == 7
    assert ends(found[-1][2], [0.0, 0.0, 0.0])


def test_what_is_no_film(rolling: gi.Solution, tmp_path: Path) -> None:
    for given, told in (
        ({"file": "a.avi"}, "ends in .gif, .html, .mp4"),
        ({"file": 3}, "ends in .gif, .html, .mp4"),
        ({"fps": 0.0}, "fps"),
        ({"speed": -1.0}, "speed"),
        ({"speed": 1e-9}, "at least"),
        ({"follow": 1}, "follow"),
        ({"span": (0.0, 1e9)}, "within the run"),
    ):
        with pytest.raises(gi.DomainError, match=told):
            rolling.animate(**{"file": tmp_path / "a.gif", **given})
    (tmp_path / "a.gif").mkdir()
    with pytest.raises(gi.OutputError):
        rolling.animate(tmp_path / "a.gif")
