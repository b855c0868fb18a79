"""What the rules of the planner see and say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..kernels.compiling.sameness import Compared
from ..problems.problem import Problem
from ..run.timeline import Timeline, plan_timeline
from ..scene.scene import Scene

__all__ = ["Choice", "Context"]


@dataclass(frozen=True)
class Choice:
    """One decision of a plan: what it is about, its value in words, and why."""

    what: str
    value: str
    reason: str
    detail: Any = None


@dataclass(frozen=True, eq=False)
class Context(Compared):
    """What a rule sees: the scene, the purpose of the run, and the earlier choices."""

    scene: Scene
    purpose: str
    choices: Mapping[str, Choice] = field(default_factory=dict)

    @property
    def representation(self) -> str:
        """The name of the chosen representation."""
        return str(self.choices["representation"].detail)

    @property
    def problem(self) -> Problem:
        """The problem that is integrated."""
        return self.scene.model.problems[self.representation]

    @property
    def state(self) -> npt.NDArray[np.float64]:
        """Its initial state."""
        return self.scene.model.states[self.representation]

    @property
    def clock(self) -> bool:
        """Whether physical time is integrated beside the state."""
        return bool(self.choices["physical time"].detail)

    @cached_property
    def timeline(self) -> Timeline:
        """Steps and end."""
        time, integrate = self.scene.content.time, self.scene.content.integrate
        return plan_timeline(
            self.problem, self.scene.method, self.state, time.t_end, time.tau_end, integrate.step
        )
