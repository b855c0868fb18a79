"""The measure along whole runs: what keeps it, what is told, and that nothing else changes it."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import json

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling.recorded import Recorded
from geomint.problems.testproblems import neumann, sphere_metric
from geomint.run import driver
from geomint.watch import measure, steps_again
from tests.measure.exact_maps import PROBLEMS

NEUMANN = neumann.problem()


def run(problem: gi.Problem, y0, name: str, h: float, steps: int, **options) -> gi.Solution:
    options = {"observe": ["measure"], f"{problem.time}_end": h * steps, **options}
    return gi.solve(problem, y0, step=h, method=name, **options)


@pytest.mark.parametrize(
    ("name", "problem", "h", "steps", "level"),
    [
        ("gauss-2", "henon-heiles", 0.1, 20_000, 5e-13),
        ("gauss-1-suzuki-4", "henon-heiles", 0.1, 5_000, 5e-13),
        ("rattle-2", "double-pendulum", 0.02, 5_000, 1e-10),
        ("rattle-4", "spherical-pendulum", 0.1, 5_000, 1e-10),
    ],
)
def test_symplectic_methods_keep_the_measure(
    name: str, problem: str, h: float, steps: int, level: float
) -> None:
    """Not larger than the instrument's own noise, which is small and which the run does reach."""
    drift = run(*PROBLEMS[problem], name, h, steps).drift["measure"]
    noise = drift.scale * 2.0**-47
    assert drift.within_roundoff
    assert 1e-3 * noise < drift.max_abs_error < noise < level


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "h"), [("verlet-2", 0.1), ("rattle-2", 0.1), ("rattle-4", 0.1)])
def test_long_runs_have_no_bias(name: str, h: float) -> None:
    """A bias of the instrument would outgrow its noise."""
    drift = run(NEUMANN, neumann.initial(), name, h, 300_000).drift["measure"]
    assert drift.within_roundoff
    assert drift.scale * 2.0**-47 < 1e-9


def test_what_the_instrument_may_do_is_no_trend() -> None:
    """Below the noise that it states there is one word, whatever the trend, which may be its own."""
    scene = gi.load_scene("hamiltonized-n3")
    run = {"method": "gauss-8", "step": 0.25, "observe": ["measure"]}
    drift = gi.solve(scene.problem, scene.state, tau_end=5000.0, **run).drift["measure"]
    assert drift.within_roundoff
    assert drift.drift_class == "roundoff"
    assert drift.slope is not None


@pytest.mark.parametrize("problem", ["henon-heiles", "double-pendulum"])
def test_noise_is_as_it_is_told(problem: str) -> None:
    """The end of the sum, over runs from different states, has the deviation that is told."""
    p, y0 = PROBLEMS[problem]
    name, h = ("gauss-2", 0.1) if problem == "henon-heiles" else ("rattle-2", 0.05)
    states = gi.solve(p, y0, t_end=120.0, step=h, method=name, save_every=round(10 / h)).y
    ends = []
    for y in states:
        drift = run(p, p.canonical(y), name, h, 1000).drift["measure"]
        ends.append(drift.final_error / (drift.scale * 2.0**-47 / measure.DEVIATIONS))
    assert len(ends) >= 12
    assert 0.1 < np.sqrt(np.mean(np.square(ends))) < 1.6


@pytest.mark.parametrize(
    ("name", "problem", "h", "kinds"),
    [
        ("rk-4", "spherical-pendulum", 0.1, {"linear", "faster"}),
        ("cf-4", "pulsating-body", 0.1, {"linear", "sqrt", "bounded", "undetermined"}),
    ],
)
def test_others_lose_it(name: str, problem: str, h: float, kinds: set[str]) -> None:
    """Far above the noise; Lie group methods keep their orbits and not the measure."""
    sol = run(*PROBLEMS[problem], name, h, 2000, observe="all")
    drift = sol.drift["measure"]
    assert drift.drift_class in kinds
    assert drift.max_abs_error > 1e4 * drift.scale * 2.0**-47
    if name == "cf-4":
        assert sol.drift["momentum-squared"].within_roundoff


