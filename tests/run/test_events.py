"""Events: none missed, none invented, on the orbit of the method, the steps of the run as they were."""

from __future__ import annotations

import copy
import itertools
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, strategies as st

import chaplygin as ch
import geomint as gi
from geomint.run import driver
from tests.families import PROBLEMS, kinds
from tests.rows import examples
from tests.run.motions import second, swing

CIRCLE, FALL, LINE = swing(), swing(0.0, -9.8), swing(0.0)  # x = cos t; x'' = −9.8; x = t
PENDULUM = second("pendulum", lambda p, t, y: -gi.sin(y[0]))
SPHERE = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).hamiltonized()


def along_line(end: float = 1.0, step: float = 0.125, start: float = -0.5, **more: Any) -> Any:
    """A run along x = t + start, whose steps are exact."""
    given = {"t_end": end, "step": step, "method": "rk-4", **more}
    return gi.solve(LINE, [start, 1.0], **given)


def of_x(function: Any, **options: Any) -> gi.Event:
    recorded = gi.helper(function)
    return gi.Event(lambda params, t, y, work: recorded(y[0]), **options)


def on_line(function: Any, end: float = 1.0, **options: Any) -> np.ndarray:
    """The times at which a function of x is 0, from x = −½ on."""
    return along_line(end, events={"it": of_x(function, **options)}).t_events[0]


def in_parts(problem: gi.Problem, y0: Any, ends: list[float], **given: Any) -> list[gi.Solution]:
    """Runs that go on from each other: with the same events, at the same steps."""
    runs = [gi.solve(problem, y0, t_end=ends[0], **given)]
    for end in ends[1:]:
        runs.append(gi.solve(runs[-1], t_end=end, events=given["events"]))
    return runs


def joined(runs: list[gi.Solution], name: str) -> np.ndarray:
    return np.concatenate([run.events[name].table for run in runs])


# --- all families against many samples -----------------------------------------------------------


def component(problem: gi.Problem, row: int) -> str:
    """The name of a row of the state."""
    return [f"{name}[{i}]" for name, rows in problem.pieces for i in range(rows)][row]


@kinds
@pytest.mark.parametrize("sign", [1, pytest.param(-1, marks=pytest.mark.nightly)])
def test_families(name: str, problem: str, sign: int) -> None:
    """Every change of sign of 4000 samples is an event, and there are no others; on the orbit."""
    p, y0 = PROBLEMS[problem]
    end, run = sign * 2.6, {"method": name, "step": 0.17}
    level = float(0.5 * (y0[0] + gi.solve(p, y0, t_end=0.5 * end, **run).y[-1, 0]))
    events = {"it": gi.Event(component(p, 0), level=level)}
    sol = gi.solve(p, y0, t_end=end, **run, events=events, dense=True, save_every=1)
    assert sol.y.tobytes() == gi.solve(p, y0, t_end=end, **run, save_every=1).y.tobytes()
    times = np.linspace(0.0, end, 4001)
    met, values = sol.events["it"], sol.sol(times)[:, 0] - level
    size = np.abs(values).max()
    np.testing.assert_allclose(met.y, sol.sol(met.t), rtol=0, atol=1e-12)
    assert np.abs(met.y[:, 0] - level).max() <= 1e-13 * size
    clear = np.flatnonzero(np.abs(values) > 1e-6 * size)
    changes = [(i, j) for i, j in itertools.pairwise(clear) if values[i] * values[j] < 0.0]
    assert len(met) == len(changes) > 0
    for (i, j), t, direction in zip(changes, met.t, met.directions, strict=True):
        assert sign * times[i] <= sign * t <= sign * times[j]
        assert direction == np.sign(values[j])
    for constraint in p.constraints if "constraints" in gi.find_method(name).keeps else ():
        at_steps = max(abs(gi.value(p, constraint, y)) for y in sol.y)
        assert max(abs(gi.value(p, constraint, y)) for y in met.y) <= 4.0 * at_steps + 1e-14


