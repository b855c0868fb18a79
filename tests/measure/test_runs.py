"""The measure along whole runs: what keeps it, what is told, and that nothing else changes it."""

from __future__ import annotations

import contextlib
import dataclasses
import json
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import neumann, sphere_metric
from geomint.watch import steps_again
from geomint.watch.measure import DEVIATIONS
from tests.measure.exact_maps import PROBLEMS
from tests.measure.test_defect import NOISE, volume

NEUMANN = neumann.problem()
PENDULUM = PROBLEMS["spherical-pendulum"]


def run(problem: gi.Problem, y0: Any, name: Any, h: float, steps: int, **options: Any):
    options = {"observe": ["measure"], f"{problem.time}_end": h * steps, **options}
    return gi.solve(problem, y0, step=h, method=name, **options)


KEPT = [("gauss-2", "henon-heiles", 0.1, 20_000, 5e-13)]
KEPT += [("rattle-2", "spherical-pendulum", 0.1, 40, 1e-10)]  # in plain Python
AT_NIGHT = [("rattle-2", "double-pendulum", 0.02, 5_000, 1e-10)]
AT_NIGHT += [("gauss-1-suzuki-4", "henon-heiles", 0.1, 5_000, 5e-13)]
AT_NIGHT += [("rattle-4", "spherical-pendulum", 0.1, 5_000, 1e-10)]


@pytest.mark.parametrize(
    ("name", "problem", "h", "steps", "level"),
    [*KEPT, *(pytest.param(*case, marks=pytest.mark.nightly) for case in AT_NIGHT)],
)
def test_symplectic_methods_keep_the_measure(
    name: str, problem: str, h: float, steps: int, level: float
) -> None:
    """Below the instrument's own noise, which is small, and which the run does reach.

    There is one word for that, whatever the trend, which may be the instrument's own.
    """
    drift = run(*PROBLEMS[problem], name, h, steps, compiled=steps > 100).drift["measure"]
    noise = drift.scale * NOISE
    assert drift.within_roundoff
    assert 1e-3 * noise < drift.max_abs_error < noise < level
    assert drift.drift_class == "roundoff"
    assert drift.slope is not None


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "h"), [("verlet-2", 0.1), ("rattle-2", 0.1), ("rattle-4", 0.1)])
def test_long_runs_have_no_bias(name: str, h: float) -> None:
    """A bias of the instrument would outgrow its noise."""
    drift = run(NEUMANN, neumann.initial(), name, h, 300_000).drift["measure"]
    assert drift.within_roundoff
    assert drift.scale * NOISE < 1e-9


@pytest.mark.parametrize(
    ("problem", "name", "h"),
    [
        ("henon-heiles", "gauss-2", 0.1),
        pytest.param("double-pendulum", "rattle-2", 0.05, marks=pytest.mark.nightly),
    ],
)
def test_noise_is_as_it_is_told(problem: str, name: str, h: float) -> None:
    """The end of the sum, over runs from different states, has the deviation that is told."""
    p, y0 = PROBLEMS[problem]
    states = gi.solve(p, y0, t_end=120.0, step=h, method=name, save_every=round(10 / h)).y
    ends = []
    for y in states:
        drift = run(p, p.canonical(y), name, h, 1000).drift["measure"]
        ends.append(drift.final_error / (drift.scale * NOISE / DEVIATIONS))
    assert len(ends) >= 12
    assert 0.1 < np.sqrt(np.mean(np.square(ends))) < 1.6


@pytest.mark.parametrize(
    ("name", "problem", "kinds"),
    [
        ("rk-4", "spherical-pendulum", {"linear", "faster"}),
        ("cf-4", "pulsating-body", {"linear", "sqrt", "bounded", "undetermined"}),
    ],
)
def test_others_lose_it(name: str, problem: str, kinds: set[str]) -> None:
    """Far above the noise; Lie group methods keep their orbits and not the measure."""
    sol = run(*PROBLEMS[problem], name, 0.1, 2000, observe="all")
    drift = sol.drift["measure"]
    assert drift.drift_class in kinds
    assert drift.max_abs_error > 1e4 * drift.scale * NOISE
    if name == "cf-4":
        assert sol.drift["momentum-squared"].within_roundoff


