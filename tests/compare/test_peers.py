"""Integrators of other packages on geomint's problems: the same motion, or a reason."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.compare import peer_runs
from geomint.compare.peers import PEERS, heyoka_peer
from geomint.compare.peers.peer import End, Motion, Peer, PeerError, Ready
from geomint.compare.peers.scipy_peer import compiled_field
from geomint.compare.runs import compare
from geomint.kernels.numbers.traced import Algebra
from geomint.problems.formulas import traced_field
from geomint.problems.testproblems import henon_heiles
from geomint.report.compare_page import write_compare_report
from tests.problems import examples, spherical_pendulum

EXAMPLES = {problem.name: (problem, y0) for problem, y0 in examples()}
SCIPY = ["scipy-dop853", "scipy-lsoda"]
PENDULUM = spherical_pendulum.problem(), spherical_pendulum.INITIAL
NUMPY = Algebra(np, np.less, np.less_equal, np.where)


def model_of(problem: gi.Problem, y0: np.ndarray) -> gi.Model:
    return gi.Model({problem.name: problem}, {problem.name: y0})


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_traced_field_is_the_field(name: str) -> None:
    """Every test problem is a formula: on plain floats it has the bits of the field, but for 0 ± 0."""
    problem, y0 = EXAMPLES[name]
    for t in (0.0, 0.7):
        traced = traced_field(problem, NUMPY, t, [float(x) for x in y0])
        right = gi.derivative(problem, y0, t)
        np.testing.assert_allclose(
            np.array(traced, dtype=float), right, rtol=0, atol=1e-14 * np.abs(right).max()
        )


def test_a_field_that_decides_is_no_formula() -> None:
    @gi.field
    def deciding(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = y[0] if y[0] > 0.0 else -y[0]

    @gi.field
    def choosing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = gi.select(y[0] > 0.0, abs(y[0]), -(y[0] * y[0]) / 2.0) + gi.sqrt(abs(t))

    def greater(x: Any, y: Any) -> Any:  # as a tracer has no truth
        return SimpleNamespace(holds=x < y, __bool__=None)

    algebra = Algebra(np, greater, greater, lambda c, x, y: x if c.holds else y)
    symbolic = Algebra(np, lambda x, y: _Condition(), lambda x, y: _Condition(), np.where)
    with pytest.raises(gi.FormError, match="no formula: TypeError: undecided"):
        traced_field(gi.Problem("d", (("y", 1),), field=deciding), symbolic, 0.0, [1.0])
    problem = gi.Problem("c", (("y", 1),), field=choosing)
    assert traced_field(problem, algebra, 4.0, [2.0]) == [4.0]
    assert traced_field(problem, algebra, 4.0, [-2.0]) == [0.0]
    only = gi.Problem("h", (("y", 2),), splitting=henon_heiles.problem().splitting)
    with pytest.raises(gi.FormError, match="no field"):
        traced_field(only, NUMPY, 0.0, [1.0, 2.0])


class _Condition:
    def __bool__(self) -> bool:
        raise TypeError("undecided")


@pytest.mark.parametrize("name", PEERS)
def test_every_peer_comes_to_the_same_state(name: str) -> None:
    """Forwards and backwards, on a problem that it can state; skipped where it is not installed."""
    peer = PEERS[name]
    if peer.version is None:
        pytest.skip(f"{peer.package} is not installed")
    problem, y0 = {
        "lielab": EXAMPLES["pulsating-body"],
        "mici": EXAMPLES["spherical-pendulum"],
    }.get(name, EXAMPLES["seasonal-lotka-volterra"])
    for end in (2.0, -2.0):
        right = gi.solve(problem, y0, t_end=end, step=0.02, method="dop853").y[-1]
        if name == "lielab" and end < 0.0:
            with pytest.raises(gi.FormError, match="forwards only"):
                peer.start(Motion(problem, y0, end))
            continue
        ready = peer.start(Motion(problem, y0, end))(1e-3 if peer.fixed else 1e-10)
        first, again = ready.run(), ready.run()
        np.testing.assert_array_equal(first.y, again.y)
        assert np.max(np.abs(first.y - right)) < (1e-6 if peer.fixed else 1e-8)
        assert 1 <= ready.order <= 30
        assert first.steps or first.evaluations


def test_the_compiled_field_is_the_field() -> None:
    problem, y0 = PENDULUM
    field = compiled_field(Motion(problem, y0, 1.0))
    one, two = field(0.0, y0), field(0.0, 2.0 * y0)
    np.testing.assert_array_equal(one, gi.derivative(problem, y0))
    np.testing.assert_array_equal(two, gi.derivative(problem, 2.0 * y0))


def test_peers_run_beside_methods(tmp_path: Path) -> None:
    """Those of SciPy always; the page marks them, and says why others did not run."""
    scene = gi.load_scene("sphere-n3")
    end = {"t_end": 5.0}
    found = compare(scene.model, end, ["gauss-4"], peers=[*SCIPY, "mici"], repeats=1, steps=[0.1])
    assert [p.method for p in found.points if p.peer is None] == ["gauss-4"]
    for name in SCIPY:
        points = [p for p in found.points if p.method == name]
        assert [p.rtol for p in points] == list(peer_runs.TOLERANCES)
        errors = [p.error for p in points]
        assert errors[0] > 100.0 * errors[2] > 1000.0 * errors[4]
        assert all(p.peer.startswith("scipy ") and p.seconds > 0.0 for p in points)
        assert all(p.status == "ok" and p.evaluations > 10 and p.order for p in points)
    assert list(found.left_out) == ["mici"]
    assert found.without_result == {}
    write_compare_report(found, scene, tmp_path)
    page = (tmp_path / "compare.html").read_text("utf-8")
    assert "scipy-lsoda" in page
    assert "Peers that did not run: mici: " in page
    record = json.loads((tmp_path / "compare.json").read_text("utf-8"))
    assert record["peers_left_out"] == found.left_out
    assert {p["peer"] is None for p in record["points"]} == {True, False}


def test_what_is_not_installed_or_fails_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(motion: Motion) -> Any:
        def ready(tolerance: float) -> Ready:
            def run() -> Any:
                if tolerance < 1e-7:
                    raise PeerError("too tight")
                raise ZeroDivisionError("of its own")

            return Ready(3, run)

        return ready

    others = {
        "absent": Peer("absent", "no-such-package-of-geomint", failing),
        "failing": Peer("failing", "numpy", failing),
    }
    for name, peer in others.items():
        monkeypatch.setitem(PEERS, name, peer)
    model = model_of(*PENDULUM)
    found = compare(model, {"t_end": 1.0}, ["rk-4"], peers=others, repeats=1, steps=[0.1])
    assert found.left_out == {
        "absent": "no-such-package-of-geomint is not installed: pip install "
        "no-such-package-of-geomint"
    }
    statuses = [p.status for p in found.points if p.method == "failing"]
    assert statuses[0] == "failed: ZeroDivisionError: of its own"
    assert statuses[-1] == "failed: PeerError: too tight"
    assert found.without_result == {}
    with pytest.raises(gi.DomainError, match="scipy-dop853"):
        compare(model, {"t_end": 1.0}, ["rk-4"], peers=["scipy-dop85"])


def test_a_first_run_of_a_peer_is_not_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    """It compiles what is compiled when it is needed, for longer than runs are repeated for."""
    clock = [0.0]
    monkeypatch.setattr(peer_runs.time, "perf_counter", lambda: clock[0])
    problem, y0 = PENDULUM

    def lazy(motion: Motion) -> Any:
        def ready(tolerance: float) -> Ready:
            left = [4.0]

            def run() -> End:
                clock[0] += left.pop() if left else 0.5
                return End(y0, 1)

            return Ready(3, run)

        return ready

    peer = Peer("lazy", "numpy", lazy)
    monkeypatch.setattr(peer_runs, "_settings", lambda peer, motion: [1e-4, 1e-6])
    endpoint = SimpleNamespace(end_for=lambda p: {"t_end": 1.0}, judged=lambda *a: {"error": 0.1})
    for repeats, times in ((None, 2), (1, 1), (5, 5)):
        runs = peer_runs.peer_runs(
            [peer], model_of(problem, y0), endpoint, None, repeats, {}, print
        )
        assert [(p.seconds, p.repeats) for p in runs] == [(0.5, times)] * 2


def test_a_package_that_cannot_be_imported_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(motion: Motion) -> Any:
        raise ImportError("no symbol")

    monkeypatch.setitem(PEERS, "broken", Peer("broken", "numpy", broken))
    model = model_of(*PENDULUM)
    found = compare(model, {"t_end": 1.0}, ["rk-4"], peers=["broken"], repeats=1, steps=[0.1])
    assert found.left_out == {"broken": "ImportError: no symbol"}


def test_points_that_would_take_too_long_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peer_runs, "MAX_SECONDS", 1e-9)
    model = model_of(*PENDULUM)
    found = compare(model, {"t_end": 1.0}, ["rk-4"], peers=SCIPY[:1], repeats=1, steps=[0.1])
    first, *rest = [p for p in found.points if p.peer]
    assert first.status == "ok"
    assert all(p.status.startswith("not run: would take") for p in rest)


def test_a_problem_in_another_time_is_left_out() -> None:
    """In τ to a physical end there is no clock: another representation runs, or none."""
    scene = gi.load_scene("hamiltonized-n3")
    options: dict[str, Any] = {"peers": SCIPY[1:], "repeats": 1, "steps": [0.25]}
    for end, own in (({"tau_end": 5.0}, True), ({"t_end": 5.0}, False)):
        found = compare(scene.model, end, ["gauss-8"], **options)
        where = {p.representation for p in found.points if p.peer}
        assert len(where) == 1
        assert (where == {next(iter(scene.model.problems))}) is own
        assert min(p.bound for p in found.points if p.peer) < 1e-8
    left = compare(scene.model, {"t_end": 5.0}, ["gauss-8"], representation="own", **options)
    assert "the end is not known" in left.left_out["scipy-lsoda"]


def test_heyoka_is_told_of_a_run_that_stops() -> None:
    hy = pytest.importorskip("heyoka")
    x = hy.make_vars("x")
    _, run = heyoka_peer.taylor([(x, x * x)], 1e-10, False)
    with pytest.raises(PeerError):
        run(np.array([1.0]), 2.0)
