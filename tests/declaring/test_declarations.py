"""What a problem declares is held to what its functions do: before anything is computed."""

from __future__ import annotations

import dataclasses
import inspect
import math
import warnings
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.declaration import FEW, check_problem, check_watched
from geomint.problems.evaluate import rates_of

pytestmark = pytest.mark.nojit

# --- right problems, one of each form -------------------------------------------------------------


def oscillator(params, t, y, out, work):
    work[0] = params[0] * y[0]
    out[0] = y[1]
    out[1] = -work[0]


def energy(params, t, y, work):
    return 0.5 * (params[0] * y[0] * y[0] + y[1] * y[1])


energy_there = gi.helper(energy)


def rate(params, t, y, work):
    return 1.0 + 0.0 * y[0]


def level(params, t, y, out, work):
    out[0] = energy_there(params, t, y, work) - 0.5


def turning(params, t, y, out, work):
    """Generator of SO(3)."""
    out[0] = -params[0] * y[0]
    out[1] = -2.0 * params[0] * y[1]
    out[2] = -3.0 * params[0] * y[2]


def shift(layout, xi, y, out, work):
    """Act by a translation along each of two axes."""
    for i in range(2):
        out[i] = layout[0] * xi[i]


def commute(layout, x, y, out, work):
    work[0] = 0.0 * x[0]
    for i in range(2):
        out[i] = work[0] * y[i]


def plain(layout, u, v, out, work):
    for i in range(2):
        out[i] = v[i]


def reach(layout, u, work):
    return 0.0 * u[0]


