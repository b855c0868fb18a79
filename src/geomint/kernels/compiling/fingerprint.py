"""What a function reaches: one fingerprint of it, and whether it is still as it was.

numba compiles what a function reaches into machine code, and sees no later change. So that no stale
code runs, a function is walked once (`geomint.kernels.compiling.walk`): what it reaches is hashed,
and where each value was found is kept. `Reach.holds` looks there again: for the same objects, and
for the same content of those that can be changed.
"""

import hashlib
import itertools
import os

from .code import framed
from .walk import MISSING, Walk, content_of

_changes = itertools.count()
_process = os.urandom(16)


class Reach:
    """What a function reaches, as it is now.

    Attributes
    ----------
    fingerprint : str
        The same in every process for the same code and contents.
    kept : bool
        Whether compiled code may be kept on disk: all contents are known.
    compiled : list of (str, object)
        What numba has compiled by itself, and where it was found.
    others : list of (str, object)
        Callables and values whose content is not known, and where they were found.
    functions : list of function
        All that are reached outside of the kernel layer and of libraries.
    """

    def __init__(self, function) -> None:
        walk = Walk()
        walk.value(function)
        walk.follow_modules()
        digest = hashlib.sha256(framed(*walk.pieces))
        if not walk.kept:  # no two of these are the same, here or elsewhere
            digest.update(_process + str(next(_changes)).encode())
        self.fingerprint = digest.hexdigest()[:24]
        self.kept, self.compiled, self.others = walk.kept, walk.compiled, walk.others
        self._names = list(walk.names.values())
        self._cells, self._functions, self._tests = walk.cells, walk.functions, walk.tests
        self.functions = [function for function, *_ in walk.functions]

    def holds(self) -> bool:
        """Tell whether all of it is still as it was: in a few microseconds for most functions."""
        for space, name, value in self._names:
            if space.get(name, MISSING) is not value:
                return False
        for function, code, defaults, keywords in self._functions:
            if function.__code__ is not code or function.__defaults__ is not defaults:
                return False
            if function.__kwdefaults__ is not keywords:
                return False
        for cell, value in self._cells:
            if content_of(cell) is not value:
                return False
        return all(test() for test in self._tests)
