"""Bit for bit: compiled = plain Python = lanes, in chunks of any size, and after a restart."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.numbers.blocks import Block, LaneBlock, scalar_block
from geomint.kernels.numbers.lanes import LANES
from geomint.kernels.solve.advance import bound_stepper
from geomint.methods import Start
from geomint.methods.stepper import Stepper
from geomint.run import driver
from tests.families import PROBLEMS, families, pairs

H = 0.05


def start(name: str, problem: str, compiled: bool = True, h: float = H) -> Stepper:
    """A stepper of a method on a problem."""
    p, y0 = PROBLEMS[problem]
    return gi.find_method(name).start(Start(p, y0, 0.0, h, compiled=compiled))


def advance(stepper: Stepper, first: int, count: int) -> int:
    """Take steps, which must succeed; the iterations."""
    result = stepper.advance(first, count, 1, scalar_block(count * stepper.rows))
    assert (result.status, result.steps) == (0, count)
    return result.iterations


def plain_equals_compiled(name: str, problem: str, steps: int) -> None:
    plain, compiled = start(name, problem, compiled=False), start(name, problem)
    assert advance(plain, 0, steps) == advance(compiled, 0, steps)
    np.testing.assert_array_equal(plain.memory.data, compiled.memory.data)


@families
def test_compiled_is_plain(name: str, problem: str) -> None:
    """All of memory, predictors and carries included; and no process compiles it again."""
    plain_equals_compiled(name, problem, 10)
    stepper = start(name, problem)
    code = bound_stepper(stepper.kernel, stepper.functions).entry()
    libraries = [overload.library for overload in code.dispatcher.overloads.values()]
    assert libraries
    assert not any(library.has_dynamic_globals for library in libraries)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("rk-4", "lotka-volterra"),
        ("gauss-2", "henon-heiles"),
        ("cf-4", "pulsating-body"),
        ("rkmk-4", "pulsating-body"),
        ("rattle-2", "spherical-pendulum"),
        ("verlet-2", "neumann"),
    ],
)
def test_compiled_is_plain_for_a_thousand_steps(name: str, problem: str) -> None:
    """One method of each family."""
    plain_equals_compiled(name, problem, 1000)


@pytest.mark.nightly
@families
def test_compiled_is_plain_for_long(name: str, problem: str) -> None:
    """Every family, on its hardest problem."""
    plain_equals_compiled(name, problem, 1000)


@pytest.mark.nojit
@families
def test_plain_python_runs(name: str, problem: str) -> None:
    """Three steps of every family's own source."""
    stepper = start(name, problem, compiled=False)
    advance(stepper, 0, 3)
    assert np.isfinite(stepper.memory.data).all()


# --- lanes ----------------------------------------------------------------------------------------


def eight_states(problem: str) -> list[np.ndarray]:
    """Eight different admissible states at time 0."""
    p, y0 = PROBLEMS[problem]
    if p.hamiltonian is None:
        return [y0 * (1.0 + 0.02 * k) for k in range(LANES)]
    # Turned about the vertical and stirred by a flow that keeps the constraints of time 0.
    frozen = [y0]
    for _ in range(LANES - 1):
        frozen.append(tangent_state(p, frozen[-1] + 0.1 * np.sin(np.arange(len(y0)) + len(frozen))))
    return frozen


def tangent_state(p: gi.Problem, y: np.ndarray) -> np.ndarray:
    """Project on |q| = 1, (q, ∂H/∂p) = 0 at time 0: one constraint, H quadratic in p."""
    n = p.rows // 2
    q, momentum = y[:n] / np.linalg.norm(y[:n]), y[n:]

    def velocity(v: np.ndarray) -> np.ndarray:
        dq, dp = Block(np.zeros(n)), Block(np.zeros(n))
        p.hamiltonian.gradients(
            Block(p.params), np.float64(0), Block(q), Block(v), dq, dp, Block(np.zeros(p.work))
        )
        return dp.data

    for _ in range(2):
        response = velocity(momentum + q) - velocity(momentum)
        momentum = momentum - q * (q @ velocity(momentum)) / (q @ response)
    return np.concatenate([q, momentum])