def test_what_is_seen_of_it_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bit for bit the same in batches of any size, with states left out, and over the first steps."""
    whole = run(*PENDULUM, "rk-4", 0.05, 400, observe="all").drift
    sparse = run(*PENDULUM, "rk-4", 0.05, 400, observe_every=7).drift["measure"]
    monkeypatch.setattr(steps_again, "BATCH", 5)
    pieces = run(*PENDULUM, "rk-4", 0.05, 400).drift["measure"]
    own, means = whole["measure"], whole["measure"].windows.means
    np.testing.assert_array_equal(pieces.windows.means, means)
    assert (pieces.final_error, pieces.scale) == (own.final_error, own.scale)
    np.testing.assert_array_equal(sparse.windows.means, [*means[6::7], means[-1]])  # and the end
    assert sparse.final_error == own.final_error
    for limit in (1, 50, 64, 399, 400, 1000):
        observe = {"all": {}, "measure": {"steps": limit}}
        part, count = run(*PENDULUM, "rk-4", 0.05, 400, observe=observe).drift, min(limit, 400)
        assert part["measure"].windows.samples == count
        assert part["measure"].windows.last_time == pytest.approx(0.05 * count)
        np.testing.assert_array_equal(part["measure"].windows.means, means[:count])
        assert part["energy"].as_json() == whole["energy"].as_json()
        assert part["measure"].as_json()["until"] == part["measure"].windows.last_time
    for wrong in (0, -3, 2.5, True):
        with pytest.raises(gi.DomainError, match=r"observe\['measure'\]: steps"):
            run(*PENDULUM, "rk-4", 0.05, 4, observe={"measure": {"steps": wrong}})


@gi.observable
def rate(params, t, y, work):
    """A clock that depends on the state."""
    return 1.0 + 0.1 * y[0] * y[0]


def test_a_clock_does_not_count() -> None:
    """The row of physical time is no part of the state; runs to a physical end end with a part step."""
    p, y0 = PENDULUM
    timed = dataclasses.replace(p, time="tau", clock=rate)
    options = {"step": 0.1, "method": "rk-4", "observe": ["measure"], "compiled": False}
    without, beside = (
        gi.solve(timed, y0, tau_end=1.0, clock=c, **options).drift["measure"] for c in (False, True)
    )
    to_end = gi.solve(timed, y0, t_end=1.0, **options)
    assert beside.final_error == pytest.approx(without.final_error, abs=without.scale * NOISE)
    assert to_end.drift["measure"].windows.samples == to_end.steps + 1
    assert 1e-10 < abs(to_end.drift["measure"].final_error) < abs(2 * without.final_error)


def test_adaptive_steps_are_taken_as_they_are() -> None:
    """The map of each step at its length: the same sum as of single steps of those lengths."""
    p, y0 = PROBLEMS["henon-heiles"]
    method = gi.Adaptive(gi.RungeKutta("dormand-prince-5"), rtol=1e-5)
    options = {"observe": ["measure"], "compiled": False}
    sol = gi.solve(p, y0, t_end=4.0, method=method, save_every=1, **options)
    lengths = np.diff(sol.t)
    assert np.ptp(lengths) > 0.01
    parts = [
        run(p, y, "dormand-prince-5", h, 1, **options).drift["measure"].final_error
        for y, h in zip(sol.y, lengths, strict=False)
    ]
    assert abs(sum(parts)) > 1e-8
    assert sol.drift["measure"].final_error == pytest.approx(sum(parts), rel=1e-6)


@gi.field
def swing(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -gi.sin(y[0]) if y[0] > 0.0 else gi.sin(-y[0])


@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.nightly)])
def test_a_field_for_single_numbers(compiled: bool) -> None:
    """Its branches are no obstacle, also where a method calls it for lane after lane."""
    pieces = (("q", 1), ("p", 1))
    p = gi.Problem("swing", pieces, field=swing, measure=gi.Measure(volume))
    lost = run(p, [0.5, 0.2], "rk-4", 0.1, 50, compiled=compiled)
    assert lost.drift["measure"].max_abs_error > 1e-7
    warned = pytest.warns(gi.GeomintWarning, match="one number at a time")
    with warned if compiled else contextlib.nullcontext():
        kept = run(p, [0.5, 0.2], "gauss-2", 0.1, 100 if compiled else 5, compiled=compiled)
    assert kept.drift["measure"].within_roundoff


# --- names, reports and files -------------------------------------------------------------------


def test_names() -> None:
    """All includes the measure and the groups do not; what is given under its name comes first."""
    p, y0 = PENDULUM
    energy = p.invariants["energy"]
    own = dataclasses.replace(p, invariants={"measure": energy})

    def seen(observe: Any, problem: gi.Problem = p, y: Any = y0) -> dict[str, gi.Drift]:
        return run(problem, y, "rk-4", 0.1, 3, observe=observe, compiled=False).drift

    assert {*seen("all")} == {*p.invariants, *p.constraints, "measure"}
    assert {*seen("invariants")} == {*p.invariants}
    assert [*seen(["measure", "energy"])] == ["measure", "energy"]
    given, named = seen({"measure": energy})["measure"], seen("all", own)["measure"]
    assert given.final_error == named.final_error == seen("energy")["energy"].final_error != 0.0
    assert (given.kind, named.kind) == ("others", "integrals")
    without = sphere_metric.problem()
    start = sphere_metric.initial(without)
    with pytest.raises(gi.DomainError, match=r"'measure': expected one of \['.*no measure"):
        seen(["measure"], without, start)
    assert "measure" not in seen("all", without, start)


@pytest.mark.usefixtures("blank_pictures")
def test_reports_and_scenes(tmp_path: Any) -> None:
    """A scene may ask for it; the page explains it and says how long; the JSON has its numbers."""
    scene = gi.load_scene("hamiltonized-n3").changed(
        time={"tau_end": 1.0},
        integrate={"method": "rk-4", "step": 0.05},
        observe={"quantities": ["energy", "measure"], "measure": {"steps": 8}},
    )
    (done,) = gi.drift_report(scene, tmp_path, progress=False)
    record = json.loads((tmp_path / "drift.json").read_text(encoding="utf-8"))
    told = record["methods"][done.label]["quantities"]["measure"]
    assert (told["initial"], told["max_rel_error"]) == (0.0, None)
    assert told["final_error"] == done.drift["measure"].final_error
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for words in ("density ratio × Jacobian determinant", "measure (to τ = 0.4)"):
        assert words in page
    assert "energy (to" not in page


@pytest.mark.parametrize("p", [[0.0, 0.0, 1e281], [0.0, 1e200, 0.0]])
def test_states_whose_rates_overflow_fail_in_their_first_step(p: list[float]) -> None:
    """As they do unwatched; with a step that is given, no default step is asked for."""
    with pytest.raises(gi.NonFiniteError) as raised:
        run(NEUMANN, [1.0, 0.0, 0.0, *p], "gauss-8", 0.25, 4, compiled=False)
    assert raised.value.step == 0
