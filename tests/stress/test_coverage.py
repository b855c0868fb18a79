"""What the page says is stressed is stressed: axes, systems, the quick run."""

import re
import warnings
from functools import cache
from pathlib import Path

import geomint as gi
from geomint.problems.systems import find_system, system_names
from geomint.stress import sweep
from geomint.stress.state_cases import is_steady
from geomint.stress.sweep import Selection, family_of, items_of, selected
from tests.problems import examples
from tests.stress.stress_support import CASES, EVERY

AXES = list(dict.fromkeys(case.axis.name for case in CASES))
PAGE = (Path(__file__).parents[2] / "docs" / "stress.md").read_text(encoding="utf-8")
# What cases of chaplygin call the motions of a system, if not as the system; sizes and places follow.
MOTIONS = {
    "chaplygin-sphere-reduced": "sphere",
    "chaplygin-sphere-hamiltonized": "sphere",
    "chaplygin-ball": "ball-diagonal|ball-full|steady|tumbling",
    "homogeneous-ball": "homogeneous",
    "ball-on-group": "group",
    "ball-poisson": "poisson",
    "rolling-ball": "rolling",
    "rubber-ball": "rubber",
    "veselova": "veselova|veselova-classical",
}
GENERAL = {"step", "rest", "zeros", "steady"}  # of all scenes
PLACE = r"(-at-axis|-at-plane|-all-pairs|-straight|-upright)?(-n\d+)?"


def rows(first):
    """Return the rows of the table of the page whose heading begins with a word, cell by cell."""
    start = PAGE.index(f"| {first} |")
    lines = PAGE[start : PAGE.index("\n\n", start)].splitlines()
    return [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in lines]


@cache
def model_of(name):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gi.GeomintWarning)
        return gi.load_scene(name)


@cache
def problems_on(axis):
    """Return the names of the problems of scenes and test problems on an axis."""
    chosen = [c for c in EVERY if c.axis.name == axis and c.system.startswith(("scene:", "test:"))]
    models = [(case.representations, sweep._built(case.build)) for case in chosen]
    return {model.problems[name].name for names, model in models for name in names}


def covered(system, axis):
    motion = re.compile(f"({MOTIONS.get(system, system)}){PLACE}")
    if any(case.axis.name == axis and motion.fullmatch(case.system) for case in CASES):
        return True
    own = [
        next(iter(scene.model.problems.values())).name
        for scene in map(model_of, gi.scene_names())
        if scene.content.system.name == system
    ]
    assert own
    return bool(set(own) & problems_on(axis))


def test_the_table_of_axes():
    names = [row[0] for row in rows("axis")[2:]]
    assert sorted(names) == sorted(AXES)
    assert {"rest", "zeros", "steady"} <= set(names)


def test_the_table_of_systems():
    head, _, *table = rows("system")
    assert sorted(head[1:]) == sorted(AXES)
    chaplygin = [
        n for n in system_names() if find_system(n).build.__module__.startswith("chaplygin")
    ]
    shown = {row[0] for row in table}
    assert shown <= set(chaplygin)
    for system in set(chaplygin) - shown:
        assert {axis for axis in AXES if covered(system, axis)} <= GENERAL, system
    reasons = set(re.findall(r"^- (\w): ", PAGE, flags=re.MULTILINE))
    for system, *marks in table:
        for axis, mark in zip(head[1:], marks, strict=True):
            assert (mark == "✓") == covered(system, axis), (system, axis)
            assert mark == "✓" or mark in reasons


def test_every_test_problem_is_on_the_axes_of_states():
    rows = {problem.name: problem.rows for problem, _ in examples()}
    small = {name for name in rows if rows[name] <= 30}  # 36 numbers are on no axis of states
    assert set(rows) - small == {"outer-solar-system-6"}
    assert rows.keys() <= problems_on("step")
    assert small <= problems_on("rest") & problems_on("zeros")
    assert small - {"schwarzschild"} <= problems_on(
        "steady"
    )  # its axes are not outside of the hole


def test_the_quick_run_has_every_axis_and_family():
    numbers, methods = selected(Selection(quick=True))
    groups, judged = items_of(numbers, methods, quick=True)
    items = [item for group in groups for item in group]
    assert {CASES[item.case].axis.name for item in items} == set(AXES)
    every = {(family_of(m), m.adaptive) for m in map(gi.find_method, gi.method_names())}
    run = {gi.find_method(item.method) for item in items}
    assert {(family_of(m), m.adaptive) for m in run} == every
    assert not judged


def test_no_groups_of_the_quick_run_share_a_problem():
    groups, _ = items_of(*selected(Selection(quick=True)), quick=True)
    models = [
        {case: sweep._built(CASES[case].build) for case in {i.case for i in g}} for g in groups
    ]
    found = [
        {(p.name, p.rows) for p in (models[k][i.case].problems[i.representation] for i in group)}
        for k, group in enumerate(groups)
    ]
    assert len(groups) > 1
    assert len(set.union(*found)) == sum(map(len, found))


def test_steady_cases_are_steady():
    """Generators are constant along exp(tξ)·y0, in each representation with an action."""
    steady = [case for case in EVERY if case.steady]
    assert len(steady) > 20
    seen = set()
    for case in steady:
        if case.axis.name == "rotation" and case.system in seen:
            continue
        seen.add(case.system)
        model = sweep._built(case.build)
        for name in case.representations or model.problems:
            problem = model.problems[name]
            if problem.action is not None:
                assert is_steady(problem, model.states[name]), (case.system, name)


def test_special_states_are_on_their_manifolds():
    """To rounding: methods project what is off, and would be blamed for it."""
    for case in EVERY:
        if case.axis.name not in ("rest", "zeros", "steady") or case.n > 0:
            continue
        model = sweep._built(case.build)
        for name, problem in model.problems.items():
            if "g" not in problem.slices:
                off = [gi.value(problem, f, model.states[name]) for f in problem.constraints]
                assert all(abs(x) <= 1e-13 for x in off), (case.system, case.value, off)


def test_rest_is_rest():
    case = next(
        c for c in EVERY if c.system == "test:double-spherical-pendulum-px" and c.value == 0.0
    )
    model = case.build()
    (problem,), (y,) = model.problems.values(), model.states.values()
    assert not y[problem.slices["px"]].any()
    assert y[problem.slices["pw"]].any()
