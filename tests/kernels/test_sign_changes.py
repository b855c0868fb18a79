"""What interpolation says of a function between two nodes, and how far it may be off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from geomint.kernels.numbers.blocks import scalar_block
from geomint.kernels.solve import sign_changes as sc

pytestmark = pytest.mark.nojit

PHASES = np.linspace(0.0, 2.0 * np.pi, 73)


def looked_at(
    function: Callable[[np.ndarray], np.ndarray], even: bool = True
) -> tuple[float, float]:
    """The error that is estimated, and that of the quartic, between the last two of eight nodes."""
    nodes = np.arange(8.0) if even else np.cumsum([1.0, 0.8, 1.3, 1.0, 0.7, 1.2, 1.0, 0.9])
    times, values, f = scalar_block(8), scalar_block(8), scalar_block(5)
    weights = scalar_block(sc.WEIGHTS)
    times.data[:], values.data[:] = nodes, function(nodes)
    sc.write_weights(times, 7, even, weights)
    f.data[0], f.data[4] = values.data[6], values.data[7]
    tail = sc.look(values, weights, f)
    x = np.linspace(0.0, 1.0, 33)
    found = np.array([sc.quartic(f, s) for s in x])
    return tail, float(np.abs(found - function(nodes[6] + x * (nodes[7] - nodes[6]))).max())


def oscillation(
    omega: float, phase: float, harmonic: float = 0.0
) -> Callable[[np.ndarray], np.ndarray]:
    return lambda t: np.cos(omega * t + phase) + harmonic * np.cos(2.0 * omega * t + 1.7 * phase)


@pytest.mark.parametrize("even", [True, False])
@pytest.mark.parametrize("omega", [1e-3, 0.1, 0.3, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0, 2.8])
def test_the_error_is_not_underestimated(omega: float, even: bool) -> None:
    """At any phase of an oscillation, extrema among them; alone and with a harmonic."""
    for harmonic in (0.0, 0.2):
        for phase in PHASES:
            tail, error = looked_at(oscillation(omega, phase, harmonic), even)
            assert error <= tail + 1e-13


def test_it_is_not_refused_either() -> None:
    """Slow functions are known well, faster ones less, and fast ones not at all."""
    for omega, most in ((0.1, 1e-5), (0.5, 1e-2), (0.8, 0.1)):
        assert max(looked_at(oscillation(omega, phase))[0] for phase in PHASES) < most
    assert min(looked_at(oscillation(3.0, phase))[0] for phase in PHASES) >= 1e300


def signs(*values: float, tail: float = 0.0, rounding: float = 0.0) -> tuple[int, float]:
    f, b = scalar_block(5), scalar_block(5)
    f.data[:] = values
    return sc.verdict(f, b, tail, rounding)


def test_verdicts() -> None:
    """None, one, not clear; from both sides; with ends that are 0; with errors."""
    x = np.linspace(0.0, 1.0, 5)
    assert signs(*(1.0 + x)) == (sc.NONE, 1.0)
    assert signs(*(-1.0 - x)) == (sc.NONE, -1.0)
    assert signs(*(x - 0.4)) == (sc.ONE, -1.0)
    assert signs(*(0.6 - x)) == (sc.ONE, 1.0)
    assert signs(*x)[0] == sc.NONE
    assert signs(*x)[1] == 1.0
    assert signs(*((x - 0.3) * (x - 0.6)))[0] == sc.UNCLEAR
    assert signs(*((x - 0.5) ** 2))[0] == sc.UNCLEAR
    assert signs(*(1.0 + x), tail=1.2)[0] == sc.UNCLEAR
    assert signs(0.0, 0.0, 0.0, 0.0, 0.0)[0] == sc.UNCLEAR
    assert signs(*(1e-300 * (x - 0.4)))[0] == sc.ONE
    assert signs(*(1e300 * (x - 0.4)))[0] == sc.ONE


@pytest.mark.parametrize("omega", [1e-2, 0.3, 1.0, 2.0, 3.0])
def test_the_error_of_a_quartic(omega: float) -> None:
    """Through values that are known, at any phase of an oscillation."""
    x, f = np.linspace(0.0, 1.0, 65), scalar_block(5)
    for phase in PHASES:
        function = oscillation(omega, phase)
        f.data[:] = function(np.linspace(0.0, 1.0, 5))
        error = np.abs([sc.quartic(f, s) for s in x] - function(x)).max()
        assert error <= sc.of_quartic(f) + 1e-15
