"""`solve_ensemble`: integrate many members, of one problem or of several."""

import time
from collections.abc import Iterator
from concurrent.futures import Executor
from os import PathLike
from typing import Any

import numpy as np

from ...arguments import finite, whole
from ...errors import DomainError, EnsembleError, LeftOutWarning, StateWarning, tell
from ...methods import Exact, Method, find_solver
from ..asked import check_switches
from ..calls import explained, still
from ..progress import Progress
from ..step_notes import tell_short_run
from .given import Asked, canonical_members
from .outcome import ENDED_EARLY, empty_outcome
from .place import place_for
from .readings.spelled import chosen_readings
from .result import Ensemble
from .spread import checked_executor, checked_workers, first_look, spread


@explained
@still
def solve_ensemble(
    problems: Any,
    states: Any,
    *,
    t0: float = 0.0,
    t_end: float | None = None,
    tau_end: float | None = None,
    method: str | Method | None = None,
    step: float | None = None,
    t_eval: Any = None,
    tau_eval: Any = None,
    events: Any = None,
    save_every: int | None = None,
    observe: Any = (),
    observe_every: int = 1,
    clock: bool | None = None,
    estimate_error: bool = False,
    readings: Any = (),
    keep_states: bool | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    out: str | PathLike[str] | None = None,
    progress: bool | None = None,
) -> Ensemble:
    r"""Integrate every state, or a state of every problem, as `geomint.solve` does one.

    Members share nothing: the bits of each are those of its single run, whatever the lanes, threads,
    workers, their order and what other members do. One that fails is reported with its error and hurts
    no other.

    Where states after steps of given lengths are all that is asked for, whole blocks of members are
    moved by compiled code, eight at once in a vector if the method's step works lane by lane
    (explicit Runge–Kutta, splittings, group methods on SO(3)): see `geomint.kernels.solve.members`.
    What is wanted beside that (`t_eval`, `events`, `observe`, adaptive steps, ends in physical time of
    a problem in τ) takes a run of `geomint.solve` for each member, of which the cores share the steps,
    but not the Python between them; processes share all of it.

    Parameters
    ----------
    problems : Problem, or sequence of Problem
        One for all members or one for each, with the same pieces in the same time. Those that differ in
        their parameters alone share compiled code.
    states : array_like, shape (N, rows), or (rows,)
        Flat states, one a row, or one for all problems. A member whose state is none, as with NaN,
        fails alone.
    t0, t_end, tau_end, method, step, t_eval, tau_eval, events, save_every, observe, observe_every
        As those of `geomint.solve`, for every member. Without a `step` each has its own default; where
        a sample shows that such steps err by more than is promised, members are single runs, which
        begin anew.
    clock, estimate_error
        Likewise.
    readings : str, Reading, sequence of them, or mapping of names to them
        What is read off every member, while the states along its run are at hand:
        ``"final:NAME"``, ``"drift:NAME"`` (the largest deviation from the first value),
        ``"lowest:NAME"``, ``"highest:NAME"``, ``"mean:NAME"``, ``"digits:NAME"``,
        ``"frequency:NAME"``, ``"windows:NAME"``, NAME a component or a quantity, and ``"exponent"``,
        ``"exponent-error"``, ``"chaotic"``; `geomint.Windows`, `geomint.Histogram`,
        `geomint.Exponents`, `geomint.SectionPoints`, or a `geomint.Reading` of one's own. States
        are looked at every `save_every` steps, by default
        every one.
    keep_states : bool, optional
        Whether those states are kept. Default: if there are no readings.
    workers : int, optional
        Threads of this process; of an executor how many it has, by which the size of blocks is
        chosen. Default: as many as there are cores.
    executor : concurrent.futures.Executor, optional
        What runs blocks of members in place of threads: a ``ProcessPoolExecutor``, that of a dask
        client (``Client.get_executor()``), of mpi4py. The problem is sent to its workers
        (`geomint.SendingError` where that cannot be).
    out : path, optional
        The folder of a Zarr store: what becomes of a block of members is written there at once, and
        not kept in memory. An ensemble that was broken off goes on when it is called again with the
        same arguments; what is there is not computed again, failed members neither. See
        `geomint.run.ensemble.store.store`, and `geomint.open_ensemble`.
    progress : bool, optional
        Show how many members are done. Default: if standard error is a terminal.

    Returns
    -------
    Ensemble
        After Ctrl-C with the members that are done; others are ``"not run"``. With `out` its arrays
        are read when they are asked for.

    Raises
    ------
    OutputError
        Where `out` cannot be written, or has something else: another ensemble, which the message
        tells from this one.
    MissingCodeError
        For `out` without the library zarr.
    ArgumentError, DomainError, FormError, MethodError, DeclarationError
        Before anything is computed.
    EnsembleError
        If workers of the executor have died, or it fails in another way: ``partial`` is the ensemble
        with the members that are done, as it is of a reading's `DomainError`.

    Warns
    -----
    GeomintWarning
        Of states that were projected, of what members have to say, and of members with too few
        states for an average or a frequency, which have NaN.

    Examples
    --------
    >>> import geomint as gi
    >>> import numpy as np
    >>> from geomint.problems.testproblems import henon_heiles
    >>> states = np.random.default_rng(1).uniform(-0.2, 0.2, (100, 4))
    >>> many = gi.solve_ensemble(henon_heiles.problem(), states, t_end=10.0, method="rk-4", step=0.05)
    >>> many.final.shape, many.success
    ((100, 4), True)
    """
    check_switches(
        estimate_error=estimate_error, clock=clock, progress=progress, keep_states=keep_states
    )
    pool = checked_executor(executor)
    count_of_workers = checked_workers(workers)
    if save_every is not None:
        whole("save_every", save_every, 1)
    whole("observe_every", observe_every, 1)
    given = canonical_members(problems, states)
    chosen, begin = find_solver(method, given.problems[0]), finite("t0", t0)
    chosen_for = chosen_readings(readings)
    if save_every is None and t_eval is None and tau_eval is None:
        along = [name for name, reading in chosen_for.items() if reading.along]
        if along and isinstance(chosen, Exact):
            expected = "t_eval or tau_eval with it: the exact flow takes no steps"
            raise DomainError("readings", along[0], expected)
        save_every = 1 if along else None
    keep = not chosen_for if keep_states is None else keep_states
    shared = {
        "t0": begin, "t_end": t_end, "tau_end": tau_end, "step": step, "save_every": save_every,
        "clock": clock,
    }  # fmt: skip
    asked_for = {
        "t_eval": t_eval, "tau_eval": tau_eval, "events": events,
        "observe": None if isinstance(observe, tuple) and not observe else observe,
        "observe_every": None if observe_every == 1 else observe_every,
        "estimate_error": estimate_error or None,
    }  # fmt: skip
    wanted = {
        name: tuple(value) if isinstance(value, Iterator) else value  # each member begins anew
        for name, value in asked_for.items()
        if value is not None
    }
    asked = Asked(chosen, shared, len(given), wanted, chosen_for, keep, out is not None)
    alike = {tuple(problem.diagnostics): problem for problem in given.problems}
    for reading in chosen_for.values():
        for problem in alike.values():
            reading.check(problem, asked)
    count = len(given)
    many = Ensemble(given, asked, empty_outcome(1, given.states.shape[1]))
    with (
        place_for(out, given, asked, count_of_workers) as place,
        Progress(progress, count, f"{count} members") as bar,
    ):
        start, begun_with = time.perf_counter(), count - len(place.left)
        try:
            known = first_look(asked, given) if place.fresh else None
            place.begin()
            if known is not None:
                place.take(*known)
            bar.begin()
            start = time.perf_counter()
            blocks = spread(
                *(asked, given, place.left, place.size, count_of_workers, pool),
                lambda done: bar.update(begun_with + done),
            )
            for done in blocks:
                place.take(*done)
        except KeyboardInterrupt:
            pass  # the status of members tells
        except (EnsembleError, DomainError) as error:
            error.partial = many
            raise
        finally:
            many.found, many.run_seconds = place.found, time.perf_counter() - start
    _tell_members(many)
    _tell_few(many)
    if step is not None and asked.steps_alone and "success" in many.status:
        own_end = t_end if tau_end is None else tau_end
        own = given.problem(0).time
        if own_end is not None and (own == "t" or t_end is None):  # others are runs of their own
            start = begin if own == "t" else 0.0
            tell_short_run(given.problem(0), abs(float(own_end) - start), float(step))
    return many


