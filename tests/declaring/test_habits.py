"""What users of other solvers write out of habit: refused by name, with what to write instead."""

from __future__ import annotations

import enum
import functools
import math
import random
import time  # noqa: F401 - one of the habits
import types
from typing import Any

import numpy as np
import pytest
from numba.core import config

import geomint as gi

pytestmark = pytest.mark.nojit

TABLE, RATES, CONSTANTS = [1.0, 2.0], {"k": 1.0}, np.array([1.0, 2.0])
PAIR = (1.0, (2.0, 3.0))
OBJECT, GENERATOR = types.SimpleNamespace(k=1.0), random.Random(1)


class Rates:
    k = 1.0


class Row(enum.IntEnum):
    q = 0
    p = 1


@gi.helper
def added(a, b):
    return a + b


@gi.helper
def of_three(a, b):
    return added(*(a, b)) * PAIR[1][0]


def plain_helper(a):
    return 2.0 * a


# --- functions ------------------------------------------------------------------------------------

# A line of a field, and what its error says.
HABITS = {
    "out[1] = -math.sin(y[0])": "calls math.sin: write gi.sin",
    "out[1] = -np.sin(y[0])": "calls np.sin: write gi.sin",
    "out[1] = math.atan2(y[1], y[0])": r"calls math.atan2: write gi\.atan2 \(",
    "out[1] = np.power(y[0], 3.0)": r"calls np.power: write gi\.pow \(",
    "out[1] = np.maximum(y[0], 0.0)": r"calls np.maximum: write gi\.maximum \(",
    "out[1] = gi.asinh(y[0])": r"No geomint attribute asinh, but gi\.sqrt, gi\.exp, .*gi\.atan2",
    "out[1] = -np.dot(y, y)": "calls np.dot: write loops over rows",
    "out[1] = np.array([y[0], y[1]])[0]": "calls np.array: write loops over rows",
    "out[1] = np.where(y[0] > 0.0, y[0], y[1])": "calls np.where: write gi.select",
    "out[1] = TABLE[0] * y[0]": "reads TABLE, a list: .*tuples, numpy arrays, or params",
    "out[1] = RATES['k'] * y[0]": "reads RATES, a dict: .*params",
    "out[1] = random.random()": "calls random.random: write arithmetic",
    "out[1] = time.time()": "calls time.time: write arithmetic",
    "out[1] = getattr(math, 'pi')": "calls getattr: write arithmetic",
    "out[1] = y[0]; del y": "deletes a variable",
    "out[1] = plain_helper(y[0])": r"calls plain_helper, a plain function: .*gi\.helper",
    "out[1] = y[0]; print(y[0])": "calls print: write observe=",
    "out[1] = float(format(y[0]))": "calls format: write arithmetic",
    "out[1] = [-y[0]][0]": r"makes a list, dict or set: .*out\[0\] = ",
    "out[1] = [2.0 * v for v in (y[0], y[1])][0]": "makes a list",
    "out[1] = sum(y[i] for i in range(2))": "has a generator: write a loop",
    "return [y[1], -y[0]]": "makes a list",
    "raise ValueError('too large')": "raises an exception: .*math.nan",
    "assert t < 1e9; out[1] = y[0]": "asserts: .*math.nan",
    "try: out[1] = 1.0 / y[0]\n    except ZeroDivisionError: pass": "has a try .*gi.select",
    "import math; out[1] = y[0]": "imports: do it outside",
    "out[1] = -y[:1][0]": r"reads a slice of y: rows are y\[i\] .*gi\.part\(y, start, rows\)",
    "out[:] = y": "writes a slice of out: rows are",
    "q, p = y": r"takes y apart: rows are y\[i\]",
    "for v in y: out[1] = v": r"takes y apart: rows are y\[i\]",
    "out[1] = sum(y)": r"takes y apart: rows are y\[i\]",
    "out[1] = (2.0 * y)[0]": "blocks .* have rows, no arithmetic",
    "out[1] = y.shape[0]": "blocks .* have rows, no arithmetic",
    "out[1] = params['k'] * y[0]": r"reads params\['k'\]: rows are counted by whole numbers",
    "out[1] = added(y[0])": "raises TypeError: .*added",
}
RIGHT = (
    "out[1] = math.pi * np.pi * y[0] + CONSTANTS[1] + PAIR[1][0]",
    "for i in range(len(y)): out[i] = -y[len(y) - 1 - i]",
    "out[1] = abs(gi.sin(y[0])) + of_three(*(y[0], y[1]))",
    "pair = (y[0], y[1]); out[1] = pair[0] * float(max(1, 2))",
    "out[Row.q] = y[Row.p]; out[Row.p] = -y[Row.q]",
    "double = lambda x: 2.0 * x; out[1] = double(y[0])",
)


