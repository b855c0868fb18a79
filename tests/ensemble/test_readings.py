"""What is read off members: as of the states of single runs, without keeping states."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run.ensemble import spread


@gi.observable
def product(params: Any, t: Any, y: Any, work: Any) -> Any:
    return y[0] * y[4]


PROBLEM = replace(gi.load_scene("hamiltonized-n3").problem, observables={"product": product})
STATES = np.array([PROBLEM.random_state(seed) for seed in range(9)])
HENON = henon_heiles.problem()
RUN: dict[str, Any] = {"tau_end": 12.0, "method": "rk-4", "step": 0.05}
BURST: dict[str, Any] = {"t_end": 2.0, "method": "rk-4", "step": 0.05}


def series(run: gi.Solution, name: str) -> np.ndarray:
    """Return a component, or a quantity, of a run at its saved states."""
    if name in PROBLEM.diagnostics:
        return np.array([gi.value(PROBLEM, name, y) for y in run.y])
    return run.y[:, int(name[-2])]


def rms(x: np.ndarray) -> list[float]:
    parts = np.array_split(x[1:] - x[0], 32)
    return [float(np.sqrt(np.mean(p * p))) for p in parts]


BY_HAND = {
    "final": lambda x: x[-1],
    "drift": lambda x: np.abs(x - x[0]).max(),
    "lowest": np.min,
    "highest": np.max,
    "mean": lambda x: gi.birkhoff_average(x).value,
    "digits": lambda x: gi.birkhoff_average(x).digits,
    "frequency": lambda x: abs(
        gi.frequencies(x - gi.birkhoff_average(x).value, RUN["step"])[0].frequency
    ),
    "windows": rms,
}


@pytest.mark.parametrize("kind", BY_HAND)
@pytest.mark.parametrize("of", ["gamma[2]", "product"])
def test_as_by_hand_from_the_states(kind: str, of: str) -> None:
    name = f"{kind}:{of}"
    many = gi.solve_ensemble(PROBLEM, STATES, **RUN, readings=name)
    assert many.y.shape[1] == 1
    assert np.array_equal(many.counts, np.ones(9))
    for k, state in enumerate(STATES):
        run = gi.solve(PROBLEM, state, **RUN, save_every=1)
        by_hand = BY_HAND[kind](series(run, of))
        assert np.allclose(many.readings[name][k], by_hand, rtol=1e-9, atol=0, equal_nan=True)
        assert np.array_equal(many.final[k], run.y[-1])


def test_exponents_are_those_of_single_runs() -> None:
    """With their errors, and the verdict whether they are above 0."""
    words = ["exponent", "exponent-error", "chaotic"]
    given: dict[str, Any] = {"t_end": 2000.0, "step": 0.1, "method": "rk-4"}
    states = [[0.0, 0.1, 0.3, 0.0], [0.0, -0.25, 0.42081, 0.0]]
    asked = [*words, gi.Exponents(2)]
    many = gi.solve_ensemble(HENON, states, **given, readings=asked)
    for k, verdict in enumerate(("regular", "chaotic")):
        alone = gi.lyapunov(HENON, states[k], count=1, progress=False, **given)
        assert alone.verdict == verdict
        found = [alone.exponents[0], alone.errors[0], float(verdict == "chaotic")]
        assert [many.readings[word][k] for word in words] == found
        both = gi.lyapunov(HENON, states[k], count=2, progress=False, **given)
        assert np.array_equal(many.readings["exponents"][k], both.exponents)


def test_points_of_sections_are_those_of_single_motions() -> None:
    many = gi.solve_ensemble(PROBLEM, STATES, **RUN, readings=gi.SectionPoints("gamma[2]", 7))
    found = many.readings["section:gamma[2]"]
    assert found.shape == (9, 7, 7)
    alone = gi.poincare_section(PROBLEM, STATES[4], "gamma[2]", 7, method="rk-4", step=0.05)
    assert np.array_equal(found[4, :, 0], alone.tau)
    assert np.array_equal(found[4, :, 1:], alone.y)


def test_a_histogram_counts_all_states_of_all_members_once() -> None:
    edges = np.linspace(-1.0, 1.0, 9)
    asked = {"h": gi.Histogram("gamma[0]", edges)}
    many = gi.solve_ensemble(PROBLEM, STATES, **RUN, readings=asked, keep_states=True)
    assert many.y.shape[1] == 241
    inside = many.y[:, :, 0]
    assert np.array_equal(many.readings["h"], np.histogram(inside, edges)[0])
    spread = gi.solve_ensemble(PROBLEM, np.tile(STATES, (30, 1)), **RUN, readings=asked, workers=2)
    assert np.array_equal(spread.readings["h"], 30 * many.readings["h"])


def test_the_same_by_other_ways() -> None:
    """Blocks of an executor, members one by one: to the same bits."""
    names = ["drift:K", "frequency:gamma[1]", "windows:energy"]
    one = gi.solve_ensemble(PROBLEM, STATES, **RUN, readings=names, workers=1)
    with ThreadPoolExecutor(2) as pool:
        other = gi.solve_ensemble(PROBLEM, STATES, **RUN, readings=names, executor=pool)
    by_one = gi.solve_ensemble(PROBLEM, STATES, **RUN, readings=names, observe=["energy"])
    for name in names:
        assert np.array_equal(one.readings[name], other.readings[name])
        assert np.array_equal(one.readings[name], by_one.readings[name])


def test_several_problems_read_their_own_quantities() -> None:
    spheres = [ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=d).hamiltonized() for d in (2.0, 4.0)]
    many = gi.solve_ensemble(spheres, STATES[0], **RUN, readings="final:energy")
    for k, sphere in enumerate(spheres):
        assert many.readings["final:energy"][k] == gi.value(sphere, "energy", many.final[k])
    assert many.readings["final:energy"][0] != many.readings["final:energy"][1]


class Own(gi.Reading):
    """A reading of one's own that is what a function says."""

    along, name = True, "own"

    def __init__(self, of: Any, merges: bool = False) -> None:
        self._of, self.merges = of, merges  # type: ignore[misc]

    def read(self, ran: Any) -> Any:
        return self._of(ran)