@pairs(
    [
        ("rk-4", "lotka-volterra"),
        ("dop853", "sphere-metric"),
        ("cf-4", "pulsating-body"),
        ("cf-3", "so-4"),
        ("rkmk-4", "pulsating-body"),
        ("rkmk-dop853", "so-4"),
        ("rkmk-cayley-4", "so-4"),
        ("rattle-2", "sphere-metric"),
        ("rattle-6", "spherical-pendulum"),
        ("rattle-2", "neumann"),
        ("rattle-2", "neumann-at-rest"),
        ("verlet-4", "neumann"),
        ("verlet-2", "abc-flow"),
    ],
)
def test_lanes_are_eight_runs(name: str, problem: str) -> None:
    """Kernels compiled for lanes, from eight states: each lane has the bits of its own run."""
    steps = 1000
    p, _ = PROBLEMS[problem]
    singles = [gi.find_method(name).start(Start(p, y, 0.0, H)) for y in eight_states(problem)]
    one = singles[0]
    functions = tuple(f.in_lanes for f in one.functions)
    advance = bound_stepper(one.kernel, one.functions).in_lanes.call(functions=functions)
    memory = LaneBlock(np.stack([s.memory.data for s in singles], axis=1))
    out = LaneBlock(np.zeros((steps // 100 * one.rows, LANES)))
    status, done, iterations, _ = advance(
        params=one.params,
        coefficients=one.coefficients,
        fractions=one.fractions,
        memory=memory,
        work=LaneBlock(np.zeros((len(one.work), LANES))),
        rows=one.rows,
        t0=0.0,
        h=H,
        first=0,
        count=steps,
        every=100,
        out=out,
    )
    assert (status, done) == (0, steps)
    used = []
    for k, single in enumerate(singles):
        saved = scalar_block(steps // 100 * single.rows)
        result = single.advance(0, steps, 100, saved)
        used.append(result.iterations)
        np.testing.assert_array_equal(memory.data[:, k], single.memory.data)
        np.testing.assert_array_equal(out.data[:, k], saved.data)
    assert iterations >= max(used)
    assert len({tuple(column) for column in memory.data[: one.rows].T}) == LANES


# --- chunks and restarts --------------------------------------------------------------------------


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Chunks of one to a few steps, of changing sizes."""
    monkeypatch.setattr(driver, "FIRST_CHUNK", 3)
    # Chunks seem to take any time: sizes rise and fall.
    rng = np.random.default_rng(0)
    clock = itertools.accumulate(10.0 ** rng.uniform(-3.0, 0.5) for _ in itertools.count())
    monkeypatch.setattr(driver, "running_clock", lambda: next(clock))
    return


@families
def test_bits_do_not_depend_on_chunks(
    name: str, problem: str, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    """Saved states, drifts and costs are the same for chunks of any size."""
    p, y0 = PROBLEMS[problem]

    def run() -> gi.Solution:
        return gi.solve(
            p, y0, t_end=12.34, step=H, method=name, save_every=7, observe="all", observe_every=3
        )

    expected = run()
    sizes = []
    original = Stepper.advance

    def counting(self: Stepper, first: int, count: int, *others: object) -> object:
        sizes.append(count)
        return original(self, first, count, *others)

    monkeypatch.setattr(Stepper, "advance", counting)
    request.getfixturevalue("small_chunks")
    found = run()
    assert len(set(sizes)) > 3
    np.testing.assert_array_equal(found.tau, expected.tau)
    np.testing.assert_array_equal(found.y, expected.y)
    assert (found.steps, found.iterations) == (expected.steps, expected.iterations)
    assert found.evaluations == expected.evaluations
    for quantity, drift in expected.drift.items():
        assert found.drift[quantity].max_abs_error == drift.max_abs_error
        assert found.drift[quantity].final_error == drift.final_error
        assert found.drift[quantity].slope == drift.slope


@families
def test_a_run_resumes_from_its_memory(name: str, problem: str) -> None:
    """Memory saved in the middle of a run and given to a fresh stepper continues bit for bit."""
    whole, first_half = start(name, problem), start(name, problem)
    advance(whole, 0, 100)
    advance(first_half, 0, 37)
    saved = first_half.memory.data.tobytes()
    second_half = start(name, problem)
    second_half.memory.data[:] = np.frombuffer(saved)
    advance(second_half, 37, 63)
    np.testing.assert_array_equal(second_half.memory.data, whole.memory.data)


@families
def test_work_is_only_scratch(name: str, problem: str) -> None:
    """Nothing that the next step depends on lies outside of memory."""
    clean, dirty = start(name, problem), start(name, problem)
    advance(clean, 0, 5)
    advance(clean, 5, 5)
    advance(dirty, 0, 5)
    dirty.work.data[:] = np.random.default_rng(0).standard_normal(len(dirty.work))
    advance(dirty, 5, 5)
    np.testing.assert_array_equal(dirty.memory.data, clean.memory.data)


# --- costs ----------------------------------------------------------------------------------------


class Counter:
    """Counts the calls of a recorded function, in plain Python."""

    def __init__(self) -> None:
        self.calls = 0

    def count(self, f: gi.Problem) -> object:
        def counted(*args):
            self.calls += 1
            return f.function(*args)

        return counted


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("name", "problem", "stages"),
    [
        ("rk-4", "lotka-volterra", 4),
        ("dop853", "lotka-volterra", 12),
        ("gauss-3", "lotka-volterra", 3),
    ],
)
def test_evaluations_are_counted(name: str, problem: str, stages: int) -> None:
    """What a solution reports is what was called: once a stage and iteration."""
    import dataclasses

    p, y0 = PROBLEMS[problem]
    counter = Counter()
    counted = dataclasses.replace(p, field=gi.field(counter.count(p.field)))
    for _ in range(2):  # the first one looks at what the problem declares, too
        counter.calls = 0
        sol = gi.solve(counted, y0, t_end=1.0, step=0.1, method=name, compiled=False)
    assert sol.steps == 10
    assert sol.evaluations == sol.iterations * stages
    # A Gauss method evaluates all its stages in one call, in lanes; and tries once if it can.
    gauss = name.startswith("gauss")
    assert counter.calls == (sol.iterations + 1 if gauss else sol.evaluations)


@pytest.mark.nojit
@pytest.mark.parametrize(("name", "stages"), [("cf-4", 4), ("cf-3", 3), ("rkmk-4", 4)])
def test_evaluations_of_generators_are_counted(name: str, stages: int) -> None:
    """Once a stage."""
    import dataclasses

    p, y0 = PROBLEMS["pulsating-body"]
    counter = Counter()
    generator = gi.field(counter.count(p.action.generator))
    counted = dataclasses.replace(p, action=gi.GroupAction(generator, p.action.group))
    for _ in range(2):  # the first one looks at what the problem declares, too
        counter.calls = 0
        sol = gi.solve(counted, y0, t_end=1.0, step=0.1, method=name, compiled=False)
    assert sol.evaluations == 10 * stages
    assert counter.calls == sol.evaluations


def test_kinds_have_names() -> None:
    """For messages."""
    assert (repr(SCALAR), repr(LANE)) == ("SCALAR", "LANE")