@kinds
def test_ends(name: str, problem: str, tmp_path: Path) -> None:
    """A run ends at a terminal event and goes on, also from its file, to all others, once each."""
    p, y0 = PROBLEMS[problem]
    run = {"method": name, "step": 0.17}
    middle = float(0.5 * (y0[0] + gi.solve(p, y0, t_end=1.2, **run).y[-1, 0]))
    event = {"it": gi.Event(component(p, 0), level=middle)}
    plain = gi.solve(p, y0, t_end=3.0, **run, events=event)
    ending = {"it": gi.Event(component(p, 0), level=middle, terminal=True)}
    watched: Any = {"first": lambda params, t, y, work: y[0]}
    stopped = gi.solve(p, y0, t_end=3.0, **run, events=ending, dense=True, observe=watched)
    assert stopped.success
    assert "'it'" in stopped.message
    assert stopped.t[-1] == plain.t_events[0][0] == stopped.drift["first"].windows.last_time
    np.testing.assert_array_equal(stopped.y[-1], plain.y_events[0][0])
    for end in (np.nextafter(stopped.t[-1], 0.0), stopped.t[-1], 0.0):
        with pytest.raises(gi.DomainError, match=f"t_end = .*beyond {stopped.t[-1]:.9g}"):
            gi.solve(stopped, t_end=end)
    stopped.save(tmp_path / "run.nc")
    loaded = gi.load(tmp_path / "run.nc", p)
    assert (loaded, loaded.events) == (stopped, stopped.events)
    times = np.linspace(0.0, stopped.t[-1], 9)
    np.testing.assert_array_equal(loaded.sol(times), stopped.sol(times))
    found = []
    while stopped.message:
        found.append(float(stopped.t[-1]))
        stopped, loaded = (gi.solve(s, t_end=3.0, events=ending) for s in (stopped, loaded))
        assert loaded.events == stopped.events
    np.testing.assert_allclose(found, plain.t_events[0], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(stopped.y[-1], plain.y[-1])


# --- where it is 0, nearly, or not at all ---------------------------------------------------------


@gi.event
def of_roots(params: Any, t: Any, y: Any, work: Any) -> Any:
    """A polynomial by its scale, how many roots it has, and these, in the last parameters."""
    product = params[3] + 0.0 * y[0]
    for i in range(9):
        product = product * gi.select(i < params[4], y[0] - params[5 + i], 1.0 + 0.0 * y[0])
    return product


MULTIPLE = st.lists(st.tuples(st.integers(0, 20), st.integers(1, 5)), max_size=4)


@examples(5)
@given(MULTIPLE, st.sampled_from([0.37, 0.25, 0.05, 5.0]), st.sampled_from([0.0, 1e6, -1e9]))
@example([(4e-4, 5)], 0.37, 0.0)  # soon after the beginning
@example([(4e-6, 3)], 0.05, 1e6)
@example([(0, 2), (20, 5), (10, 1)], 5.0, -1e9)  # at both ends of a step
@example([(1.48, 2), (4, 4), (8, 3)], 0.37, 0.0)  # that touch a node
def test_roots_of_any_multiplicity(roots: Any, step: float, t0: float) -> None:
    """Those at which the sign changes, at steps or between, however small the values and slopes."""
    roots = dict(roots)  # in quarters of x
    assume(sum(roots.values()) <= 9)
    known = sorted(0.25 * x for x, times in roots.items() if times % 2 and 0 < x < 20)
    every = [0.25 * x for x, times in roots.items() for _ in range(times)]
    for sign, scale, method in ((1.0, 1.0, "gauss-8"), (-1.0, 1.0, "rk-4"), (1.0, 1e-150, "rk-4")):
        y0 = 0.0 if sign > 0.0 else 5.0
        params = [scale, len(every), *(y0 + sign * np.array(every)), *[0.0] * (9 - len(every))]
        run = {"t0": t0, "t_end": t0 + 5.0 * sign, "method": method, "step": step}
        met = gi.solve(swing(0.0, 0.0, 0.0, *params), [y0, 1.0], **run, events=of_roots)
        found = np.abs(met.events["of_roots"].y[:, 0] - y0)
        np.testing.assert_allclose(found, known, rtol=0, atol=2e-14 + math.ulp(t0))


def test_touching() -> None:
    """Beyond rounding both sides of a dip are two events; what touches 0, or does not, is none."""
    for dip in (1e-3, 1e-6, 1e-9, 0.0, -1e-12):
        found = on_line(lambda x: (x - 0.0371) * (x - 0.0371), 2.0, level=dip)
        known = 0.5371 + np.array([-1.0, 1.0]) * math.sqrt(dip) if dip > 0.0 else []
        np.testing.assert_allclose(found, known, rtol=0, atol=1e-14 / math.sqrt(abs(dip) or 1.0))


def test_stretches_of_zeros() -> None:
    """One event where a function leaves 0 with another sign; none where it comes back, or stays."""

    @gi.observable
    def dead(params: Any, t: Any, y: Any, work: Any) -> Any:
        left = gi.select(y[0] < -0.2, y[0] + 0.2, 0.0 * y[0])
        return gi.select(y[0] > 0.31, y[0] - 0.31, left)

    def one_side(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.select(y[0] > 0.31, y[0] - 0.31, 0.0 * y[0])

    for step in (0.125, 0.037, 0.6):
        events = {x: gi.Event(dead, x) for x in ("both", "up", "down")}
        met = along_line(1.0, step, events={**events, "one side": gi.Event(one_side)}).t_events
        np.testing.assert_allclose(np.concatenate(met), [0.81, 0.81], rtol=0, atol=1e-14)
        assert len(met[2]) == 0
        assert len(along_line(0.7, step, events={"it": dead}).t_events[0]) == 0
        back = along_line(-1.0, step, 0.5, events={"it": dead})
        np.testing.assert_allclose(back.t_events[0], [-0.7], rtol=0, atol=1e-14)


@pytest.mark.parametrize("coefficient", [0.9, 0.99])
@pytest.mark.parametrize(("method", "step"), [("gauss-8", 0.1), ("gauss-8", 0.003), ("rk-4", 0.02)])
def test_what_bounces(method: str, step: float, coefficient: float) -> None:
    """A run that begins where an event has ended one tells the next bounce, whatever is left of it."""
    tiny = of_x(lambda x: 1e-300 * x, terminal=True)
    for event in (gi.Event("x", terminal=True), tiny):
        y, known = [1.0, 0.0], math.sqrt(2.0 / 9.8)
        for _ in range(40):
            sol = gi.solve(FALL, y, t_end=3.0, method=method, step=step, events=event)
            assert sol.t[-1] == pytest.approx(known, rel=1e-9)
            h, v = sol.y[-1]
            y, known = [h, -coefficient * v], -2.0 * coefficient * v / 9.8


def test_where_runs_begin_and_end() -> None:
    """On an event, to rounding, none is told; a crossing soon after the beginning is."""
    for step in (0.001, 0.01, 0.1):
        run = {"t_end": 1.0, "step": step, "method": "rk-4", "events": "x"}
        for left in (0.0, 1.7e-16, -1.7e-16):
            for speed in (4.0, 0.1, 0.01):
                met = gi.solve(FALL, [left, speed], **run).events["x"]
                np.testing.assert_allclose(met.t, [2.0 * speed / 9.8], rtol=1e-9)
                assert met.directions.tolist() == [-1.0]
            assert len(gi.solve(FALL, [left, -1.0], **run).t_events[0]) == 0
        for height in (1e-3, 1e-9, 1e-12):
            met = gi.solve(FALL, [height, -1.0], **run).events["x"]
            np.testing.assert_allclose(met.t, [height], rtol=1e-2)
            met = gi.solve(FALL, [-height, 1.0], **run).events["x"]
            assert met.directions.tolist() == [1.0, -1.0]
    for sign, direction in itertools.product((1.0, -1.0), ("both", "up", "down")):
        event = {"x": gi.Event("x", direction)}
        sol = gi.solve(CIRCLE, [0.0, 1.0], t_end=sign * math.pi, step=0.1, events=event)
        assert len(sol.t_events[0]) == 0
        rest = gi.solve(sol, t_end=sign * 3.5, events=event)
        told = gi.Event("x", direction).sign in (0, -sign)
        np.testing.assert_allclose(rest.t_events[0], [sign * math.pi] * told, atol=1e-14)
    rest = gi.solve(CIRCLE, [0.0, 0.0], t_end=3.0, step=0.1, events=["x", "v"])
    assert [len(t) for t in rest.t_events] == [0, 0]


def test_what_fades_away() -> None:
    """A motion that tends to 0 crosses it at 1e-60 as at 1."""
    friction, run = 0.2, {"step": 0.2, "events": ["x", "v"]}
    sol = gi.solve(swing(1.0, 0.0, friction), [1.0, 0.0], t_end=1400.0, method="gauss-8", **run)
    half = math.pi / math.sqrt(1.0 - 0.25 * friction**2)
    assert np.abs(sol.y[-1]).max() < 1e-60
    for times in sol.t_events:
        np.testing.assert_allclose(np.diff(times), half, rtol=0, atol=1e-11)
        assert times[-1] > 1400.0 - half


def test_faster_than_the_steps() -> None:
    """Found where the values at quarters of a step tell that there is more; also by time alone."""
    found = on_line(lambda x: gi.sin(300.0 * x), end=4.0)
    known = np.arange(-47, 335) * math.pi / 300.0 + 0.5
    np.testing.assert_allclose(found, known, rtol=0, atol=1e-13)
    strobe = gi.Event(lambda params, t, y, work: gi.sin(20.0 * t), "up")
    found = along_line(2.0, events={"it": strobe}).t_events[0]
    np.testing.assert_allclose(found, 0.1 * math.pi * np.arange(1, 7), rtol=0, atol=1e-13)


TOO_FAST: dict[str, Any] = {  # of x, from which time on, up to which one
    "jump": (lambda x: gi.select(x > 0.05, 1.0, -1.0), 0.4, 0.6),
    "no number": (lambda x: gi.sqrt(0.3 - x), 0.7, 0.9),
    "chatter": (lambda x: gi.sin(1.0 / (0.3001 - x)), 0.4, 0.9),
    "fast": (lambda x: gi.sin(1e4 * x), 0.0, 0.2),
    "gathering": (lambda x: (0.3001 - x) * gi.sin(1.0 / (0.3001 - x)), 0.4, 0.9),
    "noise": (lambda x: gi.select(x < 0.0, x, 1e-9 * (gi.sin(1e12 * x) + 1.000001)), 0.4, 0.7),
}


@pytest.mark.parametrize("name", TOO_FAST)
def test_what_cannot_be_told(name: str) -> None:
    """An error, and no fewer events: jumps, no numbers, too many in a step; with name and time."""
    function, begin, end = TOO_FAST[name]
    with pytest.raises(gi.EventError, match=name) as caught:
        along_line(4.0, events={name: of_x(function)})
    assert begin <= caught.value.t <= end
    assert caught.value.partial.t[-1] <= caught.value.t + 0.125
    assert pickle.loads(pickle.dumps(caught.value)).name == name


# --- directions, ends, going on ------------------------------------------------------------------


QUARTERS = gi.Event(lambda params, t, y, work: gi.sin(4.0 * math.pi * t))  # every ¼ of time
CLOSE = st.sampled_from([0.3, 0.03, 3e-3, 3e-4])  # apart, with other directions
ROUNDINGS = st.sampled_from([0.0, 1e-16, 1e-15, 1e-12, 1e-10, -1e-16, -1e-15, -1e-12, -1e-10])
CUTS = st.lists(st.tuples(st.integers(0, 50), ROUNDINGS), min_size=1, max_size=4)
STEPS = st.sampled_from([("gauss-2", 0.21), ("gauss-8", 0.25), ("gauss-8", 0.3), ("rk-4", 0.02)])


@given(CUTS, CLOSE, STEPS)
@example([(5, 0.0)], 0.3, ("rk-4", 0.02))
@example([(0, 0.0), (3, 1e-16), (16, -1e-16)], 3e-4, ("gauss-8", 0.25))
def test_parts_are_the_whole(cuts: Any, apart: float, steps: tuple[str, float]) -> None:
    """Wherever runs meet, at events, at steps, nearly: each event is told once, with its direction."""
    events = {"close": gi.Event("x", level=math.cos(0.5 * apart)), "x": "x", "often": QUARTERS}
    run = {"method": steps[0], "step": steps[1], "events": events}
    (whole,) = in_parts(CIRCLE, [0.0, 1.0], [9.0], **run)
    assert whole.events["close"].directions.tolist() == [1.0, -1.0, 1.0, -1.0]
    at_events = np.sort(np.concatenate([*whole.t_events, steps[1] * np.arange(1, 9.0 / steps[1])]))
    places = at_events[[k % len(at_events) for k, _ in cuts]]
    ends = sorted({float(at + off) for at, (_, off) in zip(places, cuts, strict=True)})
    runs = in_parts(CIRCLE, [0.0, 1.0], [*(e for e in ends if steps[1] <= e < 9.0), 9.0], **run)
    for name, known in whole.events.items():
        found = joined(runs, name)
        assert found[:, 1].tolist() == known.directions.tolist()
        close = 2e-14 / apart if name == "close" else 1e-13
        np.testing.assert_allclose(found[:, 0], known.t, rtol=0, atol=close)


@pytest.mark.parametrize("t0", [1e6, 1e8, -1e10])
@pytest.mark.parametrize("method", ["gauss-8", "rk-4"])
def test_told_once_far_away(t0: float, method: str) -> None:
    """Where a step is few roundings of the time, a run that ends at an event tells it, or the next."""
    given = {"t0": t0, "method": method, "step": 0.11337, "events": "x"}
    (whole,) = in_parts(PENDULUM, [0.5, 1.0], [t0 + 20.1234567], **given)
    known = whole.t_events[0]
    assert len(known) > 3
    runs = in_parts(PENDULUM, [0.5, 1.0], [float(known[1]), t0 + 20.1234567], **given)
    assert sum(len(run.t_events[0]) for run in runs) == len(known)


@given(ROUNDINGS, st.sampled_from([0.03, 0.125, 0.05, 0.25]))
def test_ends_that_coincide(off: float, level: float) -> None:
    """Of events at nearly one time, that end the run or not, each is told once."""
    both = {"a": gi.Event("x", level=level, terminal=True)}
    both["b"] = gi.Event("x", level=level + off, terminal=True)
    both["c"] = gi.Event("x", level=level + off)
    runs = [along_line(events=both)]
    while runs[-1].message:
        assert len(runs) <= 2
        runs.append(gi.solve(pickle.loads(pickle.dumps(runs[-1])), t_end=1.0, events=both))
    for name in both:
        assert joined(runs, name)[:, 0] == pytest.approx([0.5 + level], abs=2e-10)


def test_a_cut_that_lost_a_crossing() -> None:
    """The first of two crossings, where a run ends at the second: one to some bits."""
    event, end = {"it": gi.Event("v", level=2.0224431786659807)}, 0.3548290399694999
    y0, run = [2.414072896809409, 2.1442845754583004], {"method": "gauss-1", "events": event}
    first = gi.solve(PENDULUM, y0, t_end=end, step=0.12290926635596956, **run)
    then = gi.solve(first, t_end=end + 0.13, events=event)
    told = [sol.events["it"].directions.tolist() for sol in (first, then)]
    assert told == [[-1.0], [1.0]]


@pytest.mark.parametrize("method", ["gauss-8", "rattle-2"])
def test_rounding_alone_is_no_crossing(method: str) -> None:
    """What stays at its level, to some roundings of much larger terms; from the first step on."""
    p, y0 = PROBLEMS["spherical-pendulum"] if method == "rattle-2" else PROBLEMS["sphere-metric"]
    y0 = p.canonical(y0)
    square = gi.observable(lambda params, t, y, work: y[0] * y[0] + y[1] * y[1] + y[2] * y[2])
    event = {"length": gi.Event(square, level=float(y0[:3] @ y0[:3]))}
    end = {"tau_end" if p.time == "tau" else "t_end": 10.0}
    sol = gi.solve(p, y0, **end, method=method, step=0.1, events=event)
    assert len(sol.events["length"].t) == 0


def test_what_lies_beyond_the_end() -> None:
    """What cannot be told is no error beyond the event that ends the run, be it in the same step."""
    no_number = of_x(lambda x: gi.sqrt(0.3 - x) - 0.12)
    jump = of_x(lambda x: gi.select(x > 0.26, 1.0, -1.0))
    for start in (-0.5, -4.5):  # along the orbit; along the interpolant
        guard = {"guard": gi.Event("x", level=0.29, terminal=True)}
        for events in ({"no": no_number, **guard}, {**guard, "no": no_number}):
            sol = along_line(7.0, start=start, events=events)
            assert sol.message == "ended by the event 'guard'"
            assert sol.t[-1] + start == pytest.approx(0.29, abs=1e-12)
            assert sol.events["no"].tau + start == pytest.approx([0.2856], abs=1e-12)
        with pytest.raises(gi.EventError, match="jump"):
            along_line(7.0, start=start, events={"jump": jump, **guard})


def test_the_first_end_counts() -> None:
    """Of several events that end a run the first does; of one of them its third; none is later."""
    events = {"x": gi.Event("x", terminal=3), "v": gi.Event("v", terminal=5)}
    run = {"t_end": 100.0, "step": 0.3, "events": {**events, "half": gi.Event("x", level=0.5)}}
    for sign in (-1.0, 1.0):
        sol = gi.solve(CIRCLE, [1.0, 0.0], **{**run, "t_end": sign * 100.0})
        assert sol.message == "ended by the event 'x'"
        assert [len(t) for t in sol.t_events] == [3, 2, 3]
        assert sol.t[-1] == sol.t_events[0][-1] == pytest.approx(sign * 2.5 * math.pi, abs=1e-12)
    asked = gi.solve(CIRCLE, [1.0, 0.0], **run, t_eval=[1.0, 7.0, 8.0])
    np.testing.assert_array_equal(asked.t, [1.0, 7.0])


WATCHED: dict[str, Any] = {"observe": {"x": gi.observable(lambda params, t, y, work: y[0])}}
IN_CHUNKS: dict[str, Any] = {  # problem, state, what is asked for
    "an end at a step": (
        *(LINE, [-0.5, 1.0]),
        {"t_end": 2.0, "step": 0.125, "method": "rk-4", "events": gi.Event("x", terminal=True)}
        | {"dense": True, "save_every": 1, **WATCHED},
    ),
    "ends": (
        *(SPHERE, SPHERE.random_state(5)),
        {"t_end": 60.0, "step": 0.4, "events": ["gamma[2]", gi.Event("gamma[0]", terminal=9)]},
    ),
    "late": (CIRCLE, [1.0, 0.0], {"t0": 2900.0, "t_end": 3000.0, "step": 0.2, "events": ["x"]}),
    "an end by the clock": (
        *(SPHERE, SPHERE.random_state(5)),
        {"t_end": 4.0, "step": 0.1, "method": "gauss-4", "observe": "K", "t_eval": [1.0, 4.0]},
    ),
}


@pytest.mark.parametrize("name", IN_CHUNKS)
def test_chunks_do_not_matter(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """However a run is cut into chunks: the same bits of all, where it ends and goes on from."""
    problem, y0, given = IN_CHUNKS[name]
    found = []
    for first, seconds in ((64, 0.03), (1, 0.0), (3, 0.0), (5, 0.0), (10**6, 1.0)):
        monkeypatch.setattr(driver, "FIRST_CHUNK", first)
        monkeypatch.setattr(driver, "CHUNK_SECONDS", seconds)
        found.append(gi.solve(problem, y0, **given))
        assert found[-1] == found[0]
        assert found[-1].restart == found[0].restart
        assert (found[-1].events, found[-1].drift) == (found[0].events, found[0].drift)
        if name == "an end at a step":  # that is the last whole one
            np.testing.assert_array_equal(found[-1].t, [0.0, 0.125, 0.25, 0.375, 0.5])
            np.testing.assert_array_equal(found[-1].sol(found[-1].t), found[-1].y)


def test_two_times() -> None:
    """In τ the times are physical, and τ is there too; with an end in τ and no clock τ alone."""
    y0, run = SPHERE.random_state(2), {"step": 0.4, "events": "gamma[1]"}
    sol = gi.solve(SPHERE, y0, t_end=20.0, **run, dense=True)
    met = sol.events["gamma[1]"]
    np.testing.assert_allclose(sol.sol(met.t), met.y, rtol=0, atol=1e-13)
    np.testing.assert_allclose(sol.sol(tau=met.tau), met.y, rtol=0, atol=1e-13)
    bare = gi.solve(SPHERE, y0, tau_end=float(sol.tau[-1]), clock=False, **run)
    assert bare.events["gamma[1]"].t is None
    np.testing.assert_allclose(bare.t_events[0], met.tau, rtol=0, atol=1e-12)


# --- what they are --------------------------------------------------------------------------------


def test_values() -> None:
    """Events compare, copy, pickle, have names; names and functions mean the same, and compile once."""
    one = gi.Event("gamma[2]", direction=1, terminal=2, level=0.25)
    assert one == gi.Event("gamma[2]", "up", 2, 0.25) != gi.Event("gamma[2]")
    for other in (copy.copy(one), copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        assert other == one
    assert one.name == "gamma[2] = 0.25"

    @gi.event(direction="down", level=0.5)
    def mine(params: Any, t: Any, y: Any, work: Any) -> Any:
        return y[0]

    run = {"t_end": 9.0, "step": 0.3, "method": "gauss-8"}
    known = gi.solve(CIRCLE, [1.0, 0.0], **run, events={"x": gi.Event("x[0]", "down", level=0.5)})
    made = gi.solve(CIRCLE, [1.0, 0.0], **run, events=mine)
    np.testing.assert_array_equal(known.t_events[0], made.t_events[0])
    with pytest.raises(KeyError, match=r"events\['.*'\]: no such name.*mine = 0\.5'.* events=…"):
        made.events["mine"]
    for what in ("x", "v", mine.what):  # at another level, of another component
        sol = gi.solve(CIRCLE, [1.0, 0.0], **run, events={"it": gi.Event(what, level=0.123)})
        assert sol.compile_seconds == 0.0
        assert len(sol.t_events[0]) > 1


def test_wrong_events() -> None:
    """Typed errors that say what is right; of an event when it is made."""
    for events, said in (
        (lambda t, y: y[0], "decorate it with @geomint.event"),
        *(("x[1]", r"x\[0\] to x\[0\]"), ("radius", "a component or a quantity")),
        *((x, "names of components") for x in (7, [3.0])),
        (["x", "x"], "unlike each other"),
        *((x, "a name of 1 to") for x in ({"": "x"}, {3: "x"})),
    ):
        with pytest.raises(gi.DomainError, match=said):
            gi.solve(CIRCLE, [1.0, 0.0], t_end=1.0, events=events)
    for name, values in {
        **{"direction": ("left", 2, None, []), "terminal": (0, -1, "yes")},
        **{"level": (math.nan, "x"), "what": (3,)},
    }.items():
        for value in values:
            with pytest.raises(gi.DomainError, match=name):
                gi.Event(**{"what": "x", name: value})
