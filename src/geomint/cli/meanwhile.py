"""What a command's page will need is imported while compiled code runs, which leaves Python free."""

import contextlib
import importlib
import sys
import threading

from ..run.progress import WHEN_RUNNING

SWITCH = 2e-4  # seconds

_NEEDED = (
    "geomint.reports.files",
    "geomint.plots.figure",
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_svg",
)


def import_meanwhile(at_once: bool = False) -> None:
    """Import what pages and figures are made with, beside the next run.

    Or `at_once`. Before a run Python has enough to do. What fails here fails again, and is told, where
    it is imported for use.
    """

    def load() -> None:
        # The run comes back to Python every millisecond or two, and must not wait for five.
        before = sys.getswitchinterval()
        sys.setswitchinterval(SWITCH)
        with contextlib.suppress(Exception):
            for name in _NEEDED:
                importlib.import_module(name)
        sys.setswitchinterval(before)

    thread = threading.Thread(target=load, name="importing the page")
    if at_once:
        thread.start()
    else:
        WHEN_RUNNING.append(thread.start)
