"""Members spread over threads of this process, or over the workers of an executor."""

import contextlib
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from typing import Any

import numpy as np

from ...arguments import Array, Integers, whole
from ...errors import DomainError, EnsembleError, GeomintError, quoted
from ...kernels.compiling.cores import cores
from ...kernels.numbers.lanes import LANES
from ..timeline import plan_timeline
from .compiled import run_compiled
from .given import Asked, Members
from .outcome import NOT_RUN, Outcome, empty_outcome
from .readings.reading import Ran, read_off
from .single import run_single

Block = Integers  # numbers of members

LEAST, MOST = 64, 1024  # members of a block: what preparing one is worth; what a dead worker loses
NUMBERS = 1 << 22  # of states along the runs of a block, where they are not kept
# Blocks for every worker, so that none waits long for another at the end: fewer where members take
# equal times, as preparing a block costs as much as some hundred steps of a member.
EACH, EACH_ALIKE = 8, 4
# Of an ensemble on disk: a block is a chunk of every array, and is lost if it is broken off.
MOST_STREAMED, NUMBERS_STREAMED, EACH_STREAMED = 4096, 1 << 20, 32
AHEAD = 2  # of them for every worker that are under way or not yet written: what memory holds
FIRST = 16  # members of which one has to begin, or what is asked of all is wrong
LOOK = 0.05  # seconds between looks at Ctrl-C


def first_look(asked: Asked, given: Members) -> tuple[Block, Outcome] | None:
    """Check and compile what all members share; return a member's outcome if that took a run.

    Raises
    ------
    GeomintError
        For what is wrong with the first member, the last and all that were tried between them: with
        what is asked of all.
    """
    failure = None
    members = np.flatnonzero(given.admitted)
    between = np.linspace(0, len(members) - 1, FIRST).astype(int)
    for k in dict.fromkeys(members[[0, -1, *between]].tolist()):
        block = np.array([k])
        one = given.of(block)
        alike = one if len(given.problems) == 1 else given.of(np.array([k, k]))  # as blocks will be
        try:
            if asked.steps_alone and run_compiled(asked, alike, np.ones(1)) is not None:
                return None
            found = empty_outcome(1, given.states.shape[1])
            run_single(asked, one, [0], np.zeros(1), found, strict=True)
            if found.status[0] == "interrupted":
                raise KeyboardInterrupt
            _read(asked, one, found, np.zeros(1))
        except GeomintError as error:
            failure = failure or error
        else:
            return block, found
    assert failure is not None
    raise failure


def run_block(asked: Asked, given: Members, stop: Array | None = None) -> Outcome:
    """Return what has become of some members: in another thread or process as here."""
    stop = np.zeros(1) if stop is None else stop
    found = empty_outcome(len(given), given.states.shape[1])
    here = np.flatnonzero(given.admitted)
    if asked.steps_alone and len(here):
        with contextlib.suppress(GeomintError):  # of the first member, which its own run will tell
            part = given if given.admitted.all() else given.of(here)
            moved = run_compiled(asked, part, stop)
            if moved is not None:
                found.take(here, moved)
    left = [k for k, status in enumerate(found.status) if status == NOT_RUN]
    run_single(asked, given, left, stop, found)
    _read(asked, given, found, stop)
    found.cut = found.cut or bool(stop[0])
    return found


def _read(asked: Asked, given: Members, found: Outcome, stop: Array) -> None:
    for k, told in given.told.items():
        found.warnings[k] = (*told, *found.warnings.get(k, ()))
    if asked.readings or not asked.keep_states:
        read_off(Ran(given, asked, found, stop), asked.readings)


def checked_workers(workers: Any) -> int:
    """Return how many threads there are to be, by default as many as this process has cores."""
    if workers is None:
        return cores()
    return whole("workers", workers, 1, 10**6)


def checked_executor(executor: Any) -> Executor | None:
    """Return an executor, or raise `DomainError`."""
    if executor is None or isinstance(executor, Executor):
        return executor
    raise DomainError(
        "executor", executor, "a concurrent.futures.Executor, such as Client.get_executor()"
    )


