"""The order of every method, measured on problems that leave it no excuse.

All problems are nonlinear, depend on time and state, and for Lie group methods on generators that do
not commute. The error of three runs must lie well above rounding and fall with the declared power
of the step, to ±0.2 on both sides between any two neighbours: a method that is better than it says
is as wrong as one that is worse. Where float64 ends, the kernels' own source runs in plain Python on
longer numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
import pytest
from mpmath import mp

import geomint as gi
from geomint.kernels.numbers.blocks import Block
from geomint.kernels.solve.gauss import gauss_coefficients
from geomint.kernels.solve.lobatto import lobatto_coefficients
from geomint.methods import Start, methods, rkmk
from geomint.methods.gauss import lane_positions, spread_columns
from geomint.methods.lobatto import lane_positions as lobatto_positions
from geomint.methods.stepper import Stepper
from geomint.problems.testproblems import neumann, pulsating_body, sphere_metric
from geomint.tableaux import (
    COMMUTATOR_FREE,
    COMPOSITIONS,
    RUNGE_KUTTA,
    Composition,
    gauss_legendre,
    lobatto_pair,
)
from tests.problems import abc_flow, double_pendulum, frame_in_field, lotka_volterra, so_n_flow

T_END = 2.0
COMPOSED = [f"gauss-1-{name}" for name, scheme in COMPOSITIONS.items() if scheme.base_order == 2]
COMPOSED += ["rattle-kahan-li-6", "verlet-yoshida-6", "gauss-2-suzuki-6", "gauss-2-yoshida-6"]
COMPOSED += ["gauss-3-triple-jump-8", "verlet-4-suzuki-6", "rattle-4-suzuki-6"]
NAMES = [name for name in (*methods(), *COMPOSED) if not gi.find_method(name).adaptive]

# Steps of the three runs, by order: errors between 1e-14 and 1e-2.
COUNTS = {
    1: (256, 512, 1024),
    2: (128, 256, 512),
    3: (128, 256, 512),
    4: (64, 128, 256),
    5: (64, 91, 128),
    6: (23, 32, 45),
    8: (8, 11, 16),
}
LATE = {"gauss-1-sofroniou-spaletta-8": (11, 13, 16)}  # the asymptotics begin later
PLATEAU = 5e-15


@cache
def cases(form: str) -> list[tuple[gi.Problem, np.ndarray]]:
    """Return the problems of a form."""
    metric, frame = sphere_metric.problem(), frame_in_field.problem()
    return {
        "field": [(lotka_volterra.problem(), lotka_volterra.INITIAL)],
        "action": [
            (pulsating_body.problem(), pulsating_body.INITIAL),
            (so_n_flow.problem(4), so_n_flow.initial(4)),
        ],
        "hamiltonian": [
            (metric, sphere_metric.initial(metric)),
            (double_pendulum.problem(), double_pendulum.INITIAL),
            (frame, frame_in_field.initial(frame)),
        ],
        "splitting": [
            (abc_flow.problem(), abc_flow.INITIAL),
            (neumann.problem(season=0.4), neumann.initial()),
        ],
    }[form]


@cache
def reference(problem_index: int, form: str) -> np.ndarray:
    """The end of a run of a method of order 32 at a small step, on the ODE form."""
    problem, y0 = cases(form)[problem_index]
    return gi.solve(problem, y0, t_end=T_END, step=T_END / 64, method="gauss-16").y[-1]


def slopes(counts: tuple[int, ...], errors: list[Any]) -> list[float]:
    """The measured orders between neighbouring runs."""
    return [
        float(mp.log(e / f) / mp.log(mp.mpf(n) / m))
        for (m, e), (n, f) in pairwise(zip(counts, errors, strict=True))
    ]


def measured(
    method: gi.Method, form: str, index: int, counts: tuple[int, ...], floor: float = PLATEAU
) -> list[float]:
    """The measured orders of a method on one problem in float64."""
    problem, y0 = cases(form)[index]
    exact = reference(index, form)
    errors = [
        float(
            np.max(
                np.abs(
                    gi.solve(problem, y0, t_end=T_END, step=T_END / n, method=method).y[-1] - exact
                )
            )
        )
        for n in counts
    ]
    assert floor < errors[-1] <= errors[0] < 0.1, errors
    return slopes(counts, errors)


IN_FLOAT64 = [name for name in NAMES if gi.find_method(name).order <= 8]


@pytest.mark.parametrize("name", IN_FLOAT64)
def test_order(name: str) -> None:
    """Methods of order up to 8, in float64."""
    method = gi.find_method(name)
    for index in range(len(cases(method.needs))):
        form, at = method.needs, index
        if name == "dormand-prince-5":
            # On the first problem its terms of order 5 are so small that 5.4 is seen to 1e-13.
            form, at = "action", 0
        found = measured(method, form, at, LATE.get(name, COUNTS[method.order]))
        assert found == pytest.approx([method.order] * 2, abs=0.2), (name, found)


def at_rest(form: str) -> tuple[gi.Problem, np.ndarray]:
    """A problem of a form with a piece of the state that is exactly 0."""
    if form == "action":
        y0 = pulsating_body.INITIAL.copy()
        y0[:3] = 0.0
        return pulsating_body.problem(), y0
    y0 = neumann.initial()
    y0[3:] = 0.0
    return neumann.problem(season=0.4), y0


@pytest.mark.parametrize("name", [name for name in IN_FLOAT64 if gi.find_method(name).order <= 6])
def test_order_from_rest(name: str) -> None:
    """Where all that moves in the first step is a piece that was 0."""
    method = gi.find_method(name)
    problem, y0 = at_rest(method.needs)
    exact = gi.solve(problem, y0, t_end=T_END, step=T_END / 256, method="dop853").y[-1]
    counts = COUNTS[method.order]
    errors = [
        float(
            np.max(
                np.abs(
                    gi.solve(problem, y0, t_end=T_END, step=T_END / n, method=method).y[-1] - exact
                )
            )
        )
        for n in counts
    ]
    assert errors[0] < 0.1
    if errors[-1] > 20 * PLATEAU:
        found = slopes(counts, errors)
        assert min(found) > method.order - 0.4, (name, found, errors)


# --- longer numbers -------------------------------------------------------------------------------


def extended(stepper: Stepper, number: Callable[[float], Any], h: Any) -> Stepper:
    """Return a stepper whose numbers are all of another kind, at first with the same values."""

    def block(old: Block) -> Block:
        values = [number(v) for v in old.data]
        dtype = object if isinstance(h, mp.mpf) else np.longdouble
        return Block(np.array(values, dtype=dtype))

    blocks = ("params", "coefficients", "fractions", "memory", "work")
    return replace(stepper, h=h, **{name: block(getattr(stepper, name)) for name in blocks})


def end_of(stepper: Stepper, steps: int) -> list[Any]:
    """Take all steps; the state with its carry."""
    result = stepper.advance(0, steps, steps, Block(stepper.memory.data[: stepper.rows].copy()))
    assert result.status == 0, result
    return list(stepper.state + stepper.carry)


def plain_start(method: gi.Method, problem: gi.Problem, y0: np.ndarray) -> Stepper:
    return method.start(Start(problem, y0, 0.0, 1.0, compiled=False))


SOLVED = ("gauss-5", "lobatto-6")  # in many digits, below
IN_LONGDOUBLE = [name for name in NAMES if gi.find_method(name).order == 10 and name not in SOLVED]


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="longdouble is float64 here")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.nightly] * (i > 0))
        for i, name in enumerate(IN_LONGDOUBLE)
    ],
)
def test_order_in_extended_precision(name: str) -> None:
    """Compositions of order 10, whose asymptotics begin where float64 ends.

    Those of splittings begin where longdouble ends.
    """
    method = gi.find_method(name)
    number = mp.mpf if method.needs == "splitting" else np.longdouble
    table = COMPOSITIONS["sofroniou-spaletta-10"]
    fractions = [number(x) for x in (*table.gamma, *table.starts)]
    exact = (*table.gamma_exact, Fraction(0), *accumulate(table.gamma_exact[:-1]))
    rest = [float(x - Fraction(float(x))) for x in exact]
    base = {"hamiltonian": gi.Rattle(), "splitting": gi.Verlet(), "field": gi.Gauss(1)}[
        method.needs
    ]
    problem, y0 = cases(method.needs)[0]
    *counts, many = {
        "field": (10, 12, 15, 48),
        "hamiltonian": (16, 20, 25, 48),
        "splitting": (22, 25, 29, 58),
    }[method.needs]
    ends = []
    for n in (*counts, many):
        plain = plain_start(gi.Compose(base, table.name), problem, y0)
        with mp.workdps(28):
            stepper = extended(plain, number, number(T_END) / n)
            stepper.fractions.data[:] = [
                x + number(r) for x, r in zip(fractions, rest, strict=True)
            ]
            ends.append(np.array(end_of(stepper, n)))
    # The reference is the method itself at half the step: its error is a thousandth of the last.
    errors = [np.max(np.abs(end - ends[-1])) for end in ends[:-1]]
    assert errors[-1] > (0.0 if number is mp.mpf else 3e-18)
    found = slopes(counts, errors)
    assert found == pytest.approx([10] * 2, abs=0.2), (name, found)
    assert np.max(np.abs(ends[-1] - reference(0, method.needs))) < 1e-14


def taylor_solution(problem: gi.Problem, y0: np.ndarray, steps: int, degree: int) -> list[Any]:
    """The end of `lotka_volterra` by Taylor series, independent of all methods here."""
    amplitude, frequency = (mp.mpf(float(p)) for p in problem.params)
    u, v = (mp.mpf(float(x)) for x in y0)
    h = mp.mpf(T_END) / steps
    for n in range(steps):
        sine, cosine = mp.sin(frequency * h * n), mp.cos(frequency * h * n)
        derivatives = (cosine, -sine, -cosine, sine)
        U, V, growth, decline = [u], [v], [], []
        scale = amplitude
        for k in range(degree):
            one = 1 if k == 0 else 0
            growth.append(one - V[k] + scale * derivatives[k % 4])
            decline.append(U[k] - one - V[k] / 8)
            scale *= frequency / (k + 1)
            U.append(mp.fdot(U, growth[::-1]) / (k + 1))
            V.append(mp.fdot(V, decline[::-1]) / (k + 1))
        powers = [h**k for k in range(degree + 1)]
        u, v = mp.fdot(U, powers), mp.fdot(V, powers)
    return [u, v]


def exact_gauss(stages: int) -> tuple[list[Any], list[Any], list[list[Any]]]:
    """Nodes, weights and μ: the tableau's 50 digits, or for the highest orders as many as asked for."""
    table = gauss_legendre(stages)
    stored = [mp.mpf(str(c)) for c in table.nodes]
    if stages <= 13:
        weights = [mp.mpf(str(b)) for b in table.weights]
        return (
            stored,
            weights,
            [[mp.mpf("0.5") + mp.mpf(str(e)) for e in row] for row in table.skew],
        )
    nodes = []
    for c in stored:
        x = 2 * c - 1
        for _ in range(3):  # Newton
            p, below = mp.legendre(stages, x), mp.legendre(stages - 1, x)
            x -= p * (x * x - 1) / (stages * (x * p - below))
        nodes.append((x + 1) / 2)
        assert abs(nodes[-1] - c) < mp.mpf(10) ** -49
    weights = [4 * c * (1 - c) / (stages * mp.legendre(stages - 1, 2 * c - 1)) ** 2 for c in nodes]
    legendre = [[mp.legendre(k, 2 * c - 1) for k in range(stages + 1)] for c in nodes]
    mu = [
        [c + sum(q[k] * (p[k + 1] - p[k - 1]) for k in range(1, stages)) / 2 for q in legendre]
        for c, p in zip(nodes, legendre, strict=True)
    ]
    return nodes, weights, mu


