"""The drift report: the contract of ``drift.json``, and a page that needs nothing but itself."""

import base64
import json
import math
import re
from html.parser import HTMLParser

import pytest

import geomint as gi
from geomint.report.drift_page import write_drift_report
from geomint.report.text import number, parameters_told, with_error
from geomint.run.provenance import finite_json
from geomint.watch.growth import CLASSES

NUMBERS = [
    "initial",
    "max_abs_error",
    "scale",
    "final_error",
    "slope",
    "slope_stderr",
    "trend_bound",
]


def quantities(record):
    """Return the quantities of the one method."""
    (entry,) = record["methods"].values()
    return entry["quantities"]


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    scene = gi.load_scene("ball-3d").changed(time={"t_end": 40.0})
    return folder, gi.drift_report(scene, folder, progress=False)["cf-4"].solution


@pytest.fixture(scope="module")
def record(report):
    def refuse(constant):
        raise AssertionError(f"{constant} is no JSON")

    text = (report[0] / "drift.json").read_text(encoding="utf-8")
    return json.loads(text, parse_constant=refuse)


@pytest.fixture(scope="module")
def page(report):
    return (report[0] / "report.html").read_text(encoding="utf-8")


def test_parameters_are_those_given(page):
    """Under their keys and symbols, in their order; what the equations have beside follows."""
    told = re.findall(r"<dt>([^<]*)</dt><dd>([^<]*)</dd>", page)
    names = [name for name, _ in told]
    first = names.index("moments (I)")
    assert told[first : first + 2] == [("moments (I)", "1, 2, 3"), ("D", "1")]
    assert "a" not in names[:first]


def test_a_weight_is_told_as_it_was_given():
    ball = {"name": "rolling-ball", "moments": [0.4, 0.5, 0.7], "m": 2.0, "rho": 0.5}
    state = {"gamma": [0.48, 0.6, 0.64], "omega": [1.0, -2.0, 1.5]}
    scene = gi.Scene("r", system=ball, initial=state, time={"t_end": 1.0})
    told = parameters_told(scene, scene.problem)
    assert list(told)[:3] == ["moments (I)", "m", "rho (ρ)"]
    assert [told[key] for key in list(told)[:3]] == ["0.4, 0.5, 0.7", "2", "0.5"]
    assert "D" in told  # of the equations


def test_the_contract(record):
    """That of several methods, with one."""
    assert (record["status"], record["time"], record["physical_end"]) == ("success", "t", None)
    assert list(record["methods"]) == ["cf-4"]
    names = {"energy", "K", "area", "norm", "spatial-momentum", "measure"}
    assert set(quantities(record)) == names == set(record["kinds"])
    for quantity in quantities(record).values():
        assert quantity["class"] in CLASSES
        for key in NUMBERS:
            assert isinstance(quantity[key], int | float)
            assert math.isfinite(quantity[key])
        if quantity["initial"] == 0:
            assert quantity["max_rel_error"] is None
            assert quantity["scale"] > 0
        else:
            expected = quantity["max_abs_error"] / abs(quantity["initial"])
            assert quantity["max_rel_error"] == pytest.approx(expected, rel=1e-12)
        assert abs(quantity["final_error"]) <= quantity["max_abs_error"]


def test_the_numbers_are_those_of_the_solution(record, report):
    solution = report[1]
    for name, drift in solution.drift.items():
        quantity = quantities(record)[name]
        assert quantity["max_abs_error"] == drift.max_abs_error
        assert quantity["slope"] == drift.slope
        assert quantity["class"] == drift.drift_class


def test_provenance_is_complete(record):
    provenance, run = record["provenance"], record["methods"]["cf-4"]["run"]
    for key in ("geomint", "python", "numpy", "numba"):
        assert provenance["versions"][key]
    for key in ("cpu", "platform", "date", "scene_toml", "scene_hash"):
        assert provenance[key]
    assert (run["step"], run["method"], run["status"]) == (0.02, "cf-4", "success")
    assert run["field_evaluations"] == 4 * run["steps"] == 8000


@pytest.mark.usefixtures("blank_pictures")
def test_the_scene_of_the_provenance_gives_the_same_numbers(record, tmp_path):
    path = tmp_path / "again.toml"
    path.write_text(record["provenance"]["scene_toml"], encoding="utf-8")
    gi.drift_report(path, tmp_path / "again", progress=False)
    again = json.loads((tmp_path / "again" / "drift.json").read_text(encoding="utf-8"))
    assert quantities(again) == quantities(record)
    assert again["provenance"]["scene_hash"] == record["provenance"]["scene_hash"]


