"""What runs compiled: numbers, blocks, steppers, group actions. Imports nothing above itself."""

from pathlib import Path


def sources() -> dict[Path, int]:
    """Return when each source of this folder was written; clocks may differ, so they are compared."""
    found = Path(__file__).parent.rglob("*.py")
    return {path: path.stat().st_mtime_ns for path in found if path.is_file()}


STARTED = sources()  # what this process runs