def test_chunks_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bit for bit the same in chunks and batches of any size, and with states left out."""
    p, y0 = PROBLEMS["spherical-pendulum"]
    whole = run(p, y0, "rk-4", 0.05, 400).drift["measure"]
    sparse = run(p, y0, "rk-4", 0.05, 400, observe_every=7).drift["measure"]
    monkeypatch.setattr(driver, "FIRST_CHUNK", 3)
    monkeypatch.setattr(steps_again, "BATCH", 5)
    rng = np.random.default_rng(0)
    clock = itertools.accumulate(10.0 ** rng.uniform(-3.0, 0.5) for _ in itertools.count())
    monkeypatch.setattr(driver, "running_clock", lambda: next(clock))
    pieces = run(p, y0, "rk-4", 0.05, 400).drift["measure"]
    np.testing.assert_array_equal(pieces.windows.means, whole.windows.means)
    assert (pieces.final_error, pieces.scale) == (whole.final_error, whole.scale)
    seldom = [*whole.windows.means[6::7], whole.windows.means[-1]]  # and the end
    np.testing.assert_array_equal(sparse.windows.means, seldom)
    assert sparse.final_error == whole.final_error


@pytest.mark.parametrize("limit", [1, 50, 399, 400, 1000])
def test_only_the_first_steps(limit: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same sum as far as it goes, whatever the chunks; everything else goes on to the end."""
    p, y0 = PROBLEMS["spherical-pendulum"]
    whole = run(p, y0, "rk-4", 0.05, 400, observe="all").drift
    monkeypatch.setattr(driver, "FIRST_CHUNK", 7)
    part = run(p, y0, "rk-4", 0.05, 400, observe={"all": {}, "measure": {"steps": limit}}).drift
    count = min(limit, 400)
    assert part["measure"].windows.samples == count
    assert part["measure"].windows.last_time == pytest.approx(0.05 * count)
    np.testing.assert_array_equal(
        part["measure"].windows.means, whole["measure"].windows.means[:count]
    )
    assert part["energy"].as_json() == whole["energy"].as_json()
    assert part["measure"].as_json()["until"] == part["measure"].windows.last_time


@pytest.mark.parametrize("limit", [0, -3, 2.5, True])
def test_limits_that_make_no_sense(limit: float) -> None:
    p, y0 = PROBLEMS["spherical-pendulum"]
    with pytest.raises(gi.DomainError, match=r"observe\['measure'\]: steps"):
        run(p, y0, "rk-4", 0.05, 4, observe={"measure": {"steps": limit}})


def test_a_last_partial_step_counts() -> None:
    """A run that ends within a step adds the defect of that step."""
    p, y0 = PROBLEMS["lotka-volterra"]
    sol = gi.solve(p, y0, t_end=0.35, step=0.1, method="rk-4", observe=["measure"], save_every=1)
    parts = [gi.solve(p, y0, t_end=0.3, step=0.1, method="rk-4", observe=["measure"])]
    late = dataclasses.replace(
        p, field=shifted(p.field), measure=gi.Measure(shifted(p.measure.log_density))
    )
    parts.append(
        gi.solve(late, sol.y[3], t_end=0.05, step=0.05, method="rk-4", observe=["measure"])
    )
    expected = sum(part.drift["measure"].final_error for part in parts)
    assert sol.drift["measure"].final_error == pytest.approx(expected, rel=1e-7)
    assert sol.drift["measure"].windows.samples == 4


def shifted(f: Recorded) -> Recorded:
    """The same function of time, 0.3 later."""

    def field(params, t, y, out, work):
        f(params, t + 0.3, y, out, work)

    def value(params, t, y, work):
        return f(params, t + 0.3, y, work)

    return gi.field(field) if f.function.__code__.co_argcount == 5 else gi.observable(value)


@gi.observable
def rate(params, t, y, work):
    """A clock that depends on the state."""
    return 1.0 + 0.1 * y[0] * y[0]


def test_a_clock_does_not_count() -> None:
    """The row of physical time is no part of the state; runs to a physical end end with a part step."""
    p, y0 = PROBLEMS["spherical-pendulum"]
    timed = dataclasses.replace(p, time="tau", clock=rate)
    options = {"step": 0.1, "method": "rk-4", "observe": ["measure"]}
    without = gi.solve(timed, y0, tau_end=20.0, clock=False, **options).drift["measure"]
    beside = gi.solve(timed, y0, tau_end=20.0, clock=True, **options).drift["measure"]
    to_end = gi.solve(timed, y0, t_end=20.0, **options)
    assert beside.final_error == pytest.approx(without.final_error, abs=without.scale * 2.0**-47)
    assert to_end.drift["measure"].windows.samples == to_end.steps + 1
    assert 1e-9 < abs(to_end.drift["measure"].final_error) < abs(2 * without.final_error)


def test_adaptive_steps_are_taken_as_they_are() -> None:
    """The map of each step at its length: the same sum as of single steps of those lengths."""
    p, y0 = PROBLEMS["henon-heiles"]
    method = gi.Adaptive(gi.RungeKutta("dormand-prince-5"), rtol=1e-5)
    sol = gi.solve(p, y0, t_end=10.0, method=method, observe=["measure"], save_every=1)
    lengths = np.diff(sol.t)
    assert np.ptp(lengths) > 0.01
    total = 0.0
    for y, h in zip(sol.y, lengths, strict=False):
        single = gi.solve(p, y, t_end=h, step=h, method="dormand-prince-5", observe=["measure"])
        total += single.drift["measure"].final_error
    assert abs(total) > 1e-8
    assert sol.drift["measure"].final_error == pytest.approx(total, rel=1e-6)


