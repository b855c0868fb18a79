"""Frequencies from samples: against sums that are known, against tori, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi


@given(
    nu=st.floats(-2.5, 2.5),
    amplitude=st.complex_numbers(min_magnitude=1e-3, max_magnitude=1e3),
    step=st.sampled_from([0.01, 1.0, 37.0]),
)
def test_one_term_is_found_to_rounding(nu, amplitude, step):
    signal = amplitude * np.exp(1j * nu * np.arange(500))
    (term,) = gi.frequencies(signal, step)
    assert term.frequency * step == pytest.approx(nu, abs=1e-13)
    assert abs(term.amplitude - amplitude) < 1e-10 * abs(amplitude)


@pytest.mark.parametrize(("count", "allowed"), [(1000, 1e-5), (4000, 1e-8), (16000, 1e-11)])
def test_several_terms(count, allowed):
    """The error falls as T^(−2p−2): 1e3 for a factor 4 with p = 2, which is T^(−5) and more."""
    times = np.arange(count) * 0.1
    terms = [(1.0, np.sqrt(2.0)), (0.3j, -np.sqrt(5.0)), (0.02, np.pi)]
    signal = sum(c * np.exp(1j * nu * times) for c, nu in terms)
    found = gi.frequencies(signal, 0.1, terms=3)
    for term, (amplitude, nu) in zip(found, terms, strict=True):
        assert term.frequency == pytest.approx(nu, abs=allowed)
        assert abs(term.amplitude - amplitude) < max(1e3 * allowed, 1e-9)


def test_a_real_signal_has_pairs():
    times = 0.1 * np.arange(4000)
    found = gi.frequencies(np.cos(1.7 * times), 0.1, terms=2)
    assert sorted(term.frequency for term in found) == pytest.approx([-1.7, 1.7], abs=1e-9)


@pytest.mark.parametrize("order", [0, 2, 7])
@pytest.mark.parametrize(
    ("signal", "lines"),
    [
        (np.full(100, 7.0), {0.0: 7.0}),
        (np.full(33, 3.0 - 4.0j), {0.0: 3.0 - 4.0j}),
        (np.exp(0.2j * np.pi * np.arange(100)), {0.2 * np.pi: 1.0}),  # on a line of the transform
        (np.exp(0.3j * np.arange(16)), {0.3: 1.0}),
        (2.0 + (-1.0) ** np.arange(400), {0.0: 2.0, np.pi: 1.0}),
        (1e8 + np.cos(0.7 * np.arange(1000)), {0.0: 1e8, 0.7: 0.5, -0.7: 0.5}),
        (1e12 + np.cos(0.7 * np.arange(4000)), {0.0: 1e12, 0.7: 0.5, -0.7: 0.5}),
        (np.zeros(40), {}),
        (np.zeros(40, dtype=complex), {}),
    ],
)
def test_where_nothing_is_left_nothing_is_found(signal, lines, order):
    """Nor is a term split into several of one frequency."""
    found = gi.frequencies(signal, 1.0, terms=len(lines) + (signal[0] < 1e7), order=order)
    assert len(found) == len(lines)
    for term in found:
        nu = min(lines, key=lambda nu: abs(np.exp(1j * nu) - np.exp(1j * term.frequency)))
        assert np.exp(1j * term.frequency) == pytest.approx(np.exp(1j * nu), abs=1e-4)
        assert term.amplitude == pytest.approx(lines[nu], rel=2e-2)


def test_the_largest_term_is_the_first():
    times = np.arange(1000)
    close = np.exp(0.3j * times) + np.exp(0.31j * times) + 0.1 * np.exp(2.0j * times)
    sizes = [abs(term.amplitude) for term in gi.frequencies(close, 1.0, terms=6)]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(
    ("signal", "step", "terms", "order", "match"),
    [
        (np.zeros(3), 1.0, 1, 2, "at least 16"),
        (np.full(20, np.nan), 1.0, 1, 2, "finite"),
        (np.zeros((20, 2)), 1.0, 1, 2, "in a row"),
        (np.ones(20), 0.0, 1, 2, "step"),
        (np.ones(20), 1.0, 0, 2, "terms"),
        (np.exp(0.3j * np.arange(100)), 1e-320, 1, 2, "inverse"),
    ],
)
def test_nonsense(signal, step, terms, order, match):
    with pytest.raises(gi.DomainError, match=match):
        gi.frequencies(signal, step, terms, order)


@pytest.mark.parametrize("size", [1e-310, 1e-300, 1e300, 1.7e308])
def test_signals_of_any_size(size):
    """Also where |z| is no number any more, or 1/|z|; amplitudes have the signal's size."""
    corners = np.array([1.0 + 1.0j, -1.0 + 1.0j, -1.0 - 1.0j, 1.0 - 1.0j] * 100)
    signal = size * corners.real + 1j * (size * corners.imag)
    (term,) = gi.frequencies(signal, 1.0)
    assert term.frequency == pytest.approx(0.5 * np.pi, abs=1e-9)
    assert term.amplitude.real / size == pytest.approx(1.0, rel=1e-6)
    assert gi.rotation_number(signal).value == pytest.approx(0.5 * np.pi, abs=1e-9)
