"""One line on a terminal while functions are compiled: how many, and how long it will take."""

import sys

_USUAL = 1.2  # seconds a function, before any has been compiled


class CompilingLine:
    """Written over by every function that has to be compiled, and gone when the run begins.

    Where standard error is no terminal, it is written once, without counts.

    Parameters
    ----------
    shown : bool
    expected : int
        How many functions will be asked for, some of them found in the cache; 0 if not known.
    """

    def __init__(self, shown: bool, expected: int = 0) -> None:
        self._shown, self._expected = shown, expected
        self._count, self._seconds, self._written = 0, 0.0, False

    def begins(self, number: int) -> None:
        """Say that a function has to be compiled, which is the `number`-th that is asked for."""
        if not self._shown:
            return
        words, terminal = "once, then kept in the cache", sys.stderr.isatty()
        if terminal:
            rest = max(self._expected - number, 0) + 1
            left = rest * (_USUAL + self._seconds) / (1 + self._count)
            of = f"/{max(self._expected, number)}, about {max(round(left), 1)} s left"
            text = f"geomint: compiling {number}{of if self._expected else ''} ({words})"
            print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)
        elif not self._written:
            print(f"geomint: compiling ({words})", file=sys.stderr)
        self._written = True

    def ends(self, seconds: float) -> None:
        """Take the time that a function took."""
        self._count, self._seconds = self._count + 1, self._seconds + seconds

    def clear(self) -> None:
        """Leave the terminal as it was."""
        if self._written and sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
        self._written = False
