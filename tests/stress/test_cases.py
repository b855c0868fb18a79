"""What is there to stress: cases of all packages, cells for every method."""

from importlib.metadata import entry_points

import pytest

import geomint as gi
from geomint.stress import sweep
from geomint.stress.sweep import Selection, items_of, selected
from tests.stress.stress_support import CASES, EVERY

LARGE = 16  # larger ones take a second to build


def test_every_case_of_a_package_is_there():
    given = [c for point in entry_points(group="geomint.stress") for c in point.load()()]
    assert sorted(map(repr, CASES)) == sorted(map(repr, given))


def test_cells_are_told_apart():
    places = [(c.system, c.representations, c.axis.name, c.text, c.n) for c in EVERY]
    assert len(set(places)) == len(places)


@pytest.mark.parametrize("axis", dict.fromkeys(case.axis.name for case in CASES))
def test_every_case_is_built_or_refused(axis):
    for case in EVERY:
        if case.axis.name != axis or case.n > LARGE:
            continue
        try:
            model = sweep._built(case.build)
        except gi.GeomintError:
            assert (axis, case.value) == ("edge", 0.0)
            continue
        names = set(model.problems)
        assert case.representations is None or set(case.representations) <= names
        assert case.reference is None or case.reference in names
        assert set(case.quick) <= names


def test_axes_of_the_issue():
    axes = {case.axis.name for case in CASES}
    assert axes >= {
        "edge",
        "spread",
        "equal",
        "momentum",
        "planes",
        "rotation",
        "dimension",
        "step",
    }
    assert {case.n for case in CASES if case.axis.name == "dimension"} >= {2, 100}
    assert max(case.value for case in CASES if case.axis.name == "momentum") >= 1e150


@pytest.mark.parametrize(("quick", "axes"), [(False, ("momentum",)), (True, ())])
def test_every_method_is_stressed(quick, axes):
    selection = Selection(tuple(gi.method_names()), (), axes, quick)
    groups, _ = items_of(*selected(selection), quick)
    assert {item.method for group in groups for item in group} == set(gi.method_names())


def test_every_scene_is_stressed():
    systems = {case.system for case in CASES if case.axis.name == "step"}
    assert {f"scene:{name}" for name in gi.scene_names()} <= systems


def test_selections():
    numbers, methods = selected(Selection(("rk-4",), (), ("edge",), quick=True))
    assert [m.name for m in methods] == ["rk-4"]
    assert {CASES[i].axis.name for i in numbers} == {"edge"}
    assert all(CASES[i].quick for i in numbers)
    for selection, word in ((Selection(axes=("edg",)), "edge"), (Selection(("rk-5",)), "rk-4")):
        with pytest.raises(gi.GeomintError, match=word):
            selected(selection)


def test_quick_takes_the_ends_of_every_family():
    _, methods = selected(Selection(quick=True))
    names = {m.name for m in methods}
    assert {"gauss-1", "gauss-16", "heun-2", "dop853", "dop853-adaptive"} <= names
    assert len(names) < 0.6 * len(gi.method_names())
