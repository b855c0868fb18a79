"""One line on a terminal while functions are compiled: how many, and how long it will take."""

import sys

_USUAL = 1.2  # seconds a function, before any has been compiled


def on_terminal() -> bool:
    """Tell whether standard error is a terminal; it may be closed."""
    return sys.stderr is not None and sys.stderr.isatty()


class CompilingLine:
    """Written over by every function that has to be compiled, and gone when the run begins.

    Where standard error is no terminal, it is written once in a process, without counts.

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
        if on_terminal():
            self._written = True
            rest = max(self._expected - number, 0) + 1
            left = rest * (_USUAL + self._seconds) / (1 + self._count)
            of = f"/{max(self._expected, number)}, about {max(round(left), 1)} s left"
            text = (
                f"compiling {number}{of if self._expected else ''} (once, then kept in the cache)"
            )
            print(f"\r\x1b[Kgeomint: {text}", end="", file=sys.stderr, flush=True)
        else:
            from ..kernels.compiling.compile import announce  # there by now: it imports numba

            announce()

    def ends(self, seconds: float) -> None:
        """Take the time that a function took."""
        self._count, self._seconds = self._count + 1, self._seconds + seconds

    def clear(self) -> None:
        """Leave the terminal as it was."""
        if self._written:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
        self._written = False
