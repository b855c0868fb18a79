"""What interpolation says of a function between two nodes, and how far it may be off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, strategies as st

from geomint.kernels.numbers.blocks import Block
from geomint.kernels.solve.sign_changes import look, of_quartic, quartic, verdict, write_weights
from tests.rows import examples

pytestmark = pytest.mark.nojit

UNEVEN = np.cumsum([1.0, 0.8, 1.3, 1.0, 0.7, 1.2, 1.0, 0.9])
PHASES = st.floats(0.0, 6.3)
UNCLEAR = 2  # how many roots there are, but for this


def looked_at(
    function: Callable[[np.ndarray], np.ndarray], nodes: np.ndarray | None = None
) -> tuple[float, float]:
    """The error that is estimated, and that of the quartic, between the last two of eight nodes."""
    even, nodes = nodes is None, np.arange(8.0) if nodes is None else nodes
    values, f, weights = Block(function(nodes)), Block(np.zeros(5)), Block(np.zeros(56))
    write_weights(Block(nodes), 7, even, weights)
    f.data[0], f.data[4] = values.data[6:]
    tail = look(values, weights, f)
    return tail, off(f, lambda x: function(nodes[6] + x * (nodes[7] - nodes[6])))


def off(f: Block, function: Callable[[np.ndarray], np.ndarray]) -> float:
    """How far the quartic is from a function."""
    x = np.linspace(0.0, 1.0, 33)
    return float(np.abs([quartic(f, s) for s in x] - function(x)).max())


def oscillation(
    omega: float, phase: float, harmonic: float = 0.0
) -> Callable[[np.ndarray], np.ndarray]:
    return lambda t: np.cos(omega * t + phase) + harmonic * np.cos(2.0 * omega * t + 1.7 * phase)


@examples(100)
@given(st.floats(1e-3, 3.0), PHASES, st.sampled_from([0.0, 0.2]), st.sampled_from([None, UNEVEN]))
def test_the_error_is_not_underestimated(omega, phase, harmonic, nodes) -> None:
    """At any phase of an oscillation, extrema among them; alone and with a harmonic."""
    tail, error = looked_at(oscillation(omega, phase, harmonic), nodes)
    assert error <= tail + 1e-13
    f, function = Block(np.zeros(5)), oscillation(omega, phase)
    f.data[:] = function(np.linspace(0.0, 1.0, 5))
    assert off(f, function) <= of_quartic(f) + 1e-15


@examples(30)
@given(PHASES)
def test_it_is_not_refused_either(phase: float) -> None:
    """Slow functions are known well, faster ones less, and fast ones not at all."""
    for omega, most in ((0.1, 1e-5), (0.5, 1e-2), (0.8, 0.1)):
        assert looked_at(oscillation(omega, phase))[0] < most
    assert looked_at(oscillation(3.0, phase))[0] >= 1e300


X = np.linspace(0.0, 1.0, 5)


@pytest.mark.parametrize(
    ("values", "tail", "roots", "sign"),
    [
        (1.0 + X, 0.0, 0, 1.0),
        (-1.0 - X, 0.0, 0, -1.0),
        (X - 0.4, 0.0, 1, -1.0),
        (0.6 - X, 0.0, 1, 1.0),
        (X, 0.0, 0, 1.0),  # an end that is 0
        ((X - 0.3) * (X - 0.6), 0.0, UNCLEAR, None),
        ((X - 0.5) ** 2, 0.0, UNCLEAR, None),
        (1.0 + X, 1.2, UNCLEAR, None),
        (1.0 + X, 0.2, 0, 1.0),
        (0.0 * X, 0.0, UNCLEAR, None),
        (1e-300 * (X - 0.4), 0.0, 1, -1.0),
        (1e300 * (X - 0.4), 0.0, 1, -1.0),
    ],
)
def test_verdicts(values: np.ndarray, tail: float, roots: int, sign: float | None) -> None:
    """None, one, not clear; from both sides; with ends that are 0; with errors."""
    found, before = verdict(Block(values), Block(np.zeros(5)), tail, 0.0)
    assert found == roots
    assert sign in (None, before)
