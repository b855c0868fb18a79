"""Errors can be copied and sent to another process with all that they carry."""

import copy
import pickle

import pytest

import geomint as gi

OF_STEPS = (1.0, 2, 3.0, 4, "hint")
EXAMPLES = {
    gi.GeomintError: ("plain",),
    gi.GeomintWarning: ("plain",),
    gi.ArgumentError: ("no such argument", ("x",)),
    gi.EnsembleError: ("workers have ended: KilledWorker",),
    gi.WatcherError: ("energy", 0.5, "what it said"),
    gi.DomainError: ("step", -1.0, "a positive number"),
    gi.MethodError: ("no such method",),
    gi.FormError: ("does not fit",),
    gi.DeclarationError: ("p", "field", "writes too much", "out", 3, 2),
    gi.SceneError: ("a scene",),
    gi.OutputError: ("run.nc", "no space", 28),
    gi.EventError: ("height", 1.0, 2, 3.0, "is not a finite number"),
    gi.StepSizeError: (*OF_STEPS, 0.5),
    gi.UnknownNameError: ("drift", "energy", ("area",)),
    gi.UnknownReferenceError: ("reason", 1e-3, 1e-5, "advice"),
    gi.SendingError: ("mine", "notebook"),
    gi.MissingCodeError: ("Solution.to_xarray", "needs xarray"),
    **dict.fromkeys(gi.GeomintWarning.__subclasses__(), ("too long", "step", 2.0, 1.0)),
    **{
        getattr(gi, f"{name}Error"): OF_STEPS
        for name in ("Clock", "Step", "Convergence", "Rank", "NonFinite", "StepLimit")
    },
}
WAYS = (lambda error: pickle.loads(pickle.dumps(error)), copy.copy, copy.deepcopy)


def kinds(base=(gi.GeomintError, gi.GeomintWarning)):
    for kind in base:
        yield kind
        yield from kinds(kind.__subclasses__())


def test_there_is_an_example_of_every_error():
    """Also of those that other modules define."""
    public = {kind for kind in kinds() if kind.__module__ == gi.GeomintError.__module__}
    assert public == set(EXAMPLES)


@pytest.mark.parametrize("kind", EXAMPLES, ids=lambda kind: kind.__name__)
def test_an_error_comes_back(kind):
    error = kind(*EXAMPLES[kind])
    for way in WAYS:
        again = way(error)
        assert type(again) is kind
        assert (str(again), again.args, vars(again)) == (str(error), error.args, vars(error))
        assert getattr(again, "errno", None) == getattr(error, "errno", None)


def test_what_cannot_be_sent_is_told():
    error = gi.DomainError("field", lambda: 0, "a field")
    assert copy.copy(error).value is error.value
    assert "lambda" in pickle.loads(pickle.dumps(error)).value


class Unprintable:
    def __repr__(self):
        raise RuntimeError("no")


LONG = ("x" * 10**6, 10**5000, list(range(10**5)), {1: "y" * 10**5}, Unprintable())


def test_messages_are_bounded_and_steer_no_terminal():
    """Not even those that quote a name as it is."""
    for value in LONG:
        said = str(gi.DomainError("x", value, "something else"))
        assert len(said) < 500
    assert "Unprintable" in said
    for error in (gi.SceneError("a\x1b[31m\r\u202e"), gi.DomainError("b\x9b\0", 1, "c")):
        assert str(error).isprintable()
    assert str(gi.SceneError("a\n\tb")) == "a\n\tb"


def test_an_error_of_a_run_comes_back_with_what_there_is_of_it():
    scene = gi.load_scene("sphere-n3").changed(integrate={"step": 40.0, "iteration": "fixed-point"})
    run = {"t_end": 80.0, "method": scene.method, "step": 40.0, "compiled": False}
    with pytest.raises(gi.ConvergenceError) as failed:
        gi.solve(scene.problem, scene.state, **run)
    again = pickle.loads(pickle.dumps(failed.value)).partial
    assert (again.status, again) == ("failed", failed.value.partial)
