"""Integrators of other packages on geomint's problems: the same motion, or a reason."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.cli import find_command
from geomint.compare.runs import compare
from geomint.reports.files import write
from tests.problems import spherical_pendulum

SCIPY = ["scipy-dop853", "scipy-lsoda"]
OTHERS = ["heyoka", "diffrax", "lielab", "mici"]
PENDULUM = gi.Model(
    {"pendulum": spherical_pendulum.problem()}, {"pendulum": spherical_pendulum.INITIAL}
)
RUN: dict[str, Any] = {"methods": ["rk-4"], "repeats": 1, "steps": [0.1], "observe": False}

# A package as Diffrax is one, on NumPy in place of JAX.
JAX = """
import contextlib
enable_x64 = lambda on: contextlib.nullcontext()
jit = lambda f: f
eval_shape = lambda f, *args: f(*args)
"""
DIFFRAX = """
from types import SimpleNamespace
import numpy as np
from scipy.integrate import solve_ivp
RESULTS = SimpleNamespace(successful="done")
ODETerm = PIDController = SaveAt = lambda f=None, **given: SimpleNamespace(f=f, **given)
Dopri8 = object
def diffeqsolve(term, by, t0, t1, dt0, y0, saveat, stepsize_controller, max_steps, throw):
    rtol = float(stepsize_controller.rtol)
    assert throw is False and saveat.t1
    if rtol < 1e-11:
        raise ZeroDivisionError("of its own")
    f = lambda t, y: term.f(t, y, None)
    found = solve_ivp(f, (t0, t1), y0, "DOP853", rtol=max(rtol, 1e-13), atol=stepsize_controller.atol)
    result = "too tight" if rtol < 1e-9 else "done"
    return SimpleNamespace(ys=found.y.T, result=result, stats={"num_steps": len(found.t) - 1})
"""


def reported(scene, found):
    compare = find_command("compare")
    return compare.report(compare.plan(scene), found, None)


@pytest.fixture
def package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    """Install a package for the time of a test."""

    def install(files: dict[str, str]) -> None:
        info = {"diffrax-0.1.dist-info/METADATA": "Name: diffrax\nVersion: 0.1\n"}
        for name, text in {"jax/__init__.py": JAX, **info, **files}.items():
            (tmp_path / name).parent.mkdir(exist_ok=True)
            (tmp_path / name).write_text(text, "utf-8")
        monkeypatch.syspath_prepend(tmp_path)
        for module in ("jax", "jax.numpy", "diffrax"):
            monkeypatch.delitem(sys.modules, module, raising=False)

    return install


@gi.field
def choosing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A formula of all kinds of things, which has no kinks where the motion is."""
    here = gi.select(t < 9.0, gi.sin(t), gi.cos(t)) + abs(y[1] - 9.0)
    there = gi.select(y[0] >= -9.0, y[0], 0.5 * y[0]) - gi.select(y[0] > 9.0, y[1], 0.5 * y[1])
    out[0] = here / 4.0 - there * y[1]
    out[1] = 1.0 - gi.sqrt(1.0 + y[0] * y[0]) + params[0] * y[0] - y[1]


CHOOSING = gi.Problem("p", (("x", 1), ("y", 1)), params=[0.3], field=choosing)


@pytest.mark.parametrize("end", [1.5, -1.5])
def test_a_traced_field_is_the_field(package: Any, end: float) -> None:
    """Forwards and backwards; failures are points that say so."""
    package({"jax/numpy.py": "from numpy import *", "diffrax.py": DIFFRAX})
    model = gi.Model({"p": CHOOSING}, {"p": np.array([0.5, -0.2])})
    found = compare(model, {"t_end": end}, peers=["diffrax"], **RUN)
    points = [p for p in found.points if p.peer]
    assert {(p.peer, p.method, p.order) for p in points} == {("diffrax 0.1", "diffrax", 8)}
    assert [p.rtol for p in points] == [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13]
    errors = [p.error for p in points[:3]]
    assert errors[0] > 10.0 * errors[2]
    assert errors[2] < 1e-8
    statuses = (
        ["ok"] * 3
        + ["failed: PeerError: too tight"]
        + ["failed: ZeroDivisionError: of its own"] * 2
    )
    assert [p.status for p in points] == statuses


def test_a_package_that_cannot_be_imported_is_left_out(package: Any) -> None:
    package({"jax/numpy.py": "", "diffrax.py": "raise ImportError('no symbol')"})
    found = compare(PENDULUM, {"t_end": 1.0}, peers=["diffrax"], **RUN)
    assert found.left_out == {"diffrax": "ImportError: no symbol"}


def test_peers_run_beside_methods(tmp_path: Path) -> None:
    """Those of SciPy always; the page marks them, and says why others did not run."""
    scene = gi.load_scene("sphere-n3")
    given = {**RUN, "methods": ["gauss-4"], "peers": [*SCIPY, *OTHERS]}
    found = compare(scene.model, {"t_end": 5.0}, **given)
    assert [p.method for p in found.points if p.peer is None] == ["gauss-4"]
    for name in {p.method for p in found.points if p.peer}:
        points = [p for p in found.points if p.method == name]
        assert min(p.bound for p in points if p.bound is not None) < 1e-5
        assert all(p.seconds > 0.0 and p.order for p in points if p.status == "ok")
    for name in SCIPY:
        points = [p for p in found.points if p.method == name]
        assert [p.rtol for p in points] == [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13]
        errors = [p.error for p in points]
        assert errors[0] > 100.0 * errors[2] > 1000.0 * errors[4]
        assert all(p.peer.startswith("scipy ") and p.evaluations > 10 for p in points)
    ran = {p.method for p in found.points if p.peer}
    assert {*ran, *found.left_out} == {*SCIPY, *OTHERS}
    for name, why in found.left_out.items():
        assert why == f"{name} is not installed: pip install {name}" or name == "mici"
    assert found.without_result == {}
    write(reported(scene, found), tmp_path)
    page = (tmp_path / "compare.html").read_text("utf-8")
    assert "scipy-lsoda" in page
    assert "Peers that did not run: " in page
    record = json.loads((tmp_path / "compare.json").read_text("utf-8"))
    assert record["peers_left_out"] == found.left_out
    assert {p["peer"] is None for p in record["points"]} == {True, False}


def test_a_problem_in_another_time_is_left_out() -> None:
    """In τ to a physical end there is no clock: another representation runs, or none."""
    scene = gi.load_scene("hamiltonized-n3")
    options = {**RUN, "peers": SCIPY[1:]}
    for end, own in (({"tau_end": 5.0}, True), ({"t_end": 5.0}, False)):
        found = compare(scene.model, end, **options)
        where = {p.representation for p in found.points if p.peer}
        assert len(where) == 1
        assert (where == {next(iter(scene.model.problems))}) is own
        assert min(p.bound for p in found.points if p.peer) < 1e-8
    left = compare(scene.model, {"t_end": 5.0}, representation="own", **options)
    assert "the end is not known" in left.left_out["scipy-lsoda"]