def _tell_members(many: Ensemble) -> None:
    """Warn once of all that members have to say, but of states, of which that was done."""
    told = {
        k: [w for w in said if type(w) is not StateWarning] for k, said in many.warnings.items()
    }
    told = {k: said for k, said in told.items() if said}
    if told:
        k = min(told)
        first = told[k][0]
        text = f"{len(told)} of {len(many)} members have `warnings`; member {k}: {first}"
        tell(type(first)(text, first.quantity, first.size, first.time))


def _tell_few(many: Ensemble) -> None:
    """Warn of readings that members have none of, since they have few states."""
    asked = many.asked
    needed = {name: r.fewest for name, r in asked.readings.items() if r.fewest > 1}
    if not needed:
        return
    every, times = asked.shared["save_every"], asked.times
    states = many.steps // every + 1 if times is None else np.full(len(many), np.size(times))
    states = states[~np.isin(many.status, ENDED_EARLY)]
    few = {name: int((states < fewest).sum()) for name, fewest in needed.items()}
    names = [name for name, count in few.items() if count]
    if names:
        text = (
            f"{few[names[0]]} of {len(many)} members have fewer than {needed[names[0]]} states at "
            f"equal steps, and no value of {', '.join(names)}: take shorter steps or a later end"
        )
        tell(LeftOutWarning(text, names[0], few[names[0]]))
