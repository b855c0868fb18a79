"""Errors can be copied and sent to another process with all that they carry."""

import copy
import pickle
import subprocess
import sys

import pytest

import geomint as gi
from geomint import errors

EXAMPLES = {
    gi.GeomintError: ("plain",),
    gi.GeomintWarning: ("plain",),
    gi.ArgumentError: ("no such argument", ("x",)),
    gi.EnsembleError: ("workers have ended: KilledWorker",),
    gi.WatcherError: ("energy", 0.5, "what it said"),
    gi.ClockError: (1.0, 2, 3.0, 4, "hint"),
    gi.DomainError: ("step", -1.0, "a positive number"),
    gi.MethodError: ("no such method",),
    gi.FormError: ("does not fit",),
    gi.DeclarationError: ("p", "field", "writes too much", "out", 3, 2),
    gi.SceneError: ("a scene",),
    gi.OutputError: ("run.nc", "no space", 28),
    gi.StepError: (1.0, 2, 3.0, 4, "hint"),
    gi.ConvergenceError: (1.0, 2, 3.0, 4, "hint"),
    gi.RankError: (1.0, 2, 3.0, 4, "hint"),
    gi.NonFiniteError: (1.0, 2, 3.0, 4, "hint"),
    gi.EventError: ("height", 1.0, 2, 3.0, "is not a finite number"),
    gi.StepLimitError: (1.0, 2, 3.0, 4, "hint"),
    gi.StepSizeError: (1.0, 2, 3.0, 4, "hint", 0.5),
    gi.UnknownNameError: ("drift", "energy", ("area",)),
    gi.UnknownReferenceError: ("reason", 1e-3, 1e-5, "advice"),
    gi.SendingError: ("mine", "notebook"),
    gi.MissingCodeError: ("Solution.to_xarray", "needs xarray"),
    **dict.fromkeys(gi.GeomintWarning.__subclasses__(), ("too long", "step", 2.0, 1.0)),
}
WAYS = {
    "pickle": lambda error: pickle.loads(pickle.dumps(error)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


def kinds(base=(gi.GeomintError, gi.GeomintWarning)):
    for kind in base:
        yield kind
        yield from kinds(kind.__subclasses__())


def test_there_is_an_example_of_every_error():
    """Also of those that other modules define."""
    public = {kind for kind in kinds() if kind.__module__ == errors.__name__}
    assert public == set(EXAMPLES)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", EXAMPLES, ids=lambda kind: kind.__name__)
def test_an_error_comes_back(kind, way):
    error = kind(*EXAMPLES[kind])
    again = WAYS[way](error)
    assert type(again) is kind
    assert str(again) == str(error)
    assert again.args == error.args
    assert vars(again) == vars(error)
    assert getattr(again, "errno", None) == getattr(error, "errno", None)


def test_what_cannot_be_sent_is_told():
    error = gi.DomainError("field", lambda: 0, "a field")
    assert copy.copy(error).value is error.value
    assert "lambda" in pickle.loads(pickle.dumps(error)).value


LONG = {"text": "x" * 10**6, "int": 10**5000, "list": list(range(10**5)), "dict": {1: "y" * 10**5}}


@pytest.mark.parametrize("value", LONG.values(), ids=LONG)
def test_messages_have_a_bounded_length(value):
    assert len(str(gi.DomainError("x", value, "something else"))) < 500


class Unprintable:
    def __repr__(self):
        raise RuntimeError("no")


def test_a_value_without_a_text():
    assert "Unprintable" in str(gi.DomainError("x", Unprintable(), "something else"))


POOL = """
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import geomint as gi


def fail(kind):
    scene = gi.load_scene("sphere-n3")
    if kind == "domain":
        scene.problem.exact([float("nan")] * 6)
    gi.run_scene(scene.changed(integrate={"step": 40.0, "iteration": "fixed-point"}), progress=False)


if __name__ == "__main__":
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        error = pool.submit(fail, sys.argv[1]).exception(timeout=120)
    print(type(error).__name__, getattr(getattr(error, "partial", None), "status", None))
"""


@pytest.mark.parametrize(
    ("kind", "told"), [("domain", "DomainError None"), ("step", "ConvergenceError failed")]
)
def test_a_pool_gets_the_error_of_its_worker(kind, told, tmp_path):
    """With what there is of the run."""
    script = tmp_path / "pool.py"
    script.write_text(POOL, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(script), kind], capture_output=True, text=True, check=False
    )
    assert done.stdout.strip() == told, done.stderr


def test_messages_steer_no_terminal():
    """Not even those that quote a name as it is."""
    for error in (gi.SceneError("a\x1b[31m\r\u202e"), gi.DomainError("b\x9b\0", 1, "c")):
        assert str(error).isprintable()
    assert str(gi.SceneError("a\n\tb")) == "a\n\tb"
