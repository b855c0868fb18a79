"""Watchers of one's own: what they see, what becomes of their errors, how they are found."""

from __future__ import annotations

import copy
import math
import pickle
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles, pulsating_body
from geomint.testing import check_watcher
from geomint.watch.measure import InvariantMeasure
from geomint.watch.registry import plugged

# Steps are as long as a test wants them.
pytestmark = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")

PROBLEM, START = henon_heiles.problem(), [0.0, 0.1, 0.3, 0.0]
RUN: dict[str, Any] = {"step": 0.1, "method": "rk-4", "compiled": False, "progress": False}


@dataclass(eq=False, kw_only=True)
class Counting(gi.Watcher):
    """How many states it has seen; each once, in their order."""

    every_state = True

    by: float = 1.0

    def begin(self, run: Any) -> float:
        self.time, self.count = 0.0, 0
        return 0.0

    def values(self, times: Any, states: Any, lengths: Any) -> Any:
        assert states.shape == (len(times), 4)
        with pytest.raises(ValueError, match="read-only"):
            states[0, 0] = 3.0
        assert np.allclose(self.time + np.cumsum(lengths), times)
        before, self.time, self.count = self.count, times[-1], self.count + len(times)
        return self.by * np.arange(before + 1, self.count + 1)


class Sampled(Counting):
    """The same of the states that are sampled."""

    every_state = False


@dataclass(eq=False, kw_only=True)
class Given(gi.Watcher):
    """A series that is given: after each second of the run another number."""

    series: tuple[Any, ...] = (0.0,)
    first: Any = 0.0
    size: Any = 1.0

    def begin(self, run: Any) -> Any:
        return self.first

    def values(self, times: Any, states: Any, lengths: Any) -> Any:
        return [self.series[min(int(abs(t)), len(self.series) - 1)] for t in times]

    def scale(self) -> Any:
        return self.size


def made(what: Callable[[Any, Any], Any], **others: Any) -> gi.Watcher:
    """A watcher whose values are what a function makes of times and states."""

    def values(self: Any, times: Any, states: Any, lengths: Any) -> Any:
        return what(times, states)

    return type("Made", (Given,), {"values": values, **others})()


def late(what: Callable[[int], Any]) -> gi.Watcher:
    """A watcher that makes something of so many states after the first chunk of a run."""

    def values(times: Any, states: Any) -> Any:
        return what(len(times)) if times[-1] > 7.0 else np.zeros(len(times))

    return made(values)


def solved(observe: Any, t_end: float = 10.0, **options: Any) -> gi.Solution:
    return gi.solve(PROBLEM, START, t_end=t_end, observe=observe, **{**RUN, **options})


# --- what they see --------------------------------------------------------------------------------


@pytest.mark.parametrize("end", [10.0, -10.0, 9.97, 0.04])
@pytest.mark.filterwarnings("ignore:step = 0.1 is longer")
def test_every_state_or_those_that_are_sampled(end: float) -> None:
    """Each once, the last one too; runs come in chunks."""
    steps, whole = math.ceil(abs(end) / 0.1), int(abs(end) / 0.1 + 1e-9)
    for every in (1, 7, 1000):
        found = solved({"all": Counting(), "some": Sampled()}, end, observe_every=every).drift
        assert found["all"].final_error == steps
        samples = whole // every + (whole % every != 0 or whole < steps)
        assert found["some"].final_error == samples
        for drift in found.values():
            assert drift.windows.samples == samples
            assert drift.windows.last_time == pytest.approx(end)


def test_adaptive_steps_and_a_clock() -> None:
    """The lengths of an adaptive method's steps; states without the clock's row."""
    sol = solved({"all": Counting()}, method="dormand-prince-5-adaptive")
    assert sol.drift["all"].final_error == sol.steps

    def begin(self: Any, run: Any) -> float:
        assert len(run.step(run.state, run.time, 0.01)) == len(run.state) == 6
        return 0.0

    wide = made(lambda times, states: np.full(len(times), float(states.shape[1])), begin=begin)
    sphere = gi.load_scene("hamiltonized-n3")
    for method in ("gauss-2", "dormand-prince-5-adaptive"):
        options = {**RUN, "method": method, "observe": {"rows": wide}}
        drift = gi.solve(sphere.problem, sphere.state, t_end=1.0, **options).drift["rows"]
        assert (drift.max_abs_error, drift.windows.last_time) == (6.0, 1.0)


