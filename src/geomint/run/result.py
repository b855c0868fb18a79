"""What a run leaves, as data: states, drifts, costs."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from ..arguments import Array, piece_rows
from ..errors import ByName, DomainError, GeomintWarning
from ..kernels.compiling.sameness import Compared
from ..methods.method import Method
from ..problems.problem import Problem, Time
from ..watch.drift import Drift
from .accuracy.accuracy import Accuracy
from .dense import Kept
from .local_error import EndError, LocalError, Ranked
from .met import Met
from .restart import Restart
from .stored import Stored, StoredMethod, StoredProblem, known

Status = Literal["success", "interrupted", "failed", "not finite"]


class StepSizes(NamedTuple):
    """Lengths of steps in the problem's own time; all the same at fixed step.

    Steps that the end of an adaptive run cuts short count in the mean only.
    """

    min: float
    mean: float
    max: float


@dataclass(repr=False, eq=False)
class Result(Compared):
    """The data of a `geomint.Solution`, where its attributes are described."""

    about: Problem | StoredProblem = field(compare=False)
    by: Method | StoredMethod = field(compare=False)
    step: float
    step_sizes: StepSizes
    tau: Array
    y: Array
    drift: dict[str, Drift]
    steps: int
    rejected: int
    iterations: int
    evaluations: int
    run_seconds: float = field(compare=False)
    watching_seconds: float = field(compare=False)
    compile_seconds: float = field(compare=False)
    status: Status
    message: str
    drift_time: Time = "t"
    physical: Array | None = field(default=None, repr=False)
    restart: Restart | None = field(default=None, repr=False)
    kept: Kept | None = field(default=None, repr=False)
    events: dict[str, Met] = field(default_factory=dict, repr=False)
    error_estimate: Array | None = field(default=None, repr=False)
    route: str = ""
    accuracy: Accuracy | None = field(default=None, repr=False)
    end_error: EndError | None = None
    warnings: tuple[GeomintWarning, ...] = field(default=(), compare=False, repr=False)
    ranked: Ranked | LocalError | None = field(default=None, compare=False, repr=False)
    origin: Mapping[str, Any] | None = field(default=None, compare=False, repr=False)
    newton: bool = False

    def __post_init__(self) -> None:
        self.drift, self.events = ByName(self.drift, "drift"), ByName(self.events, "events")

    def _compared(self) -> list[Any]:
        """Return all that is data, and what is known of problem and method without their code."""
        return [known(self.about), known(self.by), *super()._compared()]

    def code(self, of: str = "about", unpickle: bool = False) -> Any:
        """Return the problem, or what the method is ``by``, made by its name if it has no code yet.

        Raises
        ------
        MissingCodeError
            If there is none of that name; nothing is unpickled unless that is asked for.
        """
        value = getattr(self, of)
        if isinstance(value, Stored):
            value = value.found(unpickle)
            setattr(self, of, value)
        return value

    @property
    def problem(self) -> Problem:
        """The problem; of a file that was loaded with ``trust=True`` it may be unpickled for that."""
        return self.code("about", unpickle=True)

    @property
    def method(self) -> Method:
        """The method, as `problem` is."""
        return self.code("by", unpickle=True)

    @property
    def t(self) -> Array:
        """Physical times of the saved states."""
        if self.physical is None:
            raise DomainError("clock", False, "clock=True: physical time was not integrated")
        return self.physical

    @property
    def local_error(self) -> LocalError | None:
        """What steps err by, measured when it is asked for; None of adaptive methods."""
        return self.ranked.error if isinstance(self.ranked, Ranked) else self.ranked

    @property
    def success(self) -> bool:
        """Whether the end was reached, and all that was observed is finite."""
        return self.status == "success"

    def piece(self, name: str) -> Array:
        """Return the saved values of one piece of the state, one a row."""
        return self.y[:, piece_rows(self.about.slices, name)]
