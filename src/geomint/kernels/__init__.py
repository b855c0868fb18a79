"""What runs compiled: numbers, blocks, steppers, group actions. Imports nothing above itself."""

from pathlib import Path


def sources() -> dict[Path, tuple[int, ...]]:
    """Return when each source of this folder was written; clocks may differ, so they are compared."""
    stats = {path: path.stat() for path in Path(__file__).parent.rglob("*.py") if path.is_file()}
    return {path: (s.st_mtime_ns, s.st_ctime_ns, s.st_size, s.st_ino) for path, s in stats.items()}


STARTED = sources()  # what this process runs