def test_the_first_steps_alone() -> None:
    for watcher in (Counting(steps=7), Sampled(steps=7)):
        for every in (1, 3, 100):
            drift = solved({"it": watcher}, observe_every=every).drift["it"]
            assert drift.final_error == 7.0
            assert drift.windows.last_time == pytest.approx(0.7)
    energy = solved({"energy": {"steps": 7}, "invariants": {}}, 3.0).drift["energy"]
    assert energy.windows.samples == 30  # the group comes later, and has no options
    energy = solved({"invariants": {}, "energy": {"steps": 7}}, 3.0).drift["energy"]
    assert energy.windows.samples == 7


def test_a_run_that_is_interrupted() -> None:
    """In its first step, when nothing has been sampled; and on the way, also while the end is."""

    def press(*_: Any) -> None:
        raise KeyboardInterrupt

    def begin(self: Any, run: Any) -> float:
        run.stepper.advance = press
        return 3.0

    sol = solved({"all": Counting(), "some": Sampled(), "given": made(print, begin=begin)})
    assert sol.status == "interrupted"
    for drift in sol.drift.values():
        assert (drift.windows.samples, drift.max_abs_error) == (0, 0.0)
        assert drift.drift_class == "undetermined"
    assert sol.drift["given"].initial == 3.0
    sol.plot_drift()

    sol = solved({"stop": late(press), "all": Counting()})
    assert sol.status == "interrupted"
    assert 0 < sol.drift["all"].windows.samples <= sol.steps


@pytest.mark.parametrize(
    ("series", "size", "expected"),
    [
        ((0.0,), 1.0, "roundoff"),
        ((5e-324,), 1e-300, "roundoff"),
        *((series, 1.0, "not finite") for series in ((1.0, np.inf, 2.0), (np.nan,))),
        (tuple(range(100)), 1.0, "linear"),
        ((1e308, -1e308), 1.0, "undetermined"),
        ((1.0, 2.0), 0.0, "undetermined"),
    ],
)
def test_numbers_of_all_sizes(series: Any, size: float, expected: str, tmp_path: Any) -> None:
    """Not finite, constant, tiny, huge: a class, a figure, and a file that says the same."""

    class Turns(Given):
        kind, label, note = "integrals", "turns", "counts turns."

    sol = solved({"it": Turns(series=series, size=size)}, 50.0, step=0.5)
    drift = sol.drift["it"]
    assert drift.scale > 0.0
    if expected != "undetermined":
        assert drift.drift_class == expected
    assert (sol.status == "success") == (expected != "not finite")
    labels = [axes.get_ylabel() for axes in sol.plot_drift().axes]
    unit = "turns (dimensionless)"
    assert labels == [f"largest {unit}", f"mean {unit}"] or expected == "not finite"
    sol.save(tmp_path / "run.nc")
    found = gi.load(tmp_path / "run.nc").drift["it"]
    assert found == drift or expected == "not finite"
    assert (found.kind, found.label, found.note) == ("integrals", "turns", "counts turns.")


# --- errors ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        (lambda count: 1 / 0, "ZeroDivisionError"),
        (lambda count: None, "real number"),
        (lambda count: [1.0] * (count + 1), "one for each state"),
        (lambda count: np.ones((count, 1)), "one for each state"),
        (lambda count: np.ones(count) * 1j, "real number"),
        (lambda count: ["a"] * count, "real number"),
        (lambda count: gi.solve(PROBLEM, START, t_end=math.inf), "DomainError: t_end = inf"),
    ],
)
def test_an_error_on_the_way_names_the_watcher(returned: Any, words: str) -> None:
    """And ends the run, at the end too; what was computed, and seen by others, is there."""
    with pytest.raises(gi.WatcherError, match=f"'wrong' failed after t = .*{words}") as raised:
        solved({"size": Counting(), "wrong": late(returned)})
    error, partial = raised.value, raised.value.partial
    assert error.name == "wrong"
    assert 64 < error.step == partial.steps == partial.drift["size"].final_error <= 100
    assert partial.status == "failed"
    assert "'wrong'" in partial.message
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), again.name) == (gi.WatcherError, str(error), "wrong")
    with pytest.raises(gi.WatcherError, match="'wrong' failed") as raised:
        solved({"wrong": late(returned)}, observe_every=1000)
    assert raised.value.partial.steps == 100


