"""Methods by name: every name leads back to its method, options and structure are kept."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

import geomint as gi
from geomint.methods import methods
from geomint.tableaux import COMMUTATOR_FREE, COMPOSITIONS, RUNGE_KUTTA
from tests.problems import examples

pytestmark = pytest.mark.nojit

COMPOSED = [
    f"{base}-{name}"
    for base, order in (("gauss-1", 2), ("rattle", 2), ("verlet", 2), ("gauss-2", 4))
    for name, scheme in COMPOSITIONS.items()
    if scheme.base_order <= order < scheme.order
] + ["gauss-1-suzuki-4-suzuki-6", "rattle-4-suzuki-6-suzuki-8"]


@pytest.mark.parametrize("name", [*methods(), *COMPOSED])
def test_names_lead_back_to_what_a_method_states(name: str) -> None:
    """A method's own name finds the method; form, order, default step, words for tables."""
    method = gi.find_method(name)
    again = gi.find_method(method.name)
    assert again == gi.find_method(again) == method
    assert again.name == method.name
    assert method.needs in ("field", "action", "hamiltonian", "splitting")
    assert 1 <= method.order <= 32
    assert 0.0 < method.step_fraction <= 1.0
    assert method.summary
    assert method.references
    assert method.symplectic is (name.startswith(("gauss", "lobatto", "rattle", "verlet")))
    assert method.symmetric is method.symplectic


# The default step as a part of the characteristic time, evaluations of a step, the family.
FACTS = {
    "cf-1": (0.005, 1, "commutator-free"), "cg-4": (0.03, 5, "Crouch–Grossman"),
    "rkmk-heun-2": (0.01, 2, "Runge–Kutta–Munthe-Kaas, exponential coordinates"),
    "rkmk-cayley-dop853": (0.1, 12, "Runge–Kutta–Munthe-Kaas, Cayley coordinates"),
    "bogacki-shampine-3-adaptive": (0.02, 4, "explicit Runge–Kutta"),
    "dormand-prince-5": (0.05, 6, "explicit Runge–Kutta"),
    "verlet-2": (0.02, 3, "Störmer–Verlet splitting"), "rattle-2": (0.02, 2, "RATTLE"),
    "verlet-8": (0.21, 3, "Störmer–Verlet splitting"), "rattle-6": (0.13, 2, "RATTLE"),
    "verlet-4": (0.05, 3, "Störmer–Verlet splitting"), "rattle-10": (0.25, 2, "RATTLE"),
    "gauss-1": (0.02, 1, "Gauss collocation"), "gauss-2": (0.033, 2, "Gauss collocation"),
    "gauss-8": (0.6, 8, "Gauss collocation"), "lobatto-3": (0.033, 3, "Lobatto IIIA–IIIB"),
    "lobatto-8": (0.15, 8, "Lobatto IIIA–IIIB"),
}  # fmt: skip


@pytest.mark.parametrize("name", FACTS)
def test_what_plans_and_lists_take_from_a_method(name: str) -> None:
    """Default steps are those that published results were made with."""
    method, (fraction, evaluations, family) = gi.find_method(name), FACTS[name]
    problem, y0 = next((p, y) for p, y in examples() if method.needs in p.forms)
    motion = gi.Integrator(problem, y0, method, step=0.1, compiled=False)
    assert (motion.stepper.flow.evaluations, method.family) == (evaluations, family)
    assert method.step_fraction == pytest.approx(fraction, rel=1e-14)


def test_all_tableaux_have_methods() -> None:
    """A new literal in a registry of tableaux is a new method; one that estimates an adaptive one."""
    expected = {*RUNGE_KUTTA, *COMMUTATOR_FREE}
    for prefix in ("rkmk", "rkmk-cayley"):
        expected |= {f"{prefix}-{name}".replace("-rk-", "-") for name in RUNGE_KUTTA}
    tableaux = [name for name, table in RUNGE_KUTTA.items() if table.b_hat is not None]
    families = ("{}", "rkmk-{}", "rkmk-cayley-{}")
    adaptive = {f"{f.format(t)}-adaptive" for f in families for t in tableaux}
    assert expected | adaptive <= set(gi.method_names())
    assert adaptive == {n for n in gi.method_names() if gi.find_method(n).adaptive}


