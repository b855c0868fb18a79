"""Compiled functions give the bits of plain Python, for float64 and for lanes."""

import numpy as np
import pytest
from numba.core import types
from support import CASES

from chaplygin.measures import constant_density
from geomint.kernels.compiling import signatures
from geomint.kernels.compiling.compile import LANE, SCALAR, compile_function, extended_kind
from geomint.kernels.compiling.recorded import Recorded
from geomint.kernels.numbers.blocks import as_lanes, scalar_block

LABELS = [
    "reduced-special-n3",
    "reduced-full-n4",
    "hamiltonized-special-n3",
    "ball-special-n4",
    "ball-attitude-diagonal-n3",
    "ball-full-n4",
    "classical-special-n3",
    "classical-attitude-full-n3",
    "veselova-reduced-n4",
    "veselova-hamiltonized-n4",
    "veselova-classical-n3",
    "ellipsoid-n4",
    "group-full-n3",
    "poisson-full-n3",
    "reduced-equal-2-n4",
    "lr-1-full-n3",
    "stiefel-2-diagonal-n4",
    "rubber-diagonal-n3",
    "neumann-n3",
    "clebsch-n4",
]
CHOSEN = [case for case in CASES if case.label in LABELS]
EACH = pytest.mark.parametrize("case", CHOSEN, ids=str)
KINDS = pytest.mark.parametrize("kind", [SCALAR, LANE], ids=str)


def block_of(kind, array):
    """Return an aligned block of the array; its lanes are scaled by different factors."""
    if kind is SCALAR:
        block = scalar_block(len(array))
        block.data[:] = array
    else:
        block = as_lanes(scalar_block(8 * len(array)), 0, len(array))
        block.data[:] = np.outer(array, np.linspace(0.7, 1.3, 8))
    return block


def vector(f):
    """Return a function without the time, which Python cannot pass as a lane value."""

    def call(params, y, out, work):
        f(params, 0.0 * y[0], y, out, work)

    return Recorded(call)


def number(f):
    def call(params, y, out, work):
        out[0] = f(params, 0.0 * y[0], y, work)

    return Recorded(call)


def same_bits(case, kind, call, rows):
    signature = types.void(SCALAR.block, kind.block, kind.block, kind.block)
    results = []
    for run in (call, compile_function(call, signature)):
        params = block_of(SCALAR, case.problem.params)
        y, out = block_of(kind, case.y), block_of(kind, np.zeros(rows))
        run(params, y, out, block_of(kind, np.zeros(case.problem.work)))
        results.append(np.array(out.data))
    assert np.isfinite(results[0]).all()
    assert np.any(results[0] != 0.0)
    np.testing.assert_array_equal(results[0], results[1])
    return results[0]


@EACH
@KINDS
def test_field(case, kind):
    plain = same_bits(case, kind, vector(case.problem.field), len(case.y))
    if kind is LANE:
        assert np.ptp(plain[0]) > 0.0


@pytest.mark.parametrize("case", [c for c in CHOSEN if c.problem.action], ids=str)
@KINDS
def test_generator(case, kind):
    action = case.problem.action
    same_bits(case, kind, vector(action.generator), action.group.algebra_rows)


@EACH
@KINDS
def test_values(case, kind):
    functions = dict(case.problem.diagnostics)
    if case.problem.clock is not None:
        functions["clock"] = case.problem.clock
    if case.problem.measure.log_density is not constant_density:
        functions["log-density"] = case.problem.measure.log_density
    for f in functions.values():
        if kind is SCALAR:
            y = case.y * np.linspace(0.9, 1.2, len(case.y))
            same_bits(type(case)(case.label, None, case.problem, y), kind, number(f), 1)
        else:
            same_bits(case, kind, number(f), 1)


@EACH
@KINDS
def test_manifold_of_the_measure(case, kind):
    off = type(case)(case.label, None, case.problem, 0.9 * case.y)
    measure = case.problem.measure
    same_bits(off, kind, vector(measure.manifold), measure.conditions)


@pytest.mark.parametrize("case", [c for c in CHOSEN if c.problem.hamiltonian], ids=str)
@KINDS
def test_hamiltonian_form(case, kind):
    n, form = len(case.y) // 2, case.problem.hamiltonian
    gradients = compile_function(_without_time(form.gradients), _form_signature(kind, 6))
    constraint = compile_function(form.constraint, signatures.constraint(kind))
    params = block_of(SCALAR, case.problem.params)
    q, p = block_of(kind, case.y[:n]), block_of(kind, case.y[n:])
    found = []
    for first, second in (
        (_without_time(form.gradients), form.constraint),
        (gradients, constraint),
    ):
        out = [block_of(kind, np.zeros(size)) for size in (n, n, 1, n)]
        work = block_of(kind, np.zeros(0))
        first(params, q, p, out[0], out[1], work)
        second(params, q, out[2], out[3], work)
        found.append(np.concatenate([np.array(b.data) for b in out]))
    np.testing.assert_array_equal(found[0], found[1])


def _without_time(f):
    def call(params, q, p, dq, dp, work):
        f(params, 0.0 * q[0], q, p, dq, dp, work)

    return Recorded(call)


def _form_signature(kind, count):
    return types.void(SCALAR.block, *[kind.block] * (count - 1))


@EACH
def test_compiles_for_references(case):
    """Reference solutions run the fields on double-double numbers."""
    compile_function(case.problem.field, signatures.field(extended_kind()))
    if case.problem.clock is not None:
        compile_function(case.problem.clock, signatures.value(extended_kind()))