def failing(ran: Any) -> Any:
    """Fail of the members that begin beyond 1."""
    if (ran.given.states > 1.0).any():
        raise KeyError("no")
    return np.ones(len(ran))


@gi.field
def bursting(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[0] * y[0]


far = gi.observable(lambda params, t, y, work: 1.0 / y[0])
left = gi.observable(lambda params, t, y, work: (0.3 - y[0]) ** 0.5)
BURSTING = gi.Problem(
    "bursting", pieces=(("x", 1),), field=bursting, observables={"left": left, "far": far}
)


def test_of_a_member_that_fails_nothing_is_read() -> None:
    """Nor is what one's own says of it looked at."""
    said = np.ones(3)
    asked = ["final:x", "drift:x", Own(lambda ran: said[: len(ran)])]
    many = gi.solve_ensemble(BURSTING, [[0.1], [3.0], [0.2]], **BURST, readings=asked)
    assert list(many.status) == ["success", "failed", "success"]
    for values in many.readings.values():
        assert list(np.isnan(values)) == [False, True, False]
    assert said[1] == 1.0


@pytest.mark.parametrize("kind", ["drift", "lowest", "highest", "mean", "windows"])
def test_what_is_no_number_at_a_state_has_no_extremes(kind: str) -> None:
    """Of the root of what becomes negative: neither its largest value until then, nor any other."""
    states = [[0.1], [0.25], [0.35]]  # never; on the way; from the first state on
    found = gi.solve_ensemble(BURSTING, states, **BURST, readings=f"{kind}:left").readings
    finite = np.isfinite(found[f"{kind}:left"].reshape(3, -1)).all(axis=1)
    assert finite.tolist() == [True, False, False]


def test_infinite_values_are_no_warning_of_their_own() -> None:
    asked = ["drift:far", "highest:far", "windows:far"]
    found = gi.solve_ensemble(BURSTING, [[0.0], [0.1]], **BURST, readings=asked).readings
    assert np.isnan(found["drift:far"][0])
    assert found["highest:far"][0] == np.inf
    assert np.isfinite(found["drift:far"][1])


@pytest.mark.parametrize("begin", [1e9, -1e10])
def test_late_times_are_even_as_early_ones_are(begin: float) -> None:
    """Ten digits before the point leave few behind it for a step."""
    name = "frequency:q[0]"
    run: dict[str, Any] = {"method": "rk-4", "step": 0.05, "readings": name}
    states = 0.2 * np.eye(4)[[0, 2]]
    early = gi.solve_ensemble(HENON, states, **run, t_end=50.0)
    late = gi.solve_ensemble(HENON, states, **run, t0=begin, t_end=begin + 50.0)
    assert np.isfinite(early.readings[name]).all()
    assert np.allclose(late.readings[name], early.readings[name], rtol=1e-5)


@pytest.mark.parametrize("more", [{"save_every": 3}, {"t_eval": [0.5, 1.0]}, {"out": "a.zarr"}])
def test_too_few_states_for_an_average_are_told(more: dict[str, Any], tmp_path: Path) -> None:
    run = BURST | more
    if "out" in more:
        run |= {"step": 0.25, "out": tmp_path / "a.zarr"}
    asked = ["mean:x", "final:x", "digits:x"]
    with pytest.warns(gi.GeomintWarning, match="2 of 2 .* fewer than 16 states.* mean:x, digits:x"):
        many = gi.solve_ensemble(BURSTING, [[0.1], [0.2]], **run, readings=asked)
    assert np.isnan(many.readings["mean:x"]).all()
    assert np.isfinite(many.readings["final:x"]).all()


def test_a_quantity_that_some_problems_lack_is_told_before() -> None:
    problems = [BURSTING, replace(BURSTING, observables={"far": far})]
    with pytest.raises(gi.DomainError, match="readings = 'left'"):
        gi.solve_ensemble(problems, [0.1], **BURST, readings="final:left")


@pytest.mark.parametrize(
    "asked",
    [
        Own(lambda ran: np.ones(len(ran)), merges=True),
        Own(lambda ran: np.ones((len(ran),) + (1,) * (len(ran) >= 64))),
    ],
)
@pytest.mark.parametrize("out", [None, "a.zarr"])
def test_blocks_that_do_not_fit_together(asked: Any, out: Any, tmp_path: Path) -> None:
    run = BURST | {"workers": 1, "out": None if out is None else tmp_path / out}
    with pytest.raises(gi.DomainError, match=r"'own'.*as of other members"):
        gi.solve_ensemble(BURSTING, np.full((70, 1), 0.1), **run, readings=asked)


@pytest.mark.parametrize("wanted", [{}, {"events": "x"}])
def test_states_that_are_not_to_be_kept_are_not(wanted: Any) -> None:
    run = BURST | {"save_every": 1, "keep_states": False, **wanted}
    many = gi.solve_ensemble(BURSTING, [[0.1]], **run)
    assert many.y.shape == (1, 1, 1)
    assert many.tau[0, 0] == 2.0


@pytest.mark.parametrize("workers", [1, 2])
def test_a_reading_that_fails_late_loses_nothing_that_is_done(workers: int) -> None:
    states = np.linspace(0.1, 0.2, 640)[:, None].copy()
    states[300] = 1.5
    run = BURST | {"workers": workers}
    with pytest.raises(gi.DomainError, match="KeyError") as caught:
        gi.solve_ensemble(BURSTING, states, **run, readings=Own(failing))
    many = caught.value.partial
    done = many.status == "success"
    assert done[:64].all()
    assert not done[300]
    assert np.isfinite(many.readings["own"][done]).all()
    whole = gi.solve_ensemble(BURSTING, states, **run)
    np.testing.assert_array_equal(many.final[done], whole.final[done])


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("drift:enrgy", "energy"),
        ("drfit:energy", "drift"),
        ("drift", "NAME"),
        ("final:gamma[3]", r"gamma\[0\]"),
        (["final:K", "final:K"], "unlike"),
        (7, "readings"),
        ([7], "readings"),
        (Own(lambda ran: [1.0] * (len(ran) + 1)), "a row for each"),
        (Own(lambda ran: {}["no"]), "KeyError"),
        (gi.Histogram("energy", [1.0, 1.0]), "rising"),
        (gi.Histogram("energy", "ab"), "edges"),
        (gi.Windows("energy", 0), "count"),
        (gi.Exponents(0), "count"),
        (gi.SectionPoints(["gamma[0]", "gamma[1]"]), "one event"),
        (("mean:K", {"method": "dop853-adaptive"}), "equal steps"),
        (("mean:K", {"tau_eval": np.geomspace(0.1, 4.0, 40)}), "equal steps"),
        (("exponent", {"tau_end": None, "t_end": 4.0}), "tau_end"),
        ((gi.SectionPoints("gamma[2]", 3), {"tau_end": -5.0}), "tau_end = "),
        ((gi.SectionPoints("gamma[2]", 3), {"t0": 3.0}), "t0 = "),
    ],
)
def test_what_cannot_be_read(asked: Any, said: str) -> None:
    """Averages and frequencies are of equal steps; sections begin at time 0 and go forward."""
    asked, run = asked if isinstance(asked, tuple) else (asked, {})
    with pytest.raises(gi.DomainError, match=said):
        gi.solve_ensemble(PROBLEM, STATES, **{"tau_end": 4.0, **run}, readings=asked)


