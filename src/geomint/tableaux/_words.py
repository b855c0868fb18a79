"""Truncated series of words: the algebra in which compositions of flows are compared.

The flow of a combination of non-commuting fields is a series of words, whose letters are the
fields, and composing flows multiplies the series by concatenating words, the flow that acts first
on the left. Every letter has a weight, the power of the step it comes with; words heavier than the
order of interest are dropped.
"""

from collections.abc import Callable, Hashable, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import TypeVar

Letter = TypeVar("Letter", bound=Hashable)
Number = TypeVar("Number", Fraction, Decimal)


def exponential(
    field: Mapping[Letter, Number], weight: Callable[[Letter], int], order: int, one: Number
) -> dict[tuple[Letter, ...], Number]:
    """Return the series of the flow of a field: ``v(a_1) ... v(a_n) / n!`` for ``a_1 ... a_n``.

    Parameters
    ----------
    field : mapping
        Coefficients v of the letters.
    weight : callable
        Weight of a letter, at least 1.
    order : int
        Weight of the heaviest words to keep.
    one : Fraction or Decimal
        The number 1.
    """
    series = {}

    def extend(word: tuple[Letter, ...], value: Number, room: int) -> None:
        """Enter a word and all words that begin with it."""
        series[word] = value
        for letter, v in field.items():
            if weight(letter) <= room:
                extend((*word, letter), value * v / (len(word) + 1), room - weight(letter))

    extend((), one, order)
    return series


def compose(
    first: Mapping[tuple[Letter, ...], Number],
    second: Mapping[tuple[Letter, ...], Number],
    weight: Callable[[Letter], int],
    order: int,
) -> dict[tuple[Letter, ...], Number]:
    """Return the series of the flow `second` after the flow `first`."""
    weights = {word: sum(map(weight, word)) for word in (*first, *second)}
    series: dict[tuple[Letter, ...], Number] = {}
    for word, x in first.items():
        for other, y in second.items():
            if weights[word] + weights[other] <= order:
                joined = word + other
                series[joined] = series[joined] + x * y if joined in series else x * y
    return series


def distance(
    x: Mapping[tuple[Letter, ...], Number], y: Mapping[tuple[Letter, ...], Number], zero: Number
) -> Number:
    """Return the largest difference of two coefficients of the same word."""
    return max(abs(x.get(word, zero) - y.get(word, zero)) for word in {**x, **y})
