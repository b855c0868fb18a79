"""Settings of the test run.

Compiled code is kept in the user's cache folder, or where ``NUMBA_CACHE_DIR`` says, under a stamp of
the sources: a second run compiles nothing.
"""

from __future__ import annotations

import os

from hypothesis import settings

# The same examples in every run; HYPOTHESIS_PROFILE=explore looks for new ones.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))
