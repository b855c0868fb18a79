"""Methods are values: they compare, hash, copy, pickle and print by what they are made of."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from fractions import Fraction

import pytest

import chaplygin as ch
import geomint as gi
from geomint.tableaux import COMMUTATOR_FREE, COMPOSITIONS, RUNGE_KUTTA, Tableau

pytestmark = pytest.mark.nojit

MINE = dataclasses.replace(RUNGE_KUTTA["kutta-3"], name="mine-3")
VALUES = [
    *map(gi.find_method, gi.method_names()),
    gi.find_method("gauss-1-suzuki-4-suzuki-6"),
    gi.Gauss(8, iteration_tolerance=2.0**-56),
    gi.Gauss(8, max_iterations=7),
    gi.Gauss(3, iteration="newton"),
    gi.Rattle(iteration_tolerance=1e-9),
    gi.Lobatto(5, max_iterations=12),
    gi.Compose(gi.Rattle(iteration_tolerance=1e-9), 4),
    gi.Adaptive(gi.RKMK("dop853", "cayley"), rtol=1e-6, max_step=0.5, max_steps=10),
    gi.RungeKutta(MINE),
]
NAMES = {name: getattr(gi, name) for name in gi.__all__}
NAMES |= {"Tableau": Tableau, "Fraction": Fraction}


def test_copies_are_equal() -> None:
    names = {kind.__name__: kind for kind in map(type, VALUES)}
    for method in VALUES:
        for again in (
            pickle.loads(pickle.dumps(method)),
            copy.deepcopy(method),
            dataclasses.replace(method),  # type: ignore[type-var]
            gi.find_method(method.name if method.name != "mine-3" else method).with_options(
                **method.options
            ),
            eval(repr(method), {**names, **NAMES}),
        ):
            assert again == method
            assert hash(again) == hash(method)
            assert (again.name, again.order) == (method.name, method.order)
            assert (again.options, repr(again)) == (method.options, repr(method))
    assert len(set(VALUES)) == len(VALUES)
    assert repr(gi.find_method("rattle-4")) == "Compose(Rattle(), 'suzuki-4')"


def test_what_is_written_differently_is_the_same() -> None:
    """A tableau by name or itself, a scheme by name, order or itself, numbers of any type."""
    assert gi.RungeKutta("dop853") == gi.RungeKutta(RUNGE_KUTTA["dop853"])
    assert gi.CommutatorFree() == gi.CommutatorFree(COMMUTATOR_FREE["cf-4"])
    four = COMPOSITIONS["suzuki-4"]
    composed = gi.find_method(f"gauss-1-{four.name}")
    assert gi.Compose(gi.Gauss(1), 4) == gi.Compose(gi.Gauss(1), four) == composed
    assert gi.Compose(gi.Rattle(), 4) == gi.find_method("rattle-4")
    assert gi.Gauss(8, iteration_tolerance=0) == gi.Gauss()
    one, other = (gi.Adaptive(gi.RungeKutta("dop853"), atol=zero) for zero in (0.0, -0.0))
    assert one == other
    assert repr(one) == repr(other)


CHANGED = {"Ensemble", "Section", "Solution", "SeveralRuns", "Watcher"}  # while they are made
DATACLASSES = {
    name: kind
    for package in (gi, ch)
    for name, kind in vars(package).items()
    if isinstance(kind, type) and dataclasses.is_dataclass(kind)
}


def test_what_is_returned_is_not_changed_and_shows_itself() -> None:
    """Attributes cannot be set; no list of all fields hides what a value says of itself."""
    assert {n for n, k in DATACLASSES.items() if not k.__dataclass_params__.frozen} == CHANGED
    for kind in DATACLASSES.values():
        own = issubclass(kind, gi.Method) or hasattr(kind, "_shown")
        assert ("__repr__" in vars(kind)) != own, kind


# --- methods of one's own -------------------------------------------------------------------------


class Silent(gi.Method):
    """Says nothing of itself."""

    def flow(self, p: object) -> object:
        raise NotImplementedError


def test_what_a_method_does_not_say_is_named() -> None:
    for use in (gi.find_method, gi.Adaptive, lambda method: gi.Compose(method, 4)):
        with pytest.raises(gi.MethodError, match="Silent does not say its name, order, needs"):
            use(Silent())  # type: ignore[operator]
    assert (repr(Silent()), Silent().options) == ("Silent()", {})
