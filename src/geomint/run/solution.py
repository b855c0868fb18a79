"""What `geomint.solve` returns: a result that plots and saves itself."""

from __future__ import annotations

import copy
import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

from ..arguments import Array
from ..errors import DomainError
from ..methods.exact import Exact
from ..problems.shown import Shown
from .dense import DenseOutput, Output
from .exact.dense import ExactOutput
from .pictures import Pictures, time_label
from .provenance import run_provenance
from .result import Result
from .stored import StoredMethod, StoredProblem
from .variables import to_dataframe, to_xarray, variables_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(repr=False, eq=False)
class Solution(Shown, Pictures, Result):
    """The result of `geomint.solve`.

    Two are equal if their numbers are, bit by bit but for run times, and what a file knows of problem
    and method: names, pieces, parameters, options.

    Attributes
    ----------
    t : array, shape (m,)
        Physical times of the saved states.
    tau : array, shape (m,)
        The same in the problem's own time (equal to `t` unless that is τ).
    y : array, shape (m, rows)
        The saved states, one a row.
    drift : dict of name to Drift
        How each observed quantity drifted.
    step : float
        The step, with its sign; of an adaptive method the mean of those taken; 0 of the exact flow.
    step_sizes : StepSizes
        Smallest, mean and largest length of a step.
    steps, rejected : int
        Steps taken; steps that an adaptive method tried and rejected.
    iterations, evaluations : int
        Iterations of implicit steps (explicit: steps, rejected ones included); evaluations of the
        problem.
    newton : bool
        Whether Newton's method took steps for which fixed-point iteration does not contract.
    run_seconds, watching_seconds, compile_seconds : float
        For the steps; for saving states and evaluating what was observed; for compiling.
    status : str
        ``"success"``, ``"interrupted"``, ``"failed"`` or ``"not finite"`` with `message`; the last
        if the end was reached, but something that was observed was infinite or not a number.
    drift_time : ``"t"`` or ``"tau"``
        The time that drifts are measured in: physical if the end was given in it.
    restart : Restart or None
        What ``geomint.solve(solution, …)`` goes on from: the last whole step.
    events : dict of name to Met
        Where events happened, in the order in which they were asked for; see
        `geomint.run.met.Met`.
    error_estimate : array, shape (m, rows), or None
        With ``estimate_error=True`` how far the saved states are from the motion, as far as a finer
        run tells: y less the exact state at the same `tau` (where the end was given in physical time,
        at the same `t`), to first order, with its sign. Of a chaotic motion it is of use as long as it
        is small.
    local_error : LocalError or None
        What steps err by (`geomint.run.local_error`): the worst, where, and the sum; measured when it
        is asked for. None of adaptive methods, and of the exact flow.
    end_error : EndError or None
        Where something is promised of the end, what a second run says of it
        (`geomint.run.second`): with a tolerance, and with neither method nor step.
    ranked : Ranked or LocalError or None
        What it is measured by, or the same.
    warnings : tuple of GeomintWarning
        All that the run has warned of, whether or not it was shown.
    accuracy : Accuracy or None
        With ``tolerance=…`` how that is met: `geomint.run.accuracy.accuracy.Accuracy`.
    route : str
        What was followed in place of the problem, if a plan chose so: the name of a reduction, or
        ``"exact flow"``, which takes no steps.
    problem : Problem
    method : Method
        Of a solution that `geomint.load` gave they are made by their names when they are used: the
        problem by the system of its scene, the method by the registry. With ``trust=True`` what has no
        name is unpickled here, by `sol` and by going on, and nowhere else. `MissingCodeError` is
        raised where there is no code.
    about, by : Problem or StoredProblem, Method or StoredMethod
        The same, or what a file tells of them while they have no code.
    """

    @property
    def t_events(self) -> list[Array]:
        """Times of the events, an array for each, physical if these were integrated; see `events`."""
        return [met.tau if met.t is None else met.t for met in self.events.values()]

    @property
    def y_events(self) -> list[Array]:
        """States at the events, an array for each, one a row; see `events`."""
        return [met.y for met in self.events.values()]

    @functools.cached_property
    def sol(self) -> Output:
        """The states at any time of the run: ``sol.sol(t)``, or ``sol.sol(tau=…)``.

        It needs `problem` and `method`, and unpickles them where these do.

        Raises
        ------
        DomainError
            If the run did not keep what that needs, see ``dense=True`` of `geomint.solve`.
        MissingCodeError
            Of a loaded run whose problem or method has no code here.
        """
        if self.kept is None:
            raise DomainError("sol", None, "dense=True in solve: this run did not keep its steps")
        if isinstance(self.method, Exact):
            return ExactOutput(self.problem, self.kept)
        return DenseOutput(self.problem, self.method, self.kept)

    @property
    def provenance(self) -> Mapping[str, Any]:
        """All about the run, in numbers and words: of a file what was written, versions included."""
        return run_provenance(self) if self.origin is None else self.origin

    def words(self, provenance: Mapping[str, Any] | None = None) -> dict[str, str]:
        """Return what a file says of the run in words; `provenance` as JSON, by default its own."""
        return {
            "problem": self.about.name,
            "method": self.by.name,
            "adaptive": str(self.by.adaptive),
            "time": self.about.time,
            "status": self.status,
            "message": self.message,
            "provenance": json.dumps(dict(self.provenance if provenance is None else provenance)),
        }

    def plot_drift(self) -> Figure:
        """Plot the largest deviation of every observed quantity, window by window."""
        from ..plots.drift_plots import drift_figure

        label = time_label(self, self.drift_time)
        return drift_figure([(self.by.name, self.drift)], label, self.status, self.about.unit)

    def to_xarray(self) -> Any:
        """Return times, pieces, drifts and parameters as an `xarray.Dataset`, as in files.

        Raises
        ------
        MissingCodeError
            Without the library xarray.
        """
        return to_xarray(variables_of(self), self.words())

    def to_dataframe(self) -> Any:
        """Return the states as a `pandas.DataFrame`, a row for each time.

        Raises
        ------
        MissingCodeError
            Without the library pandas.
        """
        return to_dataframe(variables_of(self), self.words())

    def save(self, path: str | PathLike[str]) -> None:
        """Write all of it to a NetCDF file, whole or not at all; see `geomint.run.storage`.

        To a file ``NAME.csv`` times and saved states alone, as `to_dataframe` has them: `geomint.load`
        reads no such file.

        Raises
        ------
        DomainError
            For a name with the ending of another format.
        OutputError
        """
        from .storage import save_solution

        save_solution(self, path)

    def as_saved(self) -> Solution:
        """Return what `geomint.load` would give back, with ``trust=True`` of a run of this process.

        It can be pickled whatever the functions are.
        """
        saved = copy.copy(self)
        vars(saved).pop("sol", None)
        saved.origin = self.provenance
        saved.about, saved.by = StoredProblem.of(self.about), StoredMethod.of(self.by)
        return saved

    def _shown(self) -> tuple[str, dict[str, Any]]:
        own, count = self.about.time, len(self.tau)
        mean = "mean " if self.by.adaptive else ""
        end = f", to {own} = {self.tau[-1]:.9g}" if count else ""
        message = {"message": self.message} if self.message else {}
        drifts = {f"drift of {name}": drift.brief for name, drift in self.drift.items()}
        way = self.route or self.by.name
        return f"solution of {self.about.name!r} by {way}", {
            "status": self.status,
            **message,
            "steps": f"{self.steps} of {mean}{self.step:.6g}" if self.step else "none",
            "states": f"{count}{end}",
            **told_errors(self),
            **drifts,
        }


def told_errors(found: Result) -> dict[str, str]:
    """Return in words what steps err by, and the end, where that is known, and kinds of warnings."""
    local, end, kinds = found.local_error, found.end_error, [w.kind for w in found.warnings]
    told = {}
    if local is not None:
        told["local error"] = f"{local.largest:.2g}, at {found.about.time} = {local.time:.4g}"
    if end is not None:
        told["error at the end"] = f"about {end.error:.1g}"
    if kinds:
        told["warnings"] = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
    return told