def gauss_end(stages: int, steps: int, spoil: Any = 0) -> list[Any]:
    """The end of a Gauss method's run in mpmath numbers."""
    problem, y0 = cases("field")[0]
    method = gi.Gauss(stages, iteration_tolerance=0.0, max_iterations=1000)
    stepper = extended(plain_start(method, problem, y0), mp.mpf, mp.mpf(T_END) / steps)
    nodes, weights, mu = exact_gauss(stages)
    nodes[0] += spoil
    width = 8 if stages <= 8 else 16
    at = lane_positions(stages, width)
    layout = gauss_coefficients(problem.rows, width // 8, 1)
    for name, values in (("c", nodes), ("b", weights)):
        gi.section(stepper.coefficients, layout, name).data[at] = values
    matrix = np.full((width, width), mp.mpf(0), dtype=object)
    matrix[np.ix_(at, at)] = np.array(mu, dtype=object)
    assert np.allclose(
        spread_columns(gauss_legendre(stages).mu, at, width), matrix.T.ravel().astype(float)
    )
    gi.section(stepper.coefficients, layout, "mu").data[:] = matrix.T.ravel()
    return end_of(stepper, steps)


def gauss_slopes(stages: int, counts: tuple[int, ...], spoil: Any = 0) -> list[float]:
    problem, y0 = cases("field")[0]
    with mp.workdps(28 + 4 * max(stages - 5, 0)):
        exact = taylor_solution(problem, y0, 32, 40 + 3 * stages)
        errors = [
            max(abs(x - y) for x, y in zip(gauss_end(stages, n, spoil), exact, strict=True))
            for n in counts
        ]
        return slopes(counts, errors)


@pytest.mark.parametrize(
    "stages",
    [pytest.param(s, marks=[pytest.mark.nightly] * (s not in (5, 8))) for s in range(5, 17)],
)
def test_order_in_many_digits(stages: int) -> None:
    """Gauss methods up to order 32, against Taylor series."""
    found = gauss_slopes(stages, (14, 15, 16) if stages < 14 else (16, 17, 18))
    assert found == pytest.approx([2 * stages] * 2, abs=0.2), found


def lobatto_end(stages: int, steps: int, spoil: Any = 0) -> np.ndarray:
    """The end of a run of a Lobatto pair in mpmath numbers, coefficients and all."""
    problem, y0 = cases("hamiltonian")[0]
    plain = plain_start(gi.Lobatto(stages, max_iterations=1000), problem, y0)
    stepper = extended(plain, mp.mpf, mp.mpf(T_END) / steps)
    pair, at, layout = lobatto_pair(stages), lobatto_positions(stages), lobatto_coefficients(1)
    nodes, weights = ([mp.mpf(str(x)) for x in row] for row in (pair.nodes, pair.weights))
    for name, values in (("c", nodes), ("b", weights)):
        gi.section(stepper.coefficients, layout, name).data[at] = values
    mu = np.array([[mp.mpf("0.5") + mp.mpf(str(x)) for x in row] for row in pair.excess])
    mu[1, 1] += spoil
    for name, values in (("mu", mu), ("nu", 1 - mu.T)):
        matrix = np.full((8, 8), mp.mpf(0), dtype=object)
        matrix[np.ix_(at, at)] = values
        gi.section(stepper.coefficients, layout, name).data[:] = matrix.T.ravel()
    q = stepper.memory.data[: len(y0) // 2]
    q[:] = q / mp.sqrt(q @ q)  # on the sphere in all digits, where all later states are
    return np.array(end_of(stepper, steps))


def lobatto_slopes(stages: int, counts: tuple[int, ...], spoil: Any = 0) -> list[float]:
    with mp.workdps(32):
        *ends, fine = [lobatto_end(stages, n, spoil) for n in (*counts, 2 * counts[-1])]
        return slopes(counts, [np.max(np.abs(end - fine)) for end in ends])


@pytest.mark.nightly
@pytest.mark.parametrize("stages", [6, 8])
def test_order_of_lobatto_pairs_in_many_digits(stages: int) -> None:
    """Up to order 14, against twice as many steps."""
    found = lobatto_slopes(stages, (14, 16, 18))
    assert found == pytest.approx([2 * stages - 2] * 2, abs=0.3), found


@pytest.mark.nightly
def test_a_spoiled_pair_is_noticed() -> None:
    """The 14th digit of a coefficient; the pair stays symplectic."""
    found = lobatto_slopes(7, (14, 16, 18), mp.mpf(10) ** -14)
    assert found != pytest.approx([12] * 2, abs=0.3)


def rkmk_end(coordinates: str, index: int, steps: int) -> list[Any]:
    """The end of a run of the RKMK method of order 8 in mpmath numbers, coefficients and all."""
    problem, y0 = cases("action")[index]
    table = RUNGE_KUTTA["dop853"]
    plain = plain_start(gi.RKMK(table, coordinates=coordinates), problem, y0)
    stepper = extended(plain, mp.mpf, mp.mpf(T_END) / steps)
    numbers = [x for row in (*table.A, table.b, table.c) for x in row]
    exact = [mp.mpf(x.numerator) / x.denominator for x in numbers]
    data = stepper.coefficients.data
    assert np.allclose(data[-len(exact) :].astype(float), np.array(exact, dtype=float))
    data[-len(exact) :] = exact
    return end_of(stepper, steps)


@pytest.mark.parametrize(
    "index", [pytest.param(0, id="SO(3)"), pytest.param(1, id="SO(4)", marks=pytest.mark.nightly)]
)
def test_rkmk_of_order_8_in_many_digits(index: int) -> None:
    """Both coordinates, closed form and series; the Cayley map is rational, exact to all digits.

    The truth is the method in the other coordinates at half the step.
    """
    counts = (12, 14, 17)
    with mp.workdps(30):
        truth = rkmk_end("cayley", index, 34)
        for coordinates in ("exp", "cayley"):
            ends = [rkmk_end(coordinates, index, n) for n in counts]
            errors = [max(abs(x - y) for x, y in zip(e, truth, strict=True)) for e in ends]
            found = slopes(counts, errors)
            assert found == pytest.approx([8] * 2, abs=0.2), (coordinates, found)
        assert np.max(np.abs(np.array(truth, dtype=float) - reference(index, "action"))) < 1e-11


def test_every_method_is_measured() -> None:
    """Nothing in the registry is left out: adaptive methods are measured in test_adaptive."""
    in_digits = [*(f"gauss-{s}" for s in range(5, 17)), *(f"lobatto-{s}" for s in (6, 7, 8))]
    assert set(NAMES) == {*IN_FLOAT64, *IN_LONGDOUBLE, *in_digits}


# --- what must fail -------------------------------------------------------------------------------


def spoiled(table: Any, name: str, change: Fraction) -> Any:
    """A tableau whose last two weights differ by a bit; the sum is kept."""
    values = list(getattr(table, name))
    values[-1] += change
    values[-2] -= change
    return replace(table, **{name: tuple(values)})


@pytest.mark.parametrize(
    ("method", "order"),
    [
        (gi.RungeKutta(spoiled(RUNGE_KUTTA["rk-4"], "b", Fraction(1, 1000))), 4),
        (gi.RKMK(spoiled(RUNGE_KUTTA["rk-4"], "b", Fraction(1, 1000))), 4),
        (gi.RungeKutta(replace(RUNGE_KUTTA["kutta-3"], order=4)), 4),
    ],
    ids=["weights", "weights in the algebra", "a wrong claim"],
)
def test_a_spoiled_tableau_is_noticed(method: gi.Method, order: int) -> None:
    """A thousandth of a weight."""
    found = measured(method, method.needs, 0, COUNTS[order], floor=0.0)
    assert found != pytest.approx([order] * 2, abs=0.2)


def test_a_spoiled_exponential_is_noticed() -> None:
    """With its two exponentials merged the method is of order 4 only if everything commutes."""
    table = COMMUTATOR_FREE["cf-4"]
    start, exponentials = table.update
    merged = tuple(sum(column) for column in zip(*exponentials, strict=True))
    spoilt = replace(table, update=type(table.update)(start, (merged,)))
    for index in range(2):
        found = measured(gi.CommutatorFree(spoilt), "action", index, COUNTS[4], floor=0.0)
        assert found != pytest.approx([4] * 2, abs=0.2)


def test_a_truncated_bracket_series_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """RKMK without its commutators."""
    monkeypatch.setattr(rkmk, "dexpinv_weights", lambda terms: [Fraction(1)])
    found = measured(gi.RKMK("rk-4"), "action", 1, COUNTS[4], floor=0.0)
    assert found != pytest.approx([4] * 2, abs=0.2)


@pytest.mark.parametrize("tableau", ["bogacki-shampine-3", "rk-4", "dormand-prince-5", "dop853"])
def test_the_series_is_as_long_as_the_order_needs(
    tableau: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With one term less, the order is lost; SO(4) has no closed form."""
    order = RUNGE_KUTTA[tableau].order
    weights = rkmk.dexpinv_weights
    counts = COUNTS[order] if order < 8 else (16, 23, 32)

    def shorter(terms: int) -> list[Fraction]:
        complete = weights(terms)
        return complete[: max(k for k, w in enumerate(complete) if w)]

    monkeypatch.setattr(rkmk, "dexpinv_weights", shorter)
    found = measured(gi.RKMK(tableau), "action", 1, counts, floor=0.0)
    assert max(found) < order - 0.3, found


@gi.helper
def backwards(layout, u, v, out, work):
    """dexp⁻¹ of SO(3) with B_1 = +1/2: that of right actions."""
    out[0] = v[0] + 0.5 * (u[1] * v[2] - u[2] * v[1])
    out[1] = v[1] + 0.5 * (u[2] * v[0] - u[0] * v[2])
    out[2] = v[2] + 0.5 * (u[0] * v[1] - u[1] * v[0])


@pytest.mark.parametrize("coordinates", ["exp", "cayley"])
def test_the_wrong_side_is_noticed(coordinates: str) -> None:
    """With the sign of the bracket changed, all orders above 1 are lost."""
    problem, y0 = cases("action")[0]
    group = replace(problem.action.group, dexpinv=backwards, dcayinv=backwards)
    wrong = replace(problem, action=replace(problem.action, group=group))
    exact = reference(0, "action")
    ends = [
        gi.solve(
            wrong,
            y0,
            t_end=T_END,
            step=T_END / n,
            method=gi.RKMK(coordinates=coordinates),
            compiled=False,
        )
        for n in (64, 128)
    ]
    errors = [np.max(np.abs(end.y[-1] - exact)) for end in ends]
    assert slopes((64, 128), errors)[0] < 2.5


def test_a_spoiled_composition_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ten-thousandth of one fraction."""
    good = COMPOSITIONS["suzuki-4"]
    first, second = good.fractions
    bad = Composition("bad-4", 4, 2, (str(float(first) + 1e-4), second))
    monkeypatch.setitem(COMPOSITIONS, "bad-4", bad)
    for base, form in ((gi.Gauss(1), "field"), (gi.Rattle(), "hamiltonian")):
        found = measured(gi.Compose(base, "bad-4"), form, 0, COUNTS[4], floor=0.0)
        assert found != pytest.approx([4] * 2, abs=0.2)


@pytest.mark.nightly
def test_a_spoiled_node_is_noticed() -> None:
    """The 34th digit of a Gauss node."""
    with mp.workdps(60):
        change = mp.mpf(10) ** -34
    found = gauss_slopes(12, (14, 15, 16), change)
    assert found != pytest.approx([24] * 2, abs=0.2)