def field_of(line: str) -> Any:
    space = dict(globals())
    exec(f"def habitual(params, t, y, out, work):\n    out[0] = y[1]\n    {line}\n", space)
    return gi.field(space["habitual"])


def oscillator(field: Any) -> gi.Problem:
    return gi.Problem("oscillator", (("y", 2),), [1.5], field=field)


@pytest.mark.parametrize("line", HABITS)
def test_a_habit_is_refused_whether_compiled_or_not(line: str) -> None:
    """One short line: the function, the line, and what to write; before anything is compiled."""
    said = []
    for compiled in (True, False):
        with pytest.raises(gi.DeclarationError, match=HABITS[line]) as caught:
            gi.solve(oscillator(field_of(line)), [0.5, 0.1], t_end=1.0, step=0.1, compiled=compiled)
        said.append(str(caught.value))
    assert said[0] == said[1]
    assert "(habitual, <string>:3)" in said[0]
    assert "\n" not in said[0]
    assert len(said[0]) < 250


def test_habits_of_helpers_and_observables() -> None:
    """Are found in whatever is reached, and named there."""

    @gi.helper
    def root(x):
        return math.sqrt(x)

    def through(params, t, y, out, work):
        out[0] = out[1] = root(y[0])

    with pytest.raises(gi.DeclarationError, match=r"calls math\.sqrt: write gi\.sqrt \(root, "):
        gi.solve(oscillator(gi.field(through)), [0.5, 0.1], t_end=1.0)
    right = oscillator(field_of(RIGHT[0]))
    distance = gi.observable(lambda params, t, y, work: np.sqrt(y[0]))
    for ask in (
        lambda: gi.solve(right, [0.5, 0.1], t_end=1.0, observe={"distance": distance}),
        lambda: gi.value(right, distance, [0.5, 0.1]),
    ):
        with pytest.raises(gi.DeclarationError, match=r"calls np\.sqrt: write gi\.sqrt"):
            ask()


@pytest.mark.parametrize("read", ["OBJECT.k", "Rates.k", "float(GENERATOR.random())"])
def test_objects_are_for_plain_python(read: str) -> None:
    """Counters and the like are a tool for finding errors; compiled code has none, and says so."""
    problem = oscillator(field_of(f"out[1] = {read}"))
    run = {"t_end": 0.1, "step": 0.1, "method": "rk-4"}
    assert gi.solve(problem, [0.5, 0.1], **run, compiled=False).success
    if not config.DISABLE_JIT:
        with pytest.raises(
            gi.GeomintError, match=r"(Rates|OBJECT|GENERATOR).*: (what it|expected)"
        ):
            gi.solve(problem, [0.5, 0.1], **run)


def test_what_is_no_function() -> None:
    """Is refused where it is recorded; what is asynchronous, where it is used."""
    for wrong in (functools.partial(plain_helper, 1.0), OBJECT.__eq__, math.sin, Rates, "f", None):
        for record in (gi.field, gi.observable, gi.helper):
            with pytest.raises(
                gi.DeclarationError, match="expected a Python function written with"
            ):
                record(wrong)

    async def later(params, t, y, out, work):
        out[0] = out[1] = 1.0

    for compiled in (True, False):
        with pytest.raises(gi.DeclarationError, match="is asynchronous: write def"):
            gi.solve(oscillator(gi.field(later)), [0.5, 0.1], t_end=1.0, compiled=compiled)


@pytest.mark.parametrize("line", RIGHT)
def test_what_is_no_habit(line: str) -> None:
    run = {"t_end": 0.1, "step": 0.1, "method": "rk-4"}
    ends = [
        gi.solve(oscillator(field_of(line)), [0.5, 0.1], **run, compiled=compiled).y[-1]
        for compiled in (True, False)
    ]
    np.testing.assert_array_equal(*ends)