def block_size(asked: Asked, given: Members, workers: int) -> int:
    """Return how many members a block has."""
    count, rows = len(given), int(given.states.shape[1])
    held = 1 if asked.keep_states and not asked.streamed else expected_samples(asked, given)
    if asked.streamed:
        most, each = MOST_STREAMED, EACH_STREAMED
        numbers = NUMBERS_STREAMED if asked.keep_states else NUMBERS
    else:
        most, numbers = MOST, NUMBERS
        each = EACH_ALIKE if asked.steps_alone else EACH
    most = min(most, max(numbers // (held * rows), 1))
    most = most // LANES * LANES or most
    least = min(LEAST, most) if asked.steps_alone else 1
    size = -(-count // (each * workers))
    return min(max(-(-size // LANES) * LANES, least), most)


def expected_samples(asked: Asked, given: Members) -> int:
    """Return about how many states of a member there will be, until its readings are made."""
    if asked.times is not None:
        return max(int(np.size(asked.times)), 1)
    if not asked.shared["save_every"]:
        return 1
    k = int(given.admitted.argmax())
    line = plan_timeline(given.problem(k), asked.method, given.states[k], **asked.ends)
    return int(line.expected / asked.shared["save_every"]) + 2


def blocks_of(which: Block, size: int) -> list[Block]:
    """Return numbers of members in blocks: each of those from a multiple of the size to the next."""
    starts = np.flatnonzero(np.diff(which // size)) + 1
    return [block for block in np.split(which, starts) if len(block)]


def spread(
    asked: Asked,
    given: Members,
    which: Block,
    size: int,
    workers: int,
    executor: Executor | None,
    between: Callable[[int], None],
) -> Iterator[tuple[Block, Outcome]]:
    """Yield blocks of members and what has become of them, in the order in which they are done.

    Parameters
    ----------
    size : int
        Of a block.
    between : callable
        Called with the number of members that are done, some twenty times a second. It may raise
        KeyboardInterrupt: blocks that have begun are then ended, and yielded, before that is raised.

    Raises
    ------
    EnsembleError, GeomintError
        If the workers have died, or a reading fails, after all that is done has been yielded.
    """
    blocks = blocks_of(which, size)
    ahead = AHEAD * workers if asked.streamed else len(blocks)
    if executor is not None:
        shared = np.zeros(1) if isinstance(executor, ThreadPoolExecutor) else None
        yield from _collected(executor, asked, given, blocks, ahead, shared, between)
        return
    with ThreadPoolExecutor(workers, "geomint") as pool:
        yield from _collected(pool, asked, given, blocks, ahead, np.zeros(1), between)


def _collected(
    pool: Executor,
    asked: Asked,
    given: Members,
    blocks: list[Block],
    ahead: int,
    stop: Array | None,
    between: Callable[[int], None],
) -> Iterator[tuple[Block, Outcome]]:
    futures: dict[Future[Outcome], Block] = {}
    waiting = deque(blocks)
    failure = None

    def begin() -> BaseException | None:
        """Let blocks begin, as many as may be under way; return why no more can."""
        extra = () if stop is None else (stop,)
        try:
            while waiting and len(futures) < ahead:
                of = given.of(waiting[0])
                future = pool.submit(run_block, asked, of, *extra)
                if not isinstance(future, Future):
                    raise TypeError(f"{quoted(future)} was submitted, and is no Future")
                futures[future] = waiting.popleft()
        except KeyboardInterrupt:
            raise
        except BaseException as broken:  # an executor that is shut down, or broken in any way
            return broken
        return None

    def end() -> None:
        """Let nothing begin any more, and what has begun come to its next look."""
        if stop is not None:
            stop[0] = 1.0
        for future in futures:
            future.cancel()

    done = 0
    try:
        failure = begin()
        while futures:
            try:
                ready, _ = wait(futures, LOOK, FIRST_COMPLETED)
                between(done)
            except KeyboardInterrupt as interrupt:
                end()
                failure = failure or interrupt
                ready, _ = wait(futures)
            for future in ready:
                block = futures.pop(future)
                try:
                    found = future.result()
                    if not (isinstance(found, Outcome) and len(found.tau) == len(block)):
                        raise TypeError(f"{quoted(found)} is not what {len(block)} members give")
                except BaseException as problem:  # of a worker; or it was cancelled
                    failure = failure or problem
                    end()
                else:
                    done += len(block)
                    yield block, found
            failure = failure or begin()
    finally:
        end()
    if isinstance(failure, KeyboardInterrupt | GeomintError):  # Ctrl-C, or of a reading
        raise failure
    if failure is not None:
        raise EnsembleError(f"workers have ended: {quoted(failure)}") from failure