def test_entry_points_add_methods(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of any package."""
    mine = gi.RungeKutta(dataclasses.replace(RUNGE_KUTTA["kutta-3"], name="mine-3"))
    silent = object.__new__(type(mine))
    offered = {"mine-3": mine, "other-name": mine, "no-method": print, "silent": silent}

    class Point:
        group, value, dist = "geomint.methods", "other:method", None

        def __init__(self, name: str) -> None:
            self.name = name

        def load(self) -> object:
            if self.name == "broken":
                raise RuntimeError("at its import")
            return offered[self.name]

    monkeypatch.setattr(
        "importlib.metadata.entry_points", lambda group: [Point(n) for n in [*offered, "broken"]]
    )
    methods.cache_clear()
    try:
        with pytest.warns(
            gi.GeomintWarning, match="is left out: expected a geomint.Method"
        ) as said:
            assert gi.find_method("mine-3") is mine
        assert len(said) == 4
        assert any("RuntimeError: at its import" in str(w.message) for w in said)
        assert not {"other-name", "no-method", "silent", "broken"} & set(gi.method_names())
    finally:
        methods.cache_clear()


@pytest.mark.parametrize(
    ("word", "meant", "family"),
    [
        ("verlet", "verlet-2", "verlet-2, verlet-4"),
        ("Verlett", "verlet-2", "verlet-2, verlet-4"),
        ("rattle", "rattle-2", "rattle-2, rattle-4"),
        ("RK", "rk-4", "rk-4"),
        ("gauss", "gauss-8", "gauss-1, gauss-2"),
        ("lobatto", "lobatto-3", "lobatto-3, lobatto-4"),
        ("gauss8", "gauss-8", ""),
        ("cf4", "cf-4", ""),
        ("dop", "dop853", ""),
    ],
)
def test_what_a_wrong_name_may_mean(word: str, meant: str, family: str) -> None:
    """Of a family without a number the default, or the lowest order, and what else it has."""
    with pytest.raises(gi.MethodError, match=f"Did you mean '{meant}'") as raised:
        gi.find_method(word)
    assert (f" The family: {family}" in str(raised.value)) == bool(family)


@pytest.mark.parametrize(
    "name", ["gauss-3", "lobatto-4", "rattle-2", "rattle-4", "gauss-1-suzuki-4"]
)
def test_options_keep_the_rest(name: str) -> None:
    """Order, name and composition."""
    method = gi.find_method(name)
    changed = method.with_options(max_iterations=7, iteration_tolerance=1e-9)
    assert changed.options["max_iterations"] == 7
    assert changed.options["iteration_tolerance"] == 1e-9
    assert (changed.name, changed.order) == (method.name, method.order)
    assert method.with_options() is method
    problem, y0 = next((p, y) for p, y in examples() if method.needs in p.forms)
    starts = [gi.Integrator(problem, y0, m, step=0.1, compiled=False) for m in (changed, method)]
    assert len({len(motion.stepper.flow.fractions) for motion in starts}) == 1


def test_compositions_know_their_base() -> None:
    """An order of the base that the scheme was not made for is refused; others compose."""
    assert gi.Compose(gi.Gauss(1), 6).order == 6
    assert gi.Compose(gi.Rattle(), "suzuki-4").order == 4
    assert gi.Compose(gi.Verlet(), 8).order == 8
    assert gi.Compose(gi.Gauss(2), 6) == gi.find_method("gauss-2-suzuki-6")
    assert gi.Compose(gi.Compose(gi.Gauss(1), 4), 6) == gi.find_method("gauss-1-suzuki-4-suzuki-6")
    assert gi.Compose(gi.Gauss(2), "kahan-li-8").order == 8
    with pytest.raises(gi.MethodError, match="bases of order 4 or more to 6"):
        gi.Compose(gi.Rattle(), "suzuki-6")
    with pytest.raises(gi.MethodError, match="'gauss-3' has order 6"):
        gi.Compose(gi.Gauss(3), "suzuki-6")
    with pytest.raises(gi.MethodError, match="symmetric are"):
        gi.Compose(gi.RungeKutta(), 6)


def test_substeps_that_are_not_taken_are_noticed() -> None:
    """A method that says it is symmetric but ignores the substeps would be of its own order."""

    class Deaf(gi.Gauss):
        def flow(self, p: Any) -> Any:
            return super().flow(p._replace(lengths=(1.0,), starts=(0.0,)))

    with pytest.raises(gi.MethodError, match="takes no substeps"):
        gi.Integrator(*examples()[0], gi.Compose(Deaf(1), 4), step=0.1, compiled=False)