class Links(HTMLParser):
    def __init__(self):
        super().__init__()
        self.found, self.ids, self.images = [], [], []

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        self.found += [named[key] for key in ("src", "href", "action", "data") if key in named]
        assert tag not in ("script", "link", "iframe", "object", "embed")
        if tag == "img":
            self.images.append(named)


def test_the_page_loads_nothing(page):
    links = Links()
    links.feed(page)
    assert links.found
    assert all(link.startswith("data:image/svg+xml;base64,") for link in links.found)
    assert "http" not in re.sub(r'"data:[^"]*"', "", page)
    assert "@import" not in page
    assert "url(" not in page


def test_images_are_pictures_with_words(page):
    links = Links()
    links.feed(page)
    assert len(links.images) == 10  # motion 4, two kinds beyond round-off, two folded
    for image in links.images:
        assert image["alt"]
        svg = base64.b64decode(image["src"].split(",", 1)[1]).decode("utf-8")
        assert "<svg" in svg
        # Names of namespaces and licences aside, nothing in a picture points outside.
        assert not re.findall(r'(?:href|src)="(?!#)', svg)


def test_the_page_tells_what_was_done(page, record):
    for words in (
        "Classical Chaplygin ball",
        "cf-4, order 4",
        "0.02 in t",
        "2\u202f000",
        "spatial-momentum",
        "trend over the run ≤",
        "No larger than 32 ε × scale: K, area",
        "(scale ",
        "prefers-color-scheme: dark",
        "@media print",
        "width=device-width",
        record["provenance"]["scene_hash"],
        "The window means",
    ):
        assert words in page
    for quantity in quantities(record).values():
        assert f'<span class="kind {quantity["class"]}">' in page


def test_titles_are_escaped(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(
        title="<script>alert(1)</script> & co", time={"t_end": 1.0}
    )
    gi.drift_report(scene, tmp_path, progress=False)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<script>" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; co" in page


def test_nothing_watched(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(observe={"quantities": []}, time={"t_end": 1.0})
    gi.drift_report(scene, tmp_path, progress=False)
    assert quantities(json.loads((tmp_path / "drift.json").read_text())) == {}
    assert "No quantity was watched" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_backwards(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(time={"t_end": -100.0})
    solution = gi.drift_report(scene, tmp_path, progress=False)[0].solution
    assert solution.tau[-1] == -100.0
    assert solution.drift["energy"].slope is not None


def test_physical_time_of_a_problem_in_tau(tmp_path):
    scene = gi.load_scene("hamiltonized-n3").changed(time={"t_end": 50.0})
    gi.drift_report(scene, tmp_path, progress=False)
    record = json.loads((tmp_path / "drift.json").read_text())
    assert record["methods"]["gauss-8"]["run"]["drift_time"] == record["time"] == "t"
    assert "slope per unit of t" in (tmp_path / "report.html").read_text(encoding="utf-8")
    own = gi.load_scene("hamiltonized-n3").changed(time={"tau_end": 50.0})
    assert gi.drift_report(own, tmp_path, progress=False)[0].solution.drift_time == "tau"
    assert "slope per unit of τ" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_what_is_not_finite_is_null():
    assert finite_json({"a": [math.nan, math.inf, 1.0], 1: None}) == {
        "a": [None, None, 1.0],
        "1": None,
    }


def test_numbers_for_readers():
    assert number(None) == "—"
    assert number(math.nan) == "not finite"
    assert number(-1.234e-11) == "−1.23e-11"
    assert number(0.0) == "0"
    assert with_error(9.599333e-15, 2.3e-20) == "(9.599333 ± 0.000023)e-15"
    assert with_error(-1.0e-20, 1.7e-20) == "(−1.0 ± 1.7)e-20"
    assert with_error(0.0, 0.0) == "0"
    assert with_error(None, None) == "—"
    assert with_error(1.0, 0.0) == "(1.00 ± 0.00)e+00"


@pytest.mark.usefixtures("blank_pictures")
def test_a_report_of_python_is_that_of_the_command(tmp_path, report):
    scene = gi.load_scene("ball-3d").changed(time={"t_end": 40.0}).for_drift()
    page = write_drift_report(gi.run_methods(scene, ["cf-4"], False), tmp_path, "geomint drift x")
    assert "geomint drift x" in page.read_text(encoding="utf-8")
    one, other = (
        quantities(json.loads((folder / "drift.json").read_text(encoding="utf-8")))
        for folder in (tmp_path, report[0])
    )
    assert one == other
