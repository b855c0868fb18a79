"""Figures: drawn for any series, readable in print, and nothing left unsaid."""

import matplotlib
import numpy as np
import pytest

from geomint.plots.drift_plots import draw_means, draw_sizes, drift_figure, panel_figure
from geomint.plots.style import COLOURS, Picture, data_uri, series_style
from tests.series import drift_of_series

N = 4000
T = np.arange(1, N + 1) / N
SERIES = {
    "oscillation": 1e-9 * np.sin(300.0 * T),
    "line": 1e-10 * T,
    "zero": np.zeros(N),
    "half-zero": np.where(T < 0.5, 0.0, 1e-15),
    "not-finite": np.where(T < 0.9, T**3, np.nan),
    "huge": 1e300 * T,
    "one": np.array([1e-3]),
    "none": np.zeros(0),
}


def drift(name):
    times = np.arange(1.0, len(SERIES[name]) + 1.0)
    return drift_of_series(name, times, 1.0 + SERIES[name], 1.0, initial=1.0)


def panel_of(kind, name):
    if kind == "means":
        return panel_figure(lambda axes: draw_means(axes, name, drift(name), "t"))
    return panel_figure(lambda axes: draw_sizes(axes, name, [(0, "_", drift(name))], "t"))


def texts(figure):
    figure.canvas.draw()
    return "\n".join(t.get_text() for t in figure.findobj(match=lambda a: hasattr(a, "get_text")))


@pytest.mark.parametrize("name", SERIES)
@pytest.mark.parametrize("kind", ["sizes", "means"])
def test_a_panel_of_anything(name, kind):
    uri = data_uri(panel_of(kind, name))
    assert uri.startswith("data:image/svg+xml;base64,")
    assert len(uri) > 5000


def test_what_a_logarithmic_axis_cannot_show_is_said():
    shown = texts(panel_of("sizes", "zero"))
    assert "exactly 0 throughout" in shown
    assert "exactly 0 in" in texts(panel_of("sizes", "half-zero"))
    assert "or not finite in" in texts(panel_of("sizes", "not-finite"))
    assert "shorter than a window" in texts(panel_of("sizes", "none"))
    assert "exactly 0 throughout" in texts(panel_of("means", "zero"))


def test_one_run_shows_sizes_and_means(tmp_path):
    figure = drift_figure([("cf-4", {name: drift(name) for name in SERIES})], "tau")
    assert len(figure.axes) == 2 * len(SERIES)
    assert figure.get_size_inches()[0] == 6.5
    shown = texts(figure)
    assert "τ (dimensionless)" in shown
    assert "32 ε × scale" in shown
    Picture(figure).save(tmp_path, "drift")
    assert (tmp_path / "drift.png").stat().st_size > 10_000
    assert (tmp_path / "drift.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_a_picture_is_drawn_once(tmp_path, monkeypatch):
    """For the page and its files; a file has a ground of its own, as viewers may be dark."""
    figure = drift_figure([("cf-4", {"line": drift("line")})], "t")
    kinds, draw = [], figure.savefig
    monkeypatch.setattr(figure, "savefig", lambda to, **k: kinds.append(str(to)) or draw(to, **k))
    picture = Picture(figure)
    uri = picture.uri
    picture.save(tmp_path, "drift")
    assert picture.uri == uri
    assert len(kinds) == 2
    text = (tmp_path / "drift.svg").read_text(encoding="utf-8")
    assert text.replace('<rect width="100%" height="100%" fill="#ffffff"/>', "", 1) == picture.svg
    assert text != picture.svg


def test_several_runs_share_panels_and_a_legend():
    drifts = {name: drift(name) for name in SERIES}
    runs = [("cf-4", drifts), ("gauss-8", drifts), ("rk-4", {"line": drift("line")})]
    figure = drift_figure(runs, "t")
    assert len(figure.axes) == len(SERIES)
    labels = [t.get_text() for t in figure.legends[0].get_texts()]
    assert labels[:2] == ["cf-4", "gauss-8"]


def test_the_legend_names_runs_that_the_first_panel_lacks():
    runs = [("a", {"zero": drift("zero")}), ("b", {"line": drift("line")})]
    labels = [t.get_text() for t in drift_figure(runs, "t").legends[0].get_texts()]
    assert labels == ["a", "b"]


def test_nothing_watched():
    assert "no quantity was watched" in texts(drift_figure([("cf-4", {})], "t"))


def test_no_font_is_smaller_than_eight_points():
    figure = drift_figure([("cf-4", {"line": drift("line"), "zero": drift("zero")})], "t")
    figure.canvas.draw()
    sizes = [
        text.get_fontsize()
        for text in figure.findobj(match=lambda a: hasattr(a, "get_fontsize"))
        if text.get_text()
    ]
    assert min(sizes) >= 8.0


def test_series_are_told_apart_without_colour():
    styles = [series_style(i) for i in range(35)]
    assert len({(s["marker"], str(s["linestyle"])) for s in styles}) == 35
    assert len(COLOURS) == 7


def test_the_users_settings_are_left_alone():
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    drift_figure([("cf-4", {"line": drift("line")})], "t")
    assert dict(mpl.rcParams) == before


@pytest.mark.parametrize(
    "settings",
    [
        {"text.usetex": True},
        {"savefig.format": "pdf", "image.cmap": "gray", "savefig.bbox": "tight"},
        {"svg.fonttype": "none", "path.simplify": False, "figure.facecolor": "red"},
        {"axes.prop_cycle": matplotlib.cycler(color=["red"]), "xtick.direction": "in"},
    ],
    ids=str,
)
def test_pictures_do_not_depend_on_the_users_settings(settings, tmp_path):
    """Neither while they are made nor while they are saved."""

    def content(name):
        Picture(drift_figure([("cf-4", {"line": drift("line")})], "t")).save(tmp_path, name)
        return [(tmp_path / f"{name}.{ending}").read_bytes() for ending in ("png", "svg")]

    expected = content("a")
    with matplotlib.rc_context(settings):
        assert content("b") == expected
