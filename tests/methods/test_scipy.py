"""Methods of geomint in SciPy's `solve_ivp`, against SciPy's own and against `geomint.solve`."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi

METHODS = {name: getattr(gi.scipy, name) for name in gi.scipy.__all__ if name != "FixedStep"}
NAMES = {"RK4": "rk-4", "DOP853": "dop853"} | {f"GAUSS{s}": f"gauss-{s}" for s in (1, 2, 4, 6, 8)}
START, END = [2.0, 0.0], 20.0
each = pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.nightly] * (n not in ("RK4", "GAUSS4"))) for n in METHODS],
)


def swing(t, y):
    return np.array([y[1], -np.sin(y[0])])


def energy(y):
    return y[1] ** 2 / 2 - np.cos(y[0])


def kepler(t, y):
    return np.append(y[2:], -y[:2] / np.hypot(*y[:2]) ** 3)


@pytest.fixture(scope="module")
def truth():
    return solve_ivp(
        swing, (0, END), START, "DOP853", rtol=1e-13, atol=1e-13, dense_output=True
    ).sol


@gi.field
def field(params, t, y, out, work):
    out[0], out[1] = y[1], -gi.sin(y[0])


PENDULUM = gi.Problem("pendulum", (("y", 2),), field=field)


def test_every_method_is_named_after_one_of_geomint() -> None:
    assert set(NAMES) == set(METHODS)
    for name, method in METHODS.items():
        assert gi.find_method(NAMES[name]).order == method.order


@each
def test_steps_are_those_of_geomint(name: str) -> None:
    """Within a rounding a step: the last one is partial."""
    step = 0.3
    ours = solve_ivp(swing, (0, END), START, method=METHODS[name], step=step)
    same = gi.solve(PENDULUM, START, t_end=END, method=NAMES[name], step=step, save_every=1)
    assert ours.success
    np.testing.assert_allclose(ours.t, same.t, rtol=1e-15)
    np.testing.assert_allclose(ours.y.T, same.y, atol=3e-14)


@each
def test_states_at_any_time(name: str, truth) -> None:
    """t_eval, dense output and events are as accurate as steps, forwards and backwards."""
    method, step = METHODS[name], 0.02 if METHODS[name].order < 8 else 0.2
    times = np.linspace(0.0, END, 37)
    asked = {"method": method, "step": step, "events": lambda t, y: y[0], "dense_output": True}
    sol = solve_ivp(swing, (0, END), START, t_eval=times, **asked)
    atol = {2: 3e-3, 4: 3e-6}.get(method.order, 1e-7)
    np.testing.assert_allclose(sol.y, truth(times), atol=atol)
    np.testing.assert_array_equal(sol.sol(times), sol.y)
    assert len(sol.t_events[0]) == 5
    assert abs(truth(sol.t_events[0])[0]).max() < atol
    assert abs(sol.y_events[0][:, 0]).max() < 1e-11
    back = solve_ivp(swing, (END, 0), sol.y[:, -1], t_eval=times[::-1], **asked)
    np.testing.assert_allclose(back.y[:, ::-1], sol.y, atol=2 * atol)
    if name.startswith("GAUSS"):  # a symmetric method comes back
        np.testing.assert_allclose(back.y[:, -1], START, atol=1e-12)


@each
@pytest.mark.parametrize("phase", [1, -1], ids=["slow", "fast"])
def test_tolerances_choose_the_step(name: str, phase: int) -> None:
    """An orbit of eccentricity 0.6, from either end: errors of the size that SciPy's methods make."""
    e = 0.6 * phase
    y0 = np.array([1 + e, 0.0, 0.0, np.sqrt((1 - e) / (1 + e))])
    tolerances = [1e-2, 1e-4] if name == "GAUSS1" else [1e-3, 1e-6]
    last = np.inf
    for rtol in tolerances:
        given = {"rtol": rtol, "atol": rtol / 1000}
        sol = solve_ivp(kepler, (0, 6 * np.pi), y0, method=METHODS[name], **given)
        rk = solve_ivp(kepler, (0, 6 * np.pi), y0, method="RK45", **given)
        steps = np.diff(sol.t)
        np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
        error, theirs = (abs(found.y[:, -1] - y0).max() for found in (sol, rk))
        assert error < 3 * theirs + 30 * rtol
        assert error < last / 10
        last = error


