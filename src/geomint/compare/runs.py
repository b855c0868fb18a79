"""Comparison of methods on one system: run time against error, at the same physical time.

Every method runs in whatever representation and time suits it; all final states are turned into the
same physical quantities (`Problem.physical_state`) at the same physical time, and compared with a
reference of about 32 digits (`geomint.compare.reference`), or with the exact flow
(`geomint.compare.exact_reference`), that a second method of another family confirms. Errors that it
is not far better than are not given. Integrators of other packages, `peers`, run beside the methods.
"""

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import Any

from ..arguments import whole
from ..errors import FormError
from ..kernels.compiling.sameness import Compared
from ..methods import Method, find_method
from ..plan.fitting import representation_for
from ..problems.systems import Model
from ..run.many import Outcome, attempt, run_many
from ..run.reported import Reported
from ..run.solve import solve
from ..watch.drift import Drift
from .endpoint import Endpoint, Source, endpoint_of
from .ladder import check_representation, checked_steps, ladder
from .peer_runs import peer_runs
from .peers import find_peers
from .point import MAX_SECONDS, Point, timed_runs

__all__ = ["Comparison", "Point", "compare"]


@dataclass(eq=False)
class Comparison(Compared, Reported):
    """All points, the reference, and the drifts of each method's best run.

    `status` is ``"interrupted"`` if Ctrl-C ended it before the last point; `left_out` says of peers
    that did not run why.
    """

    points: list[Point]
    reference: dict[str, Any]
    drifts: list[tuple[str, dict[str, Drift]]] = field(default_factory=list)
    compile_seconds: float = 0.0
    status: str = "success"
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def without_result(self) -> dict[str, str]:
        """Methods, not peers, of which no point has a result, and why their first one has none."""
        found = {p.method for p in self.points if p.bound is not None}
        first: dict[str, str] = {}
        for point in self.points:
            if point.method not in found and point.peer is None:
                first.setdefault(point.method, point.status)
        return first

    def as_json(self) -> dict[str, Any]:
        """Return the numbers under the names of ``compare.json``."""
        return {
            "status": self.status,
            "points": [asdict(point) for point in self.points],
            "peers_left_out": self.left_out,
            "reference": self.reference,
        }