def test_adaptive_members_at_even_times() -> None:
    name, times = "frequency:q[0]", np.linspace(0.0, 20.0, 201)
    states = 0.2 * np.eye(4)[[0, 2]]
    run: dict[str, Any] = {"t_end": 20.0, "t_eval": times, "readings": name}
    fine = gi.solve_ensemble(HENON, states, **run, step=0.01, method="rk-4")
    other = gi.solve_ensemble(HENON, states, **run, method="dop853-adaptive")
    assert np.allclose(fine.readings[name], other.readings[name], rtol=1e-5)


def test_the_exact_flow_needs_times_to_read_at() -> None:
    """It takes no steps: without times there is only the last state, and every drift would be 0."""
    sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    run: dict[str, Any] = {"tau_end": 4.0, "method": "exact"}
    with pytest.raises(gi.DomainError, match=r"drift:gamma\[0\].*tau_eval"):
        gi.solve_ensemble(sphere, STATES[:2], **run, readings=["final:K", "drift:gamma[0]"])
    times = np.linspace(0.0, 4.0, 41)
    many = gi.solve_ensemble(sphere, STATES[:2], **run, tau_eval=times, readings="drift:gamma[0]")
    assert (many.readings["drift:gamma[0]"] > 0.1).all()


def test_in_a_dataset() -> None:
    """With a reading of one's own: how often a component changes its sign."""
    turns = Own(lambda ran: np.count_nonzero(np.diff(np.sign(ran.series("gamma[0]"))), axis=1))
    asked = {"h": gi.Histogram("gamma[0]", [-1, 0, 1]), "w": gi.Windows("K", 4), "f": "final:K"}
    many = gi.solve_ensemble(PROBLEM, STATES, **RUN, readings={**asked, "turns": turns})
    data = many.to_xarray()
    assert data["f"].dims == data["turns"].dims == ("member",)
    assert data["w"].dims[0] == "member"
    assert "member" not in data["h"].dims
    assert many.readings["turns"].max() > 1


def test_many_members_in_little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """States of a block are all that is held at a time, and blocks are small enough."""
    sizes: list[int] = []
    run_block = spread.run_block
    monkeypatch.setattr(
        spread, "run_block", lambda *given: sizes.append(len(given[1])) or run_block(*given)
    )
    monkeypatch.setattr(spread, "NUMBERS", 1 << 14)
    many = gi.solve_ensemble(PROBLEM, np.tile(STATES, (20, 1)), **RUN, readings="drift:energy")
    assert max(sizes) * 242 * 6 <= 1 << 14
    assert sum(sizes) == 180
    assert np.isfinite(many.readings["drift:energy"]).all()
