"""Every system with an exact motion: the scenes' problems that have one, and states of all kinds."""

from __future__ import annotations

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.exact_support import TAU_AND_T, flow_of, problem_of, special_states


def _systems() -> dict[str, tuple[gi.Problem, np.ndarray]]:
    found, known = {}, set()
    for scene in map(gi.load_scene, gi.scene_names()):
        for name, problem in scene.model.problems.items():
            what = problem.name, problem.rows, problem.params.tobytes()
            if problem.make_exact is not None and what not in known:
                known.add(what)
                found[f"{scene.name}-{name}"] = problem, scene.model.states[name]
    return found


def _special() -> dict[str, tuple[gi.Problem, np.ndarray]]:
    """Steady turns, planes, equal moments, nearly equal ones, next to a separatrix."""
    found = {}
    for pattern in ("3", "lagrange", "two-pairs"):
        for kind in TAU_AND_T:
            problem = problem_of(pattern, kind)
            for name, state in special_states(problem).items():
                found[f"{pattern}-{kind}-{name}"] = problem, state
            turn = np.zeros(problem.rows)
            turn[0], turn[problem.rows // 2 + 1] = 1.0, 0.7
            found[f"{pattern}-{kind}-steady"] = problem, problem.canonical(turn)
    sphere = ch.ChaplyginSphere([0.8, 1.1, 1.5], 4.0)
    for problem in (sphere.hamiltonized(), sphere.reduced()):
        near = flow_of(problem, [1.0, 0.0, 3e-3], [0.0, 3e-3, 0.2])
        found[f"next to a separatrix-{problem.time}"] = problem, near
    close = ch.ChaplyginSphere([0.8, 0.8 + 1e-9, 1.5], 4.0).hamiltonized()
    found["nearly equal"] = close, close.random_state(4)
    return found


SYSTEMS, SPECIAL = _systems(), _special()
ALL = {**SYSTEMS, **SPECIAL}
each = pytest.mark.parametrize("name", ALL)
# One of each kind: in both times, classical ones, pairs of equal axes, a steady turn.
KINDS = ["hamiltonized-n3-hamiltonized", "hamiltonized-n3-reduced", "ball-3d-classical"]
KINDS += ["veselova-classical-classical", "lagrange-n4-reduced", "homogeneous-n4-ball"]


def systems(count: int) -> pytest.MarkDecorator:
    """Return all systems as parameters, of which so many kinds are in the fast row."""
    late = [pytest.mark.nightly]
    return pytest.mark.parametrize(
        "name", [pytest.param(x, marks=late if x not in KINDS[:count] else []) for x in SYSTEMS]
    )


def own_end(problem: gi.Problem, end: float) -> dict[str, float]:
    """The keyword of an end in the problem's own time."""
    return {"tau_end" if problem.time == "tau" else "t_end": end}


def span(problem: gi.Problem, y0: np.ndarray, periods: float = 5.0) -> float:
    """Some of the shortest periods, in the problem's own time."""
    motion = problem.exact(y0)
    found = motion.frequencies if problem.time == "tau" else motion.mean_frequencies
    return periods * 2.0 * np.pi / float(np.max(np.abs(found)))


def components(problem: gi.Problem) -> list[str]:
    """The names of all rows of the state."""
    return [f"{piece}[{i}]" for piece, rows in problem.pieces for i in range(rows)]
