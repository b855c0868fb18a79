"""Values are equal if they are made of the same; whatever they are made of, nothing is raised."""

from __future__ import annotations

import copy
import functools
import itertools
import operator
import pickle
import sys
import types
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import scipy.sparse

import geomint as gi
from geomint.kernels.compiling import sending
from tests.sending.other_process import turning
from tests.sending.test_sending import again

pytestmark = pytest.mark.nojit


def made(**parts: Any) -> gi.Problem:
    return gi.Problem("turning", (("y", 2),), params=[2.0], field=turning, **parts)


class Scaled:
    """A function that is an object, with no equality of its own."""

    def __init__(self, factor: float) -> None:
        self.factor = factor

    def __call__(self, y: Any) -> Any:
        return {"y": self.factor * y}

    def named(self, y: Any) -> Any:
        return {"y": self.factor * y}


class Ambiguous(Scaled):
    """What compares as arrays do."""

    def __eq__(self, other: object) -> Any:
        return np.array([True, False])


class Foreign(Ambiguous):
    """What cannot be compared at all."""

    def __eq__(self, other: object) -> bool:
        raise RuntimeError("no")


PARTS = itertools.cycle([0.1, 0.2, 0.3])


class Rounded(Scaled):
    """What says itself what it is equal to, whatever else it has."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Rounded) and round(self.factor) == round(other.factor)


VALUES = {
    "NaN": lambda k: float("nan") if k else 0.0,
    "numpy's NaN": lambda k: np.float64("nan") if k else 0.0,
    "complex NaN": lambda k: complex(1.0, float("nan")) if k else 1j,
    "no time": lambda k: np.datetime64("NaT") if k else np.datetime64("2020"),
    "objects": lambda k: np.array([k, "a", None], dtype=object),
    "masked": lambda k: np.ma.masked_array([1.0, 2.0], [k, 1]),
    "sparse": lambda k: scipy.sparse.csr_array(np.diag([1.0, k])),
    "generator": np.random.default_rng,
    "partial": lambda k: functools.partial(Scaled.named, Scaled(k)),
    "object": Scaled,
    "method": lambda k: Scaled(k).named,
    "item": operator.itemgetter,
    "ambiguous": Ambiguous,
    "foreign": Foreign,
    "rounded": lambda k: Rounded(k + next(PARTS)),
    "fraction": lambda k: Fraction(k, 7),
    "shape": lambda k: [np.zeros((1, 2, 3)), np.zeros((3, 2, 1)) if k else np.zeros((1, 2, 3))],
}


@pytest.mark.filterwarnings("ignore::scipy.sparse.SparseEfficiencyWarning")
@pytest.mark.parametrize("name", VALUES)
def test_what_problems_are_made_of(name: str) -> None:
    """Made again, sent or copied it is equal; made of something else it is not."""
    make = VALUES[name]
    problem = made(parameters={"value": make(1)})
    for other in (
        made(parameters={"value": make(1)}),
        again(problem),
        copy.copy(problem),
        copy.deepcopy(problem),
    ):
        assert problem == other
        assert hash(problem) == hash(other)
    assert problem != made(parameters={"value": make(0)})


def test_shapes_of_many_arrays() -> None:
    """What is compared is kept while it is: its id would be given to something else."""
    for count in range(1, 10):
        one, other = ([np.zeros((1, 2, 3)) for _ in range(count)] for _ in range(2))
        problem = made(parameters={"value": [*one, np.zeros((1, 2, 3))]})
        assert problem == made(parameters={"value": [*one[::-1], np.zeros((1, 2, 3))]})
        assert problem != made(parameters={"value": [*other, np.zeros((3, 2, 1))]})


@pytest.mark.parametrize("code", ["k * y", "(lambda z: k * z)(y)", "helped(y)"])
def test_functions_that_find_other_globals(code: str) -> None:
    """As those of two notebooks: one code, other values."""

    def physical(k: float) -> Any:
        space: dict[str, Any] = {"k": k, "__name__": "notebook"}
        exec(
            f"def helped(y):\n    return k * y\ndef physical(y):\n    return {{'y': {code}}}", space
        )
        return space["physical"]

    assert made(physical=physical(2.0)) == made(physical=physical(2.0))
    assert made(physical=physical(2.0)) != made(physical=physical(3.0))


def test_copies_need_no_other_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Functions are the same ones in a copy, as Python copies functions; mappings are others."""
    monkeypatch.setattr(sending, "cloudpickle", lambda: None)
    space: dict[str, Any] = {"gi": gi, "__name__": "no_such_module"}
    exec("@gi.observable\ndef mine(params, t, y, work):\n    return y[0]", space)
    problem = made(observables={"mine": space["mine"]}, parameters={"list": [1.0]})
    assert copy.copy(problem) == copy.deepcopy(problem) == problem
    assert copy.deepcopy(problem).observables["mine"] is space["mine"]
    assert copy.deepcopy(problem).parameters["list"] is not problem.parameters["list"]
    mine: dict[str, Any] = {}  # what a user does with his own later changes no problem
    problem = made(observables=mine, parameters=mine)
    mine["later"] = 1
    assert problem == made()


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        ("out[0] = 2.0 * y[1]", "out[0] = 3.0 * y[1]", "'mine' .* same version"),
        ("def mine", "def another", "'mine' .* same version"),
        ("import geomint", "import no_such_library, geomint", "cannot be imported: ModuleNotFound"),
    ],
)
def test_other_versions_of_modules(
    before: str, after: str, text: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Functions of the top of a module, too, are held to their code where they are received."""
    source = "import geomint\n@geomint.field\ndef mine(params, t, y, out, work):\n    "
    source += "out[0] = 2.0 * y[1]\n    out[1] = 0.0 * y[0]\n"
    monkeypatch.syspath_prepend(tmp_path)
    module = types.ModuleType("sent_module")
    exec(source, vars(module))
    monkeypatch.setitem(sys.modules, "sent_module", module)
    problem = gi.Problem("mine", (("y", 2),), field=module.mine)
    content = pickle.dumps(problem)
    assert again(problem) == problem
    sending.kept.cache_clear()
    monkeypatch.delitem(sys.modules, "sent_module")
    (tmp_path / "sent_module.py").write_text(source.replace(before, after))
    with pytest.raises(gi.SendingError, match=text):
        pickle.loads(content)


def test_long_contents_are_not_kept() -> None:
    """A process that receives thousands of problems has no more than 256 short ones."""
    short, long = (made(parameters={"table": np.zeros(n)}) for n in (10, 2**18))
    for problem, kept in ((short, True), (long, False)):
        content = pickle.dumps(problem)
        found = pickle.loads(content)
        assert found == problem
        assert (pickle.loads(content) is found) is kept
