"""
Energy drift of four methods
============================

A hundred thousand steps of the Hamiltonised Chaplygin sphere, the same step for all. What is
symplectic and symmetric oscillates; the Runge–Kutta method drifts in proportion to time; eight Gauss
stages leave rounding alone.
"""

import matplotlib.pyplot as plt

import chaplygin as ch
import geomint as gi

problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
figure, axes = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
for method in ("rk-4", "verlet-4", "rattle-4", "gauss-8"):
    given = {"method": method, "step": 0.05, "observe": ["energy"]}
    sol = gi.solve(problem, problem.random_state(1), tau_end=5000.0, **given)
    times, _, largest = sol.drift["energy"].windows.closed
    axes.loglog(times, largest, label=method)
axes.set(xlabel="time τ (dimensionless)", ylabel="largest |H − H₀| (dimensionless)")
legend = axes.legend(ncols=2)
