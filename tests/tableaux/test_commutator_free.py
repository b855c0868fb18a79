"""Lie group methods: exact order conditions on ordered forests, and what must fail."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from operator import attrgetter

import pytest

from geomint.tableaux import (
    COMMUTATOR_FREE,
    RUNGE_KUTTA,
    CommutatorFreeTableau,
    commutator_free_defect,
    flow,
    runge_kutta_defect,
)

METHODS = list(COMMUTATOR_FREE.values())
each_method = pytest.mark.parametrize("method", METHODS, ids=attrgetter("name"))


@each_method
def test_order_is_the_declared_one(method: CommutatorFreeTableau) -> None:
    """All ordered forests up to the order are satisfied, and not all of the next size.

    Exactly, or to what the last published digit explains; on a commutative group too, where the
    method is that of Runge and Kutta.
    """
    assert commutator_free_defect(method, method.order) <= method.tolerance
    assert commutator_free_defect(method, method.order + 1) > Fraction(1, 1000)
    assert runge_kutta_defect(method.classical, method.order) <= method.tolerance
    assert COMMUTATOR_FREE[method.name] is method
    assert method.name.endswith(f"-{method.order}")
    assert method.references
    assert method.classical.explicit


@each_method
def test_arrays_repeat_the_flows(method: CommutatorFreeTableau) -> None:
    """Starts, counts and rows in float64 are the exact ones, padded with zeros; rows sum to nodes."""
    s, left = len(method.stages), method.numbers.tolist()
    assert len(left) == 2 * len(method.flows) + s * method.exponentials
    for i, each in enumerate(method.flows):
        start = method.c[each.start - 1] if each.start else 0
        assert abs(start + sum(method.row_sums[i]) - (*method.c, 1)[i]) <= method.tolerance
        assert left[:2] == [each.start - 1, len(each.exponentials)]
        del left[:2]
        for a in each.exponentials:
            assert left[:s] == [float(x) for x in a] + [0.0] * (s - len(a))
            del left[:s]
    assert not method.numbers.flags.writeable


def test_known_structure() -> None:
    """Counts of exponentials and underlying methods known from the literature."""
    counts = {name: method.exponentials for name, method in COMMUTATOR_FREE.items()}
    few = {"cf-1": 1, "cf-2": 2, "cf-3": 3, "cf-4": 5}
    assert counts == {**few, "cg-2": 3, "cg-3": 6, "cg-4": 15}
    classical, rk4 = COMMUTATOR_FREE["cf-4"].classical, RUNGE_KUTTA["rk-4"]
    assert (classical.A, classical.b, classical.c) == (rk4.A, rk4.b, rk4.c)
    for name in ("cg-2", "cg-3", "cg-4"):
        rows = [a for each in COMMUTATOR_FREE[name].flows for a in each.exponentials]
        assert all(sum(map(bool, a)) == 1 for a in rows)


PUBLISHED_CG4 = """
0.8177227988124852
0.3199876375476427 0.0659864263556022
0.9214417194464946 0.4997857776773573 -1.0969984448371582
0.3552358559023322 0.2390958372307326 1.3918565724203246 -1.1092979392113465
0.1370831520630755 -0.0183698531564020 0.7397813985370780 -0.1907142565505889 0.3322195591068374
"""


def crouch_grossman(text: str) -> CommutatorFreeTableau:
    """A method with one generator an exponential, of order 4 by its name."""
    stages = [
        flow(0, *("0 " * j + word for j, word in enumerate(line.split())))
        for line in text.splitlines()
    ]
    tolerance = Fraction(1, 10**12)
    return CommutatorFreeTableau("cg-4", 4, tuple(stages[:-1]), stages[-1], (), tolerance)


def test_cg4_continues_the_published_digits() -> None:
    """Every coefficient rounds to the published one; a_54 with the well-known typing error fails."""
    published, ours = crouch_grossman(PUBLISHED_CG4), COMMUTATOR_FREE["cg-4"]
    for each, other in zip(published.flows, ours.flows, strict=True):
        for a, b in zip(each.exponentials, other.exponentials, strict=True):
            assert [round(x, 16) for x in b] == list(a)
    assert commutator_free_defect(published, 4) < Fraction(1, 10**16)
    mistyped = crouch_grossman(PUBLISHED_CG4.replace("3465", "3565"))
    assert commutator_free_defect(mistyped, 4) > Fraction(1, 10**15)


def test_wrong_methods_are_noticed() -> None:
    """Their orders are those of their conditions, to digits beyond the fifteenth."""
    method = COMMUTATOR_FREE["cf-4"]
    single = replace(method, update=flow(0, "1/6 1/3 1/3 1/6"))
    assert runge_kutta_defect(single.classical, 4) == commutator_free_defect(single, 2) == 0
    assert commutator_free_defect(single, 3) > 0
    swapped = method.update._replace(exponentials=method.update.exponentials[::-1])
    assert commutator_free_defect(replace(method, update=swapped), 3) > Fraction(1, 100)
    tolerance = Fraction(1, 10**15)
    for update in (
        flow(0, "1/4 1/6 1/6 -0.08333333333333333333", "-1/12 1/6 1/6 0.25000000000000000000"),
        flow(0, "1/4 1/6 1/6 -1/12 ", "-1/12 0.1666666666666666 0.1666666666666667 1/4"),
    ):
        broken = replace(method, update=update, tolerance=tolerance)
        assert 0 < commutator_free_defect(broken, method.order) < tolerance


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"update": flow(0, "1/2 1/3")}, "total weight 1"),
        ({"update": flow(3, "1")}, "flow 3 uses"),
        ({"stages": (flow(0), flow(0, "0 1/2"))}, "flow 2 uses"),
        ({"stages": (flow(1), flow(0, "1/2"))}, "flow 1 uses"),
        ({"stages": (flow(0), flow(-1, "1/2"))}, "flow 2 uses"),
    ],
)
def test_construction_is_validated(change: dict[str, object], message: str) -> None:
    """Stages that are not known yet and wrong sums are refused."""
    with pytest.raises(ValueError, match=f"cf-2: .*{message}"):
        replace(COMMUTATOR_FREE["cf-2"], **change)  # type: ignore[arg-type]


def test_floats_are_refused() -> None:
    """A float has lost digits before it can be checked."""
    with pytest.raises(TypeError, match="Fractions"):
        replace(COMMUTATOR_FREE["cf-1"], update=(0, ((1.0,),)))  # type: ignore[arg-type]


@each_method
def test_translations_give_the_classical_method(method: CommutatorFreeTableau) -> None:
    """On a commutative group, where exponentials add, the step is that of the classical method."""
    A, b = method.classical.A, method.classical.b
    L: list[Fraction] = []
    for a in A:
        Y = Fraction(1, 3) + sum(x * k for x, k in zip(a, L, strict=False))
        L.append(Y * Y / 5)
    classical = Fraction(1, 3) + sum(x * k for x, k in zip(b, L, strict=True))
    values = [Fraction(1, 3)]
    K: list[Fraction] = []
    for start, exponentials in method.flows:
        Y = values[start]
        for a in exponentials:
            Y += sum(x * k for x, k in zip(a, K, strict=False))
        values.append(Y)
        K.append(Y * Y / 5)
    assert values[-1] == classical
