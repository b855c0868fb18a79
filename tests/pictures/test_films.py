"""Films: as many frames as they say, at the times that they say, of what turns as it turns."""

from __future__ import annotations

import itertools
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import chaplygin as ch
import geomint as gi
from geomint.plots import film
from geomint.run import filmed

BALL = ch.ChaplyginSphere.from_moments([1.0, 2.0, 3.0], m=1.0, rho=1.0)


@pytest.fixture(scope="module")
def rolling() -> gi.Solution:
    problem = BALL.contact(rho=1.0)
    y0 = problem.state(gamma=[0.6, 0.0, 0.8], k=[6.0, -2.0, 7.0])
    return gi.solve(problem, y0, t_end=40.0, step=0.1, method="gauss-4", dense=True)


@pytest.fixture
def stamps(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What would be filmed, in place of a film."""
    found: list[Any] = []

    def note(scene: Any, stamp: Any, file: Path, fps: float, progress: Any) -> None:
        found.append((scene, stamp))
        file.write_bytes(b"film")

    monkeypatch.setattr(film, "save_film", note)
    return found


def frames(path: Path) -> list[Any]:
    with Image.open(path) as image:
        found = []
        for i in range(image.n_frames):
            image.seek(i)
            found.append(np.asarray(image.convert("L")).astype(int))
    return found


@pytest.mark.parametrize("follow", [False, True])
def test_a_gif(rolling: gi.Solution, tmp_path: Path, follow: bool) -> None:
    seen: list[tuple[int, int]] = []
    given = {"span": (2.0, 2.8), "fps": 10.0, "speed": 1.0, "follow": follow}
    path = rolling.animate(tmp_path / "a.gif", **given, progress=lambda i, n: seen.append((i, n)))
    pictures = frames(path)
    assert len(pictures) == 9 == len(seen)
    assert all(np.any(x != y) for x, y in itertools.pairwise(pictures))


def test_a_page(rolling: gi.Solution, tmp_path: Path) -> None:
    path = rolling.animate(tmp_path / "a.html", span=(0.0, 0.3), fps=10.0, speed=1.0)
    page = path.read_text(encoding="utf-8")
    assert page.count("iVBORw0KGgo") == 4
    assert not re.findall(r"(?:src|href)=.http|https?://", page)
    assert "t = 0 … 0.3" in page


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_a_video(rolling: gi.Solution, tmp_path: Path) -> None:
    path = rolling.animate(tmp_path / "a.mp4", span=(0.0, 0.3), fps=10.0, speed=1.0)
    assert path.read_bytes()[4:8] == b"ftyp"


def test_without_ffmpeg(
    rolling: gi.Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from matplotlib.animation import FFMpegWriter

    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(gi.DomainError, match=r"\.gif or \.html.*ffmpeg"):
        rolling.animate(tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []


def test_times_of_frames(rolling: gi.Solution, tmp_path: Path, stamps: list[Any]) -> None:
    """`speed` is time of the motion over time of the film, the last frame at the end."""
    rolling.animate(tmp_path / "a.gif", span=(10.0, 16.0), fps=20.0, speed=3.0)
    times = stamps[-1][1].times
    np.testing.assert_allclose(np.diff(times), 3.0 / 20.0, rtol=1e-12)
    assert times[[0, -1]].tolist() == [10.0, 16.0]
    assert "t = 10.00 (dimensionless)" in stamps[-1][1].at(0)


def test_a_film_without_a_speed(rolling: gi.Solution, tmp_path: Path, stamps: list[Any]) -> None:
    """At most twelve seconds: a calm beginning, or all of the span that is named."""
    rolling.animate(tmp_path / "a.gif")
    times = stamps[-1][1].times
    assert len(times) == filmed.SECONDS * 25 + 1
    assert times[-1] < 40.0
    attitudes = rolling.sol(times)[:, rolling.problem.slices["g"]].reshape(-1, 3, 3)
    cosines = np.einsum("kij,kij->k", attitudes[1:], attitudes[:-1])
    turns = np.arccos(0.5 * (cosines - 1.0)) / (2 * np.pi) * 25.0
    assert 0.5 * filmed.SLOW < turns.max() <= 1.01 * filmed.SLOW
    rolling.animate(tmp_path / "a.gif", span=(0.0, 40.0), fps=80.0)
    assert stamps[-1][1].times[-1] == 40.0


def test_frames_that_are_far_apart_are_told(
    rolling: gi.Solution, tmp_path: Path, stamps: list[Any]
) -> None:
    with pytest.warns(gi.GeomintWarning, match="of a turn between two frames"):
        rolling.animate(tmp_path / "a.gif", fps=5.0, speed=10.0)


def test_saved_states_are_filmed(tmp_path: Path, stamps: list[Any]) -> None:
    """Each frame is a state that there is, and bears its time."""
    problem = BALL.classical(attitude=True)
    y0 = problem.random_state(2)
    solution = gi.solve(problem, y0, t_end=6.0, step=0.05, method="cf-4", save_every=1)
    solution.animate(tmp_path / "a.gif", fps=7.0, speed=1.0)
    assert set(stamps[-1][1].times) <= set(solution.t)


def test_what_has_no_attitude_is_a_direction(tmp_path: Path, stamps: list[Any]) -> None:
    hamiltonized = BALL.hamiltonized()
    given = {"tau_end": 3.0, "method": "gauss-4", "step": 0.1, "dense": True}
    y0 = hamiltonized.random_state(1)
    gi.solve(hamiltonized, y0, **given, clock=False).animate(tmp_path / "a.gif")
    assert isinstance(stamps[-1][0], film.SphereScene)
    assert "τ = " in stamps[-1][1].at(1)
    gi.solve(hamiltonized, y0, **given, clock=True).animate(tmp_path / "a.gif")
    assert isinstance(stamps[-1][0], film.BallScene)
    neumann = ch.neumann_problem([1.0, 2.0, 3.5])
    solution = gi.solve(neumann, neumann.random_state(1), t_end=3.0, step=0.1, dense=True)
    solution.animate(tmp_path / "b.gif", span=(0.0, 0.3), fps=4.0, speed=1.0)
    assert isinstance(stamps[-1][0], film.SphereScene)


def test_a_ball_at_rest(tmp_path: Path) -> None:
    problem = BALL.contact(rho=1.0)
    y0 = problem.state(gamma=[0.0, 0.0, 1.0], k=np.zeros(3))
    solution = gi.solve(problem, y0, t_end=1.0, step=0.25, method="gauss-2", dense=True)
    path = solution.animate(tmp_path / "a.gif", fps=0.5)
    assert path.stat().st_size > 1000


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"file": "a.avi"}, "ends in .gif, .html, .mp4"),
        ({"file": 3}, "ends in .gif, .html, .mp4"),
        ({"fps": 0.0}, "fps"),
        ({"speed": -1.0}, "speed"),
        ({"speed": 1e-9}, "at least"),
        ({"follow": 1}, "follow"),
        ({"span": (0.0, 1e9)}, "within the run"),
    ],
)
def test_what_is_no_film(
    rolling: gi.Solution, tmp_path: Path, given: dict[str, Any], told: str
) -> None:
    given = {"file": tmp_path / "a.gif", **given}
    with pytest.raises(gi.DomainError, match=told):
        rolling.animate(**given)


def test_where_nothing_can_be_written(rolling: gi.Solution, tmp_path: Path) -> None:
    (tmp_path / "a.gif").mkdir()
    with pytest.raises(gi.OutputError):
        rolling.animate(tmp_path / "a.gif")
