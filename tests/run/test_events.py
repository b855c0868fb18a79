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

import chaplygin as ch
import geomint as gi
from geomint.run import driver
from tests.families import PROBLEMS, kinds
from tests.problems import lotka_volterra


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """y = (cos ω t, sin ω t)."""
    out[0] = -params[0] * y[1]
    out[1] = params[0] * y[0]


CIRCLE = gi.Problem("circle", (("x", 1), ("y", 1)), field=turning, params=[1.0])


@gi.field
def passing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """y = t."""
    out[0] = 1.0 + 0.0 * y[0]


LINE = gi.Problem("line", (("x", 1),), field=passing)


def on_line(function: Any, end: float = 1.0, step: float = 0.125, **options: Any) -> np.ndarray:
    """The times at which a function of x = t is 0, from −½ … on, whose steps are exact."""
    event = gi.Event(function, **options)
    return gi.solve(
        LINE, [-0.5], t_end=end, step=step, method="rk-4", events={"it": event}
    ).t_events[0]


# --- all families against many samples -----------------------------------------------------------


@kinds
@pytest.mark.parametrize(
    "sign",
    [1, pytest.param(-1, marks=pytest.mark.nightly)],
    ids=["forwards", "backwards"],
)
def test_families(name: str, problem: str, sign: int) -> None:
    """Every change of sign of 4000 samples is an event, and there are no others; on the orbit."""
    p, y0 = PROBLEMS[problem]
    end, rows = sign * 2.6, range(1)
    middle = gi.solve(p, y0, t_end=0.5 * end, method=name, step=0.17).y[-1]
    events = {
        str(r): gi.Event(component(p, r), level=float(0.5 * (y0[r] + middle[r]))) for r in rows
    }
    run = {"t_end": end, "method": name, "step": 0.17}
    sol = gi.solve(p, y0, **run, events=events, dense=True, save_every=1)
    assert sol.y.tobytes() == gi.solve(p, y0, **run, save_every=1).y.tobytes()
    times = np.linspace(0.0, end, 4001)
    states = sol.sol(times)
    assert sum(len(met) for met in sol.events.values()) > 0
    for r in rows:
        met, values = sol.events[str(r)], states[:, r] - events[str(r)].level
        size = np.abs(values).max()
        np.testing.assert_allclose(met.y, sol.sol(met.t), rtol=0, atol=1e-12)
        assert np.abs(met.y[:, r] - events[str(r)].level).max(initial=0.0) <= 1e-13 * size
        clear = np.flatnonzero(np.abs(values) > 1e-6 * size)
        changes = [(i, j) for i, j in itertools.pairwise(clear) if values[i] * values[j] < 0.0]
        assert len(met) == len(changes)
        for (i, j), t, direction in zip(changes, met.t, met.directions, strict=True):
            assert sign * times[i] <= sign * t <= sign * times[j]
            assert direction == np.sign(values[j])
    if "constraints" in gi.find_method(name).keeps:
        for constraint in p.constraints.values():
            for met in sol.events.values():
                at_steps = max(abs(gi.value(p, constraint, y)) for y in sol.y)
                off = [abs(gi.value(p, constraint, y)) for y in met.y]
                assert max(off, default=0.0) <= 4.0 * at_steps + 1e-14


def component(problem: gi.Problem, row: int) -> str:
    """The name of a row of the state."""
    for name, rows in problem.slices.items():
        if rows.start <= row < rows.stop:
            return f"{name}[{row - rows.start}]"
    raise AssertionError


@pytest.mark.parametrize("step", [0.3, 1.1, 3.3])
def test_many_in_a_step(step: float) -> None:
    """Up to three in a step of a fast circle; times to rounding."""
    for omega in (1.0, 3.0):
        problem = gi.Problem("circle", CIRCLE.pieces, field=turning, params=[omega])
        run = {"t_end": 40.0, "step": step / omega, "method": gi.Gauss(16, max_iterations=1000)}
        sol = gi.solve(problem, [1.0, 0.0], **run, events=["x", "y"])
        for met, first in zip(sol.events.values(), (0.5 * math.pi, math.pi), strict=True):
            known = np.arange(first, 40.0 * omega, math.pi) / omega
            assert len(met) == len(known)
            np.testing.assert_allclose(met.t, known, rtol=0, atol=1e-12)


# --- where it is 0, nearly, or not at all ---------------------------------------------------------


def test_zero_at_the_start() -> None:
    """Where a run begins there is no event, whatever comes after; the next one is one."""
    for y0 in ([0.0, 1.0], [0.0, -1.0]):
        sol = gi.solve(CIRCLE, y0, t_end=7.0, step=0.1, events="x")
        np.testing.assert_allclose(sol.t_events[0], [math.pi, 2 * math.pi], rtol=0, atol=1e-14)
    rest = gi.solve(CIRCLE, [0.0, 0.0], t_end=3.0, step=0.1, events=["x", "y"])
    assert [len(t) for t in rest.t_events] == [0, 0]


