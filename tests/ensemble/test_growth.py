"""Growth over the members of real ensembles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles

HENON = henon_heiles.problem()
STATES = np.random.default_rng(1).uniform(-0.2, 0.2, (100, 4))
READ = gi.Windows("energy", 24)


def test_brouwers_law() -> None:
    """Gauss methods round without bias: the energy walks. rk-4 drifts, its energy linearly."""
    many = gi.solve_ensemble(HENON, STATES, t_end=3000.0, step=0.4, method="gauss-8", readings=READ)
    walks = many.growth("energy")
    assert walks.drift_class == "sqrt"
    assert walks.interval[0] < 0.5 < walks.interval[1]
    assert walks.size < 1e-15
    many = gi.solve_ensemble(HENON, STATES, t_end=500.0, step=0.05, method="rk-4", readings=READ)
    drifts = many.growth("energy")
    assert drifts.drift_class == "linear"
    assert abs(drifts.exponent - 1.0) < 0.02
    assert "linear" in repr(drifts)
    assert "systematic" in drifts.meaning


def test_times_of_windows_and_members_that_fail(tmp_path: Path) -> None:
    states = np.vstack((STATES[:40], [[0.0, 40.0, 0.0, 60.0]]))
    run: dict[str, Any] = {"t_end": 60.0, "step": 0.05, "method": "rk-4"}
    own = gi.solve_ensemble(HENON, states, **run, readings={"w": gi.Windows("energy", 10)})
    found = own.growth("w")
    assert found.name == "energy"
    assert found.members == 40
    assert np.allclose(found.t, 3.0 + 6.0 * np.arange(10) + 0.025)
    times = np.linspace(0.0, 60.0, 1201)
    given = {**run, "t_eval": times, "readings": gi.Windows("energy", 10)}
    other = gi.solve_ensemble(HENON, states, **given, out=tmp_path / "a.zarr")
    assert np.allclose(other.growth("energy").t, found.t)
    assert np.allclose(other.growth("energy").exponent, found.exponent, atol=1e-6)
    seen = gi.open_ensemble(tmp_path / "a.zarr").growth("energy")
    assert seen.exponent == other.growth("energy").exponent
    assert np.array_equal(seen.t, other.growth("energy").t)
    late = found.t[2] - 3.0
    assert own.growth("w", since=late - 0.1).t[0] == found.t[2]
    assert own.growth("w", seed=1).exponent_stderr != found.exponent_stderr
    assert own.growth("w", seed=1).exponent == found.exponent


UNEVEN = {"t_eval": np.linspace(0.0, 10.0, 99), "save_every": 1}


@pytest.mark.parametrize(
    ("more", "ask", "said"),
    [
        ({"readings": "drift:energy"}, {}, r"geomint.Windows \(here: none"),
        ({}, {"name": "K"}, "windows:energy"),
        ({}, {"name": 7}, "windows:energy"),
        ({"states": STATES[:7]}, {}, "at least 8 members"),
        ({}, {"since": 9.0}, "8 of 24 windows"),
        ({}, {"seed": -1}, "seed"),
        ({"readings": gi.Windows("energy", 999)}, {}, "at least 8 members"),
        (UNEVEN, {}, "save_every = 1: expected None beside times"),
        ({"method": "dop853-adaptive", "step": None}, {}, "steps of one length"),
    ],
)
def test_what_cannot_be_told(more: dict[str, Any], ask: dict[str, Any], said: str) -> None:
    run = {"states": STATES[:30], "t_end": 10.0, "step": 0.05, "method": "rk-4", "readings": READ}
    many = gi.solve_ensemble(HENON, **run | more)
    with pytest.raises(gi.DomainError, match=said):
        many.growth(**{"name": "energy", **ask})


@pytest.mark.parametrize("times", [None, np.linspace(0.0, 60.0, 301)])
def test_members_that_an_event_ends_have_no_part_in_it(times: Any) -> None:
    """Their windows are of shorter runs: the same times would be wrong."""
    run: dict[str, Any] = {"t_end": 60.0, "step": 0.05, "method": "rk-4", "readings": READ}
    run["t_eval"] = times
    stop = gi.Event("q[0]", level=0.2, terminal=True)
    many = gi.solve_ensemble(HENON, STATES[:40], **run, events=stop)
    whole = np.array([len(met.t) == 0 for met in many.events["q[0] = 0.2"]])
    assert 8 <= whole.sum() < 40
    alone = gi.solve_ensemble(HENON, STATES[:40][whole], **run)
    assert many.growth("energy").members == whole.sum()
    assert np.array_equal(many.growth("energy").rms, alone.growth("energy").rms)


def test_pictures() -> None:
    run: dict[str, Any] = {"t_end": 50.0, "step": 0.05, "method": "rk-4", "readings": READ}
    figure = gi.solve_ensemble(HENON, STATES, **run).growth("energy").plot()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[0] == "5% to 95% of the members"
    assert labels[-1].startswith("t^b, b = 0.81 ±")
    assert figure.axes[0].get_xlabel().startswith("t")
    still = gi.solve_ensemble(HENON, np.zeros((9, 4)), **run).growth("energy")
    assert still.drift_class == "roundoff"
    assert still.plot().axes[0].texts[0].get_text() == "exactly 0 throughout"
