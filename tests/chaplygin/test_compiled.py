"""Compiled functions give the bits of plain Python, for float64 and for lanes."""

import numpy as np
import pytest
from numba.core import types

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import EXTENDED, LANE, SCALAR
from geomint.kernels.compiling.recorded import Recorded
from geomint.kernels.compiling.signatures import CONSTRAINT, FIELD, VALUE
from geomint.kernels.numbers.blocks import as_lanes, scalar_block
from geomint.problems.forms import constant_density
from tests.chaplygin.support import CASES

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
# Of which most is in others too: at night.
LATER = {
    "reduced-full-n4",
    "ball-special-n4",
    "ball-attitude-diagonal-n3",
    "classical-special-n3",
    "veselova-reduced-n4",
    "veselova-hamiltonized-n4",
    "poisson-full-n3",
    "reduced-equal-2-n4",
    "neumann-n3",
}
# Of which lanes alone are compiled: what Python means otherwise than numba does, it does in both.
LANES_FIRST = {
    "ball-full-n4",
    "group-full-n3",
    "lr-1-full-n3",
    "stiefel-2-diagonal-n4",
    "rubber-diagonal-n3",
}
CHOSEN = [case for case in CASES if case.label in LABELS]


def marked(cases, *kinds):
    """Return all pairs of a kind and a case as parameters."""
    late = {kind: LATER if kind is LANE else LATER | LANES_FIRST for kind in kinds}
    return [
        pytest.param(k, c, marks=[pytest.mark.nightly] * (c.label in late[k]), id=f"{k}-{c}")
        for k in kinds
        for c in cases
    ]


def each(cases):
    return pytest.mark.parametrize(("kind", "case"), marked(cases, SCALAR, LANE))


EACH = each(CHOSEN)


def block_of(kind, array):
    """Return an aligned block of the array; its lanes are scaled by different factors."""
    if kind is SCALAR:
        block = scalar_block(len(array))
        block.data[:] = array
    else:
        block = as_lanes(scalar_block(8 * len(array)), 0, len(array))
        block.data[:] = np.outer(array, np.linspace(0.7, 1.3, 8))
    return block


def functions_of(problem):
    """Return all functions (params, t, y, …) of a problem by name, and how many rows they write."""
    found = {"field": (problem.field, problem.rows)}
    if problem.action:
        found["generator"] = (problem.action.generator, problem.action.group.algebra_rows)
    measure = problem.measure
    found["manifold"] = (measure.manifold, measure.conditions)
    values = dict(problem.diagnostics)
    if problem.clock is not None:
        values["clock"] = problem.clock
    if measure.log_density is not constant_density:
        values["log-density"] = measure.log_density
    return found | {name: (f, None) for name, f in values.items()}


class Together:
    """All functions of a problem in one: an entry of its own for each would take long to compile."""

    def __init__(self, problem):
        space, lines, self.rows, at = {"__name__": __name__, "part": gi.part}, [], {}, 0
        for i, (name, (f, rows)) in enumerate(functions_of(problem).items()):
            space[f"f{i}"] = f
            at, self.rows[name] = at + (rows or 1), slice(at, at + (rows or 1))
            start = self.rows[name].start
            if rows is None:
                lines.append(f"out[{start}] = f{i}(params, 0.0 * y[0], y, work)")
            else:
                lines.append(f"f{i}(params, 0.0 * y[0], y, part(out, {start}, {rows}), work)")
        # Without the time, which Python cannot pass as a lane value.
        exec("def call(params, y, out, work):\n    " + "\n    ".join(lines), space)
        self.call, self.size = Recorded(space["call"]), at


TOGETHER = {case.label: Together(case.problem) for case in CHOSEN}


def same_bits(case, kind, y, names):
    """Compare some functions of a case in plain Python and compiled; return the bits."""
    call, rows, size = (getattr(TOGETHER[case.label], name) for name in ("call", "rows", "size"))
    signature = types.void(SCALAR.block, kind.block, kind.block, kind.block)
    results = []
    for run in (call, compile_function(call, signature)):
        params, out = block_of(SCALAR, case.problem.params), block_of(kind, np.zeros(size))
        run(params, block_of(kind, y), out, block_of(kind, np.zeros(case.problem.work)))
        results.append(np.array(out.data))
    for name in names:
        one, other = (result[rows[name]] for result in results)
        assert np.isfinite(one).all(), name
        assert np.any(one != 0.0), name
        np.testing.assert_array_equal(one, other, err_msg=name)
    return results[0][rows[names[0]]]


@EACH
def test_field(case, kind):
    plain = same_bits(case, kind, case.y, ["field"])
    if kind is LANE:
        assert np.ptp(plain[0]) > 0.0


@each([c for c in CHOSEN if c.problem.action])
def test_generator(case, kind):
    same_bits(case, kind, case.y, ["generator"])


@EACH
def test_values(case, kind):
    names = [name for name, (_, rows) in functions_of(case.problem).items() if rows is None]
    y = case.y * np.linspace(0.9, 1.2, len(case.y)) if kind is SCALAR else case.y
    same_bits(case, kind, y, names)


@EACH
def test_manifold_of_the_measure(case, kind):
    same_bits(case, kind, 0.9 * case.y, ["manifold"])


@each([c for c in CHOSEN if c.problem.hamiltonian])
def test_hamiltonian_form(case, kind):
    n, form = len(case.y) // 2, case.problem.hamiltonian
    gradients = compile_function(_without_time(form.gradients), _form_signature(kind, 6))
    constraint = compile_function(form.constraint, CONSTRAINT.of(kind))
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


@pytest.mark.nightly
@pytest.mark.parametrize("case", CHOSEN, ids=str)
def test_compiles_for_references(case):
    """Reference solutions run the fields on double-double numbers."""
    compile_function(case.problem.field, FIELD.of(EXTENDED))
    if case.problem.clock is not None:
        compile_function(case.problem.clock, VALUE.of(EXTENDED))