def test_zero_at_a_step() -> None:
    """A root exactly at a node, the first, a later one, the last, is one event."""

    @gi.observable
    def at_zero(params: Any, t: Any, y: Any, work: Any) -> Any:
        return y[0]

    for step in (0.5, 0.25, 0.125, 0.0625):
        found = on_line(at_zero, step=step)
        assert found.shape == (1,)
        assert abs(found[0] - 0.5) < 1e-6 * step
    assert len(on_line(at_zero, end=0.5)) == 0  # the sign does not change before the end


def test_touching() -> None:
    """What touches 0 is no event; beyond rounding both sides of a dip are two."""
    for dip in (1e-3, 1e-6, 1e-9):

        @gi.observable
        def parabola(params: Any, t: Any, y: Any, work: Any) -> Any:
            return (y[0] - 0.0371) * (y[0] - 0.0371) - dip  # noqa: B023

        found = on_line(parabola, end=2.0)
        known = 0.5371 + np.array([-1.0, 1.0]) * math.sqrt(dip)
        np.testing.assert_allclose(found, known, rtol=0, atol=1e-11 / math.sqrt(dip) * 1e-3)

    @gi.observable
    def above(params: Any, t: Any, y: Any, work: Any) -> Any:
        return (y[0] - 0.0371) * (y[0] - 0.0371)

    @gi.observable
    def cubic(params: Any, t: Any, y: Any, work: Any) -> Any:
        return (y[0] - 0.0371) * (y[0] - 0.0371) * (y[0] - 0.0371)

    assert len(on_line(above, end=2.0)) == 0
    assert on_line(cubic, end=2.0) == pytest.approx([0.5371], abs=1e-14)