@pytest.mark.parametrize(
    ("options", "words"),
    [
        *(
            ({"first": x}, "begin returned .*expected a real number")
            for x in ("a", None, [1.0], 1j)
        ),
        ({"size": "large"}, "scale returned"),
    ],
)
def test_an_error_before_the_run(options: Any, words: str) -> None:
    with pytest.raises(gi.WatcherError, match=f"'wrong' failed after t = 0: .*{words}"):
        solved({"wrong": Given(**options)})


NEEDY = made(print, obstacle=lambda self, problem: f"{problem.name!r} has no knots")


@pytest.mark.parametrize(
    ("observe", "words"),
    [
        ({"knots": NEEDY}, "has no knots"),
        (
            {"it": type("Odd", (Given,), {"kind": "odd"})},
            r"kind = 'odd': expected one of \['energy'",
        ),
        *(({"it": Counting(steps=n)}, f"steps = {n}") for n in (0, 2.5)),
        *(({"it": x}, "or a geomint.Watcher") for x in (3, dict, None)),
        ({"it": {}}, "a quantity of the problem"),
        ({"measure": {"steps": "3"}}, "steps = '3'"),
        ({"measure": {3: 4}}, "options by their names"),
        ({3: Counting()}, "names of quantities"),
        ({"a/b": Counting()}, "a/b"),
    ],
)
def test_what_is_no_watcher_is_refused(observe: Any, words: str) -> None:
    with pytest.raises(gi.DomainError, match=words):
        solved(observe)


def test_options() -> None:
    assert Counting().with_options(by=2).by == 2.0
    assert Counting().options == {"steps": None, "by": 1.0}
    for wrong in ("2", True, np.nan, None):
        with pytest.raises(gi.DomainError, match="by = "):
            Counting().with_options(by=wrong)
    with pytest.raises(gi.DomainError, match="Did you mean 'by'"):
        Counting().with_options(buy=2.0)


# --- values ---------------------------------------------------------------------------------------

FAST = [Counting(by=2.0), Sampled(), Given(series=tuple(range(9)))]
WATCHERS = [*FAST, InvariantMeasure(steps=20)]


@pytest.mark.parametrize("watcher", [*FAST, pytest.param(WATCHERS[-1], marks=pytest.mark.nightly)])
def test_they_are_values(watcher: gi.Watcher) -> None:
    same = [copy.copy(watcher), copy.deepcopy(watcher), pickle.loads(pickle.dumps(watcher))]
    assert all(other == watcher and hash(other) == hash(watcher) for other in same)
    assert all(other != watcher for other in WATCHERS if other is not watcher)
    assert watcher != watcher.with_options(steps=3)
    check_watcher(watcher, PROBLEM, START, 0.1)


@pytest.mark.nightly
def test_of_another_form_that_depends_on_time() -> None:
    check_watcher(Given(steps=5), pulsating_body.problem(), pulsating_body.INITIAL, 0.1, "cf-2")


class Shared(Given):
    """Remembers in its class: a second run sees the first one."""

    total = 0.0

    def values(self, times: Any, states: Any, lengths: Any) -> Any:
        Shared.total += 1.0
        return np.full(len(times), Shared.total)


class Chunky(Given):
    """Begins anew with every chunk."""

    def values(self, times: Any, states: Any, lengths: Any) -> Any:
        return np.arange(float(len(times)))


class Restless(Given):
    def begin(self, run: Any) -> float:
        run.stepper.advance(0, 1, 1, type(run.stepper.memory)(np.zeros(4)))
        return 0.0


class Unequal(Given):
    __eq__, __hash__ = object.__eq__, object.__hash__


