"""What the rows of tests take: the fast one a few examples of a property, the nightly one hundreds."""

from __future__ import annotations

from hypothesis import settings

FEW, MANY = 10, 250


def examples(count: int, **options: object) -> settings:
    """Take `count` examples in the fast row, and as many times more at night."""
    return settings(max_examples=count * settings.default.max_examples // FEW, **options)
