"""Compilation at need: options, signatures, specialisations, and the account of time spent.

Compiled code is asked for by *type* of number (`geomint.kernels.compiling.number_types`) and, for
fields, by row count: a field whose row count is a constant is unrolled by LLVM (measured: 1.6 times
faster at n = 3), while its signature stays the same for every stepper.
"""

import functools
import gc
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import parent_process
from types import FrameType, FunctionType
from typing import Any

from numba.core import config as _config, types
from numba.core.errors import NumbaExperimentalFeatureWarning, NumbaPedanticWarning
from numba.extending import typeof_impl

from ..numba_inside import address_of, compiled, dispatcher_of, global_compiler_lock, linked
from ..numbers import (  # noqa: F401 - what numba is to know
    typing_addresses,
    typing_blocks,
    typing_elementary,
)
from .beside import other
from .cache import KeptCode, plain
from .call import Code
from .clock import standing_still
from .fingerprint import Reach
from .foreign import refuse_compiled, refuse_foreign, refuse_modules
from .recorded import Recorded

config: Any = _config
# Code is called by its address (`geomint.kernels.compiling.call`): it needs no way in from Python or C.
_OPTIONS = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
DEEPEST = 2000  # calls of Python: ten times as many as numba was seen to need
_lock = threading.RLock()
_listeners: list[Callable[[str, float | None], None]] = []
_announced: list[bool] = []
_asked = 0


def _before_fork() -> None:
    _lock.acquire()
    global_compiler_lock.acquire()


def _after_fork() -> None:
    global_compiler_lock.release()
    _lock.release()


if hasattr(os, "register_at_fork"):
    # A child that begins while a thread compiles would wait for ever for locks that nobody holds.
    os.register_at_fork(
        before=_before_fork, after_in_parent=_after_fork, after_in_child=_after_fork
    )


@typeof_impl.register(Recorded)
def _typeof_recorded(value: Recorded, c):
    return types.Dispatcher(value.made(make_dispatcher))


def listen(listener: Callable[[str, float | None], None]) -> Callable[[], None]:
    """Call ``listener(name, None)`` when a compilation starts and ``listener(name, seconds)`` after.

    Functions found in the on-disk cache are not reported. Returns a function that ends it.
    """
    _listeners.append(listener)
    return lambda: _listeners.remove(listener)


def functions_asked() -> int:
    """Return how often compiled code has been asked for in this process."""
    return _asked


def announce() -> None:
    """Say on standard error that functions are compiled: once, and not for a process of another one."""
    if _announced or sys.stderr is None or parent_process() is not None:
        return
    _announced.append(True)
    with suppress(OSError, ValueError):  # it is closed
        print("geomint: compiling (once, then kept in the cache)", file=sys.stderr, flush=True)


def _notify(name: str, seconds: float | None) -> None:
    if not _listeners:
        announce()
    for listener in _listeners:
        listener(name, seconds)


def _unique(recorded: Recorded) -> FunctionType:
    """Return the function under a qualified name of its own, made with its fingerprint.

    LLVM symbols are made of that name and a counter that begins anew in every process. Two cached
    functions of one name from two processes may have the same symbol, and a third process that
    loads both would run one of them for the other. The module is this one, because numba imports it
    with the code: a user's may be anything that has its name there.
    """
    f = recorded.function
    copy = FunctionType(f.__code__, f.__globals__, plain(f.__name__), f.__defaults__, f.__closure__)
    copy.__module__, copy.__doc__, copy.__kwdefaults__ = __name__, f.__doc__, f.__kwdefaults__
    copy.__qualname__ = f"{plain(f.__qualname__)}_{recorded.fingerprint}"
    return copy


def make_dispatcher(recorded: Recorded):
    """Return a numba dispatcher of a recorded function for use inside of other compiled code."""
    refuse = functools.partial(refuse_modules, recorded)
    return dispatcher_of(_unique(recorded), refuse, forceinline=recorded.inline, **_OPTIONS)


def _codes(recorded: Recorded) -> tuple[Reach, dict[int, Code]]:
    """Return what a function reaches, of which code has addresses, and its codes: none yet."""
    refuse_compiled(recorded)
    return recorded.reach, {}


def compile_function(recorded: Recorded, signature):
    """Return the code of `recorded`, compiled for `signature` or found in the cache.

    What the function reaches is looked at in each call: after a change it is other code. With
    NUMBA_DISABLE_JIT it is the function as it is.

    Raises
    ------
    DomainError
        If the function reaches what numba has compiled by itself.
    """
    global _asked
    _asked += 1
    if config.DISABLE_JIT:
        return recorded.function
    reach, codes = recorded.made(_codes)
    code = codes.get(id(signature))  # which the code keeps
    if code is not None:
        return code
    with standing_still(), _lock, _room(), warnings.catch_warnings():
        # Steppers take fields as first-class functions, which numba calls experimental every
        # time; its pedantic warnings are addressed to its own developers.
        warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
        warnings.simplefilter("ignore", NumbaPedanticWarning)
        if id(signature) not in codes:  # another thread may have been first
            found = _found_or_compiled(recorded, reach, signature)
            codes[id(signature)] = Code(address_of(found), (found, reach), signature)
    return codes[id(signature)]


@contextmanager
def _room() -> Iterator[None]:
    """Let numba call as deep as it needs, however deep its caller is, and no garbage be collected.

    To look at what is in use took an eighth of numba's time.
    """
    on = gc.isenabled()
    gc.disable()
    sys.setrecursionlimit(sys.getrecursionlimit() + DEEPEST)
    try:
        yield
    finally:
        sys.setrecursionlimit(sys.getrecursionlimit() - DEEPEST)
        if on:
            gc.enable()


@contextmanager
def _ctrl_c_later() -> Iterator[None]:
    """Let Ctrl-C wait for a compilation: what is broken off there can never be compiled again.

    A second one does not wait.
    """
    pressed: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        if pressed:
            raise KeyboardInterrupt
        pressed.append(number)

    plain = threading.current_thread() is threading.main_thread()
    if not (plain and signal.getsignal(signal.SIGINT) is signal.default_int_handler):
        yield
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if pressed:
        raise KeyboardInterrupt


def _found_or_compiled(recorded: Recorded, reach: Reach, signature):
    name, start = recorded.function.__name__, time.perf_counter()
    kept = KeptCode(name, reach, signature)
    with _ctrl_c_later(), linked():
        try:
            if (found := kept.load()) is not None:
                return found
            refuse_foreign(recorded)  # what is found on the disk was made of nothing of the kind
            _notify(name, None)
            found = compiled(_unique(recorded), signature, **_OPTIONS)
            kept.save(found)
        finally:
            if beside := other("", False):
                beside.tell("")
    _notify(name, time.perf_counter() - start)
    return found
