"""What a step costs: geomint against lielab (RKMK) and Mici (constrained leapfrog).

The same method takes the same steps in both codes: RKMK of the classical Runge–Kutta tableau on the
classical Chaplygin ball (n = 3), and RATTLE on the spherical pendulum. The ends must agree. lielab
gets the smaller formulation, an attitude g in SO(3) alone (k and γ are g⁻¹ applied to constants),
in the faster of two ways to write the field; Mici analytic gradients and Jacobians.

Floors: lielab 500 times, Mici 1000 times as slow a step.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi
from machine import describe
from tests.problems import spherical_pendulum

FLOORS = {"lielab": 500.0, "mici": 1000.0}
STEP = 0.02
PEER_STEPS, OWN_STEPS = 2_000, 500_000
MOMENTS, D = np.array([1.0, 2.0, 3.0]), 1.0
K0, GAMMA0 = np.array([1.0, 0.7, -0.4]), np.array([0.6, 0.0, 0.8])


def own_run(problem: gi.Problem, y0: np.ndarray, method: gi.Method) -> Callable[[int], Any]:
    """Return ``run(steps) -> (seconds, state)`` of geomint; the seconds are those of `solve`."""

    def run(steps: int) -> tuple[float, np.ndarray]:
        begun = time.perf_counter()
        solution = gi.solve(
            problem, y0, t_end=steps * STEP, step=STEP, method=method, progress=False
        )
        return time.perf_counter() - begun, solution.y[-1]

    return run


def ball() -> tuple[gi.Problem, np.ndarray]:
    """Return the classical ball and its initial state (k, γ)."""
    problem = ch.ChaplyginSphere.from_moments(MOMENTS, D, 1.0).classical()
    return problem, problem.state(gamma=GAMMA0, k=K0)


def with_arrays(g: np.ndarray) -> np.ndarray:
    """Return the angular velocity in space for an attitude."""
    B = 1.0 / (MOMENTS + D)
    k, gamma = K0 @ g, GAMMA0 @ g
    s = B * k
    m = D * (gamma @ s) / (gamma @ (B * MOMENTS * gamma))
    return np.asarray(g @ (s + B * (m * gamma)))


def with_numbers(g: np.ndarray) -> list[float]:
    """Return the same, with Python's floats."""
    rows = g.tolist()
    k = [sum(K0[i] * rows[i][j] for i in range(3)) for j in range(3)]
    gamma = [sum(GAMMA0[i] * rows[i][j] for i in range(3)) for j in range(3)]
    B = [1.0 / (float(moment) + D) for moment in MOMENTS]
    s = [b * x for b, x in zip(B, k, strict=True)]
    w = sum(b * i * x * x for b, i, x in zip(B, MOMENTS, gamma, strict=True))
    m = D * sum(x * y for x, y in zip(gamma, s, strict=True)) / w
    omega = [x + b * m * y for x, b, y in zip(s, B, gamma, strict=True)]
    return [sum(rows[i][j] * omega[j] for j in range(3)) for i in range(3)]


def lielab_run(velocity: Callable[[np.ndarray], Any]) -> Callable[[int], Any]:
    """Return ``run(steps) -> (seconds, (k, γ))`` of lielab with the field written that way."""
    from lielab.domain import SO, CompositeAlgebra, CompositeManifold, so
    from lielab.integrate import (
        HomogeneousIVPSystem,
        IVPMethod,
        IVPOptions,
        RungeKuttaCoefficients,
        solve_ivp,
    )

    def generator(t: float, y: Any) -> Any:
        return CompositeAlgebra([so.from_vector(velocity(y.point[0].get_matrix()))])

    system, options = HomogeneousIVPSystem(generator), IVPOptions()
    options.method = IVPMethod.MuntheKaas
    options.coefficients = RungeKuttaCoefficients.RK4a
    options.variable_time_step = False
    options.dt = STEP

    def run(steps: int) -> tuple[float, np.ndarray]:
        start, end = CompositeManifold([SO(3)]), steps * STEP
        begun = time.perf_counter()
        solution = solve_ivp(system, np.array([0.0, end]), start, options)
        seconds = time.perf_counter() - begun
        if not solution.success or len(solution.t) not in (steps + 1, steps + 2):
            raise SystemExit(f"lielab took {len(solution.t) - 1} steps: {solution.message}")
        g = np.asarray(solution.ybar[-1]).reshape(3, 3)
        return seconds, np.concatenate([K0 @ g, GAMMA0 @ g])

    return run