@pytest.mark.parametrize(
    ("watcher", "words"),
    [
        (Unequal(), "a copy is not equal"),
        (Shared(), "a second run sees something else"),
        (Chunky(), "depends on the chunks"),
        (Restless(), "changes the run"),
    ],
)
def test_the_check_finds_what_is_wrong(watcher: gi.Watcher, words: str) -> None:
    with pytest.raises(AssertionError, match=words):
        check_watcher(watcher, PROBLEM, START, 0.1)


# --- names ----------------------------------------------------------------------------------------

MINE = """
import geomint as gi

class Zero(gi.Watcher):
    begin = lambda self, run: 0.0
    values = lambda self, times, states, lengths: 0.0 * times

class Never(Zero):
    obstacle = lambda self, problem: "not today"

ZERO = Zero()
wrong = 3
"""


@pytest.fixture
def plug(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Register watchers of a module ``mine``, as an installed package does."""

    def plugged_in(**entries: str) -> None:
        plugged()  # what is installed later is found, too
        info = tmp_path / "mine-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n", "utf-8")
        lines = "".join(f"{name} = {value}\n" for name, value in entries.items())
        (info / "entry_points.txt").write_text(f"[geomint.watchers]\n{lines}", "utf-8")
        plugged.cache_clear()

    (tmp_path / "mine.py").write_text(MINE, "utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield plugged_in
    plugged.cache_clear()
    sys.modules.pop("mine", None)


def test_names_of_other_packages(plug: Any) -> None:
    """A class or a value; a problem's own quantity comes first; groups do not mean them."""
    plug(zero="mine:Zero", nought="mine:ZERO", energy="mine:Zero", never="mine:Never")
    drift = solved(["zero", "nought", "energy"], 1.0).drift
    assert drift["zero"].max_abs_error == drift["nought"].max_abs_error == 0.0
    assert drift["energy"].kind == "energy"
    assert drift["energy"].max_abs_error > 0.0
    assert "zero" not in solved("all", 1.0).drift
    assert solved({"zero": {"steps": 3}}, 1.0).drift["zero"].windows.samples == 3
    with pytest.raises(gi.DomainError, match="not today"):
        solved("never")
    with pytest.raises(gi.DomainError, match="Did you mean 'zero'"):
        solved("zer0")


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("mine:wrong", r"'bad' of the group geomint.watchers = 3: expected a geomint.Watcher"),
        ("mine:absent", "'bad' of the group geomint.watchers.*AttributeError"),
        ("absent:Zero", "'bad' of the group geomint.watchers.*ModuleNotFoundError"),
    ],
)
def test_broken_entry_points(plug: Any, value: str, words: str) -> None:
    """An error that names the entry point, in scenes too; others do not suffer."""
    plug(bad=value, zero="mine:Zero")
    with pytest.raises(gi.GeomintError, match=words):
        solved("bad")
    assert solved("zero", 1.0).success
    scene = gi.load_scene("hamiltonized-n3")
    with pytest.raises(gi.SceneError, match=rf"\[observe\] quantities\[1\] = 'bad': .*{words}"):
        scene.changed_observation(["energy", "bad"])


def test_in_scenes_and_plans(plug: Any) -> None:
    """The plan names it; it is of the representation that the scene means; several methods have it."""
    plug(zero="mine:Zero", never="mine:Never")
    scene = gi.load_scene("ball-3d").changed(time={"t_end": 2.0})
    scene = scene.changed_observation(["energy", "zero"]).changed(observe={"zero": {"steps": 9}})
    plan = gi.make_plan(scene, "drift")
    assert plan.watched.chosen == ("energy", "zero")
    assert "(zero: the first 9 steps)" in plan.watched.reason
    assert "zero keep" in plan.representation.reason
    assert plan.solve(False).drift["zero"].windows.samples == 9
    with pytest.raises(gi.SceneError, match=r"\[observe.zero\] stops = 3"):
        scene.changed(observe={"zero": {"stops": 3}})
    with pytest.raises(gi.SceneError, match="not today"):
        scene.changed_observation(["never"])
