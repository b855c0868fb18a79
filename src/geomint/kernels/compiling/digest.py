"""A digest of what a value is made of: the same in every process, another one for another value.

`geomint.kernels.compiling.sameness` compares two values of one process; this one can be written down.
"""

import functools
import hashlib
import sys
from importlib import metadata
from pathlib import Path

import numpy as np

from .cache import kernel_stamp
from .contents import Contents


def digest(value) -> str:
    """Return 32 digits of what a value is made of: arrays bit by bit, functions by their code."""
    return hashlib.sha256(_Plain().of(value)).hexdigest()[:32]


class _Plain(Contents):
    def of(self, value) -> bytes:  # what a user computed is what a user wrote
        return super().of(value.item() if isinstance(value, np.generic) else value)


@functools.cache
def source_stamp() -> str:
    """Return a hash of geomint's sources, of Python, numpy and the compiler."""
    stamp = hashlib.sha256(kernel_stamp().encode())
    for path in sorted(filter(Path.is_file, Path(__file__).parents[2].rglob("*.py"))):
        stamp.update(path.read_bytes())
    return stamp.hexdigest()


def versions_of_numbers() -> str:
    """Return in words the versions of all that numbers may depend on."""
    told = [f"Python {sys.version_info.major}.{sys.version_info.minor}"]
    for name in ("numpy", "scipy", "numba", "llvmlite", "mpmath"):
        try:
            told.append(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            continue
    return f"sources {source_stamp()[:12]}, {', '.join(told)}"
