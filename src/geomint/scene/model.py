"""The sections of a scene file, as strict pydantic models.

Unknown keys, numbers written as strings, and numbers that are not finite are errors. The keys of
``[system]`` beside `name`, and those of ``[initial]``, belong to the system: see `geomint.System`.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from contextlib import suppress
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, create_model, model_validator

from ..errors import GeomintError, loaded, offered
from ..methods.registry import AUTO

Raw = Mapping[str, Any]  # a scene, or a section of one, as it was given
Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1, le=2**53)]
Name = Annotated[str, Field(min_length=1)]
Names = Annotated[list[Name], Field(min_length=1)]
Seed = Annotated[int, Field(ge=0)]


class Section(BaseModel):
    """Base of all sections: frozen, strict, without unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class OpenSection(Section):
    """What sections share that have keys of their own beside others, which belong to what they name."""

    model_config = ConfigDict(extra="allow")

    @property
    def options(self) -> dict[str, Any]:
        """The others: options of a method, such as `max_iterations`, or tables of quantities'."""
        return dict(self.__pydantic_extra__ or {})


class SystemSection(OpenSection):
    """``[system]``: a registered system and its parameters."""

    name: Name = Field(description="the name of a registered system")


class OtherEnd(Section):
    """What sections of other uses of a scene share: an end of their own."""

    _expected: ClassVar[str] = "t_end or tau_end"
    _refused: ClassVar[dict[int, str]] = {2: "both"}

    t_end: Number | None = None
    tau_end: Number | None = None

    @model_validator(mode="after")
    def _one_end(self) -> Self:
        if (count := len(self.end)) in self._refused:
            raise ValueError(f"expected {self._expected}, got {self._refused[count]}")
        if 0.0 in self.end.values():
            raise ValueError("the end must not be 0, where the run begins")
        return self

    @property
    def end(self) -> dict[str, Any]:
        """``{"t_end": …}``, ``{"tau_end": …}``, or nothing."""
        return self.model_dump(include={"t_end", "tau_end"}, exclude_none=True)


class TimeSection(OtherEnd):
    """``[time]``: the end, in physical time or in the problem's own reparametrised time.

    With a `clock` σ the scene's own representation is in the time τ of dt = σ dτ, in which even steps
    are uneven ones of t, see `geomint.time_transformed`: ``"speed"``, or one of its quantities that
    is > 0. Methods that need another form than it has then work in t, as they do without.
    """

    _expected = "exactly one of t_end and tau_end"
    _refused = {0: "neither", 2: "both"}

    clock: Name | None = Field(default=None, description='"speed", or the name of a quantity > 0')


class IntegrateSection(OpenSection):
    """``[integrate]``: the method, its step in the problem's own time, and the method's options.

    In place of the step, `tolerance` is the error that is wanted of the state at the end, relative to
    the largest number of each piece; with it ``"auto"`` is a method too. `representation` forces a
    representation of the system, by its name or as ``"own"``. With `exact` states may come from the
    exact flow, in place of the method's steps.
    """

    method: Name = Field(default="gauss-8", description="the name of a method")
    step: Positive | None = Field(default=None, description="a step > 0")
    tolerance: Annotated[float, Field(ge=2.0**-52, lt=0.1)] | None = Field(
        default=None, description="the error wanted at the end, from 2⁻⁵² to 0.1"
    )
    representation: Name | None = None
    exact: bool | None = Field(default=None, description="true or false")

    @model_validator(mode="after")
    def _one_measure(self) -> Self:
        if self.step is not None and self.tolerance is not None:
            raise ValueError("expected step or tolerance, got both")
        if self.method == AUTO and self.tolerance is None:
            raise ValueError(f"method {AUTO!r} needs a tolerance, by which it is chosen")
        return self


class ObserveSection(OpenSection):
    """``[observe]``: which quantities are watched (names or groups), every how many steps.

    A table in it has the options of the quantity of its name: ``[observe.measure] steps = 20000``.
    """

    quantities: list[Name] = Field(default=["invariants", "constraints"])
    every: Count = 1


