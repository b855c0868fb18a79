"""Growth of a deviation over the members of an ensemble: what `Ensemble.growth` returns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...arguments import Array, Booleans, finite, whole
from ...errors import DomainError
from ...problems.shown import Shown
from ...watch.growth import RULE
from ...watch.over_members import LEVELS, class_of_exponent, growth_over_members
from .given import Asked
from .readings.of_series import Windows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .result import Ensemble


SAME_END = 1e-9  # of the length of a run
FEWEST_MEMBERS, FEWEST_WINDOWS = 8, 8  # of which anything can be told


@dataclass(frozen=True, eq=False, repr=False)
class EnsembleGrowth(Shown):
    r"""How the deviation of a quantity from its first value grows over the members of an ensemble.

    Attributes
    ----------
    name : str
        Of the quantity.
    time : str
        The time that it grows in: ``"t"`` or ``"tau"``.
    t : array, shape (m,)
        Mean times of the windows, since the beginning.
    rms : array, shape (m,)
        The root of the mean square over members and over each window.
    levels, quantiles : array, shapes (5,), (5, m)
        Quantiles over members of the rms in each window.
    exponent, exponent_stderr : float
        b of rms ~ t^b by least squares in logarithms, and its standard error by samples of the members.
        NaN where nothing deviated.
    interval : tuple of float
        That of 95 % of the exponent.
    halves, halves_stderr : array, shape (2,)
        Those of the earlier and of the later half of the run, in log t: they differ where no power of t
        fits the whole.
    size : float
        The rms that the fit has at the last of the times.
    drift_class : str
        ``bounded``, ``sqrt``, ``linear``, ``faster``, ``roundoff`` or ``undetermined``: see
        `geomint.watch.over_members.class_of_exponent`.
    members : int
        How many were looked at: those that came to their ends.
    """

    name: str
    time: str
    t: Array
    rms: Array
    levels: Array
    quantiles: Array
    exponent: float
    exponent_stderr: float
    interval: tuple[float, float]
    halves: Array
    halves_stderr: Array
    size: float
    drift_class: str
    members: int

    @property
    def meaning(self) -> str:
        """The class in words, as the drift class of a run."""
        return RULE[self.drift_class]

    def plot(self) -> Figure:
        """Plot rms and quantiles over time, with the fit."""
        from ...plots.growth_plot import growth_figure

        bands = list(zip(self.levels, self.quantiles, strict=True))
        fit = (self.exponent, self.exponent_stderr, self.size)
        return growth_figure(self.name, self.time, self.t, self.rms, bands, fit)

    def _shown(self) -> tuple[str, dict[str, Any]]:
        first, second = self.halves
        return f"growth of {self.name!r} over {self.members} members", {
            "class": self.drift_class,
            "exponent": f"{self.exponent:.3f} ± {self.exponent_stderr:.2g}",
            "in halves": f"{first:.2f}, {second:.2f}",
            "rms at the end": f"{self.size:.3g}",
        }


def growth_of_ensemble(many: Ensemble, name: Any, since: Any, seed: Any) -> EnsembleGrowth:
    """Return what `Ensemble.growth` does."""
    key = _key(many, name)
    values = np.asarray(many.readings[key])
    values = values[np.isfinite(values).all(axis=1) & _at_their_ends(many)]
    if len(values) < FEWEST_MEMBERS:
        expected = (
            f"at least {FEWEST_MEMBERS} members that came to their ends, with states in windows"
        )
        raise DomainError("members", len(values), expected)
    edges = _edges(many, values.shape[1])
    begin = finite("since", since)
    late = edges[:-1] >= begin
    if late.sum() < FEWEST_WINDOWS:
        expected = f"a time that leaves {FEWEST_WINDOWS} of {len(late)} windows"
        raise DomainError("since", since, expected)
    values, edges = values[:, late], edges[len(late) - late.sum() :]
    found = growth_over_members(values, edges, whole("seed", seed, 0))
    return EnsembleGrowth(
        name=many.asked.readings[key].of,
        time=_times(many.asked)[0],
        t=0.5 * (edges[1:] + edges[:-1]),
        rms=found.rms,
        levels=np.array(LEVELS),
        quantiles=found.quantiles,
        exponent=found.exponent,
        exponent_stderr=found.stderr,
        interval=(found.low, found.high),
        halves=found.halves,
        halves_stderr=found.halves_stderr,
        size=found.size,
        drift_class=class_of_exponent(found),
        members=len(values),
    )


def _key(many: Ensemble, name: Any) -> str:
    """Return the name of the reading that has the windows of a quantity."""
    readings = many.asked.readings
    windows = {key: r.of for key, r in readings.items() if getattr(r, "kind", "") == Windows.kind}
    for key, of in windows.items():
        if isinstance(name, str) and name in (key, of):
            return key
    known = ", ".join(map(repr, windows)) or "none"
    expected = f"a quantity read by geomint.Windows (here: {known}), as readings=geomint.Windows(…)"
    raise DomainError("name", name, expected)


def _end(asked: Asked) -> tuple[str, float | None]:
    """Return the time in which an end is given, and the end."""
    for time, end in (("t", "t_end"), ("tau", "tau_end")):
        if asked.shared.get(end) is not None:
            return time, float(asked.shared[end])
    return "t" if asked.wanted.get("t_eval") is not None else "tau", None


def _times(asked: Asked) -> tuple[str, Any]:
    """Return the time of states that were asked for at times, and these; or the time of the end."""
    if asked.times is None:
        return _end(asked)[0], None
    time = "t" if "t_eval" in asked.wanted else "tau"
    return time, np.atleast_1d(np.asarray(asked.times, dtype=np.float64))


def _at_their_ends(many: Ensemble) -> Booleans:
    """Return which members went on to the end: those that an event ended have shorter windows."""
    time, times = _times(many.asked)
    end = _end(many.asked)[1] if times is None else float(times[-1])
    if end is None:
        return np.ones(len(many), dtype=bool)
    physical = time == "t" and many.problems[0].time == "tau"
    saved = many.found.physical if physical else many.found.tau
    reached = saved[np.arange(len(many)), np.maximum(many.counts - 1, 0)]
    return np.abs(reached - end) <= SAME_END * abs(end - many.asked.shared["t0"])


def _edges(many: Ensemble, count: int) -> Array:
    """Return the times since the beginning that windows begin and end at: between saved states.

    With these half a step aside, the mean of a power of t over a window of samples is that over time to
    second order, for windows of one sample too.
    """
    asked = many.asked
    times = _times(asked)[1]
    if times is not None:
        if asked.shared["save_every"]:
            raise DomainError("save_every", asked.shared["save_every"], "None beside times")
        since = np.abs(times - times[0])[1:]
        last = np.cumsum([len(part) for part in np.array_split(since, count)])
        inner = 0.5 * (since[last[:-1] - 1] + since[last[:-1]])
        last_gap = since[-1] - since[-2]
        return np.array([0.5 * since[0], *inner, since[-1] + 0.5 * last_gap])
    _, end = _end(asked)
    if many.asked.method.adaptive or end is None:
        raise DomainError("method", asked.method.name, "steps of one length, or t_eval or tau_eval")
    steps = float(np.median(many.steps[_at_their_ends(many)])) / (
        asked.shared.get("save_every") or 1
    )
    samples = max(round(steps), count)
    small, more = divmod(samples, count)
    numbers = np.arange(count + 1)
    edges = 0.5 + small * numbers + np.minimum(numbers, more)  # as numpy's array_split
    return edges * abs(end - asked.shared["t0"]) / samples