def mici_run() -> Callable[[int], Any]:
    """Return ``run(steps) -> (seconds, (q, p))`` of Mici's constrained leapfrog."""
    from mici.integrators import ConstrainedLeapfrogIntegrator
    from mici.states import ChainState
    from mici.systems import DenseConstrainedEuclideanMetricSystem

    force = np.array([0.0, 0.0, 1.0])
    system = DenseConstrainedEuclideanMetricSystem(
        neg_log_dens=lambda q: q[2],
        grad_neg_log_dens=lambda q: force,
        constr=lambda q: np.array([q @ q - 1.0]),
        jacob_constr=lambda q: 2.0 * q[None, :],
    )
    integrator = ConstrainedLeapfrogIntegrator(system, step_size=STEP)

    def run(steps: int) -> tuple[float, np.ndarray]:
        y0 = spherical_pendulum.INITIAL
        state = ChainState(pos=y0[:3].copy(), mom=y0[3:].copy(), dir=1)
        begun = time.perf_counter()
        for _ in range(steps):
            state = integrator.step(state)
        return time.perf_counter() - begun, np.concatenate([state.pos, state.mom])

    return run


def per_step(runs: dict[str, tuple[Callable[[int], Any], int]], repeats: int) -> dict[str, float]:
    """Return the median seconds a step, the codes taking turns; the first round compiles."""
    seconds: dict[str, list[float]] = {name: [] for name in runs}
    for i in range(repeats + 1):
        for name, (run, steps) in runs.items():
            used, _ = run(steps)
            if i:
                seconds[name].append(used / steps)
    return {name: statistics.median(values) for name, values in seconds.items()}


def difference(first: Callable[[int], Any], second: Callable[[int], Any]) -> float:
    """Return the largest difference of two codes after 100 steps."""
    return float(np.max(np.abs(first(100)[1] - second(100)[1])))


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    own_ball = own_run(*ball(), gi.RKMK("rk-4"))
    own_pendulum = own_run(spherical_pendulum.problem(), spherical_pendulum.INITIAL, gi.Rattle())
    lielab = {f.__name__: lielab_run(f) for f in (with_arrays, with_numbers)}
    mici = mici_run()
    agreement = {
        "lielab": difference(own_ball, lielab["with_arrays"]),
        "mici": difference(own_pendulum, mici),
    }
    seconds = per_step(
        {
            "geomint rkmk-4": (own_ball, OWN_STEPS),
            "geomint rattle-2": (own_pendulum, OWN_STEPS),
            "mici": (mici, PEER_STEPS),
            **{f"lielab {name}": (run, PEER_STEPS) for name, run in lielab.items()},
        },
        arguments.repeats,
    )
    best = min(v for name, v in seconds.items() if name.startswith("lielab"))
    ratios = {
        "lielab": best / seconds["geomint rkmk-4"],
        "mici": seconds["mici"] / seconds["geomint rattle-2"],
    }
    for name, value in seconds.items():
        print(f"{name}: {1e6 * value:.3f} µs a step")
    for name, ratio in ratios.items():
        print(
            f"{name}: {ratio:.0f} times as slow (floor {FLOORS[name]:g}); "
            f"states agree to {agreement[name]:.1e} after 100 steps"
        )
    result = {
        "benchmark": "peers-per-step",
        "seconds_per_step": seconds,
        "ratios": ratios,
        "floors": FLOORS,
        "agreement": agreement,
        "step": STEP,
        "repeats": arguments.repeats,
        "machine": describe(["geomint", "lielab", "mici", "numba", "numpy"]),
    }
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / "peers_per_step.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