@gi.field
def falling(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ḧ = −9.8."""
    out[0] = y[1]
    out[1] = -9.8 + 0.0 * y[1]


FALL = gi.Problem("fall", (("h", 1), ("v", 1)), field=falling)


def power(n: int, scale: float = 1.0) -> gi.Event:
    @gi.event
    def of_height(params: Any, t: Any, y: Any, work: Any) -> Any:
        product = scale * y[0]
        for _ in range(n - 1):
            product = product * y[0]
        return product

    return of_height


@pytest.mark.parametrize("method", ["gauss-8", "rk-4"])
def test_multiple_roots(method: str) -> None:
    """The bracket decides: roots of any multiplicity, and at any scale, are met as simple ones are."""
    known = math.sqrt(100.0 / 9.8)
    events = {str(n): power(n) for n in (1, 3, 5, 9)}
    events |= {str(scale): power(1, scale) for scale in (1e-300, 1e300, -1e-300)}
    for step in (0.013, 0.11, 0.4567, known / 7.0, known / 7.01):
        run = {"t_end": 5.0, "method": method, "step": step}
        sol = gi.solve(FALL, [50.0, 0.0], **run, events=events)
        for times in sol.t_events:
            np.testing.assert_allclose(times, [known], rtol=4e-15)
        assert [met.directions.tolist() for met in sol.events.values()] == [[-1.0]] * 6 + [[1.0]]


def test_stretches_of_zeros() -> None:
    """One event where a function leaves 0 with another sign; none where it comes back, or stays."""

    @gi.observable
    def dead(params: Any, t: Any, y: Any, work: Any) -> Any:
        left = gi.select(y[0] < -0.2, y[0] + 0.2, 0.0 * y[0])
        return gi.select(y[0] > 0.31, y[0] - 0.31, left)

    @gi.observable
    def one_side(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.select(y[0] > 0.31, y[0] - 0.31, 0.0 * y[0])

    for step in (0.125, 0.037, 0.6):
        for direction in ("both", "up"):
            found = on_line(dead, end=1.0, step=step, direction=direction)
            np.testing.assert_allclose(found, [0.81], rtol=0, atol=1e-14)
        assert len(on_line(dead, end=1.0, step=step, direction="down")) == 0
        assert len(on_line(dead, end=0.7, step=step)) == 0
        assert len(on_line(one_side, end=1.0, step=step)) == 0
        back = gi.solve(LINE, [0.5], t_end=-1.0, step=step, method="rk-4", events={"it": dead})
        np.testing.assert_allclose(back.t_events[0], [-0.7], rtol=0, atol=1e-14)


@pytest.mark.parametrize("coefficient", [0.9, 0.99])
@pytest.mark.parametrize(("method", "step"), [("gauss-8", 0.1), ("gauss-8", 0.003), ("rk-4", 0.02)])
def test_what_bounces(method: str, step: float, coefficient: float) -> None:
    """A run that begins where an event has ended one tells the next bounce, whatever is left of it."""
    run = {"t_end": 3.0, "method": method, "step": step}
    for event in (gi.Event("h", terminal=True), gi.Event(power(1, 1e-300).what, terminal=True)):
        y, known = [1.0, 0.0], math.sqrt(2.0 / 9.8)
        for _ in range(40):
            sol = gi.solve(FALL, y, **run, events=event)
            assert sol.t[-1] == pytest.approx(known, rel=1e-9)
            h, v = sol.y[-1]
            y, known = [h, -coefficient * v], -2.0 * coefficient * v / 9.8


def test_where_runs_begin_and_end() -> None:
    """On an event, to rounding, none is told; a crossing soon after the beginning is."""
    for step in (0.001, 0.01, 0.1):
        run = {"t_end": 1.0, "step": step, "method": "rk-4", "events": "h"}
        for left in (0.0, 1.7e-16, -1.7e-16):
            for speed in (4.0, 0.1, 0.01):
                met = gi.solve(FALL, [left, speed], **run).events["h"]
                np.testing.assert_allclose(met.t, [2.0 * speed / 9.8], rtol=1e-9)
                assert met.directions.tolist() == [-1.0]
            assert len(gi.solve(FALL, [left, -1.0], **run).t_events[0]) == 0
        for height in (1e-3, 1e-9, 1e-12):
            met = gi.solve(FALL, [height, -1.0], **run).events["h"]
            np.testing.assert_allclose(met.t, [height], rtol=1e-2)
            met = gi.solve(FALL, [-height, 1.0], **run).events["h"]
            assert met.directions.tolist() == [1.0, -1.0]
    for sign in (1.0, -1.0):
        for direction in ("both", "up", "down"):
            event = {"x": gi.Event("x", direction)}
            given = {"step": 0.1, "events": event}
            sol = gi.solve(CIRCLE, [0.0, -1.0], t_end=sign * math.pi, **given)
            assert len(sol.t_events[0]) == 0
            rest = gi.solve(sol, t_end=sign * 3.5, events=event)
            told = gi.Event("x", direction).sign in (0, -sign)
            np.testing.assert_allclose(rest.t_events[0], [sign * math.pi] * told, atol=1e-14)


@gi.event
def of_roots(params: Any, t: Any, y: Any, work: Any) -> Any:
    """A polynomial by how many roots it has, and these."""
    product = 1.0 + 0.0 * y[0]
    for i in range(9):
        product = product * gi.select(i < params[0], y[0] - params[1 + i], 1.0 + 0.0 * y[0])
    return product


@pytest.mark.parametrize(("method", "step"), [("gauss-8", 0.37), ("rk-4", 0.05), ("rk-4", 5.0)])
@pytest.mark.parametrize("t0", [0.0, 1e6, -1e9])
def test_roots_at_the_ends_of_steps(method: str, step: float, t0: float) -> None:
    """Multiple ones soon after the beginning, at both ends of a step, and those that touch a node."""
    for roots, simple in (
        ([1e-4] * 5, [1e-4]),
        ([1e-6] * 3, [1e-6]),
        ([0.0] * 2 + [5.0] * 5 + [2.5], [2.5]),
        ([1.0] * 2, []),
        ([0.37] * 2 + [1.0] * 4 + [2.0] * 3, [2.0]),
    ):
        for y0, sign in ((0.0, 1.0), (5.0, -1.0)):
            params = [len(roots), *(y0 + sign * np.array(roots)), *[0.0] * (9 - len(roots))]
            problem = gi.Problem("line", LINE.pieces, params, field=passing)
            run = {"t0": t0, "t_end": t0 + 5.0 * sign, "method": method, "step": step}
            met = gi.solve(problem, [y0], **run, events=of_roots)
            found = np.abs(met.events["of_roots"].y[:, 0] - y0)
            np.testing.assert_allclose(found, simple, rtol=0, atol=2e-14 + math.ulp(t0))


def test_sections_that_begin_on_their_surface() -> None:
    """Points are counted from the next crossing on, in τ and t, forwards and backwards."""
    ball = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).hamiltonized()
    y0 = ball.random_state(5)
    for event in (gi.Event("gamma[2]", "up"), gi.Event("gamma[2]")):
        first = gi.poincare_section(ball, y0, event, 3, step=0.3)
        again = gi.poincare_section(ball, first.y[0], event, 2, step=0.3)
        np.testing.assert_allclose(again.tau, first.tau[1:] - first.tau[0], rtol=0, atol=1e-12)
        end = gi.solve(ball, first.y[0], tau_end=float(again.tau[0]), step=0.3, events=event)
        assert len(end.t_events[0]) <= 1


@gi.event
def with_a_number_of_its_own(params: Any, t: Any, y: Any, work: Any) -> Any:
    return y[0] + 0.000123 * y[1]


def test_another_level_compiles_nothing() -> None:
    """Nor does another component."""
    run = {"t_end": 9.0, "step": 0.3, "method": "gauss-8"}
    gi.solve(CIRCLE, [1.0, 0.0], **run, events=["x", with_a_number_of_its_own])
    rng = np.random.default_rng()
    for what in ("x", "y", with_a_number_of_its_own.what):
        event = {"it": gi.Event(what, level=float(rng.uniform(0.1, 0.9)))}
        sol = gi.solve(CIRCLE, [1.0, 0.0], **run, events=event)
        assert sol.compile_seconds == 0.0
        assert len(sol.t_events[0]) > 1


@gi.field
def swinging(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A pendulum with friction that comes to rest at x = params[1]."""
    out[0] = y[1]
    out[1] = params[1] - y[0] - params[0] * y[1]


def test_what_fades_away() -> None:
    """A motion that tends to 0 crosses it at 1e-60 as at 1; one that ends elsewhere does not."""
    pieces, friction = (("x", 1), ("v", 1)), 0.2
    problem = gi.Problem("swing", pieces, field=swinging, params=[friction, 0.0])
    sol = gi.solve(problem, [1.0, 0.0], t_end=1400.0, step=0.2, events=["x", "v"])
    half = math.pi / math.sqrt(1.0 - 0.25 * friction**2)
    assert np.abs(sol.y[-1]).max() < 1e-60
    for times in sol.t_events:
        np.testing.assert_allclose(np.diff(times), half, rtol=0, atol=1e-11)
        assert times[-1] > 1400.0 - half
    elsewhere = gi.Problem("swing", pieces, field=swinging, params=[friction, 1.0])
    events = [gi.Event("x", level=1.0), "v"]
    rest = gi.solve(elsewhere, [2.0, 0.0], t_end=600.0, step=0.2, method="dop853", events=events)
    known = sol.t_events[0][sol.t_events[0] < 200.0]
    np.testing.assert_allclose(rest.t_events[0][: len(known)], known, rtol=0, atol=1e-6)
    assert max(map(len, rest.t_events)) < 120  # and not what rounding does to 1


def test_faster_than_the_steps() -> None:
    """Found where the values at quarters of a step tell that there is more; or an error, no fewer."""

    @gi.event
    def fast(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.sin(300.0 * y[0])

    @gi.event
    def faster(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.sin(1e4 * y[0])

    @gi.event
    def gathering(params: Any, t: Any, y: Any, work: Any) -> Any:
        return (0.3001 - y[0]) * gi.sin(1.0 / (0.3001 - y[0]))

    @gi.event
    def noise(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.select(y[0] < 0.0, y[0], 1e-9 * (gi.sin(1e12 * y[0]) + 1.000001))

    found = on_line(fast.what, end=4.0, step=0.125)
    known = np.arange(-47, 335) * math.pi / 300.0 + 0.5
    np.testing.assert_allclose(found, known, rtol=0, atol=1e-13)
    for event in (faster, gathering, noise):
        with pytest.raises(gi.EventError, match=event.name):
            gi.solve(LINE, [-0.5], t_end=4.0, step=0.125, method="rk-4", events=event)


def test_two_near_the_end_of_a_step() -> None:
    """A dip of a millionth of the event's size, close before a step, is not taken for none."""

    @gi.observable
    def dip(params: Any, t: Any, y: Any, work: Any) -> Any:
        fast = -0.004443726658953464 * gi.sin(1.1529247451231117 * y[0] + 3.0029646473448826)
        return (
            fast
            + -0.024406712722650714 * gi.sin(0.6070164654827902 * y[0] + 4.087352167534571)
            + -0.01997712920006731
        )

    h, end = 3.3736105563259864, 172.05413837262532
    run = {"t_end": -end, "step": 0.97 * h, "method": "rk-4", "events": {"it": dip}}
    found = gi.solve(LINE, [end], **run).y_events[0][:, 0] / h
    np.testing.assert_allclose(found[np.abs(found - 43.283) < 0.1], [43.28627, 43.27993], atol=1e-5)


def test_time_in_events() -> None:
    """An event may depend on time alone, more often than there are steps."""

    @gi.observable
    def strobe(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.sin(20.0 * t) + 0.0 * y[0]

    found = on_line(strobe, end=2.0, direction="up")
    np.testing.assert_allclose(found, 0.1 * math.pi * np.arange(1, 7), rtol=0, atol=1e-13)


def test_what_cannot_be_told() -> None:
    """Jumps, numbers that are none, too many in a step: typed, with the name and the time."""

    @gi.event
    def jump(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.select(y[0] > 0.05, 1.0, -1.0)

    @gi.event
    def no_number(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.sqrt(0.3 - y[0])

    @gi.event
    def chatter(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.sin(1.0 / (0.3001 - y[0]))

    for event in (jump, no_number, chatter):
        with pytest.raises(gi.EventError, match=event.name) as caught:
            gi.solve(LINE, [-0.5], t_end=1.0, step=0.125, method="rk-4", events=event)
        assert 0.4 < caught.value.t < 0.9
        assert caught.value.partial.t[-1] <= caught.value.t + 0.125
        assert pickle.loads(pickle.dumps(caught.value)).name == event.name


# --- directions, ends, going on ------------------------------------------------------------------


def test_directions() -> None:
    """Up, down, both; in the order of the run, also backwards."""
    for end in (20.0, -20.0):
        every = gi.solve(CIRCLE, [1.0, 0.0], t_end=end, step=0.3, events="y").events["y"]
        for direction, sign in (("up", 1), ("down", -1), (1, 1), (-1, -1)):
            some = gi.solve(
                CIRCLE, [1.0, 0.0], t_end=end, step=0.3, events=gi.Event("y", direction)
            ).events["y"]
            np.testing.assert_array_equal(some.t, every.t[every.directions == sign])
            assert set(some.directions) == {sign}


def test_names_of_events() -> None:
    """One that is not there is told with those that are."""
    p, y0 = PROBLEMS["sphere"] if "sphere" in PROBLEMS else next(iter(PROBLEMS.values()))
    name = component(p, 0)
    run = gi.solve(p, y0, t_end=1.0, events=gi.Event(name, level=0.3))
    with pytest.raises(KeyError, match=r"events\['.*'\]: no such name.* = 0\.3'.* events=…"):
        run.events[name]
    assert isinstance(run.events, dict)
    assert run.events.get(name) is None


@pytest.mark.parametrize("t0", [1e6, 1e8, -1e10])
@pytest.mark.parametrize("method", ["gauss-8", "rk-4"])
def test_told_once_far_away(t0: float, method: str) -> None:
    """Where a step is few roundings of the time, a run that ends at an event tells it, or the next."""
    p, y0 = PROBLEMS["henon-heiles"]
    given = {"method": method, "step": 0.11337, "events": "q[0]"}
    one = gi.solve(p, y0, t0=t0, t_end=t0 + 20.1234567, **given).t_events[0]
    assert len(one) > 3
    cut = gi.solve(p, y0, t0=t0, t_end=float(one[1]), **given)
    rest = gi.solve(cut, t_end=t0 + 20.1234567, events="q[0]")
    assert len(cut.t_events[0]) + len(rest.t_events[0]) == len(one)


def test_an_end_before_the_event() -> None:
    """A run that an event has ended goes on beyond it, whatever step it begins with."""
    p, y0 = next(iter(PROBLEMS.values()))
    y1 = gi.solve(p, y0, t_end=1.2, step=0.17).y[-1]
    what = gi.Event(component(p, 0), level=float(0.5 * (y0[0] + y1[0])), terminal=True)
    run = gi.solve(p, y0, t_end=3.0, step=0.17, events=what)
    for end in (np.nextafter(run.t[-1], 0.0), run.t[-1], 0.0):
        with pytest.raises(gi.DomainError, match=f"t_end = .*beyond {run.t[-1]:.9g}"):
            gi.solve(run, t_end=end)


@kinds
def test_ends(name: str, problem: str) -> None:
    """A run ends at a terminal event, and goes on from there to all further ones, once each."""
    p, y0 = PROBLEMS[problem]
    run = {"method": name, "step": 0.17}
    y1 = gi.solve(p, y0, t_end=1.2, **run).y[-1]
    what = gi.Event(component(p, 0), level=float(0.5 * (y0[0] + y1[0])))
    plain = gi.solve(p, y0, t_end=3.0, **run, events=what)
    (known,) = plain.t_events
    assert len(known) > 0
    ending = gi.Event(what.what, level=what.level, terminal=True)
    looked: Any = "all" if name == "rk-4" else {"first": lambda params, t, y, work: y[0]}
    stopped = gi.solve(p, y0, t_end=3.0, **run, events=ending, save_every=1, observe=looked)
    assert stopped.drift
    assert stopped.success
    assert ending.name in stopped.message
    assert stopped.t[-1] == known[0]
    np.testing.assert_array_equal(stopped.y[-1], plain.y_events[0][0])
    for drift in stopped.drift.values():
        assert drift.windows.last_time == known[0]
    found = [float(stopped.t[-1])]
    while True:
        stopped = gi.solve(stopped, t_end=3.0, events=ending)
        if not stopped.message:
            break
        found.append(float(stopped.t[-1]))
    np.testing.assert_allclose(found, known, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(stopped.y[-1], plain.y[-1])


def known_in_parts(level: float, ends: list[float], **first: Any) -> list[np.ndarray]:
    """What a run over the line x = t − ½ tells, in parts that end there, of an event at a level."""
    event, parts = {"it": gi.Event("x", level=level)}, []
    sol = gi.solve(
        LINE, [-0.5], t_end=ends[0], step=0.125, method="rk-4", events={**event, **first}
    )
    parts.append(sol.t_events[0])
    for end in ends[1:]:
        sol = gi.solve(sol, t_end=end, events=event)
        parts.append(sol.t_events[0])
    return parts


@pytest.mark.parametrize("end", [0.5, 0.55], ids=["at a step", "between"])
@pytest.mark.parametrize("off", [0.0, 1e-16, 1e-15, 1e-12, 1e-10, -1e-15, -1e-12, -1e-10])
def test_nothing_is_lost_where_runs_meet(end: float, off: float) -> None:
    """What happens where a run ends, to rounding or nearly, is told once: by it or by the next."""
    parts = known_in_parts(end - 0.5 + off, [end, 0.75, 1.0])
    assert [len(t) for t in parts] in ([1, 0, 0], [0, 1, 0])
    assert np.concatenate(parts)[0] == pytest.approx(end + off, abs=1e-14)


@pytest.mark.parametrize("off", [0.0, 1e-16, 1e-15, 1e-13, 1e-11, -1e-15, -1e-13])
def test_ends_that_coincide(off: float) -> None:
    """Of two events at nearly one time, one of which ends the run, both are told once."""
    parts = known_in_parts(0.03 + off, [1.0, 1.0], end=gi.Event("x", level=0.03, terminal=True))
    assert sum(map(len, parts)) == 1
    both = {"a": gi.Event("x", level=0.03, terminal=True)}
    both["b"] = gi.Event("x", level=0.03 + off, terminal=True)
    sol = gi.solve(LINE, [-0.5], t_end=1.0, step=0.125, method="rk-4", events=both)
    counts, runs = [len(t) for t in sol.t_events], 1
    while sol.message:
        assert runs <= 2
        sol = gi.solve(pickle.loads(pickle.dumps(sol)), t_end=1.0, events=both)
        counts, runs = [n + len(t) for n, t in zip(counts, sol.t_events, strict=True)], runs + 1
    assert counts == [1, 1]


@pytest.mark.parametrize("method", ["gauss-2", "gauss-8", "rk-4"])
@pytest.mark.parametrize("apart", [0.3, 0.03, 3e-3, 3e-4])
def test_cut_at_close_crossings(method: str, apart: float) -> None:
    """Of two close crossings none is lost, and each keeps its direction, where a run ends at one."""
    y0, run = [1.0, 0.0], {"step": 0.02 if method == "rk-4" else 0.21, "method": method}
    event = {"it": gi.Event("y", level=math.cos(0.5 * apart))}
    known = gi.solve(CIRCLE, y0, t_end=9.0, **run, events=event).events["it"]
    assert known.directions.tolist() == [1.0, -1.0, 1.0, -1.0]
    for at in known.t:
        ends = [at]
        for _ in range(2):
            ends = [np.nextafter(ends[0], 0.0), *ends, np.nextafter(ends[-1], 9.0)]
        for end in ends:
            first = gi.solve(CIRCLE, y0, t_end=float(end), **run, events=event)
            then = gi.solve(first, t_end=9.0, events=event)
            both = [sol.events["it"] for sol in (first, then)]
            times = np.concatenate([met.t for met in both])
            assert np.concatenate([met.directions for met in both]).tolist() == [1, -1, 1, -1]
            np.testing.assert_allclose(times, known.t, rtol=0, atol=2e-14 / apart)


@gi.field
def free_swinging(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A pendulum."""
    out[0] = y[1]
    out[1] = -gi.sin(y[0])


PENDULUM = gi.Problem("pendulum", (("angle", 1), ("momentum", 1)), field=free_swinging)
BALL = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
# Problem, state; method, step, component, level, end, which is a crossing to some bits: small
# differences of larger numbers, and a dip at the end of a step that is far too long.
LOST = {
    "small differences": (
        BALL,
        [
            *(-0.2693028417671992, -0.18467477034706026, -0.9451831614101953),
            *(0.5974588115252236, 0.06724363868658273, -0.18336716775165357),
        ],
        ("gauss-8", 0.13741796376532014, "gamma[1]", -0.19891071447709965, -0.2902021457773462),
    ),
    "a level": (
        PENDULUM,
        [2.414072896809409, 2.1442845754583004],
        ("gauss-1", 0.12290926635596956, "momentum[0]", 2.0224431786659807, 0.3548290399694999),
    ),
    "a dip at the end": (
        BALL,
        [
            *(-0.7837787445725445, 0.567778066271007, 0.2516325635084654),
            *(-0.622567523856032, -0.870349841283895, 0.02468026203500709),
        ],
        ("rk-4", 0.3453011645096846, "gamma[0]", -1.0572162869275588, -1.3384282044349987),
    ),
}


@pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")
@pytest.mark.parametrize("name", LOST)
def test_cuts_that_lost_a_crossing(name: str) -> None:
    """The first of two crossings, where a run ends at the second."""
    p, y0, (method, step, component, level, end) = LOST[name]
    event = {"it": gi.Event(component, level=level)}
    key = "tau_end" if p.time == "tau" else "t_end"
    first = gi.solve(p, y0, **{key: end}, method=method, step=step, events=event)
    then = gi.solve(first, **{key: end + math.copysign(step, end)}, events=event)
    told = [sol.events["it"].directions.tolist() for sol in (first, then)]
    assert told == [[-1.0], [1.0]]


@gi.observable
def squared(params: Any, t: Any, y: Any, work: Any) -> Any:
    return y[0] * y[0] + y[1] * y[1] + y[2] * y[2]


@pytest.mark.parametrize("method", ["gauss-8", "rattle-2"])
def test_rounding_alone_is_no_crossing(method: str) -> None:
    """What stays at its level, to some roundings of much larger terms; from the first step on."""
    p, y0 = PROBLEMS["spherical-pendulum"] if method == "rattle-2" else PROBLEMS["sphere-metric"]
    y0 = p.canonical(y0)
    event = {"length": gi.Event(squared, level=float(y0[:3] @ y0[:3]))}
    end = {"tau_end" if p.time == "tau" else "t_end": 10.0}
    sol = gi.solve(p, y0, **end, method=method, step=0.1, events=event)
    assert len(sol.events["length"].t) == 0


def test_parts_are_the_whole() -> None:
    """A run in parts looks back at the steps before: the same events to the bit."""
    events = {"x": gi.Event("x", level=0.3), "y": "y"}
    run = {"step": 0.25, "events": events}
    whole = gi.solve(CIRCLE, [1.0, 0.0], t_end=40.0, **run)
    part = gi.solve(CIRCLE, [1.0, 0.0], t_end=0.3, **run)
    parts = [part.events]
    for end in (0.6, 3.3, 11.0, 24.9, 40.0):
        part = gi.solve(part, t_end=end, events=events)
        parts.append(part.events)
    for name, known in whole.events.items():
        table = np.concatenate([met[name].table for met in parts])
        np.testing.assert_array_equal(table, known.table)


@gi.event
def quarters(params: Any, t: Any, y: Any, work: Any) -> Any:
    """0 at every quarter of a unit of time."""
    return gi.sin(4.0 * math.pi * t)


@pytest.mark.parametrize("step", [0.25, 0.3, 0.5])
@pytest.mark.parametrize(
    "ends", [[1.5, 1.75], [1.5000000000000002, 3.0], [2.0, 2.1000000000000001, 6.25], [0.75, 2.5]]
)
def test_many_where_runs_meet(step: float, ends: list[float]) -> None:
    """Several in the last step, roots at all steps, ends that are a rounding beyond a step."""
    sol = gi.solve(CIRCLE, [1.0, 0.0], t_end=ends[0], step=step, events=quarters)
    found = [sol.t_events[0]]
    for end in (*ends[1:], 8.1):
        sol = gi.solve(sol, t_end=end, events=quarters)
        found.append(sol.t_events[0])
    known = np.arange(1, 33) * 0.25
    np.testing.assert_allclose(np.concatenate(found), known, rtol=0, atol=1e-13)


def test_an_end_at_the_end() -> None:
    """A loop over all events of a run ends, also if the last one is where the run ends."""
    event = gi.Event(quarters.what, terminal=True)
    for end in np.arange(9.0, 15.0, 0.25):
        sol = gi.solve(LINE, [-0.5], t_end=end, step=0.25, method="rk-4", events=event)
        count = 0
        while sol.message:
            count += 1
            sol = gi.solve(sol, t_end=end, events=event)
        assert count in (4 * end - 1, 4 * end)


def test_what_lies_beyond_the_end() -> None:
    """What cannot be told is no error beyond the event that ends the run, be it in the same step."""

    @gi.observable
    def no_number(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.sqrt(0.3 - y[0]) - 0.12

    @gi.observable
    def jump(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.select(y[0] > 0.26, 1.0, -1.0)

    for start in (-0.5, -4.5):  # along the orbit; along the interpolant
        run = {"t_end": 7.0, "step": 0.125, "method": "rk-4"}
        guard = {"guard": gi.Event("x", level=0.29, terminal=True)}
        for events in ({"no": no_number, **guard}, {**guard, "no": no_number}):
            sol = gi.solve(LINE, [start], **run, events=events)
            assert sol.message == "ended by the event 'guard'"
            assert sol.t[-1] + start == pytest.approx(0.29, abs=1e-12)
            assert sol.events["no"].tau + start == pytest.approx([0.2856], abs=1e-12)
        with pytest.raises(gi.EventError, match="jump"):
            gi.solve(LINE, [start], **run, events={"jump": jump, **guard})


def test_an_end_at_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where an end is at a step, that is the last whole one, however the run is cut into chunks."""
    found = []
    for first in (64, 1, 2, 3, 4, 5):
        monkeypatch.setattr(driver, "FIRST_CHUNK", first)
        monkeypatch.setattr(driver, "CHUNK_SECONDS", 0.0)
        end = gi.Event("x", terminal=True)
        found.append(
            gi.solve(
                LINE, [-0.5], t_end=2.0, step=0.125, method="rk-4", events=end, dense=True,
                save_every=1, observe={"x": lambda params, t, y, work: y[0]},
            )
        )  # fmt: skip
        assert found[-1] == found[0]
        np.testing.assert_array_equal(found[-1].t, [0.0, 0.125, 0.25, 0.375, 0.5])
        np.testing.assert_array_equal(found[-1].sol(found[-1].t), found[-1].y)


def test_the_first_end_counts() -> None:
    """Of several events that end a run the first does; of one of them its third; none is later."""
    events = {
        "x": gi.Event("x", terminal=3),
        "y": gi.Event("y", terminal=5),
        "half": gi.Event("x", level=0.5),
    }
    sol = gi.solve(CIRCLE, [1.0, 0.0], t_end=100.0, step=0.3, events=events)
    assert sol.message == "ended by the event 'x'"
    assert [len(t) for t in sol.t_events] == [3, 2, 3]
    assert sol.t[-1] == sol.t_events[0][-1] == pytest.approx(2.5 * math.pi, abs=1e-12)
    asked = gi.solve(
        CIRCLE, [1.0, 0.0], t_end=100.0, step=0.3, events=events, t_eval=[1.0, 7.0, 8.0]
    )
    np.testing.assert_array_equal(asked.t, [1.0, 7.0])


def test_chunks_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    """However a run is cut into chunks: the same events to the bit; ends and all."""
    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).hamiltonized()
    y0 = problem.random_state(5)
    events = {"a": "gamma[2]", "b": gi.Event("gamma[0]", terminal=9)}
    found = []
    for first, seconds in ((64, 0.03), (1, 0.0), (3, 0.0), (10_000, 1.0)):
        monkeypatch.setattr(driver, "FIRST_CHUNK", first)
        monkeypatch.setattr(driver, "CHUNK_SECONDS", seconds)
        found.append(gi.solve(problem, y0, t_end=60.0, step=0.4, events=events))
    for sol in found[1:]:
        assert sol.events == found[0].events
        np.testing.assert_array_equal(sol.y, found[0].y)
        assert sol.restart == found[0].restart


def test_chunks_do_not_matter_late(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor where times are so late that the last bits of their differences vary."""
    found = []
    for first, seconds in ((64, 0.03), (5, 0.0), (10**6, 1.0)):
        monkeypatch.setattr(driver, "FIRST_CHUNK", first)
        monkeypatch.setattr(driver, "CHUNK_SECONDS", seconds)
        found.append(gi.solve(CIRCLE, [1.0, 0.0], t_end=3000.0, step=0.2, events=["x", "y"]).events)
    assert found[1] == found[0]
    assert found[2] == found[0]


def test_two_times() -> None:
    """In τ the times are physical, and τ is there too; with an end in τ and no clock τ alone."""
    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).hamiltonized()
    y0 = problem.random_state(2)
    sol = gi.solve(problem, y0, t_end=20.0, step=0.4, events="gamma[1]", dense=True)
    met = sol.events["gamma[1]"]
    np.testing.assert_allclose(sol.sol(met.t), met.y, rtol=0, atol=1e-13)
    np.testing.assert_allclose(sol.sol(tau=met.tau), met.y, rtol=0, atol=1e-13)
    bare = gi.solve(
        problem, y0, tau_end=float(sol.tau[-1]), clock=False, step=0.4, events="gamma[1]"
    )
    assert bare.events["gamma[1]"].t is None
    np.testing.assert_allclose(bare.t_events[0], met.tau, rtol=0, atol=1e-12)


# --- what they are --------------------------------------------------------------------------------


def test_plain_python_agrees() -> None:
    """The same bits without compiled code."""
    run = {"t_end": 8.0, "step": 0.3, "events": ["u", gi.Event("v", level=1.0, terminal=3)]}
    problem = lotka_volterra.problem()
    run["events"] = [f"{name}[0]" for name in problem.slices]
    run["events"] = [gi.Event(name, level=1.0) for name in run["events"]]
    fast, slow = (
        gi.solve(problem, lotka_volterra.INITIAL, **run, compiled=c) for c in (True, False)
    )
    assert fast.events == slow.events
    assert sum(map(len, fast.t_events)) > 2


def test_values() -> None:
    """Events compare, copy, pickle, print; names and functions mean the same."""
    one = gi.Event("gamma[2]", direction=1, terminal=2, level=0.25)
    assert one == gi.Event("gamma[2]", "up", 2, 0.25) != gi.Event("gamma[2]")
    for other in (copy.copy(one), copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        assert other == one
    assert one.name == "gamma[2] = 0.25"

    @gi.event(direction="down")
    def mine(params: Any, t: Any, y: Any, work: Any) -> Any:
        return y[0]

    named = gi.solve(CIRCLE, [1.0, 0.0], t_end=9.0, events={"x": gi.Event("x[0]", "down")})
    made = gi.solve(CIRCLE, [1.0, 0.0], t_end=9.0, events=mine)
    np.testing.assert_array_equal(named.t_events[0], made.t_events[0])
    assert list(made.events) == ["mine"]
    energy = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).reduced()
    gi.solve(energy, energy.random_state(1), t_end=1.0, events="energy")


@pytest.mark.parametrize(
    ("events", "said"),
    [
        (lambda t, y: y[0], "decorate it with @geomint.event"),
        ("x[1]", r"x\[0\] to x\[0\]"),
        ("radius", "a component or a quantity"),
        (7, "names of components"),
        ([3.0], "names of components"),
        (["x", "x"], "unlike each other"),
        ({"": "x"}, "a name of 1 to"),
        ({3: "x"}, "a name of 1 to"),
    ],
)
def test_wrong_events(events: Any, said: str) -> None:
    """Typed errors that say what is right."""
    with pytest.raises(gi.DomainError, match=said):
        gi.solve(CIRCLE, [1.0, 0.0], t_end=1.0, events=events)


@pytest.mark.parametrize(
    "options",
    [
        {"direction": "left"},
        {"direction": 2},
        {"direction": None},
        {"direction": []},
        {"terminal": 0},
        {"terminal": -1},
        {"terminal": "yes"},
        {"level": math.nan},
        {"level": "x"},
        {"what": 3},
    ],
)
def test_wrong_options(options: dict[str, Any]) -> None:
    """Of an event, when it is made."""
    with pytest.raises(gi.DomainError, match=next(iter(options))):
        gi.Event(**{"what": "x", **options})


@kinds
def test_files(name: str, problem: str, tmp_path: Path) -> None:
    """What a run keeps and what it has met is in its file, and goes on from there."""
    p, y0 = PROBLEMS[problem]
    run = {"method": name, "step": 0.17, "t_end": 1.3}
    events = {"first": component(p, 0), "never": gi.Event(component(p, 0), level=1e6)}
    sol = gi.solve(p, y0, **run, events=events, dense=True)
    sol.save(tmp_path / "run.nc")
    loaded = gi.load(tmp_path / "run.nc", p)
    assert loaded == sol
    assert loaded.events == sol.events
    times = np.linspace(0.0, 1.3, 9)
    np.testing.assert_array_equal(loaded.sol(times), sol.sol(times))
    more, again = (gi.solve(s, t_end=2.0, events=events) for s in (sol, loaded))
    assert more.events == again.events