class SaveSection(Section):
    """``[save]``: which states are kept: every so many steps, or at given physical times."""

    every: Count | None = None
    t_eval: Annotated[list[Number], Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _one_way(self) -> SaveSection:
        if self.every is not None and self.t_eval is not None:
            raise ValueError("expected every or t_eval, got both")
        return self


class DriftSection(OtherEnd):
    """``[drift]``: what ``geomint drift`` does otherwise than ``geomint run``.

    `methods`, as ``"NAME"`` or ``"NAME:STEP"``, are run one after the other for one report.
    """

    method: Name | None = None
    methods: Names | None = Field(
        default=None,
        description="Several methods: NAME or NAME:STEP, separated by commas; without --method "
        "and --step.",
    )
    step: Positive | None = None
    quantities: list[Name] | None = None
    every: Count | None = None

    @model_validator(mode="after")
    def _one_or_several(self) -> DriftSection:
        if self.methods is not None and (self.method is not None or self.step is not None):
            raise ValueError(
                'expected methods, or method and step; a step in methods is written "NAME:STEP"'
            )
        return self


class CompareSection(OtherEnd):
    """``[compare]``: what ``geomint compare`` does if its command line says nothing else."""

    methods: Names | None = Field(
        default=None, description="Methods, separated by commas, such as gauss-8,cf-4,rk-4."
    )
    steps: Annotated[list[Positive], Field(min_length=1)] | None = Field(
        default=None,
        description="Step sizes, separated by commas; default: chosen for each method.",
    )
    repeats: Count | None = Field(
        default=None,
        description="Number of timed runs of each point; default: 3, or fewer if one takes a second.",
    )
    reference: Literal["auto", "extended", "exact"] | None = Field(
        default=None,
        description="Reference solution: by double-double arithmetic, by the exact flow, or the "
        "faster one.",
    )
    peers: bool = Field(
        default=False,
        description="Also run integrators of other installed packages that can solve the problem.",
    )


class EventSection(Section):
    """One of ``[events]``: what is looked for along the run, by the name of its table.

    `what` is a component of the state, ``"gamma[2]"`` (from 0 on), or a quantity. With `terminal` the
    run ends there; a number: at the event of that number.
    """

    what: Name
    direction: Literal["up", "down", "both"] = "both"
    level: Number = 0.0
    terminal: bool | Count = False


class SectionSection(Section):
    """``[section]``: what ``geomint section`` does if its command line says nothing else.

    `event` is a name of ``[events]``, or else a component or a quantity itself; `direction` and `level`
    take the place of the event's. Beside the scene's motion there are `motions` − 1 others, from
    random states where the quantities `keep` have the same values.
    """

    event: Name | None = Field(
        default=None, description="Surface: one of [events], a component (gamma[2]), a quantity."
    )
    direction: Literal["up", "down", "both"] | None = Field(
        default=None, description="Crossings to count."
    )
    level: Number | None = Field(default=None, description="Value of the event on the surface.")
    points: Count = Field(default=1000, description="Number of points of each motion.")
    motions: Count = Field(default=1, description="Motions, all of the scene's energy.")
    keep: list[Name] = Field(
        default=["energy"], description="Quantities that all motions have as the scene's."
    )
    seed: Seed = Field(default=0, description="Random seed of the other motions.")
    axes: Annotated[list[Name], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="Plot these two components or quantities."
    )
    exact: bool | None = Field(default=None, description="Follow the exact flow, without steps.")


class ChaosSection(Section):
    """``[chaos]``: what ``geomint chaos`` does if its command line says nothing else."""

    count: Count | None = Field(default=None, description="Number of exponents; default: all.")


class EnsembleSection(Section):
    """``[ensemble]``: what ``geomint scan`` does if its command line says nothing else.

    `vary` has values for numbers of ``[system]`` and ``[initial]``, as lists or ``"A:B:N"``: every
    combination is integrated. With `draws` each is so from that many random states in place of the
    scene's, by the invariant measure where the quantities `keep` are as at the scene's state, or with
    the weight exp(−energy/`temperature`). What is read off every member: `show`.
    """

    vary: dict[Name, Name | list[Number]] = Field(
        default_factory=dict,
        description="Vary a number of [system] or [initial], such as D or gamma[2], with N values "
        "from A to B. Or write A:B:N:log, or values separated by commas. Give --vary twice for a map.",
    )
    draws: Count | None = Field(
        default=None, description="Random states to draw from the invariant measure."
    )
    keep: list[Name] | None = Field(
        default=None, description="Give random states the scene's values of these quantities."
    )
    temperature: Positive | None = Field(
        default=None, description="Weight random states by exp(−energy/temperature)."
    )
    seed: Seed = Field(default=0, description="Random seed of the states.")
    show: Names | None = Field(
        default=None,
        description="Results to plot: final:NAME, drift:NAME, lowest:NAME, highest:NAME, mean:NAME, "
        "digits:NAME, frequency:NAME, exponent (the largest Lyapunov exponent, with its error).",
    )
    workers: Count | None = Field(default=None, description="Threads to use; default: all cores.")


class Content(Section):
    """A whole scene file."""

    title: str = ""
    description: str = ""
    system: SystemSection = Field(description='this section, with name = "…": `geomint scenes`')
    initial: dict[str, Any] = Field(default_factory=dict)
    time: TimeSection = Field(description="this section, with an end such as t_end = 100.0")
    integrate: IntegrateSection = Field(default_factory=IntegrateSection)
    observe: ObserveSection = Field(default_factory=ObserveSection)
    save: SaveSection = Field(default_factory=SaveSection)
    events: dict[Name, EventSection] = Field(default_factory=dict)
    drift: DriftSection = Field(default_factory=DriftSection)
    compare: CompareSection = Field(default_factory=CompareSection)
    section: SectionSection = Field(default_factory=SectionSection)
    chaos: ChaosSection = Field(default_factory=ChaosSection)
    ensemble: EnsembleSection = Field(default_factory=EnsembleSection)


SECTIONS: dict[str, type[Section]] = {}  # of commands, by their names in scenes


def content_model(raw: Raw) -> type[Content]:
    """Return the model of a scene: with the sections of other commands, where it has any."""
    found = {key: _section_of(key) for key in raw if key not in Content.model_fields}
    more: dict[str, Any] = {
        key: (section, Field(default_factory=section)) for key, section in found.items() if section
    }
    return create_model("Content", __base__=Content, **more) if more else Content


def _section_of(key: str) -> type[Section] | None:
    """Return the section of a command, which says so when it is imported; None if there is none."""
    with suppress(GeomintError, ImportError):
        if key not in SECTIONS and key in (others := offered("geomint.commands")):
            loaded(others[key])
        if key not in SECTIONS and key.isidentifier():
            importlib.import_module(f"geomint.cli.commands.{key}")
    return SECTIONS.get(key)
