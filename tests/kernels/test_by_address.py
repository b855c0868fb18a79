"""Steppers behind their addresses: one kernel beside runs of all methods, with the bits of each."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling import compile as compiling
from geomint.kernels.solve.by_address import by_address
from geomint.methods.partial import PartialSteps, own_blocks
from geomint.methods.stepper import Stepper

# Methods that take other functions: a field, one and its own lanes, a generator and maps, gradients and
# constraints, flows.
METHODS = {
    "rk-4": "ball-3d",
    "gauss-3": "ball-3d",
    "cf-4": "ball-3d",
    "rkmk-4": "ball-3d",
    "rattle-2": "hamiltonized-n3",
    "verlet-2": "hamiltonized-n3",
}


def stepper_of(method: str) -> tuple[gi.Problem, Stepper]:
    scene = gi.load_scene(METHODS[method])
    motion = gi.Integrator(scene.problem, scene.state, method, step=0.05)
    return scene.problem, motion.stepper


@pytest.mark.parametrize("method", METHODS)
def test_a_step_has_its_bits(method: str) -> None:
    """As the run takes it: by the stepper itself, and through its address in an array."""
    problem, stepper = stepper_of(method)
    state = stepper.state.copy()
    rows = len(state)
    call = PartialSteps(problem, stepper)._call(False)
    out = np.zeros(rows)
    block = type(stepper.memory)
    given = {
        "states": state,
        "times": np.zeros(1),
        "nodes": np.zeros(1),
        "lengths": np.array([0.03]),
    }
    status, *_ = call(count=1, out=block(out), **{k: block(v) for k, v in given.items()})
    assert status == 0
    taken = stepper.fixed_step.single_step(state, 0.0, 0.03)
    if method.startswith("gauss"):  # it begins elsewhere: on the polynomial of the whole step
        assert np.abs(out - taken).max() < 1e-15
    else:
        assert np.array_equal(out, taken)


def test_kinds_share_what_is_compiled() -> None:
    """After one method, another kind of them compiles nothing that is beside the run."""
    compiled: list[str] = []
    end = compiling.listen(lambda name, seconds: compiled.append(name))
    try:
        for method, name in METHODS.items():
            scene = gi.load_scene(name)
            asked: dict[str, Any] = {"events": {"up": gi.Event("gamma[0]")}, "tau_eval": [0.1]}
            if scene.problem.time == "t":
                asked = {"events": asked["events"], "t_eval": [0.1]}
            end_of = "t_end" if scene.problem.time == "t" else "tau_end"
            gi.solve(scene.problem, scene.state, method=method, step=0.05, **{end_of: 0.2}, **asked)
            if method == "rk-4":
                compiled.clear()
    finally:
        end()
    assert not {"find", "partial", "to_clock"} & set(compiled)


def test_a_kind_has_one_name_everywhere() -> None:
    """The name is in code on the disk: another process has the same, another kind another one."""
    _, stepper = stepper_of("rk-4")
    own = by_address(tuple(f.signature for f in stepper.functions)).recorded.fingerprint
    _, other = stepper_of("verlet-2")
    assert own != by_address(tuple(f.signature for f in other.functions)).recorded.fingerprint
    script = """
from geomint.kernels.compiling.signatures import FIELD
from geomint.kernels.solve.by_address import by_address
print(by_address((FIELD,)).recorded.fingerprint)
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == own


def test_a_call_keeps_its_functions() -> None:
    """Copies of a call have addresses of their own to change; what they point to stays."""
    problem, stepper = stepper_of("rk-4")
    call = PartialSteps(problem, stepper)._call(False)
    codes = call.given("functions")
    copy = call.copy()
    call.set(functions=tuple(reversed(codes)))
    call.set(functions=codes)
    assert copy.given("functions") is codes
    state = stepper.state.copy()
    block, found = type(stepper.memory), []
    for one in (call, copy):
        out = np.zeros(len(state))
        given = {"states": state, "times": np.zeros(1), "nodes": np.zeros(1)}
        blocks = {k: block(v) for k, v in given.items()}
        one(
            count=1,
            out=block(out),
            lengths=block(np.array([0.02])),
            **own_blocks(stepper),
            **blocks,
        )
        found.append(out)
    assert np.array_equal(*found)
