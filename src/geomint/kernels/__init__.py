"""What runs compiled: numbers, blocks, steppers, group actions. Imports nothing above itself."""

import os


def sources() -> dict[str, int]:
    """Return when each source of this folder was written; clocks may differ, so they are compared."""
    folders = os.walk(os.path.dirname(__file__))
    paths = (os.path.join(folder, name) for folder, _, names in folders for name in names)
    return {p: os.stat(p).st_mtime_ns for p in paths if p.endswith(".py") and os.path.exists(p)}


STARTED = sources()  # what this process runs
