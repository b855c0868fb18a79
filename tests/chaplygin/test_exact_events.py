"""Events and sections on exact motions: none missed, none invented, on the motion itself."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.exact_systems import ALL, components, each, own_end, span, systems

BALL = ch.ChaplyginSphere([0.8, 1.1, 1.5], 4.0)
SPHERE, REDUCED = BALL.hamiltonized(), BALL.reduced()
Y0 = REDUCED.canonical([0.48, 0.6, 0.64, 3.0, -4.0, 1.5])
SAMPLES = 100  # in a quarter of the shortest period, about


@pytest.mark.nightly
@pytest.mark.parametrize("sign", [1, -1])
@each
def test_against_samples(name: str, sign: int) -> None:
    """Where samples change their sign there is an event, and where they do not none, or two."""
    problem, y0 = ALL[name]
    end = sign * span(problem, y0)
    own = {"clock": False} if problem.time == "tau" else {}
    dense = gi.solve(problem, y0, **own_end(problem, end), **own, method="exact", dense=True)
    times = np.linspace(0.0, end, 20 * SAMPLES + 1)
    states = dense.sol(**{problem.time: times})
    names, looked = components(problem), {}
    rows = [r for r in range(len(names)) if np.ptp(states[:, r]) > 1e-9 * np.abs(states).max()]
    # Every level is a function to compile: each part of the range at one component, by turns.
    parts = (0.13, 0.5, 0.999_99)
    parts = parts[list(ALL).index(name) % 3 :] + parts[: list(ALL).index(name) % 3]
    for r, part in zip((rows[0], rows[len(rows) // 2], rows[-1]), parts, strict=True):
        low, high = states[:, r].min(), states[:, r].max()
        level = float(low + part * (high - low))
        looked[names[r], part] = gi.Event(names[r], level=level), states[:, r] - level
    events = {f"{row} at {part}": event for (row, part), (event, _) in looked.items()}
    sol = gi.solve(problem, y0, **own_end(problem, end), **own, method="exact", events=events)
    assert sum(map(len, sol.events.values())) > 3
    for key, (_, values) in zip(events, looked.values(), strict=True):
        met, size = sol.events[key], np.abs(values).max()
        assert (np.diff(sign * met.tau) > 0.0).all()
        where = np.searchsorted(sign * times, sign * met.tau, side="right") - 1
        counts = np.bincount(where, minlength=len(times))[:-1]
        clear = np.minimum(np.abs(values[1:]), np.abs(values[:-1])) > 1e-11 * size
        changed = values[1:] * values[:-1] < 0.0
        np.testing.assert_array_equal((counts % 2 == 1)[clear], changed[clear])
        assert counts.max() <= 2
        assert (np.diff(met.directions) != 0.0).all()  # of one surface they alternate
        row = names.index(key.split(" at ")[0])
        level = events[key].level
        assert (
            np.abs(met.y[:, row] - level).max(initial=0.0) <= 1e-13 * np.abs(states[:, row]).max()
        )
        np.testing.assert_array_equal(met.y, dense.sol(**{problem.time: met.tau}))


@systems(3)
def test_events_are_those_of_steps(name: str) -> None:
    """As many as along a run of gauss-8, in the same directions, at the same times."""
    problem, y0 = ALL[name]
    end = span(problem, y0)
    first = components(problem)[0]
    run = {**own_end(problem, end), "events": [first, "energy"]}
    exact = gi.solve(problem, y0, **run, method="exact")
    steps = gi.solve(problem, y0, **run, method="gauss-8", step=abs(end) / 200)
    one, other = exact.events[first], steps.events[first]
    assert len(one) == len(other)
    np.testing.assert_array_equal(one.directions, other.directions)
    np.testing.assert_allclose(one.tau, other.tau, rtol=0, atol=1e-9 * end)
    if other.t is not None:
        np.testing.assert_allclose(one.t, other.t, rtol=0, atol=1e-9 * abs(exact.t[-1]))
    assert len(exact.events["energy"]) == 0


@pytest.mark.parametrize("problem", [SPHERE, REDUCED], ids=["in tau", "in t"])
def test_what_ends_a_motion(problem: gi.Problem) -> None:
    """A terminal event, the first or of a number; states and other events up to there; going on."""
    y0 = problem.random_state(1)
    looked = {
        "up": gi.Event("gamma[2]", "up"),
        "any": "gamma[2]",
        "p": f"{problem.pieces[1][0]}[1]",
    }
    whole = gi.solve(problem, y0, t_end=120.0, method="exact", events=looked)
    for number in (1, 3):
        ending = {**looked, "up": gi.Event("gamma[2]", "up", number)}
        times = np.linspace(0.0, 120.0, 25)
        sol = gi.solve(problem, y0, t_end=120.0, method="exact", events=ending, t_eval=times)
        end = float(whole.events["up"].t[number - 1])
        assert sol.message == "ended by the event 'up'"
        assert len(sol.events["up"]) == number
        np.testing.assert_array_equal(sol.t, times[times <= end])
        for name, met in sol.events.items():
            known = whole.events[name].t[whole.events[name].t <= end]
            np.testing.assert_array_equal(met.t, known)
        last = gi.solve(problem, y0, t_end=120.0, method="exact", events=ending)
        np.testing.assert_array_equal(last.y, whole.events["up"].y[number - 1 : number])
        on = gi.solve(sol, t_end=120.0, events=looked)
        for name, met in on.events.items():
            both = np.concatenate([sol.events[name].t, met.t])
            np.testing.assert_allclose(both, whole.events[name].t, rtol=0, atol=1e-11)


def test_roots_where_two_pieces_of_the_search_meet() -> None:
    """Pieces are quarters of the shortest period, where functions of a symmetric motion have roots."""
    y0 = SPHERE.random_state(1)
    quarter = 0.5 * math.pi / float(np.abs(SPHERE.exact(y0).frequencies).max())
    turns = {"it": gi.event(lambda params, t, y, work: gi.sin(math.pi / quarter * t))}
    for end in (99.5 * quarter, -99.5 * quarter):
        met = gi.solve(SPHERE, y0, tau_end=end, method="exact", events=turns).events["it"]
        np.testing.assert_allclose(abs(met.tau), quarter * np.arange(1, 100), rtol=1e-14)
        np.testing.assert_array_equal(np.sign(end) * met.directions, (-1.0) ** np.arange(1, 100))


def test_what_cannot_be_told() -> None:
    """A typed error with the time, and the solution up to the piece before."""

    @gi.event
    def jump(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.select(t > 5.3, 1.0, -1.0)

    @gi.event
    def lost(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.sqrt(5.3 - t)

    @gi.event
    def fast(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.sin(gi.select(t > 5.3, 1e5, 0.5) * t + 0.1)

    for bad, said in ((jump, "may jump"), (lost, "not a finite"), (fast, "more than 64 times")):
        with pytest.raises(gi.EventError, match=said) as caught:
            gi.solve(SPHERE, SPHERE.random_state(1), tau_end=30.0, method="exact",
                     events=[bad, "gamma[2]"], dense=True)  # fmt: skip
        error, partial = caught.value, caught.value.partial
        assert (error.name, error.step) == (bad.name, 0)
        assert "step" not in str(error)
        assert partial.status == "failed"
        assert 4.5 < partial.tau[-1] <= error.t <= 5.31 + 0.3
        assert (partial.events["gamma[2]"].tau <= partial.tau[-1]).all()
        assert len(partial.events["gamma[2]"]) > 0
        partial.sol(tau=partial.tau[-1])
        ended = gi.solve(SPHERE, SPHERE.random_state(1), tau_end=30.0, method="exact",
                         events=[bad, gi.Event("gamma[2]", terminal=True)])  # fmt: skip
        assert "gamma[2]" in ended.message  # which was before


def test_what_is_no_event() -> None:
    """0 for ever, an integral, a surface that is not met, one that is met where the motion begins."""

    @gi.event
    def nothing(params: Any, t: Any, y: Any, work: Any) -> Any:
        return 0.0 * y[0]

    energy = gi.value(REDUCED, "energy", Y0)
    begun = gi.Event("gamma[0]", level=float(Y0[0]))
    looked = {"0": nothing, "E": gi.Event("energy", level=1.01 * energy), "begun": begun}
    sol = gi.solve(REDUCED, Y0, t_end=30.0, method="exact", events=looked)
    assert [len(met) for met in sol.events.values()][:2] == [0, 0]
    assert len(sol.events["begun"]) > 0
    assert sol.events["begun"].t[0] > 0.1


@pytest.mark.parametrize("late", [1e9, 1e12])
def test_late_events(late: float) -> None:
    """Nearer to each other than times are spaced there nothing can be told; else as everywhere."""
    far = gi.solve(REDUCED, Y0, t_end=late, method="exact")
    on = gi.solve(far, t_end=late + 100.0, events=["gamma[2]", "p[0]"], dense=True)
    times = late + np.linspace(0.0, 100.0, 8001)
    states = on.sol(times)
    for row, met in zip((2, 3), on.events.values(), strict=True):
        changes = np.flatnonzero(states[1:, row] * states[:-1, row] < 0.0)
        assert len(met) == len(changes) > 5
        np.testing.assert_allclose(met.t, times[changes], rtol=0, atol=0.0126 + 64 * math.ulp(late))
        assert np.abs(met.y[:, row]).max() <= 1e-13 + 64.0 * math.ulp(late)


def test_what_ended_a_run_is_not_told_again() -> None:
    """Not late, where times are coarse; not where the event itself is known to some digits only."""

    @gi.event(terminal=True)
    def coarse(params: Any, t: Any, y: Any, work: Any) -> Any:
        return (1e6 + y[2]) * 1.1 - 1.1e6

    for late in (0.0, 1e9):
        begun = {"t_end": late, "method": "exact"}
        run = gi.solve(REDUCED, Y0, **begun) if late else None
        for event in (gi.Event("gamma[2]", terminal=True), coarse):
            given = {"t_end": late + 100.0, "events": event}
            sol = gi.solve(run, **given) if run else gi.solve(REDUCED, Y0, **given, method="exact")
            times = [sol.t[-1]]
            for _ in range(4):
                sol = gi.solve(sol, **given)
                times.append(sol.t[-1])
                assert [len(t) for t in sol.t_events] == [1]
            assert (np.diff(times) > 0.5).all()


# --- sections -------------------------------------------------------------------------------------


def test_sections_are_those_of_steps() -> None:
    """As many points as are asked for, of several motions, in both times."""
    for problem in (SPHERE, REDUCED):
        states = [problem.random_state(seed) for seed in range(2)]
        asked = {"event": gi.Event("gamma[2]", "up"), "points": 10}
        clock = {"clock": True} if problem.time == "tau" else {}
        exact = gi.poincare_section(problem, states, **asked, **clock, method="exact")
        steps = gi.poincare_section(problem, states, **asked, **clock, step=0.1)
        assert exact.complete
        assert "by exact" in repr(exact)
        np.testing.assert_array_equal(exact.motions, steps.motions)
        for name in ("tau", "t", "y", "directions"):
            one, other = getattr(exact, name), getattr(steps, name)
            np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-10)
        whole = gi.solve(
            problem, states[1], **own_end(problem, 1e3), method="exact", events=asked["event"]
        )
        np.testing.assert_array_equal(exact.y[10:], whole.y_events[0][:10])


def test_sections_that_end() -> None:
    """At an end, backwards, where nothing is met, with a typed error."""
    surface = gi.Event("gamma[2]", "up")
    ended = gi.poincare_section(REDUCED, Y0, surface, 40, method="exact", end=20.0)
    assert not ended.complete
    assert 0 < len(ended) < 40
    assert ended.tau[-1] <= 20.0
    back = gi.poincare_section(REDUCED, Y0, surface, 5, method="exact", end=-math.inf)
    assert back.complete
    assert (np.diff(back.tau) < 0.0).all()
    never = gi.Event("gamma[2]", level=2.0)
    assert len(gi.poincare_section(REDUCED, Y0, never, 5, method="exact", end=100.0)) == 0
    with pytest.raises(gi.DomainError, match="takes no steps"):
        gi.poincare_section(REDUCED, Y0, surface, 5, method="exact", step=0.1)
    with pytest.raises(gi.DomainError, match="at rest"):
        gi.poincare_section(REDUCED, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], surface, 5, method="exact")

    @gi.event
    def jump(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.select(y[0] > 0.3, 1.0, -1.0)

    with pytest.raises(gi.EventError, match="may jump"):
        gi.poincare_section(REDUCED, Y0, jump, 5, method="exact")
