"""Settings of the test run.

Compiled code is kept in the user's cache folder, or where ``NUMBA_CACHE_DIR`` says, under a stamp of
the sources: a second run compiles nothing.
"""

from __future__ import annotations

import os

import pytest
from hypothesis import settings

# The same examples in every run; HYPOTHESIS_PROFILE=explore looks for new ones.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


@pytest.fixture
def short_chains(monkeypatch: pytest.MonkeyPatch) -> None:
    """End the chains of draws after a few moves: where nothing is asked of their distribution."""
    from geomint.run import chains

    for name, value in (("PILOT", 5), ("PILOTS", 1), ("FORGET", 0.0)):
        monkeypatch.setattr(chains, name, value)