def drift_along(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -params[0] * y[0]


def slopes(params, t, q, p, dq, dp, work):
    for i in range(2):
        dq[i] = 0.0 * q[i]
        dp[i] = 1.0 * p[i]
    dq[1] = params[0] + 0.0 * q[0]


def circle(params, q, g, G, work):
    g[0] = q[0] * q[0] + q[1] * q[1] - 1.0
    G[0] = 2.0 * q[0]
    G[1] = 2.0 * q[1]


def kick_and_drift(k, params, t, h, y, out, work):
    if k == 0:
        out[0] = h * y[1]
        out[1] = 0.0 * h
    else:
        out[0] = 0.0 * h
        out[1] = -h * params[0] * y[0]


GROUP = gi.Group(
    "R^2",
    2,
    [1.0],
    gi.helper(shift),
    gi.helper(commute),
    1,
    cayley=gi.helper(shift),
    dexpinv=gi.helper(plain),
    dcayinv=gi.helper(plain),
    extent=gi.helper(reach),
)


def fielded(field: Any = oscillator, **changes: Any) -> gi.Problem:
    """Return the oscillator with everything that can be watched, in τ."""
    options = {
        "name": "fielded",
        "pieces": (("q", 1), ("p", 1)),
        "params": [1.0],
        "field": gi.field(field),
        "work": 1,
        "time": "tau",
        "clock": gi.observable(rate),
        "invariants": {"energy": gi.observable(energy)},
        "measure": gi.Measure(gi.observable(rate), gi.field(level), 1),
    }
    return gi.Problem(**{**options, **changes})


def acted(generator: Any = turning, group: gi.Group | None = None) -> gi.Problem:
    """Return a body that turns one vector."""
    action = gi.GroupAction(gi.field(generator), group or gi.so3(1))
    return gi.Problem("acted", (("m", 3),), [1.0], action=action)


def shifted(generator: Any = drift_along, **functions: Any) -> gi.Problem:
    """Return the oscillator under a group of one's own."""
    recorded = {k: gi.helper(f) if callable(f) else f for k, f in functions.items()}
    group = dataclasses.replace(GROUP, **recorded)
    return gi.Problem(
        "shifted", (("y", 2),), [1.0], action=gi.GroupAction(gi.field(generator), group)
    )


def swinging(gradients: Any = slopes, constraint: Any = circle, **form: Any) -> gi.Problem:
    """Return the pendulum in the plane."""
    options = {"constraints": 1, "separable": True, **form}
    hamiltonian = gi.Hamiltonian(gi.field(gradients), gi.field(constraint), **options)
    return gi.Problem("swinging", (("q", 2), ("p", 2)), [1.0], hamiltonian=hamiltonian)


def split(flow: Any = kick_and_drift, parts: Any = 2) -> gi.Problem:
    """Return the oscillator as kick and drift."""
    return gi.Problem("split", (("y", 2),), [1.0], splitting=gi.Splitting(gi.helper(flow), parts))


# --- functions with one mistake -------------------------------------------------------------------


def changed(f: Callable[..., Any], line: str, *, before: bool = False) -> Callable[..., Any]:
    """Return the function with one more line at its end, or at its beginning."""
    code = f.__code__
    names = code.co_varnames[: code.co_argcount]
    call = f"    result = _own({', '.join(names)})"
    lines = [f"    {line}", call] if before else [call, f"    {line}"]
    text = "\n".join([f"def {f.__name__}({', '.join(names)}):", *lines, "    return result"])
    space = {"_own": gi.helper(f), "gi": gi, "part": gi.part, "math": math}
    exec(text, space)
    return space[f.__name__]


def edited(f: Callable[..., Any], old: str, new: str = "_ =") -> Callable[..., Any]:
    """Return the function with another text in its source: nothing that is written, by default."""
    space = dict(f.__globals__)
    exec(inspect.getsource(f).replace(old, new), space)
    return space[f.__name__]


def nothing(*arguments):
    pass


def too_few(t, y):
    return -y[0]


def no_number(params, t, y, work):
    work[0] = y[0]


def a_block(params, t, y, work):
    return y


def returning(params, t, y, out, work):
    return y[0]


right_flow = gi.helper(kick_and_drift)


def one_part_of_three(k, params, t, h, y, out, work):
    if k < 2:
        right_flow(k, params, t, h, y, out, work)


Y2, Y3, Y4 = [1.0, 0.5], [0.6, 0.0, 0.8], [1.0, 0.0, 0.0, 0.5]
STATES = {"fielded": Y2, "acted": Y3, "shifted": Y2, "swinging": Y4, "split": Y2}
METHODS = {"field": "rk-4", "action": "rkmk-4", "hamiltonian": "rattle-2", "splitting": "verlet-2"}


def field(line: str, **more: Any) -> gi.Problem:
    """The oscillator, whose field has one more line."""
    return fielded(changed(oscillator, line, **more))


def measured(f: Any, conditions: int = 1, **more: Any) -> gi.Problem:
    return fielded(measure=gi.Measure(gi.observable(rate), gi.field(f), conditions), **more)


def grouped(**changes: Any) -> gi.Problem:
    return acted(group=dataclasses.replace(gi.so3(1), **changes))


# What is wrong, and of the error: function, block, index, size; "-" for none.
WRONG = [
    # fields
    (field("out[-2] = y[1]"), "field out -2 2"),
    (field("out[2] = y[1]"), "field out 2 2"),
    (field("out[0] = y[-1]"), "field y -1 2"),
    (field("out[0] = y[2]"), "field y 2 2"),
    (field("out[0] = params[-1]"), "field params -1 1"),
    (field("out[0] = params[1]"), "field params 1 1"),
    (field("work[1] = y[0]"), "field work 1 1"),
    (fielded(work=0), "field work 0 0"),
    (field("out[0] = part(y, 1, 1)[1]"), "field y 2 2"),
    (field("out[0] = part(part(y, 0, 2), 0, 1)[1]"), "field y 1 2"),
    (field("part(out, -1, 1)"), "field out -1 2"),
    (field("y[0] = 2.0"), "field y 0 2"),
    (field("part(y, 1, 1)[0] = 2.0"), "field y 1 2"),
    (field("params[0] = 2.0"), "field params 0 1"),
    (fielded(edited(oscillator, "out[1] =")), "field out 1 2"),
    (fielded(edited(oscillator, "out[0] =")), "field out 0 2"),
    (field("out[0] = 0.0 * out[1]", before=True), "field out 1 2"),
    (field("out[0] = work[0]", before=True), "field work 0 1"),
    (field("out[0] = None"), "field out 0 2"),
    (field("out[1] = y"), "field out 1 2"),
    (fielded(returning), "field out 0 2"),
    (fielded(too_few), "field - - -"),
    (field("out[0] = gravity"), "field - - -"),
    (field("out[0] = y[0.5]"), "field y - 2"),
    (fielded(pieces=(("q", 1),), measure=None), "field y 1 1"),
    (fielded(params=[]), "field params 0 0"),
    # functions that return a number
    (fielded(clock=gi.observable(no_number)), "clock - - -"),
    (fielded(clock=gi.observable(changed(rate, "y[-1]"))), "clock y -1 2"),
    (fielded(invariants={"e": gi.observable(a_block)}), "invariants['e'] - - -"),
    (fielded(constraints={"c": gi.observable(changed(energy, "y[2]"))}), "constraints['c'] y 2 2"),
    (
        fielded(observables={"o": gi.observable(changed(energy, "work[0]"))}, work=1),
        "observables['o'] work 0 1",
    ),
    (fielded(observables={"o": gi.field(oscillator)}), "observables['o'] - - -"),
    # the measure
    (
        fielded(measure=gi.Measure(gi.observable(changed(rate, "params[3]")))),
        "measure.log_density params 3 1",
    ),
    (measured(changed(level, "out[1] = 1.0")), "measure.manifold out 1 1"),
    (measured(edited(level, "out[0] =")), "measure.manifold out 0 1"),
    # actions
    (acted(changed(turning, "out[0] = y[-3]")), "action.generator y -3 3"),
    (acted(changed(turning, "out[3] = y[0]")), "action.generator out 3 3"),
    (acted(edited(turning, "out[2] =")), "action.generator out 2 3"),
    (acted(group=gi.so3(2)), "action.group y 6 3"),
    (acted(group=gi.so_n(3, "frame")), "action.group y 9 3"),
    (acted(group=dataclasses.replace(gi.so_n(3, "vector"), work=3)), "action.group work 57 3"),
    (grouped(algebra_rows=4), "action.generator out 3 4"),
    (shifted(act=changed(shift, "out[2] = xi[0]")), "action.group.act out 2 2"),
    (shifted(act=edited(shift, "range(2)", "range(1)")), "action.group.act out 1 2"),
    (shifted(act=changed(shift, "out[0] = layout[1]")), "action.group.act layout 1 1"),
    (shifted(cayley=changed(shift, "y[0] = 1.0")), "action.group.cayley y 0 2"),
    (shifted(bracket=changed(commute, "x[-1]")), "action.group.bracket x -1 2"),
    (shifted(work=0), "action.group.bracket work 0 0"),
    (shifted(dexpinv=edited(plain, "range(2)", "range(1, 2)")), "action.group.dexpinv out 0 2"),
    (shifted(dcayinv=changed(plain, "u[2]")), "action.group.dcayinv u 2 2"),
    (shifted(extent=nothing), "action.group.extent - - -"),
    # Hamiltonians
    (swinging(changed(slopes, "dq[0] = q[2]")), "hamiltonian.gradients q 2 2"),
    (swinging(changed(slopes, "dp[-1] = p[0]")), "hamiltonian.gradients dp -1 2"),
    (swinging(edited(slopes, "dp[i]", "dp[0]")), "hamiltonian.gradients dp 1 2"),
    (swinging(edited(slopes, "dq[i]", "dq[1]")), "hamiltonian.gradients dq 0 2"),
    (swinging(constraint=changed(circle, "g[0] = q[-1]")), "hamiltonian.constraint q -1 2"),
    (swinging(constraint=changed(circle, "g[1] = q[0]")), "hamiltonian.constraint g 1 1"),
    (swinging(constraint=edited(circle, "G[1] =")), "hamiltonian.constraint G 1 2"),
    (swinging(constraint=nothing), "hamiltonian.constraint g 0 1"),
    (swinging(changed(slopes, "dq[0] = q[0] * p[0]")), "hamiltonian.gradients dq 0 2"),
    (
        swinging(changed(slopes, "dp[1] = p[1] * (1.0 + q[0] * q[0])")),
        "hamiltonian.gradients dp 1 2",
    ),
    (swinging(changed(slopes, "dp[0] = p[0] * p[0]")), "hamiltonian.gradients dp 0 2"),
    # splittings
    (split(changed(kick_and_drift, "out[-1] = h")), "splitting.flow of part 0 out -1 2"),
    (split(edited(kick_and_drift, "out[1] =")), "splitting.flow of part 0 out 1 2"),
    (split(one_part_of_three, 3), "splitting.flow of part 2 out 0 2"),
    (split(parts=3), "splitting.flow parts 2 3"),
    (split(oscillator), "splitting.flow of part 0 - - -"),
]


def ends(problem: gi.Problem) -> dict[str, float]:
    return {"tau_end" if problem.time == "tau" else "t_end": 1.0}


@pytest.mark.parametrize(("problem", "wrong"), WRONG, ids=[wrong for _, wrong in WRONG])
def test_what_does_not_fit(problem: gi.Problem, wrong: str) -> None:
    """With or without a step, compiled or not: the function, the row and the number of rows."""
    y0 = np.resize(STATES[problem.name], problem.rows)
    for options in ({"step": 0.1}, {}, {"step": 0.1, "compiled": False}):
        with pytest.raises(gi.DeclarationError) as caught:
            gi.solve(problem, y0, method=METHODS[problem.forms[0]], **ends(problem), **options)
        error = caught.value
        found = (error.function, error.block, error.index, error.size)
        assert " ".join("-" if x is None else str(x) for x in found) == wrong, str(error)
        assert error.problem == problem.name
        assert "\n" not in str(error)


# --- declarations that no function is needed for --------------------------------------------------

RECORDED = gi.field(nothing)


NO_FIELDS = [
    *(("work", x) for x in (1.5, -1, True)),
    *(("pieces", x) for x in ((("y", 1), ("y", 1)), ((0, 1), (1, 1)), (("y", 2.0),), ("y", 2), 2)),
    *(("params", x) for x in ([[1.0], [2.0]], ["one"], [1j])),
    *(("name", 3), ("clock", rate), ("physical", 3), ("parameters", 3)),
    *(("units", 3), ("space", 3), ("constraints", 3), ("work", 1 << 40)),
    *(("observables", {x: gi.observable(energy)}) for x in ("energy", "all")),
    ("observables", [gi.observable(energy)]),
    ("constraints", {1: gi.observable(energy)}),
    *(
        ("measure", gi.observable(energy)),
        ("action", GROUP),
        ("hamiltonian", gi.observable(slopes)),
    ),
    ("splitting", gi.observable(kick_and_drift)),
]
WORK = ("rows", "work")
NO_GROUPS = {
    "act": shift, "algebra_rows": 0, "layout": [math.nan], "inline": "yes", "name": 3, "work": -1,
    "bracket": commute, "cayley": shift, "extent": reach, "rows": -1,
}  # fmt: skip


@pytest.mark.parametrize(
    ("make", "name"),
    [
        *((lambda name=name, x=x: fielded(**{name: x}), name) for name, x in NO_FIELDS),
        (lambda: fielded(invariants={"e": energy}), "invariants['e']"),
        (lambda: gi.Problem("p", (("y", 2),), field=oscillator), "field"),
        (lambda: gi.Problem("p", (("y", 2),), field=RECORDED, clock=RECORDED), "clock"),
        (lambda: gi.Measure(gi.observable(rate), gi.field(level)), "conditions"),
        (lambda: gi.Measure(gi.observable(rate), None, 1), "conditions"),
        (lambda: gi.Measure(rate), "log_density"),
        (lambda: fielded(measure=gi.Measure(RECORDED, RECORDED, 2)), "conditions"),
        *((lambda x=x: split(parts=x), "parts") for x in (1, 2.0)),
        (lambda: gi.Splitting(kick_and_drift, 2), "flow"),
        (lambda: gi.Splitting(RECORDED, 2, symplectic=1), "symplectic"),
        *((lambda x=x: swinging(constraints=x), "constraints") for x in (0, 2, 1.0)),
        (lambda: swinging(separable="yes"), "separable"),
        (lambda: gi.Hamiltonian(slopes, RECORDED, 1), "gradients"),
        (lambda: dataclasses.replace(swinging(), pieces=(("q", 2), ("p", 1))), "pieces"),
        (lambda: gi.GroupAction(RECORDED, "SO(3)"), "group"),
        (lambda: gi.GroupAction(turning, gi.so3(1)), "generator"),
        *((lambda x=x: gi.so3(x), "vectors") for x in (1.5, 0)),
        *((lambda x=x: gi.so_n(x), "n") for x in (3.0, 1)),
        (lambda: gi.translations(0), "m"),
        (lambda: gi.Measure(RECORDED, RECORDED, -1), "conditions"),
        (lambda: gi.SymplecticForm(nothing), "form"),
        (lambda: gi.SymplecticForm(RECORDED, constant=1), "constant"),
        *((lambda n=n: gi.pointwise(RECORDED, [], [[1.0]], **{"rows": 1, n: -1}), n) for n in WORK),
        *(
            (lambda name=name, x=x: dataclasses.replace(GROUP, **{name: x}), name)
            for name, x in NO_GROUPS.items()
        ),
    ],
)
def test_numbers_and_kinds(make: Callable[[], Any], name: str) -> None:
    """Refused when the problem, or the form, is made."""
    with pytest.raises(gi.DomainError) as caught:
        make()
    assert caught.value.name == name
    assert "\n" not in str(caught.value)


def test_a_clock_that_is_missing() -> None:
    """A problem in τ without one runs to an end in τ alone, and says so."""
    problem = fielded(clock=None)
    run = {"method": "rk-4", "step": 0.1, "compiled": False}
    for options in ({"t_end": 1.0}, {"tau_end": 1.0, "clock": True}):
        with pytest.raises(gi.FormError, match=r"no clock dt/dτ.*tau_end with clock=False"):
            gi.solve(problem, Y2, **run, **options)
    assert gi.solve(problem, Y2, tau_end=1.0, **run).success


def test_a_state_that_admit_spoils() -> None:
    """What it returns is a state, of the same length."""
    for spoilt in (lambda y: None, lambda y: y[:1], lambda y: y * math.nan):
        with pytest.raises(gi.DomainError, match="state"):
            fielded(admit=spoilt).canonical(Y2)


# --- every way in ---------------------------------------------------------------------------------


def test_observed_functions() -> None:
    """Of the user's own: by the name that they are given."""
    for f in (changed(energy, "y[-1]"), gi.observable(changed(energy, "y[-1]"))):
        with pytest.raises(gi.DeclarationError, match=r"observe\['mine'\].*row -1 of y"):
            gi.solve(fielded(), Y2, tau_end=1.0, method="rk-4", step=0.1, observe={"mine": f})


def test_values_and_derivatives() -> None:
    """`geomint.value` and `geomint.derivative` check what they evaluate, also by name."""
    bad = gi.observable(changed(energy, "y[-1]"))
    problem = fielded(invariants={"bad": bad})
    for f in ("bad", bad):
        with pytest.raises(gi.DeclarationError, match=r"invariants\['bad'\].*row -1 of y"):
            gi.value(problem, f, np.array(Y2))
    assert gi.value(problem, energy, Y2) == gi.value(problem, gi.observable(energy), np.array(Y2))
    with pytest.raises(gi.DeclarationError, match=r"energy of problem .fielded. .*row 9 of y"):
        gi.value(problem, changed(energy, "y[9]"), Y2)
    with pytest.raises(gi.DomainError, match="a function recorded"):
        gi.value(problem, 3, Y2)
    with pytest.raises(gi.DeclarationError, match="never writes row 1 of out"):
        gi.derivative(fielded(edited(oscillator, "out[1] =")), np.array(Y2))
    for evaluate in (
        lambda y: gi.value(fielded(), "energy", y),
        lambda y: gi.derivative(fielded(), y),
    ):
        for y in (np.ones(1), np.ones(3), np.ones((2, 1))):
            with pytest.raises(gi.DomainError, match="a state of 2 numbers"):
                evaluate(y)
    for t in ("late", None, [1.0, 2.0]):
        with pytest.raises(gi.DomainError, match="t = "):
            gi.value(fielded(), "energy", Y2, t)


def test_derivatives_are_those_of_their_state() -> None:
    """What the check has evaluated serves its own state and time, and is nobody else's to change."""
    fresh, y, z = fielded(), np.array(Y2), np.array([0.3, -0.2])
    first = gi.derivative(fresh, y)
    first[0] = 7.0
    np.testing.assert_array_equal(gi.derivative(fresh, y), [0.5, -1.0])
    np.testing.assert_array_equal(gi.derivative(fresh, z), [-0.2, -0.3])

    def forced(params, t, y, out, work):
        out[0] = y[1] * (1.0 + t)
        out[1] = -y[0]

    timed = fielded(forced)
    assert gi.derivative(timed, y)[0] == 0.5
    assert gi.derivative(timed, y, 2.0)[0] == 1.5
    slopes = [gi.jacobian(timed, y, *t)[0, 1] for t in ((), (2.0,))]
    assert slopes == pytest.approx([1.0, 3.0])
    other = dataclasses.replace(timed, params=[2.0], field=gi.field(oscillator))
    np.testing.assert_array_equal(gi.derivative(other, y), [0.5, -2.0])


@pytest.mark.parametrize(
    ("f", "says"),
    [
        (changed(oscillator, "out[0] = y[-1]"), "oscillator reads row -1 of x"),
        (edited(oscillator, "out[1] ="), "never writes row 1 of out, which has 2 rows"),
        (changed(oscillator, "out[2] = 1.0"), "writes row 2 of out"),
        (too_few, "takes"),
    ],
)
def test_functions_at_points(f: Callable[..., Any], says: str) -> None:
    """As `geomint.pointwise` is given sizes."""
    with pytest.raises(gi.DeclarationError, match=says) as caught:
        gi.pointwise(gi.field(f), [1.0], np.ones((5, 2)), 2, 1)
    assert caught.value.problem is None
    with pytest.raises(gi.DomainError, match="rows"):
        gi.pointwise(gi.field(f), [1.0], np.ones((5, 2)), 2.5, 1)


# --- what is not refused --------------------------------------------------------------------------


def test_what_depends_on_the_state() -> None:
    """A number that is not finite, or a division by zero, is for the run to tell; quietly."""

    def poles(params, t, y, out, work):
        out[0] = 1.0 / y[1]
        out[1] = gi.sqrt(-y[0]) + math.log10(y[0]) + 1.0 / float(y[1])

    problem = gi.Problem("poles", (("y", 2),), field=gi.field(poles))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for y0 in ([1.0, 0.0], [0.0, 0.0]):
            check_problem(problem, np.array(y0), "field")

    def past_the_end(params, t, y, out, work):
        out[0] = y[5]
        out[1] = 1.0 / float(y[1])

    problem = gi.Problem("past", (("y", 2),), field=gi.field(past_the_end))
    with pytest.raises(gi.DeclarationError, match="row 5 of y"):
        check_problem(problem, np.array([1.0, 0.0]), "field")


def test_parts_at_rest() -> None:
    """Parts that move nothing from here are not the same part; that would show elsewhere."""
    check_problem(split(), np.zeros(2), "splitting")

    def two_that_rest(k, params, t, h, y, out, work):
        for i in range(2):
            out[i] = h * y[i] if k == 0 else 0.0 * h

    check_problem(split(two_that_rest, 3), np.array(Y2), "splitting")


def test_large_problems_are_checked_where_they_are_used() -> None:
    """All functions of one may take minutes in plain Python."""
    rows, calls = FEW + 1, deque()

    def many(params, t, y, out, work):
        for i in range(rows):
            out[i] = -y[i]

    def counted(params, t, y, work):
        calls.append(1)
        return y[-1] if len(y) > 1 else 0.0

    problem = gi.Problem(
        "many", (("y", rows),), field=gi.field(many), invariants={"bad": gi.observable(counted)}
    )
    run = {"t_end": 0.1, "method": "rk-4", "step": 0.1, "compiled": False}
    assert gi.solve(problem, np.ones(rows), **run).success
    assert len(calls) == 0
    with pytest.raises(gi.DeclarationError, match=r"invariants\['bad'\].*row -1 of y"):
        gi.solve(problem, np.ones(rows), observe="invariants", **run)


def test_once() -> None:
    """A problem is checked once, not in every run, and what failed fails again."""
    calls: deque[int] = deque()

    def counted(params, t, y, work):
        calls.append(1)
        return 0.0 * y[0]

    problem = fielded(observables={"counted": gi.observable(counted)})
    for _ in range(3):
        check_problem(problem, np.array(Y2), "field")
        check_problem(problem, np.array([0.1, 0.2]), "field", True)
        check_watched(problem, np.array([0.1, 0.2]), problem.diagnostics)
    assert len(calls) == 1
    check_problem(dataclasses.replace(problem, params=[2.0]), np.array(Y2), "field")
    assert len(calls) == 2


# (what makes the problem from a function, that function, a block that it reads, state, form)
READING = [
    (fielded, oscillator, "y", Y2, "field"),
    (lambda f: fielded(clock=gi.observable(f)), rate, "y", Y2, "field"),
    (lambda f: fielded(invariants={"e": gi.observable(f)}), energy, "y", Y2, "field"),
    (lambda f: fielded(measure=gi.Measure(gi.observable(f))), rate, "y", Y2, "field"),
    (
        lambda f: fielded(measure=gi.Measure(gi.observable(rate), gi.field(f), 1)),
        *(level, "y", Y2, "field"),
    ),
    (acted, turning, "y", Y3, "action"),
    (shifted, drift_along, "y", Y2, "action"),
    (lambda f: shifted(act=f), shift, "y", Y2, "action"),
    (lambda f: shifted(cayley=f), shift, "xi", Y2, "action"),
    (lambda f: shifted(bracket=f), commute, "x", Y2, "action"),
    (lambda f: shifted(dexpinv=f), plain, "u", Y2, "action"),
    (lambda f: shifted(dcayinv=f), plain, "v", Y2, "action"),
    (lambda f: shifted(extent=f), reach, "u", Y2, "action"),
    (swinging, slopes, "p", Y4, "hamiltonian"),
    (lambda f: swinging(constraint=f), circle, "q", Y4, "hamiltonian"),
    (split, kick_and_drift, "y", Y2, "splitting"),
]


@pytest.mark.parametrize("case", range(len(READING)))
def test_every_function_is_checked_again_after_a_change(case: int) -> None:
    """It reads a row whose number is a global: right, then not, then right again."""
    make, f, block, y0, form = READING[case]
    reading = changed(f, f"{block}[ROW]")
    space = reading.__globals__
    space["ROW"] = 1
    problem = make(reading)

    def check() -> None:
        check_problem(problem, np.array(y0), form, problem.clock is not None)
        check_watched(problem, np.array(y0), watched)

    watched = {**problem.diagnostics}
    if problem.measure is not None:
        watched["measure"] = problem.measure
    check()
    for row in (-1, 5):
        space["ROW"] = row
        for _ in range(2):
            with pytest.raises(gi.DeclarationError, match=f"reads row {row} of {block}"):
                check()
    space["ROW"] = 0
    check()


@pytest.mark.parametrize("n", [2, 3, 5])
def test_own_groups_take_states_of_their_own_length(n: int) -> None:
    """Neither one row more nor one less."""
    pieces = gi.so_n(n, "vector", "adjoint", "frame", "vector") * gi.translations(n - 1)
    size = n * (n - 1) // 2
    groups = [(pieces, size + n - 1, 3 * n - 1 + size + n * n), (gi.so3(n), 3, 3 * n)]

    def still(params, t, y, out, work):
        for i in range(len(out)):
            out[i] = 0.0 * y[0]

    for group, algebra, rows in groups:
        assert group.algebra_rows == algebra
        for off in (0, -1, 1):
            action = gi.GroupAction(gi.field(still), group)
            problem = gi.Problem("any", (("y", rows + off),), action=action)
            if off == 0:
                assert not gi.derivative(problem, np.ones(rows)).any()
            else:
                with pytest.raises(gi.DeclarationError, match="act"):
                    gi.derivative(problem, np.ones(rows + off))


# --- far off the motion ---------------------------------------------------------------------------


@gi.helper
def counted(y):
    k = 0
    while y > k:
        k += 1
    return k


@pytest.mark.parametrize(
    "number",
    [
        *("params[int(y[0])]", "params[counted(y[0])]", "params[64 if y[0] == 67.0 else 0]"),
        *("params[int(t)]", "gi.select(abs(y[0]) > 2.0, gi.sqrt(params[3]), gi.sin(t) ** 2)"),
    ],
)
def test_rows_are_checked_where_they_depend_on_numbers(number: str) -> None:
    """Time scales look far off the motion, where there may be no such row."""
    space: dict[str, Any] = {"gi": gi, "counted": counted}
    exec(f"def f(params, t, y, out, work):\n    out[0] = {number} + 0.0 * y[0]", space)
    problem = gi.Problem("table", (("x", 1),), params=np.ones(64), field=gi.field(space["f"]))
    rates, far = rates_of(problem, np.ones(1)), np.array([67.0])
    assert rates(problem, np.ones(1), 0.0) == gi.derivative(problem, np.ones(1))
    if "select" in number:  # a formula
        np.testing.assert_array_equal(rates(problem, far, 1.0), gi.derivative(problem, far, 1.0))
    else:
        with pytest.raises(IndexError):
            rates(problem, far, 67.0)