def test_a_habit_is_looked_for_again_after_a_change() -> None:
    problem = oscillator(field_of("out[1] = CONSTANTS[0] * y[0]"))
    assert gi.derivative(problem, [0.5, 0.1])[1] == 0.5
    problem.field.function.__globals__["CONSTANTS"] = [1.0, 2.0]
    with pytest.raises(gi.DeclarationError, match="reads CONSTANTS, a list"):
        gi.derivative(problem, [0.5, 0.1])


# --- calls of solve -------------------------------------------------------------------------------

RIGHT_FIELD = field_of(RIGHT[0])
PROBLEM, Y0 = oscillator(RIGHT_FIELD), [0.5, 0.1]


def fun(t, y):
    return [y[1], -y[0]]


BY_NAME = "all further ones by name, such as t_end=20.0"
CALLS = [
    (
        (fun, (0, 20), Y0),
        {},
        r"takes a geomint\.Problem, not a function: .*params, t, y, out, work",
    ),
    ((fun, Y0), {"t_end": 1.0}, r"geomint\.field, and give geomint\.Problem\("),
    *(((PROBLEM, *given), {}, BY_NAME) for given in ((Y0, (0, 20)), ((0, 20), Y0), (Y0, 20.0))),
    ((PROBLEM,), {"t_end": 1.0}, "missing y0"),
    ((), {}, "missing a required argument: 'problem'"),
    ((PROBLEM, Y0), {"y0": Y0, "t_end": 1.0}, "multiple values for argument 'y0'"),
    (("oscillator", Y0), {"t_end": 1.0}, "problem = 'oscillator': expected a geomint.Problem"),
    ((), {"fun": fun, "t_span": (0, 1), "y0": Y0}, "'fun': write problem=.*'t_span': write t_end="),
    *(
        ((PROBLEM, Y0), {"t_end": 1.0, name: 1.0}, f"no '{name}'.*{said}")
        for name, said in {
            "t_span": "t_end=",
            "rtol": r"tolerance=.*Adaptive.*, rtol=",
            "atol": r"tolerance=.*Adaptive.*, atol=",
            "max_step": r"Adaptive.*, max_step=",
            "first_step": "step=",
            "dense_output": "dense=True",
            "args": "params=",
            "vectorized": "leave it out",
            "jac": "leave it out",
            "tend": "Did you mean 't_end'",
            "sav_every": "Did you mean 'save_every'",
            "metod": "Did you mean 'method'",
            "zzz": "Known: breaks, callback, clock, compiled",
        }.items()
    ),
]


@pytest.mark.parametrize(("args", "options", "says"), CALLS)
def test_calls_of_other_solvers(args: tuple, options: dict, says: str) -> None:
    """A typed error, that is a TypeError too, says how it is written here."""
    with pytest.raises(gi.ArgumentError, match=says) as caught:
        gi.solve(*args, **options)
    assert isinstance(caught.value, TypeError)
    assert isinstance(caught.value, gi.GeomintError)
    assert "\n" not in str(caught.value)


@gi.helper
def scaled(x, k=2.0):
    return k * x


@gi.helper
def endless(x):
    return endless(x) + x


@gi.field
def by_keyword(params, t, y, out, work):
    out[0] = scaled(y[1], k=1.0)
    out[1] = -scaled(k=0.5, x=y[0]) - 0.0 * scaled(y[0])


@gi.field
def of_no_end(params, t, y, out, work):
    out[0], out[1] = y[1], -endless(y[0])


def with_options(params, t, y, out, work, **options):
    out[0], out[1] = y[1], -y[0]


def with_a_keyword(params, t, y, out, work, *, k=2.0):
    out[0], out[1] = y[1], -k * y[0]


@pytest.mark.parametrize("is_compiled", [True, False])
def test_arguments_by_keyword(is_compiled: bool) -> None:
    """Helpers may be called so; fields take none, and a recursion without end is told."""
    arguments = {"t_end": 1.0, "step": 0.1, "method": "rk-4", "compiled": is_compiled}
    found = gi.solve(oscillator(by_keyword), Y0, **arguments).y[-1]
    same = gi.solve(oscillator(field_of("out[1] = -0.5 * y[0]")), Y0, **arguments).y[-1]
    np.testing.assert_allclose(found, same, rtol=0, atol=1e-14)
    for wrong, said in (
        *((gi.field(f), "keyword alone") for f in (with_options, with_a_keyword)),
        (of_no_end, "RecursionError"),
    ):
        with pytest.raises(gi.DeclarationError, match=said):
            gi.solve(oscillator(wrong), Y0, **arguments)
