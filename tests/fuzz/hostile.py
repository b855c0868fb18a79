"""Values that nobody means: what the mutations put in the place of good ones.

All choices are made by a `random.Random`, so that a seed gives a case again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import datetime
from decimal import Decimal
from fractions import Fraction
from random import Random
from typing import Any

import numpy as np

__all__ = ["NUMBERS", "STRINGS", "Raw", "arrays", "near", "objects", "plain"]


class Raw(str):
    """TOML text that is written as it is."""


NUMBERS: tuple[Any, ...] = (
    *(0, 1, -1, 2, 3, 7, 100, 1001, 10**6, 2**31, 2**53, 2**63 - 1, 2**63, 2**64, -(2**63)),
    *(10**18, 10**308, 10**400, -(10**400), True, False),
    *(0.0, -0.0, 0.5, -1.5, 1e-300, 5e-324, 1e-160, 1e160, 1e300, 1e308, -1e308),
    *(1.7976931348623157e308, math.inf, -math.inf, math.nan, 2.0**53, 1e18),
)
STRINGS: tuple[str, ...] = (
    *("", " ", "a", "0", "1.0", "nan", "γ²", "\x00", "a\x00b", "a/b", "../a", "/", ".", "..", "\\"),
    *("\n", "\x1b[31m", "\u202e", "\ufeff", "😀", "e\u0301", "[red]", "[/]", "%s", "{0}", "None"),
    *("all", "own", "measure", "invariants", "constraints", "energy", "self", "y0", "name"),
    *("gauss-1" + "-suzuki-4" * 2000, "gauss-1-suzuki-4-suzuki-4", "gauss-0", "gauss-99", "rk-4:"),
    *("rk-4:nan", "rk-4:1e400", "rk-4:" + "1" * 5000, "rattle", "verlet-2-yoshida-6", "rkmk-4"),
    *("dop853-adaptive", "gauss-" + "9" * 5000, "x" * 300, "ж" * 100_000, "a,b", "a" * 255),
)


def plain(rng: Random, depth: int = 2) -> Any:
    """Return a value that a scene file can hold, most often a hostile one."""
    kind = rng.randrange(24)
    if kind < 10:
        return rng.choice(NUMBERS)
    if kind < 13:
        return rng.choice(STRINGS)
    if kind < 17:
        return rng.uniform(-3.0, 3.0) * 10.0 ** rng.randint(-20, 20)
    if kind == 17:
        return Raw(rng.choice(_RAW)())
    if depth == 0:
        return rng.choice(([], {}, [[]], [{}]))
    if kind < 23:
        return [plain(rng, depth - 1) for _ in range(rng.choice((0, 1, 2, 3, 4, 9)))]
    return {rng.choice(STRINGS): plain(rng, depth - 1) for _ in range(rng.randrange(4))}


def near(rng: Random, value: Any) -> Any:
    """Return what is left of a good value after something was done to a part of it."""
    if isinstance(value, list | tuple) and value:
        items = list(value)
        at = rng.randrange(len(items))
        what = rng.randrange(10)
        if what == 0:
            del items[at]
        elif what == 1:
            items.insert(at, items[at])
        elif what == 2:
            items = [items] if rng.random() < 0.5 else [[item] for item in items]
        elif what == 3:
            items = items * rng.choice((2, 3, 400))
        else:
            items[at] = plain(rng, 1) if what == 4 else near(rng, items[at])
        return items
    if isinstance(value, bool) or not isinstance(value, int | float):
        return _near_text(rng, value) if isinstance(value, str) else plain(rng)
    if abs(value) > 1e300 or value != value:
        return rng.choice(NUMBERS)
    factors = (-1, 2, 0, 1e-8, 1e8, 1e150, 1e-150)
    changes = (value + 1, int(value), float(value), str(value), [value], rng.choice(NUMBERS))
    return rng.choice((*changes, *(value * factor for factor in factors)))


def _near_text(rng: Random, text: str) -> str:
    at = rng.randint(0, len(text))
    more = rng.choice(("-suzuki-4", "-4", "-adaptive", ":0.1", "²", "/", "-10" * 30))
    put = text[:at] + rng.choice(STRINGS[:27]) + text[at:]
    return rng.choice((text[:at], put, text + more, text.upper(), text * rng.choice((2, 50))))


def arrays(rng: Random, like: Any = None) -> Any:
    """Return something that numpy takes, or nearly takes, for an array."""
    size = rng.choice((0, 1, 2, 3, 4, 6, 50))
    if isinstance(like, list) or (isinstance(like, np.ndarray) and like.ndim):
        size = rng.choice((size, len(like), len(like)))
    numbers = [rng.choice((0.5, 1.0, rng.choice(NUMBERS))) for _ in range(size)]
    makers: tuple[Callable[[], Any], ...] = (
        lambda: numbers, lambda: np.array(numbers, dtype=object),
        lambda: np.ma.masked_array(np.ones(size), mask=[i == 0 for i in range(size)]),
        lambda: np.ones(size) * 1j, lambda: np.ones(size, dtype=np.float32),
        lambda: np.ones(size, dtype=bool), lambda: np.full(size, 1e308),
        lambda: np.full(size, 1e-320), lambda: np.arange(size), lambda: np.ones((size, 1)),
        lambda: np.ones((size, size)),
        lambda: np.eye(size) * rng.choice((1e308, 1e-308, -1.0, math.nan, 2.0)),
        lambda: np.array(["1"] * size), lambda: np.zeros(size, dtype="datetime64[s]"),
        lambda: np.zeros(size, dtype=[("a", float)]), lambda: range(size), lambda: iter(numbers),
        lambda: dict.fromkeys("abc", 1.0), lambda: {1.0, 2.0, 3.0}, lambda: [[1.0, 2.0], [3.0]],
        lambda: (Decimal(1), Fraction(1, 3), Decimal("NaN"))[: max(size, 1)], lambda: b"123",
        lambda: np.longdouble(3.0),
    )  # fmt: skip
    return rng.choice(makers)()


class Unprintable:
    """An object that has no text."""

    def __repr__(self) -> str:
        raise RuntimeError("no text")


class Unmeasurable:
    """A sequence that does not tell its length."""

    def __len__(self) -> int:
        raise RuntimeError("no length")

    def __getitem__(self, index: Any) -> float:
        raise IndexError


def _cycle() -> Any:
    value: list[Any] = [1.0]
    value.append(value)
    return value


def _nest(depth: int) -> Any:
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


def objects(rng: Random) -> Any:
    """Return an object that only Python can hand over."""
    makers: tuple[Callable[[], Any], ...] = (
        lambda: None, object, lambda: object, lambda: len, lambda: lambda: 1.0, lambda: 1j,
        lambda: complex("nan"), lambda: Decimal("1e-400"), lambda: Decimal("sNaN"),
        lambda: Fraction(1, 3), lambda: np.float64("nan"), lambda: np.int64(3),
        lambda: np.bool_(True), lambda: np.array(3.0), lambda: b"gauss-8", lambda: "\ud800",
        Unprintable, Unmeasurable, _cycle, lambda: _nest(40), lambda: _nest(100_000),
        lambda: 7**20_000, lambda: datetime(2000, 1, 1), lambda: slice(1, 2),
        lambda: {None: 1, 2: 3}, lambda: {"energy": None},
        lambda: {"a/b": lambda params, t, y, work: 1.0}, lambda: ["energy", "energy"],
        lambda: ["energy", 3], lambda: [None], lambda: [["energy"]],
    )  # fmt: skip
    return rng.choice(makers)()


_RAW: tuple[Callable[[], str], ...] = (
    lambda: "9" * 5000, lambda: "0x" + "f" * 5000, lambda: "1." + "3" * 5000, lambda: "1e999",
    lambda: "-nan", lambda: "[" * 150 + "]" * 150, lambda: "[" * 5000 + "]" * 5000,
    lambda: "{a=" * 3000 + "1" + "}" * 3000, lambda: "1979-05-27T07:32:00Z", lambda: "07:32:00",
    lambda: '"' + "\\u0000" + '"', lambda: "'''" + "\n" * 100 + "'''",
    lambda: "[" + "0.5," * 20_000 + "]", lambda: "1_000",
)  # fmt: skip
