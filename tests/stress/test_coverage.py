"""What the page says is stressed is stressed: axes, systems, the quick run."""

import re
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path

import geomint as gi
from tests.problems import examples
from tests.stress.stress_support import AXES as ALL_AXES, CASES, EVERY, built

AXES = [axis.name for axis in ALL_AXES]
PAGE = (Path(__file__).parents[2] / "docs" / "stress.md").read_text(encoding="utf-8")
# What cases of chaplygin call the motions of a system, if not as the system; sizes and places follow.
MOTIONS = {
    "chaplygin-sphere-reduced": "sphere", "chaplygin-sphere-hamiltonized": "sphere",
    "chaplygin-ball": "ball-diagonal|ball-full|steady|tumbling", "homogeneous-ball": "homogeneous",
    "ball-on-group": "group", "ball-poisson": "poisson", "rolling-ball": "rolling",
    "rubber-ball": "rubber", "veselova": "veselova|veselova-classical",
}  # fmt: skip
GENERAL = {"step", "rest", "zeros", "steady"}  # of all scenes
PLACE = r"(-at-axis|-at-plane|-all-pairs|-straight|-upright)?(-n\d+)?"


def rows(first):
    """Return the rows of the table of the page whose heading begins with a word, cell by cell."""
    start = PAGE.index(f"| {first} |")
    lines = PAGE[start : PAGE.index("\n\n", start)].splitlines()
    return [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in lines]


@cache
def problems_on(axis):
    """Return the names of the problems of scenes and test problems on an axis."""
    found = set()
    for number, case in enumerate(EVERY):
        if case.axis.name == axis and case.system.startswith(("scene:", "test:")):
            found |= {built(number).problems[name].name for name in case.representations}
    return found


@cache
def own_problems():
    """Return the system and the name of the own problem of every built-in scene."""
    scenes = map(gi.load_scene, gi.scene_names())
    return {(scene.content.system.name, scene.problem.name) for scene in scenes}


def covered(system, axis):
    motion = re.compile(f"({MOTIONS.get(system, system)}){PLACE}")
    if any(case.axis.name == axis and motion.fullmatch(case.system) for case in CASES):
        return True
    own = {name for of, name in own_problems() if of == system}
    assert own
    return bool(own & problems_on(axis))


def test_the_table_of_axes():
    names = [row[0] for row in rows("axis")[2:]]
    assert sorted(names) == sorted(AXES)
    assert {"rest", "zeros", "steady"} <= set(names)


def test_the_table_of_systems():
    head, _, *table = rows("system")
    assert sorted(head[1:]) == sorted(AXES)
    offered = entry_points(group="geomint.systems")
    chaplygin = [point.name for point in offered if point.module.startswith("chaplygin")]
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
