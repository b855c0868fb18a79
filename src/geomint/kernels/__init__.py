"""What runs compiled: numbers, blocks, steppers, group actions. Imports nothing above itself."""

from itertools import chain
from pathlib import Path

_COMPILER = ("*.py", "compiling/*.py", "numbers/*.py")


def sources() -> dict[Path, tuple[int, ...]]:
    """Return when each source of the compiler was written; clocks may differ, so they are compared.

    That is what compiled code depends on beside the functions that it is made of, whose contents are
    part of their fingerprints: how they are compiled, and what numbers and blocks are.
    """
    found = chain.from_iterable(map(Path(__file__).parent.glob, _COMPILER))
    stats = {path: path.stat() for path in sorted(found) if path.is_file()}
    return {path: (s.st_mtime_ns, s.st_ctime_ns, s.st_size, s.st_ino) for path, s in stats.items()}


STARTED = sources()  # what this process runs
