"""Work in processes of its own: one that hangs, crashes or takes too much memory ends alone.

Compiled code does not hear signals, so only another process can stop it.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from multiprocessing import get_context
from typing import Any, NamedTuple

from pebble import ProcessExpired, ProcessPool

from ..errors import GeomintError, raised


class Outcome(NamedTuple):
    """What became of one item.

    Attributes
    ----------
    ending : str
        ``"done"``, ``"raised"``, ``"died"`` or ``"hung"``.
    told : object
        What the function returned, or else what happened.
    """

    item: Any
    ending: str
    told: Any


def guarded(
    function: Callable[[Any], Any],
    items: Iterable[Any],
    *,
    seconds: float,
    workers: int = 2,
    memory: int = 0,
) -> Iterator[Outcome]:
    """Call `function` on every item, in `workers` processes, and yield outcomes in their order.

    Parameters
    ----------
    function : callable
        A function of a module: processes find it by name.
    seconds : float
        An item that takes longer, compilations included, has hung: its process is killed.
    memory : int
        Bytes that a process may take, where the platform can limit them; 0 for any number.

    Raises
    ------
    GeomintError
        Where no process can be started.
    """
    pool = ProcessPool(workers, 0, _limit, (memory,), get_context("spawn"))
    try:
        ending, why = _ending(pool.schedule(_ready, timeout=seconds), seconds)
        if ending != "done":
            expected = (
                'a script reads itself again there: call it below `if __name__ == "__main__":`'
            )
            raise GeomintError(f"no process can be started ({why}); {expected}")
        begun = [(item, pool.schedule(function, (item,), timeout=seconds)) for item in items]
        for item, future in begun:
            yield Outcome(item, *_ending(future, seconds))
    finally:
        pool.stop()  # type: ignore[no-untyped-call]
        pool.join()  # so that their processor time is counted


def _ready() -> None:
    """Tell that a process has begun."""


def _ending(future: Any, seconds: float) -> tuple[str, Any]:
    try:
        return "done", future.result()
    except TimeoutError:
        return "hung", f"still running after {seconds:.3g} s: ended"
    except ProcessExpired as death:
        return "died", f"the process ended with code {death.exitcode}"
    except Exception as error:
        return "raised", raised(error)


def _limit(memory: int) -> None:
    with suppress(ImportError):  # Windows has no such limits
        import resource

        if memory:
            most = resource.getrlimit(resource.RLIMIT_AS)[1]
            resource.setrlimit(resource.RLIMIT_AS, (memory, most))
