"""Texts of at most 80 columns and some lines, tables of HTML that escape foreign names."""

from html.parser import HTMLParser

import pytest

import geomint as gi


class Cells(HTMLParser):
    """The texts of cells; any tag that is none of a table is a mistake."""

    def __init__(self, text):
        super().__init__()
        self.open, self.cells = [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        assert tag in ("table", "caption", "tbody", "tr", "th", "td")
        self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.cells.append(data)


@pytest.fixture(scope="module")
def values():
    scene = gi.load_scene("sphere-n3").changed(time={"t_end": 2.0})
    solution = gi.run_scene(scene, progress=False)
    plan = gi.make_plan(scene, costs=True)
    return [solution, solution.as_saved(), plan, scene.problem, *solution.drift.values()]


def test_texts_are_short_and_tables_say_as_much(values):
    for value in [
        *values,
        *(p for n in gi.scene_names() for p in gi.load_scene(n).model.problems.values()),
    ]:
        lines = repr(value).splitlines()
        assert len(lines) <= 16
        assert max(map(len, lines)) <= 80
        cells = Cells(value._repr_html_()).cells
        more = len(cells[1::2]) - 8
        assert lines[-1].endswith("more>" if more > 0 else ">")
        assert (f"; and {more} more>" in " ".join(map(str.strip, lines))) == (more > 0)
        assert len(cells) >= 7
        assert all(cells)


def test_tables_of_methods():
    for method in map(gi.find_method, gi.method_names()):
        cells = Cells(method._repr_html_()).cells
        assert cells[0] == repr(method)
        facts = dict(zip(cells[1::2], cells[2::2], strict=True))
        told = facts["name"], facts["order"], facts["needs"]
        assert told == (method.name, str(method.order), method.needs)
        assert ("symplectic" in facts.get("structure", "")) == method.symplectic


@gi.field
def still(params, t, y, out, work):
    out[0] = 0.0 * y[0]


HOSTILE = "<script>alert('&')</script>" + "\x1b[2J" + "x" * 1000


def test_foreign_names_are_escaped_and_cut():
    problem = gi.Problem(HOSTILE, (("<b>", 1),), field=still, parameters={HOSTILE: 1.0})
    solution = gi.solve(problem, [1.0], t_end=1.0, step=0.5, method="rk-4", compiled=False)
    for value in (problem, solution):
        text, html = repr(value), value._repr_html_()
        assert "\x1b" not in text + html
        assert max(map(len, text.splitlines())) <= 80
        assert len(text) < 1500
        assert "<script>" in text
        assert any("<script>" in cell for cell in Cells(html).cells)


class Broken:
    def __repr__(self):
        raise RuntimeError("no")


class Many(gi.Problem):
    def _shown(self):
        return "many", {**{f"fact{i}": i for i in range(19)}, "broken": Broken()}


def test_of_many_facts_a_text_has_some_and_a_table_all():
    """What says nothing of itself is quoted."""
    many = Many("many", (("x", 1),), field=still)
    assert "and 12 more>" in repr(many)
    cells = Cells(many._repr_html_()).cells
    assert len(cells) == 41
    assert "RuntimeError" in cells[-1]
