"""Windows: their memory is bounded and their bits do not depend on how the series is cut."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from geomint.watch.windows import MAX_WINDOWS, Series


def series(count):
    rng = np.random.default_rng(1)
    return np.arange(1.0, count + 1.0) * 0.01, 1.0 + 1e-12 * np.cumsum(rng.normal(size=count))


def filled(times, values, cuts):
    """Return the windows of the second of three series."""
    series = Series(np.array([0.5, 1.0, 2.0]), 0.0)
    for part_times, part_values in zip(np.split(times, cuts), np.split(values, cuts), strict=True):
        series.add(part_times, np.array([0.5 * part_values, part_values, 3.0 * part_values]))
    return series.windows()[1]


def assert_same(a, b):
    assert (a.length, a.samples, a.last, a.last_time) == (b.length, b.samples, b.last, b.last_time)
    assert a.max_abs == b.max_abs
    for one, other in ((a.times, b.times), (a.means, b.means), (a.maxima, b.maxima)):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("count", [1, 1023, 1024, 1025, 2048, 5000, 50_000])
@pytest.mark.parametrize("chunk", [1, 7, 1000, 1024, 4096])
def test_the_bits_do_not_depend_on_chunks(count, chunk):
    times, values = series(count)
    assert_same(filled(times, values, []), filled(times, values, list(range(chunk, count, chunk))))


@given(st.lists(st.integers(0, 9000), max_size=20))
def test_the_bits_do_not_depend_on_any_cuts(cuts):
    times, values = series(9000)
    assert_same(filled(times, values, []), filled(times, values, sorted(cuts)))


@pytest.mark.parametrize("count", [1, 63, 1000, 1023, 1024, 3000, 123_456])
def test_windows_are_what_they_say(count):
    times, values = series(count)
    windows = filled(times, values, [])
    deviations = values - 1.0
    full = count // windows.length
    assert len(windows.times) == full < MAX_WINDOWS
    assert count < MAX_WINDOWS or full >= MAX_WINDOWS // 2
    used = deviations[: full * windows.length].reshape(full, -1)
    np.testing.assert_allclose(windows.means, used.mean(axis=1), rtol=1e-9, atol=1e-27)
    np.testing.assert_array_equal(windows.maxima, np.abs(used).max(axis=1))
    middle = times[: full * windows.length].reshape(full, -1).mean(axis=1)
    np.testing.assert_allclose(windows.times, middle, rtol=1e-12)
    assert windows.max_abs == np.abs(deviations).max()
    assert windows.last == deviations[-1]
    assert windows.samples == count


def test_what_is_not_finite_shows():
    series = Series(np.array([0.0, -1e308, np.inf, 0.0]), -1.0)
    first = [[1.0, np.nan, 2.0], [1.0, 1.7e308, 2.0], [1.0, 2.0, 3.0], [1.0, 2.0, 3.0]]
    series.add(np.arange(3.0), np.array(first))
    series.add(np.arange(3.0), np.ones((4, 3)))
    a, b, c, d = series.windows()
    assert np.isnan(a.max_abs)
    assert [x.not_finite_from for x in (a, b, c, d)] == [1.0, 1.0, -1.0, None]
    assert (d.max_abs, d.last) == (3.0, 1.0)