def test_the_energy_does_not_drift() -> None:
    """Where SciPy's method at its default tolerance loses a tenth; quadratic ones stay to rounding."""
    sol = solve_ivp(swing, (0, 60), START, method=gi.scipy.GAUSS4, step=0.25)
    lost = abs(energy(sol.y) - energy(sol.y[:, 0]))
    assert lost.max() < 1e-9
    assert lost[len(lost) // 2 :].max() < 1.1 * lost[: len(lost) // 2].max()
    sol = solve_ivp(lambda t, y: 1j * y, (0, 60), [1 + 0j], method=gi.scipy.GAUSS4, step=0.5)
    assert abs(abs(sol.y[0]) - 1).max() < 4e-15


@pytest.mark.nightly
def test_a_compiled_function_gives_the_same() -> None:
    compiled = numba.njit(swing)
    asked = {"method": gi.scipy.GAUSS8, "step": 0.25, "t_eval": [1.0, 19.9]}
    one, two = (solve_ivp(f, (0, END), START, **asked) for f in (swing, compiled))
    np.testing.assert_allclose(one.y, two.y, rtol=1e-13)
    assert one.nfev == two.nfev
    listed = numba.njit(lambda t, y: (y[1], -y[0]))
    with pytest.warns(gi.GeomintWarning, match="not compiled with this function"):
        sol = solve_ivp(listed, (0, np.pi), [1.0, 0.0], method=gi.scipy.RK4, step=0.01)
    np.testing.assert_allclose(sol.y[:, -1], [-1.0, 0.0], atol=1e-9)


@each
def test_special_states(name: str) -> None:
    """What is counted; at rest, of no size, no length, no time; with arguments; far smaller rows."""
    method, calls = METHODS[name], []
    f = lambda t, y: [calls.append(t) or y[1], -y[0]]  # noqa: E731
    sol = solve_ivp(f, (0, 3), START, method=method, rtol=1e-4, t_eval=[0.1, 2.9])
    assert sol.nfev == len(calls)
    rest = solve_ivp(swing, (0, 5), [0.0, 0.0], method=method)
    assert rest.success
    assert not rest.y.any()
    still = solve_ivp(lambda t, y: 0 * y, (0, 1), [3.0], method=method, step=0.3)
    assert (still.y == 3.0).all()
    none = solve_ivp(swing, (1, 1), START, method=method)
    assert none.success
    assert (none.y.T == START).all()
    empty = solve_ivp(lambda t, y: y, (0, 1), [], method=method, step=0.5)
    assert empty.success
    growing = solve_ivp(lambda t, y, a: a * y, (0, 1), [1e-150], method=method, args=(2.0,))
    assert growing.y[0, -1] == pytest.approx(1e-150 * np.exp(2), rel=2e-3)
    by_time = solve_ivp(lambda t, y: [1.0, t], (0, 1), [0.0, 1e-17], method=method, step=0.3)
    np.testing.assert_allclose(by_time.y[:, -1], [1.0, 0.5], rtol=1e-13)


def test_steps_are_as_asked_for() -> None:
    def steps(**given):
        sol = solve_ivp(swing, (0, 1), START, method=gi.scipy.GAUSS2, **given)
        return np.diff(sol.t)

    np.testing.assert_allclose(steps(step=0.3), [0.3, 0.3, 0.3, 0.1])
    np.testing.assert_allclose(steps(first_step=0.1), [0.1] * 10)
    np.testing.assert_allclose(steps(step=0.3, max_step=0.25), [0.25] * 4)
    assert steps(step=7.0) == [1.0]
    assert steps(rtol=1e-1, max_step=0.2).max() < 0.2 + 1e-15
    assert len(steps(rtol=1e-9)) > len(steps())


@pytest.mark.parametrize(
    "given",
    [
        *({"step": 0.0}, {"step": -1.0}, {"first_step": np.nan}, {"step": 0.1, "first_step": 0.1}),
        *(
            {"max_step": 0.0},
            {"rtol": 0.0},
            {"atol": -1.0},
            {"atol": [1e-6] * 3},
            {"atol": "small"},
        ),
    ],
    ids=str,
)
def test_options_that_make_no_sense(given: dict) -> None:
    """Are errors of SciPy's kind."""
    with pytest.raises(ValueError, match=list(given)[-1]):
        solve_ivp(swing, (0, 1), START, method=gi.scipy.GAUSS2, **given)
    with pytest.raises(TypeError, match="jac"):
        solve_ivp(swing, (0, 1), START, method=gi.scipy.GAUSS2, jac=None)


@each
@pytest.mark.filterwarnings("ignore:steps of")  # where it turns
@pytest.mark.parametrize("span", [(0.0, 10.0), (100.0, 200.0), (3.0, 0.1), (-0.1, 1e-3)], ids=str)
def test_the_function_is_asked_within_the_run(name: str, span: tuple[float, float]) -> None:
    """Of a slow motion with long first steps, and one that turns; however steps are given."""
    length = abs(span[1] - span[0])
    ways = ({}, {"max_step": length / 3}, {"step": length / 37}, {"first_step": 0.3 * length})
    for rate, kink in ((1e-3, span[0]), (1 / length, sum(span) / 2)):
        for given in ways:
            asked = []

            def f(t, y, rate=rate, kink=kink, asked=asked):
                asked.append(float(t))
                return rate * (abs(t - kink) - y)

            sol = solve_ivp(f, span, [1.0], METHODS[name], dense_output=True, **given)
            assert sol.success
            assert sol.t[-1] == span[1]
            sol.sol(np.linspace(*span, 11))
            assert min(span) <= min(asked)
            assert max(asked) <= max(span)
    with pytest.raises(gi.DomainError, match="a time within"):
        sol.sol(span[1] + (span[1] - span[0]))


@each
@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value", "ignore:divide")
def test_where_no_step_serves_that_is_told(name: str) -> None:
    """A layer of 1e-38, ends that no steps get to: never another value with success."""
    method = METHODS[name]
    layer = solve_ivp(lambda t, y: 1e50 / y, (1.0, 2.0), [1e6], method=method, rtol=1e-6)
    assert not layer.success
    far = solve_ivp(lambda t, y: -y, (0.0, 1e100), [1.0], method=method)
    assert not far.success
    assert "step" in far.message
    for start in (0.0, 1.0):
        short = solve_ivp(lambda t, y: -y, (start, 2.0), [1.0], method, step=1e-30)
        assert "too short" in short.message
    for end in (np.inf, np.nan):
        with pytest.raises(gi.DomainError, match="span"):
            solve_ivp(lambda t, y: -y, (0.0, end), [1.0], method=method)
    ends = lambda t, y: y[0] - 0.5  # noqa: E731
    ends.terminal = True
    open_end = solve_ivp(lambda t, y: -y, (0, np.inf), [1.0], method, events=ends, step=0.1)
    assert open_end.t[-1] == pytest.approx(np.log(2), rel=1e-3)


@each
@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value", "ignore:divide")
def test_failures_are_told_as_scipy_does(name: str) -> None:
    """Blow-up in finite time, at t = 1; a function that is not finite from some time on."""
    method = METHODS[name]
    sol = solve_ivp(lambda t, y: y * y, (0, 3), [1.0], method=method, step=0.01)
    assert not sol.success
    assert sol.status == -1
    assert 0.5 < sol.t[-1] < 1.5
    assert np.isfinite(sol.y).all()
    assert sol.message.startswith(f"{name} at t = ")
    long = solve_ivp(lambda t, y: -100 * y, (0, 10), [1.0], method=gi.scipy.GAUSS4, step=1.0)
    assert "smaller step=" in long.message
    broken = solve_ivp(lambda t, y: y * (np.nan if t > 0.5 else 1), (0, 1), [1.0], method=method)
    assert not broken.success
    assert "not finite" in broken.message
    assert broken.t[-1] < 0.75
    never = solve_ivp(lambda t, y: np.nan * y, (0, 1), [1.0], method=method)
    assert "not finite" in never.message
    assert len(never.t) == 1