def compare(
    model: Model,
    end: dict[str, float],
    methods: Iterable[str | Method],
    *,
    steps: Iterable[float] | None = None,
    first_steps: Mapping[str, float] | None = None,
    representation: str | None = None,
    repeats: int | None = None,
    observe: bool = True,
    reference: Source = "auto",
    peers: Iterable[str] = (),
    report: Callable[[str], None] = lambda text: None,
) -> Comparison:
    """Run every method at several steps and measure error and run time.

    Parameters
    ----------
    model : Model
        The system in its representations; the first is the scene's own.
    end : dict
        ``{"t_end": …}`` or ``{"tau_end": …}`` in the scene's own time.
    methods : iterable of str or Method
        A method with options of its own keeps them.
    steps : iterable of float, optional
        Steps in each method's own time. Default: 4, 2, 1, 1/2, 1/4 of its default step. Adaptive
        methods run at tolerances instead: 10⁴ … 10⁻⁴ times their own rtol, which is 1e-8 unless
        given, with atol in proportion.
    first_steps : mapping of name to float, optional
        Steps that take the place of the default steps of these methods; of an adaptive one that of
        its first step.
    representation : str, optional
        The name of the only representation to use, or ``"own"`` for the scene's own. Default: for
        each method the first that fits it.
    repeats : int, optional
        Timed runs of each point; the median counts. Default: 3, or fewer where they have taken a
        second.
    observe : bool
        Whether to measure, in an extra run at each method's finest step, the drifts.
    reference : {"auto", "extended", "exact"}
        What the reference is: an integration in double-double arithmetic; the exact flow, where the
        system has one; or the first, and the second where the first would take minutes.
    peers : iterable of str
        Integrators of other packages, of `geomint.compare.peers.PEERS`, that run too, at tolerances of
        their own. Those that are not installed or cannot state the problem are left out.
    report : callable
        Told what is being done.

    Raises
    ------
    FormError, DomainError
        If there is no exact flow and it is asked for; for a representation that the system does not
        have; for no methods, no steps, or steps where all methods are adaptive; for an unknown peer.
    UnknownReferenceError
        If the reference is not known, or not confirmed, well enough to judge errors of 1e-5.
    """
    chosen = [find_method(m) for m in methods]
    given = checked_steps(chosen, steps)
    repeats = None if repeats is None else whole("repeats", repeats, 1)
    others = find_peers(list(peers))
    check_representation(model, representation)
    endpoint, known = endpoint_of(model, end, reference, report)
    result = Comparison([], known)

    def ladder_runs(method: Method) -> Iterator[tuple[Point | str, Outcome]]:
        """Carry out the runs of one method: of its points, and with its name the one of its drifts.

        What cannot be run, or would take too long, becomes a point here.
        """
        try:
            name, problem = representation_for(model, method, end, representation)
        except FormError as error:
            result.points.append(Point(method.name, method.order, "", 0.0, None, status=str(error)))
            return
        y0, (own_end,) = model.states[name], end.values()
        base = (first_steps or {}).get(method.name)
        best = None
        last = None
        for variant, step in ladder(method, problem, y0, given, base, own_end):
            options = variant.options
            setting = f"rtol {options['rtol']:.0e}" if method.adaptive else f"step {step:.4g}"
            report(f"{method.name}, {setting}")
            point = _point(variant, name, step)
            expected = 0.0 if last is None else _expected_seconds(last, variant, step)
            if expected > MAX_SECONDS:
                status = f"not run: would take about {expected:.0f} s"
                result.points.append(replace(point, status=status))
                continue
            run = partial(solve, problem, y0, method=variant, step=step)
            timed = partial(run, **endpoint.end_for(problem))
            times, enough = timed_runs(repeats)
            yield point, attempt(timed, repeats=times, enough=enough)
            if result.points[-1].bound is not None:
                best, last = run, result.points[-1]
        if observe and best is not None:
            # Over physical time, so that all methods share an axis.
            watched = [*problem.invariants, *problem.constraints]
            yield method.name, attempt(partial(best, t_end=endpoint.physical_end, observe=watched))

    runs = (entry for method in chosen for entry in ladder_runs(method))

    def take(made: tuple[Point | str, Outcome]) -> None:
        point, outcome = made
        result.compile_seconds += outcome.compile_seconds
        if outcome.status == "interrupted":  # a part of a run has no error at the end
            raise KeyboardInterrupt
        if isinstance(point, Point):
            result.points.append(_measured(point, outcome, endpoint))
        else:
            result.drifts.append((point, outcome.result().drift))

    with warnings.catch_warnings():
        for told in ("step = .* is longer than the run", "steps of .* are so long"):
            warnings.filterwarnings("ignore", told)
        if not run_many(runs, take):
            result.status = "interrupted"
            return result
    beside = peer_runs(others, model, endpoint, representation, repeats, result.left_out, report)
    if not run_many(beside, result.points.append):
        result.status = "interrupted"
    return result


def _expected_seconds(last: Point, method: Method, step: float | None) -> float:
    """Return the run time that the last point lets expect of the next one."""
    seconds = last.seconds or 0.0
    if step is not None and not method.adaptive:
        return seconds * last.step / step
    rtol = method.options["rtol"]
    return seconds * float(((last.rtol or rtol) / rtol) ** (1.0 / (method.order + 1)))


def _point(method: Method, representation: str, step: float | None) -> Point:
    """Return a point of which nothing has been measured yet."""
    options = method.options
    return Point(
        method.name,
        method.order,
        representation,
        0.0 if method.adaptive else step or 0.0,
        options.get("iteration_tolerance"),
        rtol=options.get("rtol"),
    )


def _measured(point: Point, outcome: Outcome, endpoint: Endpoint) -> Point:
    """Return a point with what was measured."""
    if outcome.error is not None:
        status = f"failed: {type(outcome.error).__name__}: {outcome.error}"
        return replace(point, status=status)
    solution = outcome.result()
    adaptive = solution.method.adaptive
    if not (solution.steps or adaptive):  # the step that was asked for is none of it
        return replace(point, status="not measured: the step is longer than the run")
    return replace(
        point,
        step=abs(solution.step) if adaptive else point.step,
        seconds=outcome.seconds,
        steps=solution.steps,
        evaluations=solution.evaluations,
        iterations=solution.iterations if "max_iterations" in solution.method.options else None,
        newton=solution.newton,
        repeats=outcome.repeats,
        warnings=tuple(warning.as_json() for warning in solution.warnings),
        **endpoint.judged(solution.problem, solution.y[-1]),
    )
