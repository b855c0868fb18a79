"""Figures of drifts: drawn for any series, readable in print, and nothing left unsaid."""

import io

import matplotlib as mpl
import numpy as np

from geomint.plots.drift_plots import drift_figure
from tests.series import drift_of_series

N = 4000
T = np.arange(1, N + 1) / N
SERIES = {
    "oscillation": 1e-9 * np.sin(300.0 * T), "line": 1e-10 * T, "zero": np.zeros(N),
    "half-zero": np.where(T < 0.5, 0.0, 1e-15), "not-finite": np.where(T < 0.9, T**3, np.nan),
    "huge": 1e300 * T, "one": np.array([1e-3]), "none": np.zeros(0),
}  # fmt: skip


def drift(name, sign=1.0):
    times = sign * np.arange(1.0, len(SERIES[name]) + 1.0)
    return drift_of_series(name, times, 1.0 + SERIES[name], 1.0, initial=1.0)


DRIFTS = {name: drift(name) for name in SERIES}


def texts(figure):
    found = figure.findobj(match=lambda a: hasattr(a, "get_text"))
    return "\n".join(text.get_text() for text in found)


def test_one_run_shows_sizes_and_means():
    """Of anything; what a logarithmic axis cannot show is said."""
    before = dict(mpl.rcParams)
    figure = drift_figure([("cf-4", DRIFTS)], "tau", "failed")
    assert dict(mpl.rcParams) == before
    assert figure.get_size_inches()[0] == 6.5
    panels = dict(zip(SERIES, zip(figure.axes[::2], figure.axes[1::2], strict=True), strict=True))
    for name, (sizes, means) in panels.items():
        windows = DRIFTS[name].windows
        for line, numbers, most in (
            (sizes.lines[0], windows.maxima, 1e200),
            (means.lines[1], windows.means, 1e307),
        ):
            times, values = map(np.asarray, line.get_data())
            drawn = np.isfinite(values)
            kept = (np.abs(numbers) < most) & ((numbers > 0.0) | (line.axes is means))
            np.testing.assert_array_equal(times[drawn], windows.times[kept])
            np.testing.assert_array_equal(values[drawn], numbers[kept])
    for name, kind, words in (
        ("zero", 0, "exactly 0 throughout"),
        ("zero", 1, "exactly 0 throughout"),
        ("half-zero", 0, "exactly 0 in"),
        ("not-finite", 0, "or not finite in"),
        ("not-finite", 1, "not finite"),
        ("none", 0, "shorter than a window"),
        ("line", 0, "round-off"),
        ("line", 1, "trend"),
    ):
        assert words in texts(panels[name][kind])
    assert "τ (dimensionless)" in texts(figure)
    assert "run failed" in texts(figure)
    figure.savefig(io.BytesIO(), format="png")
    assert min(t.get_fontsize() for t in figure.findobj(mpl.text.Text) if t.get_text()) >= 8.0
    assert "no quantity was watched" in texts(drift_figure([("cf-4", {})], "t"))


def test_several_runs_share_panels_and_a_legend():
    """Also of runs that the first panel lacks; they are told apart without colour."""
    runs = [("cf-4", {"zero": drift("zero")})]
    runs += [(f"m{i}", {"line": drift("line", (-1.0) ** i)}) for i in range(34)]
    figure = drift_figure(runs, "t")
    assert len(figure.axes) == 2
    assert [t.get_text() for t in figure.legends[0].get_texts()] == [name for name, _ in runs]
    lines = figure.axes[1].lines[:34]
    styles = {(line.get_marker(), str(line._unscaled_dash_pattern)) for line in lines}
    assert len(styles) == 34
    assert len({line.get_color() for line in lines}) == 7
    windows = DRIFTS["line"].windows
    for line in lines:  # the largest of equal steps of log time
        times, sizes = line.get_data()
        assert len(times) <= 60
        assert (times[-1], sizes[-1]) == (windows.times[-1], windows.maxima[-1])
        assert set(sizes) <= set(windows.maxima)
        assert (np.diff(times) > 0.0).all()