@pytest.mark.parametrize("compiled", [True, False], ids=["compiled", "plain"])
def test_a_field_for_single_numbers(compiled: bool) -> None:
    """Its branches are no obstacle, also where a method calls it for lane after lane."""

    @gi.field
    def swing(params, t, y, out, work):
        out[0] = y[1]
        out[1] = -gi.sin(y[0]) if y[0] > 0.0 else gi.sin(-y[0])

    @gi.observable
    def volume(params, t, y, work):
        return 0.0 * y[0]

    p = gi.Problem(
        name="swing", pieces=(("q", 1), ("p", 1)), field=swing, measure=gi.Measure(volume)
    )
    steps = 100 if compiled else 5
    sol = run(p, [0.5, 0.2], "rk-4", 0.1, 100)
    assert sol.drift["measure"].max_abs_error > 1e-6
    warned = pytest.warns(gi.GeomintWarning, match="one number at a time")
    with warned if compiled else contextlib.nullcontext():
        sol = run(p, [0.5, 0.2], "gauss-2", 0.1, steps, compiled=compiled)
    assert sol.drift["measure"].within_roundoff


# --- names ----------------------------------------------------------------------------------------


def test_all_includes_the_measure_and_the_groups_do_not() -> None:
    p, y0 = PROBLEMS["spherical-pendulum"]
    watched = set(run(p, y0, "rk-4", 0.1, 3, observe="all").drift)
    assert watched == {*p.invariants, *p.constraints, "measure"}
    assert set(run(p, y0, "rk-4", 0.1, 3, observe="invariants").drift) == set(p.invariants)
    both = run(p, y0, "rk-4", 0.1, 3, observe=["measure", "energy"])
    assert list(both.drift) == ["measure", "energy"]


def test_a_problem_without_a_measure() -> None:
    """Says so, and what there is; ``all`` is what there is."""
    p = sphere_metric.problem()
    y0 = sphere_metric.initial(p)
    with pytest.raises(gi.DomainError, match=r"'measure': expected one of \['.*no measure"):
        gi.solve(p, y0, t_end=1.0, step=0.1, method="rk-4", observe=["measure"])
    sol = gi.solve(p, y0, t_end=1.0, step=0.1, method="rk-4", observe="all")
    assert "measure" not in sol.drift


def test_what_is_given_under_a_name_is_watched_under_it() -> None:
    """Also if the name is that of another watcher; a problem's own quantity comes before it too."""
    p, y0 = PROBLEMS["spherical-pendulum"]
    energy = p.invariants["energy"]
    options = {"t_end": 1.0, "step": 0.1, "method": "rk-4", "compiled": False}
    given = gi.solve(p, y0, observe={"measure": energy}, **options).drift["measure"]
    own = dataclasses.replace(p, invariants={"measure": energy})
    named = gi.solve(own, y0, observe="all", **options).drift["measure"]
    found = gi.solve(p, y0, observe="energy", **options).drift["energy"]
    assert given.final_error == named.final_error == found.final_error != 0.0
    assert (given.kind, named.kind) == ("others", "integrals")


# --- reports and files ----------------------------------------------------------------------------


def test_saved_and_loaded(tmp_path) -> None:
    p, y0 = PROBLEMS["spherical-pendulum"]
    sol = run(p, y0, "rk-4", 0.1, 200)
    sol.save(tmp_path / "run.nc")
    found = gi.load(tmp_path / "run.nc").drift["measure"]
    assert found.as_json() == sol.drift["measure"].as_json()
    np.testing.assert_array_equal(found.windows.means, sol.drift["measure"].windows.means)


def test_report_and_scene(tmp_path) -> None:
    """A scene may ask for it; the page explains it and the JSON has its numbers."""
    scene = gi.load_scene("hamiltonized-n3").changed(
        time={"tau_end": 5.0}, observe={"quantities": ["energy", "measure"]}
    )
    (run,) = gi.drift_report(scene, tmp_path, progress=False)
    record = json.loads((tmp_path / "drift.json").read_text(encoding="utf-8"))
    told = record["methods"][run.label]["quantities"]["measure"]
    assert (told["initial"], told["max_rel_error"]) == (0.0, None)
    assert told["final_error"] == run.drift["measure"].final_error
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "density ratio × Jacobian determinant" in page


def test_a_report_says_how_long_it_was_watched(tmp_path) -> None:
    scene = gi.load_scene("hamiltonized-n3").changed(
        time={"tau_end": 5.0},
        observe={"quantities": ["energy", "measure"], "measure": {"steps": 8}},
    )
    gi.drift_report(scene, tmp_path, progress=False)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "measure (to τ = 2)" in page
    assert "energy (to" not in page


@pytest.mark.parametrize("p", [[0.0, 0.0, 1e281], [0.0, 1e200, 0.0]])
def test_states_whose_rates_overflow_fail_in_their_first_step(p: list[float]) -> None:
    """As they do unwatched; with a step that is given, no default step is asked for."""
    problem = neumann.problem()
    state = [1.0, 0.0, 0.0, *p]
    with pytest.raises(gi.NonFiniteError) as raised:
        gi.solve(problem, state, t_end=1.0, step=0.25, observe=["measure"], compiled=False)
    assert raised.value.step == 0
